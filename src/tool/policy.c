/*
 * What to take for light that the screen doesn't show, when nobody says: a look
 * at the first frame.
 *
 * Unblocked directions end on surfaces outside the picture, and what the
 * frame's own surfaces send is a better guess than black; or they end in the
 * sky, whose light a renderer's direct diffuse light holds already.  Where a
 * lit sky is seen, its radiance tells the two apart: direct light below the
 * sky's shows what is hidden from it.  (Measured on public scenes, see
 * HACKING.md.)
 */
#include "tool/tool.h"

#include <math.h>
#include <stdio.h>

/* Share of background pixels above which a sky counts as seen. */
#define SKY_SEEN 1e-3
/* Share of the sky's radiance below which direct light hasn't got it: less than
 * what comes through a small window. */
#define LEAST_SKY 0.02
/* Share of the light of the lamps in the picture, as if nothing stood in its
 * way, that direct light must have to be theirs: half may be in shadow. */
#define LEAST_HELD 0.5

static const double pi = 3.14159265358979;

/* --- the sky --- */

static int is_background(float depth, float background) {
  return !(depth > 0.0f && depth < background && isfinite(depth));
}

/*
 * Radiance of the sky that is seen, the mean of square roots, squared: the
 * sun's disc is no measure of the sky.  0 where too little lit sky is seen.
 */
static void sky_radiance(const gbuffer *g, float background, float out[3]) {
  const float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  const size_t channels = g->map.count[ROLE_EMISSION];
  double sum[3] = {0};
  size_t sky = 0;
  for (size_t i = 0; i < pixels; i++) {
    double lit = 0;
    for (size_t c = 0; c < channels && c < 3; c++) {
      const double v = gbuffer_plane(g, ROLE_EMISSION, c)[i];
      if (is_background(depth[i], background) && isfinite(v) && v > 0) {
        sum[c] += sqrt(v);
        lit += v;
      }
    }
    sky += lit > 0;
  }
  for (size_t c = 0; c < 3; c++) {
    const double root =
        sky && channels ? sum[c < channels ? c : 0] / (double)sky : 0;
    out[c] = (double)sky > SKY_SEEN * (double)pixels ? (float)(root * root) : 0;
  }
}

/* Radiance of direct light at pixel i, channel c; 0 where the file does not
 * say. */
static double direct_light(const gbuffer *g, const hbil_config *config,
                           size_t c, size_t i) {
  const size_t channels = g->map.count[ROLE_DIRECT];
  const double v =
      channels ? gbuffer_plane(g, ROLE_DIRECT, c < channels ? c : 0)[i] : 0;
  return isfinite(v) && v > 0 ? v * config->direct_scale / pi : 0;
}

/* Whether direct light reaches LEAST_SKY of the sky's radiance anywhere, but
 * for a few pixels. */
static int holds_sky(const gbuffer *g, const hbil_config *config,
                     const float sky[3]) {
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  size_t lit = 0;
  for (size_t i = 0; i < pixels; i++)
    for (size_t c = 0; c < 3; c++)
      if (direct_light(g, config, c, i) > LEAST_SKY * sky[c] && sky[c] > 0) {
        lit++;
        break;
      }
  return (double)lit > SKY_SEEN * (double)pixels;
}

void policy_far_field(const gbuffer *first, hbil_config *config,
                      float environment[9][3], const char **reason) {
  float *sky = environment[0];
  sky_radiance(first, config->sky_depth, sky);
  config->far_field = HBIL_FAR_FRAME;
  if (!(sky[0] + sky[1] + sky[2] > 0))
    *reason = "what the frame's surfaces send: no lit sky is seen";
  else if (holds_sky(first, config, sky))
    *reason = "what the frame's surfaces send, as far as direct light is less "
              "than the sky's that is seen";
  else {
    config->far_field = HBIL_FAR_CONSTANT;
    *reason = "the sky's that is seen: direct light does not hold it";
  }
}

/* --- emission --- */

/* A pixel's patch of surface in view space. */
typedef struct patch {
  double at[3], normal[3], area;
} patch;

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The pixel's unit normal in view space, facing the eye; 0 if it has none. */
static int read_normal(const gbuffer *g, const hbil_config *config,
                       const hbil_camera *camera, size_t i, const double ray[3],
                       double out[3]) {
  double n[3];
  for (size_t c = 0; c < 3; c++)
    n[c] = gbuffer_plane(g, ROLE_NORMAL, c)[i];
  for (size_t c = 0; c < 3; c++) {
    const double *m = camera->world_from_view + c;
    out[c] = config->normal_space == HBIL_SPACE_VIEW
                 ? n[c]
                 : m[0] * n[0] + m[4] * n[1] + m[8] * n[2];
  }
  const double length = sqrt(dot(out, out));
  const double sign = dot(out, ray) > 0 ? -1 : 1;
  for (size_t c = 0; c < 3; c++)
    out[c] *= sign / length;
  return length > 0 && isfinite(length);
}

/* 0 where there is no surface. */
static int read_patch(const gbuffer *g, const hbil_config *config,
                      const hbil_camera *camera, size_t i, patch *out) {
  const int parallel = config->projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const gbuffer_ray look = gbuffer_look(
      config->projection, camera, i % g->planes.width, i / g->planes.width);
  const double *ray = look.along;
  const float depth = gbuffer_plane(g, ROLE_DEPTH, 0)[i];
  if (is_background(depth, config->sky_depth) ||
      !read_normal(g, config, camera, i, ray, out->normal))
    return 0;
  const double z = config->depth_kind == HBIL_DEPTH_RAY
                       ? depth / sqrt(dot(ray, ray))
                       : depth;
  /* A pixel's solid angle is 1 / (fx fy |r|^3), that of parallel rays is as
   * wide anywhere; a grazing one has any area, its tenth of a radian is enough.
   */
  const double grazing = 0.1 * sqrt(dot(ray, ray));
  out->area = (parallel ? 1 : z * z) /
              (camera->fx * camera->fy * fmax(-dot(out->normal, ray), grazing));
  for (size_t c = 0; c < 3; c++)
    out->at[c] = look.from[c] + z * ray[c];
  return 1;
}

/* Sum of the channels at a surface; 0 elsewhere. */
static double emitted(const gbuffer *g, const hbil_config *config, size_t i) {
  double sum = 0;
  if (is_background(gbuffer_plane(g, ROLE_DEPTH, 0)[i], config->sky_depth))
    return 0;
  for (size_t c = 0; c < g->map.count[ROLE_EMISSION]; c++)
    sum += gbuffer_plane(g, ROLE_EMISSION, c)[i];
  return isfinite(sum) && sum > 0 ? sum : 0;
}

/* A lamp: some neighbouring pixels of emission, seen as one. */
typedef struct lamp {
  patch patch;
  double light[3];
} lamp;

enum { MOST_LAMPS = 512, MOST_RECEIVERS = 2048 };

/* Every so many of the pixels that emit, so that MOST_LAMPS stand for all. */
static size_t find_lamps(const gbuffer *g, const hbil_config *config,
                         const hbil_camera *camera, lamp *out) {
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  size_t emitting = 0, count = 0, seen = 0;
  for (size_t i = 0; i < pixels; i++)
    emitting += emitted(g, config, i) > 0;
  const size_t stride = emitting / MOST_LAMPS + 1;
  for (size_t i = 0; i < pixels; i++) {
    lamp *l = &out[count];
    if (!(emitted(g, config, i) > 0) || seen++ % stride ||
        !read_patch(g, config, camera, i, &l->patch))
      continue;
    l->patch.area *= (double)stride;
    for (size_t c = 0; c < 3; c++) {
      const size_t channels = g->map.count[ROLE_EMISSION];
      const double v = gbuffer_plane(g, ROLE_EMISSION, c < channels ? c : 0)[i];
      l->light[c] = isfinite(v) && v > 0 ? v : 0;
    }
    count++;
  }
  return count;
}

/* Radiance (per albedo) that a receiver would send if nothing stood between it
 * and the lamps, all channels together. */
static double lit_by(const lamp *lamps, size_t count, const patch *receiver) {
  double sum = 0;
  for (size_t i = 0; i < count; i++) {
    const lamp *l = &lamps[i];
    double to[3];
    for (size_t c = 0; c < 3; c++)
      to[c] = l->patch.at[c] - receiver->at[c];
    const double here = dot(to, receiver->normal);
    const double there = -dot(to, l->patch.normal);
    const double r2 = dot(to, to);
    /* within a lamp's own size the formula for points ends */
    if (here > 0 && there > 0)
      sum += (l->light[0] + l->light[1] + l->light[2]) * here * there *
             l->patch.area / (pi * r2 * fmax(r2, l->patch.area));
  }
  return sum;
}

/* Share of the lamps' light that direct light accounts for. */
static double explained(const gbuffer *g, const hbil_config *config,
                        const hbil_camera *camera, const lamp *lamps,
                        size_t count) {
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  double all = 0, held = 0;
  for (size_t i = 0; i < pixels; i += pixels / MOST_RECEIVERS + 1) {
    patch receiver;
    if (emitted(g, config, i) > 0 ||
        !read_patch(g, config, camera, i, &receiver))
      continue;
    const double expected = lit_by(lamps, count, &receiver);
    double direct = 0;
    for (size_t c = 0; c < 3; c++)
      direct += direct_light(g, config, c, i);
    all += expected;
    held += fmin(direct, expected);
  }
  return all > 0 ? held / all : 1;
}

void policy_emission(const gbuffer *first, const hbil_camera *camera,
                     hbil_config *config, const char **reason) {
  lamp lamps[MOST_LAMPS + 1];
  const size_t count =
      first->map.count[ROLE_EMISSION] && first->map.count[ROLE_NORMAL] == 3
          ? find_lamps(first, config, camera, lamps)
          : 0;
  *reason = NULL;
  config->gather_emission = CL_FALSE;
  if (count == 0)
    return;
  if (explained(first, config, camera, lamps, count) >= LEAST_HELD)
    *reason = "not gathered: direct light holds it";
  else {
    config->gather_emission = CL_TRUE;
    *reason = "gathered: direct light does not hold it";
  }
}
