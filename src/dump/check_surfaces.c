/* Checks that depths are those of surfaces. */
#include "dump/check_surfaces.h"

#include "dump/pixel_ray.h"
#include "dump/selection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/*
 * A frame's depths in which planes are linear: 1/z with perspective, z with
 * parallel rays; NaN where there is no surface.
 *
 * Five pixels in a row that are a surface, a pixel, and another surface tell
 * two things.  A line through the first two and one through the last two meet
 * the pixel between them.  If both lines are far apart, an edge is there, and
 * the pixel must lie on one of them: in a mean of both sides it doesn't.  If
 * all five are on one surface, the pixel lies on the line of its neighbours,
 * but for curves and noise.  Noise alone makes fourth differences that are
 * larger than second ones, by a factor of 3.4.
 */
typedef struct depth_lines {
  const surface_points *s;
  matrix3 view_from_normals;
  double *second, *fourth; /* differences, in widths of a pixel */
  size_t smooth;           /* how many */
  size_t clean, mixed;     /* edges without and with a pixel between */
} depth_lines;

/* Widths of a pixel that lie between both sides of an edge, at least. */
static const double edge_depth = 6.0;
/* A pixel belongs to a side if it is off by less than this share of the way to
 * the other one. */
static const double same_side = 0.1;
/* Pixels of smooth surfaces are off by less, in widths of a pixel. */
static const double most_scatter = 6.0;

static double depth_at(const surface_points *s, size_t i) {
  const size_t width = s->g->planes.width;
  const double z = surface_depth(s, i % width, i / width);
  return !(z > 0.0) ? NAN : surface_rays_are_parallel(s) ? z : 1.0 / z;
}

/* The change of a depth that is a pixel's width at this depth. */
static double pixel_width(const surface_points *s, double depth) {
  return (surface_rays_are_parallel(s) ? 1.0 : depth) / s->camera->fx;
}

static void point_of(const surface_points *s, const pixel_ray *ray,
                     double depth, double out[3]) {
  const double z = surface_rays_are_parallel(s) ? depth : 1.0 / depth;
  for (int c = 0; c < 3; c++)
    out[c] = ray->from[c] + z * ray->along[c];
}

/* Whether the plane of one pixel, by its normal, comes near another one. */
static int plane_meets(const depth_lines *l, size_t one, size_t other,
                       double near) {
  const size_t width = l->s->g->planes.width;
  const hbil_projection projection = l->s->g->map.projection;
  const hbil_camera *camera = l->s->camera;
  const pixel_ray ray =
      pixel_ray_at(projection, camera, one % width, one / width);
  const pixel_ray to =
      pixel_ray_at(projection, camera, other % width, other / width);
  double n[3], normal[3], p[3];
  for (int c = 0; c < 3; c++)
    n[c] = (double)gbuffer_plane(l->s->g, ROLE_NORMAL, (size_t)c)[one];
  for (int c = 0; c < 3; c++)
    normal[c] = matrix3_dot(l->view_from_normals.m[c], n);
  point_of(l->s, &ray, depth_at(l->s, one), p);
  const double z = (matrix3_dot(normal, p) - matrix3_dot(normal, to.from)) /
                   matrix3_dot(normal, to.along);
  const double there = surface_rays_are_parallel(l->s) ? z : 1.0 / z;
  return fabs(there - depth_at(l->s, other)) < near;
}

/* Pixel i between i - step and i + step, with an edge so deep around it. */
static int is_on_a_side(const depth_lines *l, size_t i, size_t step,
                        double gap) {
  const double near = same_side * gap;
  return l->s->g->map.count[ROLE_NORMAL] >= 3 &&
         (plane_meets(l, i, i - step, near) ||
          plane_meets(l, i, i + step, near) ||
          plane_meets(l, i - step, i, near) ||
          plane_meets(l, i + step, i, near));
}

/* at: where the pixel's depth is on the way from one side, 0, to the other. */
static void measure_edge(depth_lines *l, size_t i, size_t step, double at,
                         double gap) {
  if (fabs(at) < same_side || fabs(at - 1.0) < same_side)
    l->clean++;
  else if (at > 0.0 && at < 1.0 && !is_on_a_side(l, i, step, fabs(gap)))
    l->mixed++;
}

/* depth: of five pixels in a row or a column, about pixel i. */
static void measure_five(depth_lines *l, size_t i, size_t step,
                         const double depth[5]) {
  const double a = depth[0], b = depth[1], c = depth[2], d = depth[3],
               e = depth[4];
  const double before = 2 * b - a, gap = 2 * d - e - before;
  const double unit = pixel_width(l->s, fmin(b, d));
  const double bent = fabs(b + d - 2 * c) / unit;
  if (isnan(a + b + c + d + e))
    return;
  if (fabs(gap) > edge_depth * unit && fabs(a - b) < 0.2 * fabs(gap) &&
      fabs(d - e) < 0.2 * fabs(gap))
    measure_edge(l, i, step, (c - before) / gap, gap);
  if (!(bent < most_scatter))
    return;
  l->second[l->smooth] = bent;
  l->fourth[l->smooth] = fabs(a - 4 * b + 6 * c - 4 * d + e) / unit;
  l->smooth++;
}

/* Rounding to half floats makes steps, which aren't noise. */
static int depths_are_halves(const surface_points *s) {
  const float *stored = gbuffer_plane(s->g, ROLE_DEPTH, 0);
  for (size_t i = 0; i < gbuffer_pixels(s->g); i++) {
    unsigned bits;
    memcpy(&bits, &stored[i], sizeof bits);
    if (bits & 0x1fffu) /* of the 13 that a half lacks */
      return 0;
  }
  return 1;
}

/* Frames with fewer edges, or smooth pixels, say nothing. */
enum { EDGES_LEAST = 40, SMOOTH_LEAST = 1000 };

static void conclude(depth_lines *l, surface_check *out) {
  /* both pixels beside an edge without one between count */
  out->edges = l->mixed + l->clean / 2;
  if (out->edges >= EDGES_LEAST)
    out->mixed = (double)l->mixed / (double)out->edges;
  if (l->smooth < SMOOTH_LEAST || depths_are_halves(l->s))
    return;
  const double second = select_nth(l->second, l->smooth, l->smooth / 2);
  const double fourth = select_nth(l->fourth, l->smooth, l->smooth / 2);
  out->scatter = fourth > 2.0 * second ? second : 0.0;
}

/* How far from its pixel's ray a position is seen, in pixels. */
static double blur_at(const surface_points *s, size_t i) {
  const size_t width = s->g->planes.width;
  const double *m = s->camera->world_from_view;
  double p[3], seen[3] = {0};
  for (int r = 0; r < 3; r++)
    p[r] =
        (double)gbuffer_plane(s->g, ROLE_POSITION, (size_t)r)[i] - m[4 * r + 3];
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++)
      seen[c] += m[4 * r + c] * p[r];
  const double z = surface_rays_are_parallel(s) ? 1.0 : seen[2];
  const double off = hypot(s->camera->fx * seen[0] / z + s->camera->cx -
                               ((double)(i % width) + 0.5),
                           s->camera->fy * seen[1] / z + s->camera->cy -
                               ((double)(i / width) + 0.5));
  return off < INFINITY ? off : INFINITY; /* NaN as well */
}

/* room: for as many numbers as are measured. */
static double measure_blur(const surface_points *s, double *room) {
  size_t count = 0;
  if (s->g->map.count[ROLE_POSITION] < 3 ||
      s->g->map.how.depth == DEPTH_POSITION)
    return NAN;
  for (size_t i = 0; i < gbuffer_pixels(s->g); i = surface_next(s, i))
    if (!isnan(depth_at(s, i)))
      room[count++] = blur_at(s, i);
  return count ? select_nth(room, count, count * 9 / 10) : NAN;
}

/* A row or a column from pixel i on. */
static void measure_line(depth_lines *l, size_t i, size_t step, size_t count) {
  double depth[5] = {0};
  for (size_t k = 0; k < count; k++) {
    memmove(depth, depth + 1, 4 * sizeof *depth);
    depth[4] = depth_at(l->s, i + k * step);
    if (k >= 4)
      measure_five(l, i + (k - 2) * step, step, depth);
  }
}

static void measure(depth_lines *l, size_t stride) {
  const size_t width = l->s->g->planes.width, height = l->s->g->planes.height;
  for (size_t y = 0; y < height; y += stride)
    measure_line(l, y * width, 1, width);
  for (size_t x = 0; x < width; x += stride)
    measure_line(l, x, width, height);
}

int surface_check_measure(const surface_points *s, surface_check *out) {
  const size_t width = s->g->planes.width, height = s->g->planes.height;
  const size_t stride = s->row_step; /* of columns as well */
  const size_t most =
      (height / stride + 1) * width + (width / stride + 1) * height;
  depth_lines l = {.s = s,
                   .view_from_normals = surface_view_from_normals(s),
                   .second = malloc(most * sizeof *l.second),
                   .fourth = malloc(most * sizeof *l.fourth)};
  const int failed = !l.second || !l.fourth;
  *out = (surface_check){.blur = NAN};
  if (!failed) {
    measure(&l, stride);
    conclude(&l, out);
    out->blur = measure_blur(s, l.second);
  }
  free(l.second);
  free(l.fourth);
  return failed ? -1 : 0;
}

/*
 * The limits lie between sound dumps and others.  mixed: at most .17 on 130
 * sound frames, where thin things are; .75 and more if depth is a mean over a
 * pixel.  scatter: at most .0008 if each depth belongs to the middle of its
 * pixel; .06 in a picture whose depth of field changes occlusion by .001, and
 * .35 where motion blur changes it by .08.  blur: at most .74 where samples are
 * anywhere in their pixels, and 1.9 with that motion blur.
 */
static const double mixed_limit = 0.35, scatter_limit = 0.15, blur_limit = 1.25;

void check_surfaces(const surface_points *s, int others, findings *out) {
  static const char advice[] = "motion blur, depth of field or samples beside "
                               "the pixels' middles? Write "
                               "the G-buffer without them";
  surface_check c;
  if (surface_check_measure(s, &c) != 0)
    return;
  if (c.scatter > scatter_limit)
    findings_add(out,
                 "depths scatter about their surfaces, half of them by more "
                 "than %.2g of a pixel's width, so occlusion is noise: %s",
                 c.scatter, advice);
  else if (c.mixed > mixed_limit)
    findings_add(out,
                 "depth is a mean over edges: at %.0f %% of them a pixel lies "
                 "on neither surface and blocks light in mid-air; write depth "
                 "without a filter, one sample at each pixel's middle",
                 100.0 * c.mixed);
  else if (!others && c.blur > blur_limit)
    findings_add(out,
                 "positions are up to %.2g pixels from where their pixels "
                 "look: %s",
                 c.blur, advice);
}
