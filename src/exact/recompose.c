/*
 * Recompose: a 5x5 filter that brings the slice directions of a 4x4 block
 * together, without blurring across edges; at half resolution a 5x9 filter of
 * a 4x8 block.
 *
 * A neighbour's weight is spatial times guide.  Spatial: a 5x5 window holds the
 * layers of its outer rows and columns twice, so they count half there; of the
 * layer at the four corners two opposite ones count.  Guide:
 *   max(0, 1 - (d / HBIL_PLANE_TOLERANCE)^2 - (1 - n.n') /
 * HBIL_TURN_TOLERANCE), where d is how far the neighbour's w is off the pixel's
 * tangent plane, relative to the pixel's w.
 *
 * With a single slice a pixel, the measure of its hemisphere differs from pixel
 * to pixel, so AO and irradiance are weighed by it: numerators and divisor of
 * the ratio estimator are then summed over the window.
 */
#include <float.h>
#include <stdlib.h>

#include "exact/camera.h"
#include "exact/estimate.h"
#include "exact/glossy.h"
#include "exact/lobe.h"
#include "exact/passes.h"
#include "exact/planes.h"
#include "exact/settings.h"
#include "exact/surface.h"
#include "lib/sampling_pattern.h"

/* At half resolution the pattern has 4x8 pixels, so the window has 5x9. */
static int rows_below(const exact_frame *frame) {
  return exact_gathered_layers(frame->config) == HBIL_LAYERS ? 2 : 4;
}

static double spatial_weight(const exact_frame *frame, int dx, int dy) {
  if (exact_gathered_layers(frame->config) < HBIL_LAYERS)
    return (abs(dx) == 2 ? 0.5 : 1.0) * (abs(dy) == 4 ? 0.5 : 1.0);
  const bool outer_x = abs(dx) == 2, outer_y = abs(dy) == 2;
  if (outer_x && outer_y)
    return dx == dy ? 0.5 : 0.0;
  return outer_x || outer_y ? 0.5 : 1.0;
}

static double guide_weight(const exact_frame *frame, const surface *s,
                           const exact_planes *split, int x, int y, int dx,
                           int dy) {
  const hbil_camera *camera = &frame->camera;
  const surface other = exact_surface_at(frame, split, x + dx, y + dy);
  if (!other.is)
    return 0.0;
  const double plane =
      s->w + s->slope_x * dx / camera->fx + s->slope_y * dy / camera->fy;
  const double off =
      fabs(other.w - plane) / ((double)HBIL_PLANE_TOLERANCE *
                               exact_depth_unit(frame->config, camera, s->w));
  const double bend =
      (1.0 - vec_dot(s->normal, other.normal)) / (double)HBIL_TURN_TOLERANCE;
  return fmax(0.0, 1.0 - off * off - bend);
}

/* Of a pixel that isn't gathered, the nearest ones that are have a least weight
 * if they show a surface. */
static double least_weight(const exact_frame *frame, const exact_planes *split,
                           int x, int y, int dx, int dy) {
  return !exact_is_gathered(frame->config, x, y) && abs(dx) < 2 &&
                 abs(dy) < 2 &&
                 exact_surface_at(frame, split, x + dx, y + dy).is
             ? (double)HBIL_LEAST_WEIGHT
             : 0.0;
}

static double tap_weight(const exact_frame *frame, const surface *s,
                         const exact_planes *split, int x, int y, int dx,
                         int dy) {
  if ((frame->config->sampling.unfiltered && (dx || dy)) ||
      !exact_is_gathered(frame->config, x + dx, y + dy))
    return 0.0;
  return spatial_weight(frame, dx, dy) *
         fmax(guide_weight(frame, s, split, x, y, dx, dy),
              least_weight(frame, split, x, y, dx, dy));
}

static void normalize_bent(exact_planes *resolved, int x, int y) {
  double *p[3], size = 0.0;
  for (int i = 0; i < 3; ++i) {
    p[i] = exact_at(resolved, HBIL_LIGHT_BENT + i, x, y);
    size += *p[i] * *p[i];
  }
  /* rounding leaves a length of 1e-12 where nothing is open */
  for (int i = 0; i < 3; ++i)
    *p[i] = size > 1e-24 ? *p[i] / sqrt(size) : 0.0;
}

/* Adds the estimated light of the share that is blocked by back-facing samples.
 * unknown: that share of the hemisphere. */
static void fill_unknown(const exact_frame *frame, const surface *s,
                         double unknown, int x, int y, exact_planes *resolved) {
  const double ao = *exact_at(resolved, HBIL_LIGHT_AO, x, y);
  for (int c = 0; c < 3; ++c) {
    double *light = exact_at(resolved, HBIL_LIGHT_RED + c, x, y);
    *light += PI * unknown *
              exact_unseen_radiance(frame, c, s->normal, *light / PI,
                                    fmax(0.0, 1.0 - ao - unknown), 0.0, 0.0);
  }
}

/* Adds a neighbour's lobe.  Returns the weight of the whole of it. */
static double add_lobe(const exact_planes *gathered, double weight, int x,
                       int y, int dx, int dy, exact_planes *resolved) {
  for (int p = EXACT_GLOSSY_PLANES; p < EXACT_GLOSSY_RESOLVED; ++p)
    *exact_at(resolved, p, x, y) +=
        weight * *exact_at(gathered, p, x + dx, y + dy);
  return weight * *exact_at(gathered, EXACT_GLOSSY_PLANES + HBIL_GLOSSY_WHOLE,
                            x + dx, y + dy);
}

/* Weighted squares of AO and of the channels of E_near, about their means;
 * these must be known. */
static void add_spread(const exact_planes *gathered, double ratio, int x, int y,
                       const double mean[HBIL_LIGHT_BENT], double square[2]) {
  for (int p = 0; p < HBIL_LIGHT_BENT; ++p) {
    const double off = *exact_at(gathered, p, x, y) - mean[p];
    square[p >= HBIL_LIGHT_RED] += ratio * off * off;
  }
}

/* A neighbour's weight in what is a ratio: AO and irradiance. */
static double ratio_weight(const exact_frame *frame,
                           const exact_planes *gathered, double weight, int x,
                           int y) {
  return exact_weighs_slices(frame->config)
             ? weight * *exact_at(gathered, HBIL_LIGHT_WEIGHT, x, y)
             : weight;
}

/* The errors of the means that `resolved` has, whose weights sum up to total.
 */
static void estimate_errors(const exact_frame *frame, const surface *s,
                            const exact_planes *split,
                            const exact_planes *gathered, double total, int x,
                            int y, exact_planes *resolved) {
  const int down = rows_below(frame);
  double mean[HBIL_LIGHT_BENT], square[2] = {0.0, 0.0};
  for (int p = 0; p < HBIL_LIGHT_BENT; ++p)
    mean[p] = *exact_at(resolved, p, x, y);
  for (int tap = 0; tap < 5 * (2 * down + 1); ++tap) {
    const int dx = tap % 5 - 2, dy = tap / 5 - down;
    const double weight = tap_weight(frame, s, split, x, y, dx, dy);
    if (weight > 0.0)
      add_spread(gathered,
                 ratio_weight(frame, gathered, weight, x + dx, y + dy), x + dx,
                 y + dy, mean, square);
  }
  for (int i = 0; i < 2; ++i)
    *exact_at(resolved, EXACT_RESOLVED_ERRORS + i, x, y) =
        frame->error_factors[i] * sqrt(square[i] / (total * (i ? 3.0 : 1.0)));
}

static void recompose_pixel(const exact_frame *frame, const exact_planes *split,
                            const exact_planes *gathered, int x, int y,
                            exact_planes *resolved) {
  const bool fills = exact_fills_unknown(frame->config);
  const bool glossy = exact_is_glossy(frame->config) &&
                      resolved->count >= EXACT_GLOSSY_RESOLVED;
  surface s = exact_surface_at(frame, split, x, y);
  double total =
      exact_is_gathered(frame->config, x, y) ? 0.0 : (double)HBIL_ALONE_WEIGHT;
  double unknown = 0.0, whole_lobe = 0.0;
  exact_planes_clear(resolved, x, y);
  *exact_at(resolved, HBIL_LIGHT_AO, x, y) = s.is ? total : 1.0;
  if (!s.is)
    return;
  exact_surface_slope(frame, split, x, y, &s);
  const int down = rows_below(frame);
  for (int tap = 0; tap < 5 * (2 * down + 1); ++tap) {
    const int dx = tap % 5 - 2, dy = tap / 5 - down;
    const double weight = tap_weight(frame, &s, split, x, y, dx, dy);
    if (!(weight > 0.0))
      continue;
    const double ratio = ratio_weight(frame, gathered, weight, x + dx, y + dy);
    total += ratio;
    for (int p = 0; p < HBIL_LIGHT_PLANES; ++p)
      *exact_at(resolved, p, x, y) += (p < HBIL_LIGHT_BENT ? ratio : weight) *
                                      *exact_at(gathered, p, x + dx, y + dy);
    if (fills)
      unknown +=
          ratio * *exact_at(gathered, HBIL_LIGHT_UNKNOWN, x + dx, y + dy);
    if (glossy)
      whole_lobe += add_lobe(gathered, weight, x, y, dx, dy, resolved);
  }
  for (int p = EXACT_GLOSSY_PLANES; glossy && p < EXACT_GLOSSY_RESOLVED; ++p)
    *exact_at(resolved, p, x, y) /= fmax(whole_lobe, DBL_MIN);
  for (int p = 0; p < HBIL_LIGHT_PLANES; ++p)
    *exact_at(resolved, p, x, y) /= total;
  if (resolved->count >= EXACT_RESOLVED_PLANES)
    estimate_errors(frame, &s, split, gathered, total, x, y, resolved);
  if (fills)
    fill_unknown(frame, &s, unknown / total, x, y, resolved);
  if (fills && resolved->count > HBIL_LIGHT_UNKNOWN)
    *exact_at(resolved, HBIL_LIGHT_UNKNOWN, x, y) = unknown / total;
  normalize_bent(resolved, x, y);
}

void exact_recompose(const exact_frame *frame, const exact_planes *split,
                     const exact_planes *gathered, exact_planes *resolved) {
  for (int y = 0; y < resolved->height; ++y)
    for (int x = 0; x < resolved->width; ++x)
      recompose_pixel(frame, split, gathered, x, y, resolved);
}
