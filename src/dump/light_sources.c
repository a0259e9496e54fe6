/* What the direct light of a first frame already contains. */
#include "dump/light_sources.h"

#include "dump/matrix3.h"
#include "dump/pixel_ray.h"

#include <math.h>

/* The sky counts as visible above this share of the pixels. */
#define SKY_SEEN 1e-3
/* Direct light contains the sky's if it reaches this share of the sky's
 * radiance.  Even a small window lets more in. */
#define LEAST_SKY 0.02
/* Direct light contains the lamps' if it reaches this share of what the lamps
 * would send without obstacles.  Half of the surfaces may be in shadow. */
#define LEAST_CONTAINED 0.5

static const double pi = 3.14159265358979;

/* ------------------------------------------------------------------------ */
/* The sky                                                                   */

static int is_sky(float depth, float sky_depth) {
  return !gbuffer_is_surface(depth, sky_depth);
}

/* The radiance of the visible sky: the mean of the square roots, squared, so
 * that the sun's disc counts for little.  0 if too little sky is visible. */
static void sky_radiance(const gbuffer *g, float sky_depth, float out[3]) {
  const float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  const size_t channels = g->map.count[ROLE_EMISSION];
  double sum[3] = {0};
  size_t sky = 0;
  for (size_t i = 0; i < pixels; i++) {
    double sum_here = 0;
    for (size_t c = 0; c < channels && c < 3; c++) {
      const double v = gbuffer_plane(g, ROLE_EMISSION, c)[i];
      if (is_sky(depth[i], sky_depth) && isfinite(v) && v > 0) {
        sum[c] += sqrt(v);
        sum_here += v;
      }
    }
    sky += sum_here > 0;
  }
  for (size_t c = 0; c < 3; c++) {
    const double root =
        sky && channels ? sum[c < channels ? c : 0] / (double)sky : 0;
    out[c] = (double)sky > SKY_SEEN * (double)pixels ? (float)(root * root) : 0;
  }
}

/* The radiance that direct light gives a white surface, at pixel i in channel
 * c; 0 if the file has no direct light. */
static double direct_light(const gbuffer *g, const hbil_config *config,
                           size_t c, size_t i) {
  const size_t channels = g->map.count[ROLE_DIRECT];
  const double v =
      channels ? gbuffer_plane(g, ROLE_DIRECT, c < channels ? c : 0)[i] : 0;
  return isfinite(v) && v > 0 ? v * config->inputs.direct_scale / pi : 0;
}

/* Whether direct light reaches LEAST_SKY of the sky's radiance at more than a
 * few pixels. */
static int contains_sky(const gbuffer *g, const hbil_config *config,
                        const float sky[3]) {
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  size_t bright = 0;
  for (size_t i = 0; i < pixels; i++)
    for (size_t c = 0; c < 3; c++)
      if (direct_light(g, config, c, i) > LEAST_SKY * sky[c] && sky[c] > 0) {
        bright++;
        break;
      }
  return (double)bright > SKY_SEEN * (double)pixels;
}

void far_field_choose(const gbuffer *first, hbil_config *config,
                      float environment[9][3], const char **reason) {
  float *sky = environment[0];
  sky_radiance(first, config->inputs.sky_depth, sky);
  config->model.far_field = HBIL_FAR_FRAME;
  if (!(sky[0] + sky[1] + sky[2] > 0))
    *reason =
        "the mean radiance of the frame's surfaces: no bright sky is visible";
  else if (contains_sky(first, config, sky))
    *reason =
        "the mean radiance of the frame's surfaces, where direct light is "
        "weaker than that of the visible sky";
  else {
    config->model.far_field = HBIL_FAR_CONSTANT;
    *reason =
        "the radiance of the visible sky, which direct light does not contain";
  }
}

/* ------------------------------------------------------------------------ */
/* Emission                                                                  */

/* A pixel's piece of surface, in view space. */
typedef struct patch {
  double at[3], normal[3], area;
} patch;

/* The pixel's unit normal in view space, facing the eye.  Returns 0 if it has
 * none. */
static int read_normal(const gbuffer *g, const hbil_config *config,
                       const hbil_camera *camera, size_t i, const double ray[3],
                       double out[3]) {
  double n[3];
  for (size_t c = 0; c < 3; c++)
    n[c] = gbuffer_plane(g, ROLE_NORMAL, c)[i];
  for (size_t c = 0; c < 3; c++) {
    const double *m = camera->world_from_view + c;
    out[c] = config->inputs.normal_space == HBIL_SPACE_VIEW
                 ? n[c]
                 : m[0] * n[0] + m[4] * n[1] + m[8] * n[2];
  }
  const double length = sqrt(matrix3_dot(out, out));
  const double sign = matrix3_dot(out, ray) > 0 ? -1 : 1;
  for (size_t c = 0; c < 3; c++)
    out[c] *= sign / length;
  return length > 0 && isfinite(length);
}

/* Returns 0 if the pixel shows no surface. */
static int read_patch(const gbuffer *g, const hbil_config *config,
                      const hbil_camera *camera, size_t i, patch *out) {
  const int parallel =
      config->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const pixel_ray look = pixel_ray_at(config->inputs.projection, camera,
                                      i % g->planes.width, i / g->planes.width);
  const double *ray = look.along;
  const float depth = gbuffer_plane(g, ROLE_DEPTH, 0)[i];
  if (is_sky(depth, config->inputs.sky_depth) ||
      !read_normal(g, config, camera, i, ray, out->normal))
    return 0;
  const double z = config->inputs.depth_kind == HBIL_DEPTH_RAY
                       ? depth / sqrt(matrix3_dot(ray, ray))
                       : depth;
  /* A pixel has the solid angle 1 / (fx fy |r|^3); with parallel rays, all
   * pixels have the same area.  A grazing surface may be of any size; it counts
   * as if it were tilted by a tenth of a radian. */
  const double grazing = 0.1 * sqrt(matrix3_dot(ray, ray));
  out->area =
      (parallel ? 1 : z * z) /
      (camera->fx * camera->fy * fmax(-matrix3_dot(out->normal, ray), grazing));
  for (size_t c = 0; c < 3; c++)
    out->at[c] = look.from[c] + z * ray[c];
  return 1;
}

/* The sum of a surface's emitted channels; 0 for the sky. */
static double emitted(const gbuffer *g, const hbil_config *config, size_t i) {
  double sum = 0;
  if (is_sky(gbuffer_plane(g, ROLE_DEPTH, 0)[i], config->inputs.sky_depth))
    return 0;
  for (size_t c = 0; c < g->map.count[ROLE_EMISSION]; c++)
    sum += gbuffer_plane(g, ROLE_EMISSION, c)[i];
  return isfinite(sum) && sum > 0 ? sum : 0;
}

/* A lamp: some neighbouring pixels that emit light, taken as one. */
typedef struct lamp {
  patch patch;
  double light[3];
} lamp;

enum { MOST_LAMPS = 512, MOST_RECEIVERS = 2048 };

/* Takes every n-th of the emitting pixels, so that at most MOST_LAMPS stand for
 * all of them. */
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

/* The radiance per albedo, summed over the channels, that a receiver would have
 * if nothing stood between it and the lamps. */
static double radiance_from_lamps(const lamp *lamps, size_t count,
                                  const patch *receiver) {
  double sum = 0;
  for (size_t i = 0; i < count; i++) {
    const lamp *l = &lamps[i];
    double to[3];
    for (size_t c = 0; c < 3; c++)
      to[c] = l->patch.at[c] - receiver->at[c];
    const double here = matrix3_dot(to, receiver->normal);
    const double there = -matrix3_dot(to, l->patch.normal);
    const double r2 = matrix3_dot(to, to);
    /* the formula is for points; closer than a lamp's size it is limited */
    if (here > 0 && there > 0)
      sum += (l->light[0] + l->light[1] + l->light[2]) * here * there *
             l->patch.area / (pi * r2 * fmax(r2, l->patch.area));
  }
  return sum;
}

/* The share of the lamps' light that direct light contains. */
static double explained(const gbuffer *g, const hbil_config *config,
                        const hbil_camera *camera, const lamp *lamps,
                        size_t count) {
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  double all = 0, contained = 0;
  for (size_t i = 0; i < pixels; i += pixels / MOST_RECEIVERS + 1) {
    patch receiver;
    if (emitted(g, config, i) > 0 ||
        !read_patch(g, config, camera, i, &receiver))
      continue;
    const double expected = radiance_from_lamps(lamps, count, &receiver);
    double direct = 0;
    for (size_t c = 0; c < 3; c++)
      direct += direct_light(g, config, c, i);
    all += expected;
    contained += fmin(direct, expected);
  }
  return all > 0 ? contained / all : 1;
}

void emission_choose(const gbuffer *first, const hbil_camera *camera,
                     hbil_config *config, const char **reason) {
  lamp lamps[MOST_LAMPS + 1];
  const size_t count =
      first->map.count[ROLE_EMISSION] && first->map.count[ROLE_NORMAL] == 3
          ? find_lamps(first, config, camera, lamps)
          : 0;
  *reason = NULL;
  config->model.gather_emission = CL_FALSE;
  if (count == 0)
    return;
  if (explained(first, config, camera, lamps, count) >= LEAST_CONTAINED)
    *reason = "not gathered: direct light contains it";
  else {
    config->model.gather_emission = CL_TRUE;
    *reason = "gathered: direct light does not contain it";
  }
}
