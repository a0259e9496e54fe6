/* Whether a frame's normals fit its depth. */
#include "dump/normal_fit.h"

#include <math.h>

/* The normal, facing the eye, of the surface through four pixels at a distance
 * of `step`.  Returns 0 if there is none. */
static int gradient(const normal_fit *f, size_t x, size_t y, size_t step,
                    int other, double out[3]) {
  double left[3], right[3], up[3], down[3], a[3], b[3];
  surface_point(&f->s, x - step, y, other, left);
  surface_point(&f->s, x + step, y, other, right);
  surface_point(&f->s, x, y - step, other, up);
  surface_point(&f->s, x, y + step, other, down);
  for (int c = 0; c < 3; c++) {
    a[c] = right[c] - left[c];
    b[c] = down[c] - up[c];
  }
  out[0] = a[2] * b[1] - a[1] * b[2];
  out[1] = a[0] * b[2] - a[2] * b[0];
  out[2] = a[1] * b[0] - a[0] * b[1];
  const double length = sqrt(matrix3_dot(out, out));
  for (int c = 0; c < 3; c++)
    out[c] /= length;
  return length > 0.0 && isfinite(length);
}

/* What of a depth is linear over the picture of a plane. */
static double straightened(const normal_fit *f, double z) {
  return surface_rays_are_parallel(&f->s) ? z : 1 / z;
}

/* Whether three depths in a row belong to one smooth surface: they lie on a
 * line, or are bent by less than a tenth of their own difference.  1e-3 is the
 * relative precision that half floats leave. */
static int is_smooth(const normal_fit *f, double before, double here,
                     double after) {
  if (!(before > 0 && here > 0 && after > 0))
    return 0;
  const double a = straightened(f, before), b = straightened(f, here);
  const double c = straightened(f, after);
  return fabs(a + c - 2 * b) <= 0.1 * fabs(c - a) + 1e-3 * b;
}

static int read_normal(const gbuffer *g, size_t i, double out[3]) {
  for (size_t c = 0; c < 3; c++)
    out[c] = (double)gbuffer_plane(g, ROLE_NORMAL, c)[i];
  const double length = sqrt(matrix3_dot(out, out));
  for (int c = 0; c < 3; c++)
    out[c] /= length;
  return length > 0.0 && isfinite(length);
}

static void measure_pixel(normal_fit *f, size_t x, size_t y, size_t step) {
  double n[3], planar[3], other[3];
  const double z = surface_depth(&f->s, x, y);
  const float *coverage = gbuffer_plane(f->s.g, ROLE_COVERAGE, 0);
  /* at edges, depth may be that of both sides */
  if (coverage && coverage[y * f->s.g->planes.width + x] < 0.999f)
    return;
  if (!is_smooth(f, surface_depth(&f->s, x - step, y), z,
                 surface_depth(&f->s, x + step, y)) ||
      !is_smooth(f, surface_depth(&f->s, x, y - step), z,
                 surface_depth(&f->s, x, y + step)) ||
      !read_normal(f->s.g, y * f->s.g->planes.width + x, n) ||
      !gradient(f, x, y, step, 0, planar) || !gradient(f, x, y, step, 1, other))
    return;
  matrix3_add_outer(&f->planar, planar, n);
  matrix3_add_outer(&f->other, other, n);
  f->count++;
}

/* Gradients over a two-hundredth of the picture outweigh the rounding of half
 * floats. */
normal_fit normal_fit_measure(const surface_points *s) {
  normal_fit f = {.s = *s};
  const size_t width = s->g->planes.width, height = s->g->planes.height;
  const size_t stride = (width < height ? width : height) / 100 + 1;
  const size_t step = width / 200 + 1;
  for (size_t y = step; y + step < height; y += stride)
    for (size_t x = step; x + step < width; x += stride)
      measure_pixel(&f, x, y, step);
  return f;
}

double normal_fit_cosine(const normal_fit *f, const matrix3 *sum,
                         const matrix3 *h) {
  return matrix3_inner(sum, h) / f->count;
}

matrix3 normal_fit_view_if(const normal_fit *f, dump_space space,
                           unsigned flips) {
  const channel_map *map = &f->s.g->map;
  channel_map other = *map;
  float would_be[3];
  matrix3 out = surface_view_from(&f->s, space);
  other.how.flips = flips;
  channel_map_signs(&other, space, would_be);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      out.m[i][j] *= (double)would_be[j];
  return out;
}

/* On real dumps the wrong depth is off by ten times as much as the right one.
 * 1e-3, a mean of 3 degrees, is what the wrong one comes to in a field of view
 * of 17 degrees. */
int normal_fit_is_other_depth(const normal_fit *f, const matrix3 *h) {
  const double off = 1.0 - normal_fit_cosine(f, &f->planar, h);
  const double other = 1.0 - normal_fit_cosine(f, &f->other, h);
  return off > 1e-3 && 3.0 * other < off;
}

int normal_looks_encoded(const double n[3]) {
  double e[3];
  for (int c = 0; c < 3; c++) {
    if (n[c] < 0.0 || n[c] > 1.0)
      return 0;
    e[c] = 2.0 * n[c] - 1.0;
  }
  /* 0.05: eight bits round each component to 0.004 */
  return fabs(sqrt(matrix3_dot(e, e)) - 1.0) < 0.05 &&
         fabs(sqrt(matrix3_dot(n, n)) - 1.0) > 0.01;
}
