/* Which pixels of a picture of direct light show lamps. */
#include "dump/lamps.h"

#include "dump/pixel_ray.h"
#include "dump/surface_points.h"

#include <math.h>
#include <stdlib.h>

/* Lamps are brighter than what they light by this factor at least.  A surface
 * that sees nothing but a lamp would be as bright; ordinary lamps fill little
 * of what surfaces see. */
static const float gap = 4.0f;

/* Lamps fill this share of the surfaces at most. */
static const double most_lamps = 0.2;

/* Pixels of lamps and of other surfaces that are looked at. */
enum { LAMPS = 200, RECEIVERS = 500 };

/* Light fits lamps if it is theirs within this factor, for at least this share
 * of what they send; the rest may lie in shadow. */
#define FACTOR 1.5
#define LEAST_FITTING 0.4

static float largest(const gbuffer *g, size_t i, int over_albedo) {
  float most = 0.0f;
  for (size_t c = 0; c < g->map.count[ROLE_DIRECT]; c++) {
    const float *albedo = gbuffer_plane(g, ROLE_ALBEDO, c);
    const float radiance = gbuffer_plane(g, ROLE_DIRECT, c)[i];
    const float by = over_albedo && albedo ? albedo[i] : 1.0f;
    if (by > 0.0f)
      most = fmaxf(most, radiance / by);
  }
  return most;
}

/* ------------------------------------------------------------------------ */
/* A gap in brightness                                                       */

/* Whether the radiance is even around the pixel, as it is on a lamp and not at
 * its edge, nor in the noise of single samples. */
static int is_even(const gbuffer *g, size_t x, size_t y) {
  const size_t width = g->planes.width;
  const float here = largest(g, y * width + x, 0);
  const float *coverage = gbuffer_plane(g, ROLE_COVERAGE, 0);
  for (size_t v = y - 1; v <= y + 1; v++)
    for (size_t u = x - 1; u <= x + 1; u++) {
      const float there = largest(g, v * width + u, 0);
      if (!(there <= 1.5f * here && here <= 1.5f * there) ||
          (coverage && coverage[v * width + u] < 0.999f))
        return 0;
    }
  return 1;
}

static int descending(const void *a, const void *b) {
  const float x = *(const float *)a, y = *(const float *)b;
  return (x < y) - (x > y);
}

/* The middle of the widest gap in the brightest of sorted values; 0 if none is
 * wide enough. */
static float find_gap(const float *light, size_t count) {
  float widest = gap, middle = 0.0f;
  for (size_t i = 0; (double)i < most_lamps * (double)count; i++)
    if (i + 1 < count && light[i + 1] > 0.0f &&
        light[i] / light[i + 1] >= widest) {
      widest = light[i] / light[i + 1];
      middle = sqrtf(light[i] * light[i + 1]);
    }
  return middle;
}

static float brightness_of_lamps(const surface_points *s) {
  const gbuffer *g = s->g;
  const float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  const size_t width = g->planes.width, height = g->planes.height;
  float *light = malloc(sizeof *light * (gbuffer_pixels(g) + 1)), found = 0.0f;
  size_t count = 0;
  for (size_t y = 1; light && y + 1 < height; y++)
    for (size_t x = 1; x + 1 < width; x++)
      if (surface_is_shown(s, depth[y * width + x]) && is_even(g, x, y))
        light[count++] = largest(g, y * width + x, 1);
  if (light && count) {
    qsort(light, count, sizeof *light, descending);
    found = find_gap(light, count);
  }
  free(light);
  return found;
}

/* ------------------------------------------------------------------------ */
/* Whether the gap separates lamps from what they light                      */

/* A pixel's piece of surface in view space. */
typedef struct patch {
  double at[3], normal[3], area, light;
} patch;

/* Returns 0 if the pixel shows no surface with a normal. */
static int make_patch(const surface_points *s, const matrix3 *h, size_t i,
                      int over_albedo, patch *out) {
  const size_t x = i % s->g->planes.width, y = i / s->g->planes.width;
  const pixel_ray ray = pixel_ray_at(s->g->map.projection, s->camera, x, y);
  const double z = surface_depth(s, x, y);
  double n[3];
  for (size_t c = 0; c < 3; c++)
    n[c] = (double)gbuffer_plane(s->g, ROLE_NORMAL, c)[i];
  for (int c = 0; c < 3; c++)
    out->normal[c] = matrix3_dot(h->m[c], n);
  const double length = sqrt(matrix3_dot(n, n));
  const double side = surface_rays_are_parallel(s) ? 1 : z;
  if (!(z > 0.0) || !(length > 0.0))
    return 0;
  for (int c = 0; c < 3; c++)
    out->normal[c] /= length;
  surface_point(s, x, y, 0, out->at);
  /* 0.05: steeper surfaces are too large to be a point */
  out->area = side * side / (s->camera->fx * s->camera->fy) /
              fmax(0.05, fabs(matrix3_dot(out->normal, ray.along)));
  out->light = (double)largest(s->g, i, over_albedo);
  return 1;
}

/* Irradiance / pi at b from lamp a, without obstacles. */
static double light_between(const patch *a, const patch *b) {
  double to[3], distance2 = a->area; /* never nearer than its own size */
  for (int c = 0; c < 3; c++)
    to[c] = a->at[c] - b->at[c];
  distance2 = fmax(distance2, matrix3_dot(to, to));
  const double received = matrix3_dot(b->normal, to);
  const double sent = -matrix3_dot(a->normal, to);
  return received > 0.0 && sent > 0.0 ? a->light * a->area * received * sent /
                                            (distance2 * distance2) / 3.14159265
                                      : 0.0;
}

/* Whether other surfaces have the light that these lamps send. */
static int light_fits(const patch *lamps, size_t lamp_count, double each,
                      const patch *others, size_t other_count) {
  double sent = 0.0, fitting = 0.0;
  for (size_t i = 0; i < other_count; i++) {
    double light = 0.0;
    for (size_t k = 0; k < lamp_count; k++)
      light += each * light_between(&lamps[k], &others[i]);
    sent += light;
    if (others[i].light > light / FACTOR && others[i].light < light * FACTOR)
      fitting += light;
  }
  return fitting > LEAST_FITTING * sent;
}

/* Every n-th pixel that is a lamp, or isn't one. */
static size_t make_patches(const surface_points *s, float from, int lamps,
                           size_t step, patch *out, size_t most) {
  const matrix3 h = surface_view_from_normals(s);
  size_t seen = 0, count = 0;
  for (size_t i = 0; i < gbuffer_pixels(s->g) && count < most; i++)
    if ((largest(s->g, i, 1) >= from) == lamps && seen++ % step == 0)
      count += (size_t)make_patch(s, &h, i, !lamps, &out[count]);
  return count;
}

static size_t count_lamps(const gbuffer *g, float from) {
  size_t count = 0;
  for (size_t i = 0; i < gbuffer_pixels(g); i++)
    count += largest(g, i, 1) >= from;
  return count;
}

float lamps_find(const gbuffer *g) {
  const surface_points s = surface_points_of(g, &g->map.camera);
  const float from = brightness_of_lamps(&s);
  if (!(from > 0.0f) || !g->map.count[ROLE_NORMAL])
    return 0.0f;
  const size_t bright = count_lamps(g, from);
  const size_t step = bright / LAMPS + 1;
  const size_t stride = (gbuffer_pixels(g) - bright) / RECEIVERS + 1;
  patch *all = malloc(sizeof *all * (LAMPS + RECEIVERS));
  if (!all)
    return 0.0f;
  const size_t lamps = make_patches(&s, from, 1, step, all, LAMPS);
  const size_t others =
      make_patches(&s, from, 0, stride, all + LAMPS, RECEIVERS);
  const int fits = light_fits(all, lamps, (double)step, all + LAMPS, others);
  free(all);
  return fits ? from : 0.0f;
}
