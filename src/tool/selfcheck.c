/*
 * Does a frame fit together?
 *
 * The depth's own normals, from its gradients, are held against those of the
 * file.  Let A be the sum over pixels of g n^T, g a gradient's unit normal in
 * view space, n the file's: any orthogonal H that were to bring the file's
 * normals into view space then has the mean cosine trace(H^T A)/count, and the
 * best of all is the orthogonal factor of A.  So one pass over the pixels tells
 * what another space, turned axes or another camera would come to; a second
 * matrix, of gradients with depth taken for the distance from the eye, tells
 * that from depth along the axis.
 */
#include "tool/tool.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

typedef struct matrix3 {
  double m[3][3];
} matrix3;

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double determinant(const matrix3 *a) {
  const double(*m)[3] = a->m;
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* Sum over both matrices' elements: trace(a^T b). */
static double inner(const matrix3 *a, const matrix3 *b) {
  double sum = 0;
  for (int i = 0; i < 3; i++)
    sum += dot(a->m[i], b->m[i]);
  return sum;
}

static matrix3 cofactors(const matrix3 *a) {
  matrix3 out;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const int p = (i + 1) % 3, q = (i + 2) % 3;
      const int r = (j + 1) % 3, s = (j + 2) % 3;
      out.m[i][j] = a->m[p][r] * a->m[q][s] - a->m[p][s] * a->m[q][r];
    }
  return out;
}

/* The orthogonal factor of a matrix, by Newton's iteration; 0 where its normals
 * lie in too few directions to say. */
static int orthogonal_factor(matrix3 a, matrix3 *out) {
  const double size = sqrt(inner(&a, &a));
  /* the least of three directions has 1e-3 of the largest at the least */
  if (!(fabs(determinant(&a)) > 1e-6 * size * size * size))
    return 0;
  for (int step = 0; step < 60; step++) { /* 60: 2^-60 would have converged */
    const double d = determinant(&a);
    const matrix3 c = cofactors(&a);
    double change = 0;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        const double next = 0.5 * (a.m[i][j] + c.m[i][j] / d);
        change = fmax(change, fabs(next - a.m[i][j]));
        a.m[i][j] = next;
      }
    if (change < 1e-12)
      break;
  }
  *out = a;
  return 1;
}

/* ------------------------------------------------------------------------ */
/* Gradients                                                                 */

typedef struct fit {
  const gbuffer *g;
  const hbil_camera *camera;
  float background;
  matrix3 planar, other; /* sums of g n^T, see the top; the other depth */
  double count;
} fit;

static int is_parallel(const fit *f) {
  return f->g->map.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
}

static double depth_at(const fit *f, size_t x, size_t y) {
  const float z =
      gbuffer_plane(f->g, ROLE_DEPTH, 0)[y * f->g->planes.width + x];
  return gbuffer_is_surface(z, f->background) ? (double)z : 0.0;
}

/* A pixel's point; other: if depth that was taken for that along the axis is
 * the distance from the eye, or the other way round; the same where rays are
 * parallel. */
static void point(const fit *f, size_t x, size_t y, int other, double out[3]) {
  const gbuffer_ray ray = gbuffer_look(f->g->map.projection, f->camera, x, y);
  const double length = other ? sqrt(dot(ray.along, ray.along)) : 1.0;
  const double z = f->g->map.how.depth == DEPTH_RAY
                       ? depth_at(f, x, y) * length
                       : depth_at(f, x, y) / length;
  for (int c = 0; c < 3; c++)
    out[c] = ray.from[c] + z * ray.along[c];
}

/* The normal of the surface through four neighbours, towards the eye. */
static int gradient(const fit *f, size_t x, size_t y, size_t step, int other,
                    double out[3]) {
  double left[3], right[3], up[3], down[3], a[3], b[3];
  point(f, x - step, y, other, left);
  point(f, x + step, y, other, right);
  point(f, x, y - step, other, up);
  point(f, x, y + step, other, down);
  for (int c = 0; c < 3; c++) {
    a[c] = right[c] - left[c];
    b[c] = down[c] - up[c];
  }
  out[0] = a[2] * b[1] - a[1] * b[2];
  out[1] = a[0] * b[2] - a[2] * b[0];
  out[2] = a[1] * b[0] - a[0] * b[1];
  const double length = sqrt(dot(out, out));
  for (int c = 0; c < 3; c++)
    out[c] /= length;
  return length > 0.0 && isfinite(length);
}

/* What of a depth is straight on a plane. */
static double straightened(const fit *f, double z) {
  return is_parallel(f) ? z : 1 / z;
}

/* Whether three depths in a row are those of one smooth surface: straight, or
 * bent by their own step where there is an edge.  1e-3: what half floats leave
 * of a depth. */
static int is_smooth(const fit *f, double before, double here, double after) {
  if (!(before > 0 && here > 0 && after > 0))
    return 0;
  const double a = straightened(f, before), b = straightened(f, here);
  const double c = straightened(f, after);
  return fabs(a + c - 2 * b) <= 0.1 * fabs(c - a) + 1e-3 * b;
}

static int read_normal(const gbuffer *g, size_t i, double out[3]) {
  for (size_t c = 0; c < 3; c++)
    out[c] = (double)gbuffer_plane(g, ROLE_NORMAL, c)[i];
  const double length = sqrt(dot(out, out));
  for (int c = 0; c < 3; c++)
    out[c] /= length;
  return length > 0.0 && isfinite(length);
}

static void add(matrix3 *sum, const double a[3], const double b[3]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      sum->m[i][j] += a[i] * b[j];
}

static void look_at(fit *f, size_t x, size_t y, size_t step) {
  double n[3], planar[3], other[3];
  const double z = depth_at(f, x, y);
  if (!is_smooth(f, depth_at(f, x - step, y), z, depth_at(f, x + step, y)) ||
      !is_smooth(f, depth_at(f, x, y - step), z, depth_at(f, x, y + step)) ||
      !read_normal(f->g, y * f->g->planes.width + x, n) ||
      !gradient(f, x, y, step, 0, planar) || !gradient(f, x, y, step, 1, other))
    return;
  add(&f->planar, planar, n);
  add(&f->other, other, n);
  f->count++;
}

/* Some 100 x 100 pixels of a frame say enough; gradients over a two-hundredth
 * of it outweigh the rounding of half floats. */
static void look_around(fit *f) {
  const size_t width = f->g->planes.width, height = f->g->planes.height;
  const size_t stride = (width < height ? width : height) / 100 + 1;
  const size_t step = width / 200 + 1;
  for (size_t y = step; y + step < height; y += stride)
    for (size_t x = step; x + step < width; x += stride)
      look_at(f, x, y, step);
}

/* Fewer pixels than these say nothing. */
enum { LEAST_PIXELS = 200 };

static double mean_cosine(const fit *f, const matrix3 *sum, const matrix3 *h) {
  return inner(sum, h) / f->count;
}

/* ------------------------------------------------------------------------ */
/* Findings                                                                  */

static void find(selfcheck *out, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static void find(selfcheck *out, const char *format, ...) {
  va_list arguments;
  if (out->count == SELFCHECK_FINDINGS)
    return;
  va_start(arguments, format);
  vsnprintf(out->text[out->count++], sizeof *out->text, format, arguments);
  va_end(arguments);
}

static matrix3 view_from(const fit *f, dump_space space) {
  const double *m = f->camera->world_from_view;
  matrix3 out = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (int i = 0; i < 3 && space == SPACE_WORLD; i++)
    for (int j = 0; j < 3; j++)
      out.m[i][j] = m[4 * j + i];
  return out;
}

/* What brings the frame's normals, as they were converted, into view space if
 * they are those of another space with other axes turned. */
static matrix3 view_if(const fit *f, dump_space space, unsigned flips) {
  const channel_map *map = &f->g->map;
  channel_map other = *map;
  float is[3], would_be[3];
  matrix3 out = view_from(f, space);
  other.how.flips = flips;
  convert_signs(map, map->how.normals, is);
  convert_signs(&other, space, would_be);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      out.m[i][j] *= (double)(is[j] * would_be[j]);
  return out;
}

/* In the order of how likely they are. */
static const unsigned flip_orders[] = {0, 4, 2, 1, 6, 5, 3, 7};

/* Another space or other axes, if they fit by far better. */
static int find_space(const fit *f, double agreement, selfcheck *out) {
  const conventions *how = &f->g->map.how;
  const unsigned table = source_table[f->g->map.kind].how.flips;
  double best = agreement + 0.1; /* a mean of 25 degrees is no bump map's */
  dump_space space = how->normals;
  unsigned flips = 0;
  int found = 0;
  for (int s = 0; s < 2; s++)
    for (size_t i = 0; i < sizeof flip_orders / sizeof *flip_orders; i++) {
      const matrix3 h = view_if(f, (dump_space)s, flip_orders[i]);
      const double fits = mean_cosine(f, &f->planar, &h);
      if (fits > best && fits > 0.9) {
        found = 1;
        best = fits + 1e-3; /* as good is no better */
        space = (dump_space)s;
        flips = flip_orders[i];
      }
    }
  if (!found)
    return 0;
  if (space == source_table[f->g->map.kind].how.normals)
    flips ^= table; /* --flip goes on top of the source's own */
  find(out,
       "normals don't fit the depth, but do in %s space%s%s%s%s: --normals "
       "%s%s%s%s%s",
       space == SPACE_WORLD ? "world" : "camera", flips ? " with turned " : "",
       flips & 1 ? "x" : "", flips & 2 ? "y" : "", flips & 4 ? "z" : "",
       space == SPACE_WORLD ? "world" : "camera", flips ? " --flip " : "",
       flips & 1 ? "x" : "", flips & 2 ? "y" : "", flips & 4 ? "z" : "");
  return 1;
}

/* Depth along the axis against that from the eye.  On real dumps the wrong one
 * of both is off by ten times the right one; 1e-3, a mean of 3 degrees, is what
 * it comes to in a view of 17 degrees. */
static int is_other_depth(const fit *f, const matrix3 *h) {
  const double off = 1.0 - mean_cosine(f, &f->planar, h);
  const double other = 1.0 - mean_cosine(f, &f->other, h);
  return off > 1e-3 && 3.0 * other < off;
}

static const char *lens_option(const fit *f) {
  return is_parallel(f) ? "--orthographic" : "--fov";
}

/* A turn between the camera and the one that the normals are of.  Real dumps
 * have up to half a degree, of bumps. */
static int find_turn(const fit *f, const matrix3 *h, selfcheck *out) {
  matrix3 best;
  if (!orthogonal_factor(f->planar, &best) ||
      mean_cosine(f, &f->planar, &best) < 0.95)
    return 0;
  const double turn =
      acos(fmax(-1.0, fmin(1.0, 0.5 * (inner(&best, h) - 1.0)))) * 57.29578;
  if (determinant(&best) < 0.0 || !(turn > 1.5))
    return 0;
  find(out,
       "normals fit the depth if the camera is turned by %.1f degrees: the "
       "camera of another frame, or another lens? --camera, %s",
       turn, lens_option(f));
  return 1;
}

static void find_disagreement(const fit *f, selfcheck *out) {
  if (out->agreement > 0.9)
    return;
  find(out, "normals don't fit the depth (%.0f degrees off on average)%s",
       acos(fmax(-1.0, out->agreement)) * 57.29578,
       out->high <= 1.0 && f->g->map.how.depth == DEPTH_PLANAR
           ? ", which is 0..1: --depth device or reversed, with --clip?"
       : is_parallel(f)
           ? ": another --normals, --depth, --orthographic or camera?"
           : ": another --normals, --depth, --fov or camera?");
}

static void check_normals(fit *f, selfcheck *out) {
  const conventions *how = &f->g->map.how;
  look_around(f);
  out->agreement = NAN;
  if (f->count < LEAST_PIXELS)
    return;
  const matrix3 h = view_from(f, how->normals);
  out->agreement = mean_cosine(f, &f->planar, &h);
  if (find_space(f, out->agreement, out))
    return;
  if (is_other_depth(f, &h))
    find(out,
         how->depth == DEPTH_RAY
             ? "depth is taken for the distance from the eye, but fits the "
               "normals as that along the axis: --depth planar"
             : "depth is taken for that along the camera's axis, but fits the "
               "normals as distance from the eye: --depth ray");
  else if (!find_turn(f, &h, out))
    find_disagreement(f, out);
}

/* ------------------------------------------------------------------------ */
/* Depths, positions, sizes                                                  */

/* Sums over the surfaces. */
typedef struct extent {
  double low[3], high[3]; /* of points in view space */
  size_t surface, facing, encoded;
} extent;

/* Whether n is a unit vector if it is stored as (n + 1) / 2, and none if it is
 * not. */
static int looks_encoded(const double n[3]) {
  double e[3];
  for (int c = 0; c < 3; c++) {
    if (n[c] < 0.0 || n[c] > 1.0)
      return 0;
    e[c] = 2.0 * n[c] - 1.0;
  }
  /* 0.05: eight bits round each to 0.004 */
  return fabs(sqrt(dot(e, e)) - 1.0) < 0.05 &&
         fabs(sqrt(dot(n, n)) - 1.0) > 0.01;
}

static void measure_pixel(const fit *f, const matrix3 *h, const float sign[3],
                          size_t i, extent *e) {
  const size_t width = f->g->planes.width;
  const gbuffer_ray ray =
      gbuffer_look(f->g->map.projection, f->camera, i % width, i / width);
  double p[3], n[3], seen[3], stored[3];
  if (!(depth_at(f, i % width, i / width) > 0.0))
    return;
  point(f, i % width, i / width, 0, p);
  e->surface++;
  for (int c = 0; c < 3; c++) {
    e->low[c] = fmin(e->low[c], p[c]);
    e->high[c] = fmax(e->high[c], p[c]);
    n[c] = (double)gbuffer_plane(f->g, ROLE_NORMAL, (size_t)c)[i];
    stored[c] = n[c] * (double)sign[c];
  }
  for (int c = 0; c < 3; c++)
    seen[c] = dot(h->m[c], n);
  e->facing += dot(seen, ray.along) <= 1e-3;
  e->encoded += looks_encoded(stored);
}

static extent measure(const fit *f) {
  extent e = {.low = {INFINITY, INFINITY, INFINITY},
              .high = {-INFINITY, -INFINITY, -INFINITY}};
  const matrix3 h = view_from(f, f->g->map.how.normals);
  float sign[3];
  convert_signs(&f->g->map, f->g->map.how.normals, sign);
  for (size_t i = 0; i < (size_t)f->g->planes.width * f->g->planes.height; i++)
    measure_pixel(f, &h, sign, i, &e);
  return e;
}

static void check_radius(const fit *f, const extent *e, float radius,
                         selfcheck *out) {
  double diagonal = 0.0;
  for (int c = 0; c < 3; c++)
    diagonal += (e->high[c] - e->low[c]) * (e->high[c] - e->low[c]);
  diagonal = sqrt(diagonal);
  const double pixel =
      (is_parallel(f) ? 1 : e->low[2]) / fmax(f->camera->fx, f->camera->fy);
  if (isfinite(radius) && (double)radius > diagonal)
    find(out,
         "a radius of %g is larger than all that is seen, %.3g: metres "
         "against centimetres? --radius, --unit-scale",
         (double)radius, diagonal);
  if ((double)radius < pixel)
    find(out,
         "a radius of %g is less than a pixel, %.3g where it is nearest: "
         "metres against centimetres? --radius, --unit-scale",
         (double)radius, pixel);
}

/* World units across the picture of parallel rays. */
static double picture_width(const fit *f) {
  return f->g->planes.width / f->camera->fx;
}

/* Sums over the difference of the file's positions and those rebuilt, both from
 * the eye. */
typedef struct offsets {
  double worst, other; /* largest errors, see selfcheck; with the other depth */
  double own, cross;   /* to scale one to the other */
  double shift[3], shift2;
  double count;
} offsets;

static void add_position(const fit *f, size_t x, size_t y, offsets *o) {
  const size_t i = y * f->g->planes.width + x;
  const double *m = f->camera->world_from_view;
  double here[3], other[3], off = 0, off_other = 0, far = 0;
  point(f, x, y, 0, here);
  point(f, x, y, 1, other);
  for (int c = 0; c < 3; c++) {
    const double eye = m[4 * c + 3];
    const double p =
        (double)gbuffer_plane(f->g, ROLE_POSITION, (size_t)c)[i] - eye;
    const double q = dot(m + 4 * c, here), r = dot(m + 4 * c, other);
    off += (p - q) * (p - q);
    off_other += (p - r) * (p - r);
    far += p * p;
    o->own += (q + eye) * (q + eye);
    o->cross += (p + eye) * (q + eye);
    o->shift[c] += p - q;
    o->shift2 += (p - q) * (p - q);
  }
  if (is_parallel(f)) /* wherever the camera stands */
    far = picture_width(f) * picture_width(f);
  const double e = far > 0 ? sqrt(off / far) : 0;
  const double e_other = far > 0 ? sqrt(off_other / far) : 0;
  o->worst = e > o->worst || isnan(e) ? e : o->worst;
  o->other = e_other > o->other || isnan(e_other) ? e_other : o->other;
  o->count++;
}

/* With depth in units of its own and positions as well, what is rebuilt is off
 * by the eye's place alone, as it is in those units. */
static double units_of_eye(const fit *f, const offsets *o) {
  const double *m = f->camera->world_from_view;
  const double eye[3] = {m[3], m[7], m[11]};
  double shift[3], spread = o->shift2 / o->count;
  for (int c = 0; c < 3; c++) {
    shift[c] = o->shift[c] / o->count;
    spread -= shift[c] * shift[c];
    shift[c] += eye[c];
  }
  const double length2 = dot(shift, shift), along = dot(shift, eye);
  const double units = sqrt(dot(eye, eye) / length2);
  /* constant, and in the eye's direction, to a hundredth (squared): half floats
   * may leave as much of a position.  No two units are closer than a factor of
   * 2; a camera's movement may look like less. */
  const int parallel =
      along > 0 && along * along > (1 - 1e-4) * dot(eye, eye) * length2;
  return spread < 1e-4 * length2 && parallel && fabs(log(units)) > log(2.0)
             ? units
             : 0;
}

/* The file's position, and the one that is rebuilt, along the camera's axes
 * from its place; a unit of file and depth is so many of the camera's. */
static void compare_position(const fit *f, size_t i, double unit,
                             double in_file[3], double rebuilt[3]) {
  const size_t width = f->g->planes.width;
  const double *m = f->camera->world_from_view;
  point(f, i % width, i / width, 0, rebuilt);
  rebuilt[2] *= unit;
  for (int k = 0; k < 3; k++)
    in_file[k] = 0;
  for (int c = 0; c < 3; c++) {
    const double p =
        unit * (double)gbuffer_plane(f->g, ROLE_POSITION, (size_t)c)[i] -
        m[4 * c + 3];
    for (int k = 0; k < 3; k++)
      in_file[k] += m[4 * c + k] * p;
  }
}

/* Largest error of a coordinate then, a share of the picture's width. */
static double error_in_units(const fit *f, double unit) {
  const size_t width = f->g->planes.width;
  double worst = 0, in_file[3], rebuilt[3];
  for (size_t i = 0; i < width * f->g->planes.height; i++) {
    if (!(depth_at(f, i % width, i / width) > 0.0))
      continue;
    compare_position(f, i, unit, in_file, rebuilt);
    for (int k = 0; k < 3; k++)
      worst = fmax(worst, fabs(in_file[k] - rebuilt[k]));
  }
  return worst / picture_width(f);
}

/* Parallel rays have pixels of one size, over which the file's positions spread
 * as far as their unit says; to a hundredth, and factors of 2, as above. */
static double units_of_pixels(const fit *f) {
  const size_t width = f->g->planes.width;
  double n = 0, sum[2] = {0}, sum_file[2] = {0}, square = 0, product = 0;
  double in_file[3], rebuilt[3];
  for (size_t i = 0; i < width * f->g->planes.height; i++) {
    if (!(depth_at(f, i % width, i / width) > 0.0))
      continue;
    compare_position(f, i, 1, in_file, rebuilt);
    n++;
    for (int k = 0; k < 2; k++) {
      sum[k] += rebuilt[k];
      sum_file[k] += in_file[k];
      square += rebuilt[k] * rebuilt[k];
      product += rebuilt[k] * in_file[k];
    }
  }
  square -= (sum[0] * sum[0] + sum[1] * sum[1]) / n;
  product -= (sum[0] * sum_file[0] + sum[1] * sum_file[1]) / n;
  const double unit = square / product;
  return unit > 0 && fabs(log(unit)) > log(2.0) &&
                 error_in_units(f, unit) < 0.01
             ? unit
             : 0;
}

static void check_positions(const fit *f, selfcheck *out) {
  offsets o = {0};
  const size_t width = f->g->planes.width;
  out->positions = NAN;
  if (f->g->map.count[ROLE_POSITION] < 3 ||
      f->g->map.how.depth == DEPTH_POSITION)
    return;
  for (size_t i = 0; i < width * f->g->planes.height; i++)
    if (depth_at(f, i % width, i / width) > 0.0)
      add_position(f, i % width, i / width, &o);
  out->positions = o.worst;
  if (o.count < 1.0 || o.worst < 1e-3) /* halves: 2^-11 */
    return;
  const double units =
      is_parallel(f) ? units_of_pixels(f) : units_of_eye(f, &o);
  const double scale = o.cross / o.own;
  if (o.other < 1e-3)
    find(out, "the positions say that depth is %s",
         f->g->map.how.depth == DEPTH_RAY
             ? "along the camera's axis: --depth planar"
             : "the distance from the eye: --depth ray");
  else if (units > 0.0)
    find(out,
         "positions and depth fit a camera in other units: --unit-scale %.4g "
         "(metres against centimetres?)",
         units);
  else if (!(fabs(log(scale)) < log(2.0)))
    find(out,
         "positions aren't where depth and camera lead, and are %.4g times as "
         "far: the camera of another frame, or other units? --camera, "
         "--unit-scale",
         scale);
  else if (o.worst > 0.01)
    find(out, "positions aren't where depth and camera lead: the camera of "
              "another frame? --camera");
}

/* ------------------------------------------------------------------------ */
/* Colours                                                                   */

/*
 * Eight bits a channel are sRGB, by all habits.  Nearly all values are whole
 * numbers of 255 parts then, and many different ones; of others one in seven
 * is, to the 0.07 that half floats leave of a whole number.
 */
static int is_eight_bit(const gbuffer *g, role r) {
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  unsigned char seen[256] = {0};
  size_t values = 0, whole = 0;
  int levels = 0;
  for (size_t c = 0; c < g->map.count[r]; c++) {
    const float *v = gbuffer_plane(g, r, c);
    for (size_t i = 0; i < pixels; i++) {
      const double parts = (double)v[i] * 255.0;
      if (!(parts >= 8.0 && parts <= 255.5))
        continue;
      values++;
      whole += fabs(parts - round(parts)) < 0.07;
      seen[(int)round(parts)] = 1;
    }
  }
  for (int i = 0; i < 256; i++)
    levels += seen[i];
  return levels >= 32 && (double)whole > 0.99 * (double)values;
}

/* A pass of diffuse light is black where there is nothing. */
static int lights_sky(const fit *f) {
  const size_t width = f->g->planes.width;
  const size_t pixels = width * f->g->planes.height;
  size_t sky = 0, lit = 0;
  for (size_t i = 0; i < pixels; i++) {
    if (depth_at(f, i % width, i / width) > 0.0)
      continue;
    sky++;
    for (size_t c = 0; c < f->g->map.count[ROLE_DIRECT]; c++)
      if (gbuffer_plane(f->g, ROLE_DIRECT, c)[i] > 0.0f) {
        lit++;
        break;
      }
  }
  return sky > pixels / 100 && lit > sky / 2;
}

static void check_colours(const fit *f, selfcheck *out) {
  static const role roles[] = {ROLE_ALBEDO, ROLE_DIRECT};
  const channel_map *map = &f->g->map;
  for (size_t k = 0; k < 2; k++)
    if (!map->gamma[roles[k]] && is_eight_bit(f->g, roles[k]))
      find(out,
           "%s has whole parts of 255, as pictures for the eye have, which "
           "are gamma-encoded: --colours srgb",
           role_name(roles[k]));
  if (map->is_beauty || lights_sky(f))
    find(out,
         "direct light is that of a finished picture, whose indirect light "
         "would count twice: --map direct= with a pass of direct diffuse "
         "light, or with nothing");
}

/* ------------------------------------------------------------------------ */
/* All together                                                              */

void selfcheck_frame(const gbuffer *g, const hbil_config *config,
                     const hbil_camera *camera, selfcheck *out) {
  fit f = {.g = g, .camera = camera, .background = config->sky_depth};
  memset(out, 0, sizeof *out);
  out->agreement = out->positions = NAN;
  const extent e = measure(&f);
  out->surface =
      (double)e.surface / ((double)g->planes.width * (double)g->planes.height);
  if (e.surface == 0) {
    find(out, "no pixel has a depth: --depth, --background or --map depth?");
    return;
  }
  out->low = e.low[2];
  out->high = e.high[2];
  out->facing = (double)e.facing / (double)e.surface;
  if (!g->map.how.encoded && e.encoded > e.surface / 10 * 9)
    find(out, "normals look like stored as (n+1)/2: --normals encoded");
  else
    check_normals(&f, out);
  check_positions(&f, out);
  check_radius(&f, &e, config->radius, out);
  check_colours(&f, out);
}

/* ------------------------------------------------------------------------ */
/* What names left unsure                                                    */

/* The planes as they are stored. */
static int read_stored(const char *path, const channel_map *map, gbuffer *out,
                       image_error *error) {
  channel_map stored = *map;
  const conventions as_it_is = {.unit = 1.0, .background = INFINITY};
  stored.how = as_it_is;
  stored.mirrored = 0;
  if (map->how.depth == DEPTH_POSITION)
    stored.count[ROLE_DEPTH] = 0;
  return gbuffer_read(path, &stored, 1u << ROLE_DEPTH | 1u << ROLE_NORMAL, out,
                      error);
}

/* Depths that are all negative count backwards; one that no surface is at
 * stands for nothing: the largest half, or a very large number. */
static void settle_sky(const gbuffer *stored, conventions *how,
                       selfcheck *out) {
  const float *depth = gbuffer_plane(stored, ROLE_DEPTH, 0);
  float low = INFINITY, high = -INFINITY;
  const size_t pixels = (size_t)stored->planes.width * stored->planes.height;
  if (!depth || how->depth == DEPTH_DEVICE || how->depth == DEPTH_REVERSED)
    return;
  for (size_t i = 0; i < pixels; i++)
    if (isfinite(depth[i])) {
      low = fminf(low, depth[i]);
      high = fmaxf(high, depth[i]);
    }
  how->backwards = low < 0.0f && high <= 0.0f;
  const float most = how->backwards ? -low : high;
  if (how->backwards)
    find(out, "depth counts backwards, all of it being negative");
  if (most == 65504.0f || most >= 1e9f) {
    how->background = most == 65504.0f ? most : 1e9f;
    find(out, "depths of %g are sky (--background)", (double)most);
  }
}

static void settle_encoding(const gbuffer *stored, conventions *how,
                            selfcheck *out) {
  const size_t pixels = (size_t)stored->planes.width * stored->planes.height;
  size_t encoded = 0, some = 0;
  for (size_t i = 0; i < pixels; i++) {
    double n[3];
    for (size_t c = 0; c < 3; c++)
      n[c] = (double)gbuffer_plane(stored, ROLE_NORMAL, c)[i];
    some += dot(n, n) > 0.0;
    encoded += looks_encoded(n);
  }
  how->encoded = some > 0 && encoded > some / 10 * 9;
  if (how->encoded)
    find(out, "normals are stored as (n+1)/2 (--normals)");
}

/* Which depth the normals fit, and in which space they are if they fit no
 * better in that of the source. */
static int settle_fit(const char *path, channel_map *map, selfcheck *out,
                      image_error *error) {
  hbil_config config;
  gbuffer g;
  hbil_config_init(&config);
  channels_conventions(map, &config);
  if (gbuffer_read(path, map, 1u << ROLE_DEPTH | 1u << ROLE_NORMAL, &g,
                   error) != 0)
    return -1;
  fit f = {.g = &g, .camera = &map->camera, .background = config.sky_depth};
  look_around(&f);
  const matrix3 world = view_from(&f, SPACE_WORLD);
  const matrix3 camera = view_if(&f, SPACE_CAMERA, 0);
  if (map->how.unsure & UNSURE_NORMALS && map->how.normals == SPACE_WORLD &&
      map->how.flips == 0 && f.count >= LEAST_PIXELS &&
      mean_cosine(&f, &f.planar, &camera) >
          mean_cosine(&f, &f.planar, &world) + 0.1) {
    map->how.normals = SPACE_CAMERA;
    find(out, "normals are in camera space, where they fit the depth "
              "(--normals)");
  }
  const matrix3 h = map->how.normals == SPACE_WORLD ? world : camera;
  if (map->how.unsure & UNSURE_DEPTH && map->how.depth == DEPTH_PLANAR &&
      f.count >= LEAST_PIXELS && is_other_depth(&f, &h)) {
    map->how.depth = DEPTH_RAY;
    find(out, "depth is the distance from the eye, as which it fits the "
              "normals (--depth)");
  }
  gbuffer_free(&g);
  return 0;
}

int selfcheck_settle(const char *path, channel_map *map, selfcheck *out,
                     image_error *error) {
  const unsigned unsure = map->how.unsure;
  gbuffer stored;
  memset(out, 0, sizeof *out);
  if (!unsure)
    return 0;
  if (read_stored(path, map, &stored, error) != 0)
    return -1;
  if (unsure & UNSURE_SKY)
    settle_sky(&stored, &map->how, out);
  if (unsure & UNSURE_NORMALS)
    settle_encoding(&stored, &map->how, out);
  gbuffer_free(&stored);
  return unsure & (UNSURE_DEPTH | UNSURE_NORMALS)
             ? settle_fit(path, map, out, error)
             : 0;
}
