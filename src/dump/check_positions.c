/* Checks that positions fit depth and camera. */
#include "dump/check_positions.h"

#include "dump/check_camera.h"
#include "dump/selection.h"

#include <math.h>
#include <stdlib.h>

/* World units across the picture of parallel rays. */
static double picture_width(const surface_points *s) {
  return s->g->planes.width / s->camera->fx;
}

/* Sums over the differences between the file's positions p and the computed
 * positions q. */
typedef struct offsets {
  double *errors, *others; /* of each position; with the other kind of depth */
  double most, other;      /* what nine tenths of them don't exceed */
  double own, cross;       /* sums of q.q and p.q */
  double shift[3], shift2; /* sums of p - q and its square */
  size_t count;
} offsets;

static void add_position(const surface_points *s, size_t x, size_t y,
                         offsets *o) {
  const size_t i = y * s->g->planes.width + x;
  const double *m = s->camera->world_from_view;
  double here[3], other[3], off = 0, off_other = 0, far = 0;
  surface_point(s, x, y, 0, here);
  surface_point(s, x, y, 1, other);
  for (int c = 0; c < 3; c++) {
    const double eye = m[4 * c + 3];
    const double p =
        (double)gbuffer_plane(s->g, ROLE_POSITION, (size_t)c)[i] - eye;
    const double q = matrix3_dot(m + 4 * c, here),
                 r = matrix3_dot(m + 4 * c, other);
    off += (p - q) * (p - q);
    off_other += (p - r) * (p - r);
    far += p * p;
    o->own += (q + eye) * (q + eye);
    o->cross += (p + eye) * (q + eye);
    o->shift[c] += p - q;
    o->shift2 += (p - q) * (p - q);
  }
  if (surface_rays_are_parallel(s))
    far = picture_width(s) * picture_width(s);
  const double e = far > 0 ? sqrt(off / far) : 0;
  const double e_other = far > 0 ? sqrt(off_other / far) : 0;
  o->errors[o->count] = isnan(e) ? INFINITY : e;
  o->others[o->count] = isnan(e_other) ? INFINITY : e_other;
  o->count++;
}

/* If depth and positions share a unit that is not the camera's, all positions
 * are off by the same vector, in the direction of the eye.  Returns how many
 * camera units that unit has, or 0. */
static double units_of_eye(const surface_points *s, const offsets *o) {
  const double *m = s->camera->world_from_view;
  const double eye[3] = {m[3], m[7], m[11]};
  double shift[3], spread = o->shift2 / (double)o->count;
  for (int c = 0; c < 3; c++) {
    shift[c] = o->shift[c] / (double)o->count;
    spread -= shift[c] * shift[c];
    shift[c] += eye[c];
  }
  const double length2 = matrix3_dot(shift, shift),
               along = matrix3_dot(shift, eye);
  const double units = sqrt(matrix3_dot(eye, eye) / length2);
  /* The vector must be constant and point to the eye within a hundredth (here
   * squared), the precision that half floats may leave.  Units that people mix
   * up differ by more than a factor of 2; less may be a moved camera. */
  const int parallel =
      along > 0 && along * along > (1 - 1e-4) * matrix3_dot(eye, eye) * length2;
  return spread < 1e-4 * length2 && parallel && fabs(log(units)) > log(2.0)
             ? units
             : 0;
}

/* The file's position and the computed one along the camera's axes, from the
 * camera's place, if a unit of the file is `unit` camera units. */
static void compare_position(const surface_points *s, size_t i, double unit,
                             double in_file[3], double rebuilt[3]) {
  const size_t width = s->g->planes.width;
  const double *m = s->camera->world_from_view;
  surface_point(s, i % width, i / width, 0, rebuilt);
  rebuilt[2] *= unit;
  for (int k = 0; k < 3; k++)
    in_file[k] = 0;
  for (int c = 0; c < 3; c++) {
    const double p =
        unit * (double)gbuffer_plane(s->g, ROLE_POSITION, (size_t)c)[i] -
        m[4 * c + 3];
    for (int k = 0; k < 3; k++)
      in_file[k] += m[4 * c + k] * p;
  }
}

/* The largest error of a coordinate then, as a share of the picture's width. */
static double error_in_units(const surface_points *s, double unit) {
  const size_t width = s->g->planes.width;
  double worst = 0, in_file[3], rebuilt[3];
  for (size_t i = 0; i < gbuffer_pixels(s->g); i = surface_next(s, i)) {
    if (!(surface_depth(s, i % width, i / width) > 0.0))
      continue;
    compare_position(s, i, unit, in_file, rebuilt);
    for (int k = 0; k < 3; k++)
      worst = fmax(worst, fabs(in_file[k] - rebuilt[k]));
  }
  return worst / picture_width(s);
}

/* The same as units_of_eye() for parallel rays: how far the file's positions
 * spread over the pixels, which all have the same size, tells their unit.  The
 * limits are the same. */
static double units_of_pixels(const surface_points *s) {
  const size_t width = s->g->planes.width;
  double n = 0, sum[2] = {0}, sum_file[2] = {0}, square = 0, product = 0;
  double in_file[3], rebuilt[3];
  for (size_t i = 0; i < gbuffer_pixels(s->g); i = surface_next(s, i)) {
    if (!(surface_depth(s, i % width, i / width) > 0.0))
      continue;
    compare_position(s, i, 1, in_file, rebuilt);
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
                 error_in_units(s, unit) < 0.01
             ? unit
             : 0;
}

int check_positions_camera(const surface_points *s, findings *out) {
  const gbuffer *g = s->g;
  if (g->map.count[ROLE_POSITION] < 3)
    return 0;
  fit_points *points = malloc(sizeof *points);
  camera_file camera = {.orthographic = surface_rays_are_parallel(s),
                        .fx = s->camera->fx,
                        .fy = s->camera->fy,
                        .cx = s->camera->cx,
                        .cy = s->camera->cy};
  int found = 0;
  for (int i = 0; i < 16; i++) /* from view space to OpenGL's */
    camera.camera_to_world[i] =
        s->camera->world_from_view[i] * (i % 4 == 1 || i % 4 == 2 ? -1.0 : 1.0);
  if (points) {
    camera_fit_points(g, points);
    found = check_camera(points, &camera, out);
  }
  free(points);
  return found;
}

static void explain(const surface_points *s, const offsets *o, findings *out) {
  const double units =
      surface_rays_are_parallel(s) ? units_of_pixels(s) : units_of_eye(s, o);
  const double scale = o->cross / o->own;
  /* the right kind of depth leaves the place of samples in their pixels */
  if (o->other < 1e-3 || (o->most > 0.01 && o->other < 0.2 * o->most))
    findings_add(out, "the positions say that depth is %s",
                 s->g->map.how.depth == DEPTH_RAY
                     ? "along the camera's axis: --depth planar"
                     : "the distance from the eye: --depth ray");
  else if (units > 0.0)
    findings_add(
        out,
        "positions and depth fit a camera in other units: --unit-scale %.4g "
        "(metres against centimetres?)",
        units);
  else if (!(fabs(log(scale)) < log(2.0)))
    findings_add(
        out,
        "positions aren't where depth and camera lead, and are %.4g times as "
        "far: the camera of another frame, or other units? --camera, "
        "--unit-scale",
        scale);
  else if (o->most > 0.05)
    findings_add(out,
                 "positions aren't where depth and camera lead: the camera of "
                 "another frame? --camera");
}

static double nine_tenths(double *values, size_t count) {
  return select_nth(values, count, (size_t)(0.9 * (double)(count - 1)));
}

static void compare(const surface_points *s, offsets *o, findings *out) {
  const size_t width = s->g->planes.width;
  for (size_t i = 0; i < gbuffer_pixels(s->g); i = surface_next(s, i))
    if (surface_depth(s, i % width, i / width) > 0.0)
      add_position(s, i % width, i / width, o);
  if (!o->count)
    return;
  o->most = nine_tenths(o->errors, o->count);
  o->other = nine_tenths(o->others, o->count);
  /* the precision of half floats is 2^-11 */
  if (o->most >= 1e-3)
    explain(s, o, out);
}

double check_positions(const surface_points *s, findings *out) {
  const size_t pixels = surface_looks(s);
  offsets o = {.most = NAN};
  if (s->g->map.count[ROLE_POSITION] < 3 ||
      s->g->map.how.depth == DEPTH_POSITION)
    return NAN;
  o.errors = malloc(sizeof *o.errors * pixels);
  o.others = malloc(sizeof *o.others * pixels);
  if (o.errors && o.others)
    compare(s, &o, out);
  free(o.errors);
  free(o.others);
  return o.most;
}
