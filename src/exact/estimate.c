/*
 * The estimate of unseen light: what surfaces that the screen does not show
 * send, guessed from those that it shows.
 *
 * A surfel with normal m counts for a receiver with normal n by how much they
 * face each other.  With c = -m.n the weight is the clamped cosine convolved
 * with itself, to order 2; a clamped cosine has the bands 1, 2/3, 1/4 relative
 * to the first, so that is 1 + 3 (2/3)^2 P1(c) + 5 (1/4)^2 P2(c) =
 * 1 + 4/3 P1 + 5/16 P2.  It is -0.02 at c = -1; HBIL_UNSEEN_EVEN more makes it
 * positive.  The addition theorem splits P1 and P2 into products of polynomials
 * of n and of -m, so nine sums over the frame are enough for every receiver.
 *
 * The sums are of the first bounce.  What a mean surface receives then is the
 * shown share s of its hemisphere with the mean radiance L after all bounces,
 * and the guessed share u with unseen_light times L.  So with the mean
 * reflectance rho, the gain is g = rho (s + unseen_light u), and the mean
 * radiance after all bounces is L = M / (1 - g); M is that of the first.  The
 * guess has that from the first frame on, and near light gets there one bounce
 * a frame: without history it is M = L - g L, and what it lacks shrinks by rho
 * s with each bounce.  Where surfaces see less direct light than the mean one
 * sends, near light lacks less (coming_share()).
 */
#include "exact/estimate.h"

#include <float.h>
#include <string.h>

#include "exact/camera.h"
#include "exact/input.h"
#include "exact/passes.h"
#include "exact/settings.h"
#include "exact/sky_light.h"
#include "exact/surface.h"

/* Sums over some of the pixels. */
typedef struct sums {
  double light[3][9], weight[9]; /* times the polynomials of -m */
  double reflectance[3];
  double near[3];              /* E_near / pi */
  double open, behind;         /* shares of the hemisphere */
  double dark, unlit, unlit_2; /* pixels that show how much sky they see: the
                                  open share, times what is unlit, squared */
  double lit, lit_open;        /* the others, and their open share */
} sums;

/* Those of the spherical harmonics of bands 0 to 2, without their factors. */
static void polynomials(vec3 d, double p[9]) {
  const double values[9] = {1.0,
                            d.y,
                            d.z,
                            d.x,
                            d.x * d.y,
                            d.y * d.z,
                            3.0 * d.z * d.z - 1.0,
                            d.z * d.x,
                            d.x * d.x - d.y * d.y};
  memcpy(p, values, sizeof(values));
}

/* The mean AO of the four pixels of a row that a pixel belongs to, as far as
 * they show a surface and are gathered.  A single pixel looks along few
 * directions, and what exact_unlit_part() makes of its noise isn't its mean. */
static double open_row(const exact_frame *frame, const exact_planes *split,
                       const exact_planes *gathered, int x, int y) {
  const bool weighs =
      gathered->count > HBIL_LIGHT_WEIGHT && exact_weighs_slices(frame->config);
  double open = 0.0, total = 0.0;
  for (int i = x / 4 * 4; i < x / 4 * 4 + 4 && i < split->width; ++i) {
    const double weight =
        weighs ? *exact_at(gathered, HBIL_LIGHT_WEIGHT, i, y) : 1.0;
    if (!exact_is_gathered(frame->config, i, y) ||
        !exact_is_surface(frame->config, *exact_at(split, HBIL_SPLIT_W, i, y)))
      continue;
    open += weight * *exact_at(gathered, HBIL_LIGHT_AO, i, y);
    total += weight;
  }
  return open / total;
}

/* open: open_row(). */
static void add_surfel(sums *t, const exact_frame *frame, const surface *s,
                       const exact_planes *gathered, double open, int x,
                       int y) {
  double p[9], lit;
  const double unlit =
      exact_unlit_part(exact_sky_light(frame, x, y), open, &lit);
  polynomials(vec_scale(-1.0, s->normal), p);
  for (int c = 0; c < 3; ++c) {
    const double reflectance =
        exact_transmittance(frame, c, x, y) * exact_albedo(frame, c, x, y);
    const double sent = reflectance / PI * exact_direct(frame, c, x, y) +
                        exact_gathered_emission(frame, c, x, y);
    for (int i = 0; i < 9; ++i)
      t->light[c][i] += sent * p[i];
    t->reflectance[c] += reflectance;
    t->near[c] += *exact_at(gathered, HBIL_LIGHT_RED + c, x, y) / PI;
  }
  for (int i = 0; i < 9; ++i)
    t->weight[i] += p[i];
  t->open += *exact_at(gathered, HBIL_LIGHT_AO, x, y);
  if (gathered->count > HBIL_LIGHT_UNKNOWN &&
      exact_fills_unknown(frame->config))
    t->behind += *exact_at(gathered, HBIL_LIGHT_UNKNOWN, x, y);
  t->dark += (1.0 - lit) * open;
  t->unlit += (1.0 - lit) * open * unlit;
  t->unlit_2 += (1.0 - lit) * open * unlit * unlit;
  t->lit += lit;
  t->lit_open += lit * open;
}

static sums sums_of_part(const exact_frame *frame, const exact_planes *split,
                         const exact_planes *gathered, int part) {
  const int column = part % 4, row = part / 4 % 4;
  sums t;
  memset(&t, 0, sizeof(t));
  for (int y = 4 * hbil_estimate_row(part) + row; y < split->height; y += 16)
    for (int x = column; x < split->width; x += 4) {
      const surface s = exact_surface_at(frame, split, x, y);
      if (s.is && exact_is_gathered(frame->config, x, y) &&
          hbil_estimate_uses(x / 4 / HBIL_ESTIMATE_BLOCK, y))
        add_surfel(&t, frame, &s, gathered,
                   open_row(frame, split, gathered, x, y), x, y);
    }
  return t;
}

static double radiance_of(const sums *t) {
  return t->light[0][0] + t->light[1][0] + t->light[2][0];
}

/* Adds up the parts.  The radiance of one that sends far more than typical
 * parts, whose mean is that of eighth roots, is scaled down. */
static sums sums_of_frame(const exact_frame *frame, const exact_planes *split,
                          const exact_planes *gathered) {
  sums part[HBIL_ESTIMATE_PARTS], total;
  double roots = 0.0, surfaces = 0.0;
  memset(&total, 0, sizeof(total));
  for (int i = 0; i < HBIL_ESTIMATE_PARTS; ++i) {
    part[i] = sums_of_part(frame, split, gathered, i);
    roots += part[i].weight[0] *
             pow(radiance_of(&part[i]) / fmax(part[i].weight[0], 1.0), 0.125);
    surfaces += part[i].weight[0];
  }
  const double typical = pow(roots / fmax(surfaces, 1.0), 8.0);
  for (int i = 0; i < HBIL_ESTIMATE_PARTS; ++i) {
    const double most = (double)HBIL_UNSEEN_SPIKE * typical * part[i].weight[0];
    const double radiance = radiance_of(&part[i]);
    const double scale = radiance > most ? most / radiance : 1.0;
    for (int k = 0; k < 27; ++k)
      part[i].light[k / 9][k % 9] *= scale;
    /* nothing but doubles */
    for (size_t k = 0; k < sizeof(sums) / sizeof(double); ++k)
      ((double *)&total)[k] += ((const double *)&part[i])[k];
  }
  return total;
}

/* The share of what near light lacks that is to come.  Surfaces see r times
 * the light that they would see if all were like the mean one.  After the
 * second bounce r returns to 1 but for HBIL_UNSEEN_COUPLING of the
 * difference. */
static double coming_share(double seen, double expected, double shown,
                           double unseen, double reflectance) {
  const double r = fmin(seen / fmax(expected, DBL_MIN), 1.0);
  const double later = 1.0 - (double)HBIL_UNSEEN_COUPLING * (1.0 - r);
  return (r * shown + unseen) / fmax(shown + unseen, DBL_MIN) *
         (1.0 - reflectance) / (1.0 - later * reflectance);
}

void exact_estimate_frame(exact_frame *frame, const exact_planes *split,
                          const exact_planes *gathered) {
  exact_estimate *e = &frame->estimate;
  const sums t = sums_of_frame(frame, split, gathered);
  const double surfaces = fmax(t.weight[0], 1.0);
  const double unseen = (double)frame->config->model.offscreen_light;
  const double shown = fmax(0.0, 1.0 - (t.open + t.behind) / surfaces);
  memset(e, 0, sizeof(*e));
  if (!(t.weight[0] > 0.0))
    return;
  e->sun = clamp((t.lit / surfaces - (double)HBIL_SUN_NONE) /
                     (double)(HBIL_SUN_FULL - HBIL_SUN_NONE),
                 0.0, 1.0);
  e->unlit = t.unlit / fmax(t.dark + (double)HBIL_DARK_PRIOR * t.open, DBL_MIN);
  const double lit_pixels =
      t.lit_open * e->unlit * (e->unlit + e->sun * (1.0 - e->unlit));
  const double guessed =
      t.behind +
      (1.0 - exact_sky_share(frame)) *
          (e->sun * t.unlit + (1.0 - e->sun) * t.unlit_2 + lit_pixels);
  for (int c = 0; c < 3; ++c) {
    const double reflectance = t.reflectance[c] / surfaces;
    const double gain =
        fmin(reflectance * (shown + unseen * guessed / surfaces),
             (double)HBIL_UNSEEN_GAIN);
    /* near light that contains guessed light has all bounces of that already */
    const double lacks =
        exact_fills_unknown(frame->config)
            ? 0.0
            : gain * pow(reflectance * shown, (double)frame->bounces);
    const double radiance = t.light[c][0] / surfaces / (1.0 - gain);
    const double expected = shown * (1.0 - lacks) * radiance;
    const double coming = coming_share(
        t.near[c] / surfaces, expected, shown, unseen * guessed / surfaces,
        fmin(reflectance * shown, (double)HBIL_UNSEEN_GAIN));
    e->lacks[c] = coming * lacks * radiance;
    for (int i = 0; i < 9; ++i)
      e->light[c][i] = t.light[c][i] / (1.0 - gain);
  }
  memcpy(e->weight, t.weight, sizeof(t.weight));
}

/* The sum of weight(c) over the surfels.  Multiplied out in the polynomials,
 * 5/16 P2 has the factors 15/16, 5/64 (of 3zz-1) and 15/64 (of xx-yy). */
static double weighted_sum(const double sum[9], vec3 n) {
  const double factor[9] = {1.0 + (double)HBIL_UNSEEN_EVEN,
                            4.0 / 3.0,
                            4.0 / 3.0,
                            4.0 / 3.0,
                            15.0 / 16,
                            15.0 / 16,
                            5.0 / 64.0,
                            15.0 / 16.0,
                            15.0 / 64.0};
  double p[9], total = 0.0;
  polynomials(n, p);
  for (int i = 0; i < 9; ++i)
    total += factor[i] * sum[i] * p[i];
  return total;
}

static double frame_radiance(const exact_frame *frame, int channel, vec3 n) {
  const double light = weighted_sum(frame->estimate.light[channel], n);
  const double weight = weighted_sum(frame->estimate.weight, n);
  return weight > 0.0 ? fmax(0.0, light) / weight : 0.0;
}

double exact_frame_radiance(const exact_frame *frame, int channel,
                            const double normal[3]) {
  return frame_radiance(frame, channel, vec(normal[0], normal[1], normal[2]));
}

double exact_unseen_radiance(const exact_frame *frame, int channel, vec3 normal,
                             double shown, double share, double cached,
                             double cached_share) {
  const double prior = (double)HBIL_UNSEEN_PRIOR;
  const double weight = prior * (double)frame->config->model.offscreen_light;
  return (shown + share * frame->estimate.lacks[channel] + cached +
          weight * frame_radiance(frame, channel, normal)) /
         (share + cached_share + prior);
}
