/* Cameras: what kernels need of them, computed in double and rounded once. */
#include "camera.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Element (row, column) of a row-major 4x4. */
static double at(const double m[16], int row, int column) {
  return m[4 * row + column];
}

/* Columns of the rotation are unit and at right angles, to 1e-3: beyond any
 * rounding of a float matrix (a product of two float rotations is off by less
 * than 1e-6), below any real scale or shear.  Mirrored ones are right, too: all
 * that is done with them is to change between bases. */
const char *rigid_error(const double m[16], char text[RIGID_ERROR_SIZE]) {
  const double last[4] = {0, 0, 0, 1};
  const size_t size = RIGID_ERROR_SIZE;
  for (int i = 0; i < 16; ++i)
    if (!isfinite(m[i])) {
      snprintf(text, size, "row %d, column %d: %g", i / 4, i % 4, m[i]);
      return text;
    }
  for (int i = 0; i < 4; ++i)
    if (fabs(at(m, 3, i) - last[i]) > 1e-3)
      return "the last row is not 0 0 0 1 (row-major, for column vectors)";
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b <= a; ++b) {
      double dot = 0;
      for (int r = 0; r < 3; ++r)
        dot += at(m, r, a) * at(m, r, b);
      if (a != b && fabs(dot) > 1e-3) {
        snprintf(text, size,
                 "columns %d and %d are not at right angles (skewed)", b, a);
        return text;
      }
      if (a == b && fabs(dot - 1) > 1e-3) {
        snprintf(text, size, "column %d has the length %g, not 1 (scaled)", a,
                 sqrt(dot));
        return text;
      }
    }
  return NULL;
}

/* The inverse of a rigid transform. */
static void inverse(const double m[16], double out[16]) {
  for (int r = 0; r < 3; ++r) {
    out[4 * r + 3] = 0;
    for (int c = 0; c < 3; ++c) {
      out[4 * r + c] = at(m, c, r);
      out[4 * r + 3] -= at(m, c, r) * at(m, c, 3);
    }
  }
  for (int c = 0; c < 4; ++c)
    out[12 + c] = c == 3;
}

/* ------------------------------------------------------------------------ */
/* Cameras from what a caller has                                            */

void hbil_camera_from_opengl(hbil_camera *camera,
                             const double camera_to_world[16], double fx,
                             double fy, double cx, double cy) {
  if (!camera || !camera_to_world)
    return;
  camera->fx = fx;
  camera->fy = fy;
  camera->cx = cx;
  camera->cy = cy;
  /* y up, -z forward -> y down, z forward: the second and third axes turn. */
  for (int i = 0; i < 16; ++i) {
    const int column = i % 4;
    const double sign = column == 1 || column == 2 ? -1.0 : 1.0;
    camera->world_from_view[i] = sign * camera_to_world[i];
  }
}

/* Whether an element of a projection is 0 beside others of about 1: to 1e-6,
 * which is beyond the rounding of products of float matrices and moves nothing
 * by more than 0.01 pixels. */
static bool none(double v) {
  return fabs(v) <= 1e-6;
}

/* What is wrong with the rows of x, y and w, or NULL.  In a perspective view
 * `shift`, the column that moves the picture's centre, is that of z; in an
 * orthographic one it is the last. */
static const char *xyw_error(const double p[16], int shift) {
  const int other = 5 - shift;
  const double w = at(p, 3, shift);
  for (int i = 0; i < 16; ++i)
    if (!isfinite(p[i]))
      return "projection: an element is not finite";
  if (!none(at(p, 3, 0)) || !none(at(p, 3, 1)) || !none(at(p, 3, other)) ||
      !(shift == 2 ? none(fabs(w) - 1) : none(w - 1)))
    return shift == 2
               ? "projection: the last row is not 0 0 1 0 or 0 0 -1 0, which "
                 "it is in a perspective view (conventions, inputs.projection)"
               : "projection: the last row is not 0 0 0 1, which it is in an "
                 "orthographic view (conventions, inputs.projection)";
  for (int r = 0; r < 2; ++r) {
    const double scale = at(p, r, r);
    if (scale == 0 || !none(at(p, r, 1 - r) / scale) ||
        !none(at(p, r, other) / scale))
      return shift == 2 ? "projection: the first two rows are not a 0 b 0 and "
                          "0 c d 0 (a perspective view, not skewed)"
                        : "projection: the first two rows are not a 0 0 b and "
                          "0 c 0 d (an orthographic view, not skewed)";
  }
  return NULL;
}

/* What is wrong with the row of z, or NULL.  `slope` is positive where a
 * greater clip z is farther away. */
static const char *z_error(const double p[16], double slope, bool reversed) {
  if (!none(at(p, 2, 0)) || !none(at(p, 2, 1)))
    return "projection: the third row is not 0 0 e f, so that depth depends on "
           "x or y (an oblique near plane)";
  if (slope == 0)
    return "projection: the third row gives everything the same depth";
  if ((slope < 0) != reversed)
    return reversed ? "conventions: HBIL_MATRIX_REVERSED_DEPTH, but in "
                      "projection what is nearer has the smaller depth"
                    : "conventions: not HBIL_MATRIX_REVERSED_DEPTH, but in "
                      "projection what is nearer has the greater depth";
  return NULL;
}

/* Whether a perspective view's A, the depth at infinity, is at the far plane or
 * beyond it, to 1e-3: projections with an infinite far plane are often changed
 * a little so that roundings don't clip. */
static bool ends_outside(double a, bool reversed) {
  return reversed ? a < 1e-3 : a > 1 - 1e-3;
}

/* A matrix with rows and columns exchanged if it is stored by columns. */
static void by_rows(const double in[16], cl_uint conventions, double out[16]) {
  const bool columns = (conventions & HBIL_MATRIX_COLUMN_MAJOR) != 0;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      out[4 * r + c] = columns ? at(in, c, r) : at(in, r, c);
}

/* The camera and the depth buffer's A and B of row-major matrices.  Returns
 * what is wrong, or NULL.
 *
 * Of the caller's view space only the axes' directions differ from hbil's, so
 * x, y and z are each multiplied by 1 or -1: z so that w or the depth grows
 * forward, x so that columns and y so that rows grow with it. */
static const char *convert(hbil_camera *camera, double depth[2],
                           const hbil_config *config, const double p[16],
                           const double view[16], cl_uint conventions,
                           bool with_depth) {
  const bool flat = config->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const bool reversed = (conventions & HBIL_MATRIX_REVERSED_DEPTH) != 0;
  const int shift = flat ? 3 : 2;
  const double down = conventions & HBIL_MATRIX_Y_DOWN ? 1 : -1;
  const char *error = xyw_error(p, shift);
  if (error)
    return error;
  const double w = at(p, 3, shift) < 0 ? -1 : 1;
  /* orthographic: where reversed is true, clip z grows backwards */
  const double forward = !flat ? w : (at(p, 2, 2) < 0) == reversed ? 1 : -1;
  /* clip z/w = depth[0] + depth[1]/z, or depth[0] + depth[1] z */
  depth[0] = flat ? at(p, 2, 3) : at(p, 2, 2) * forward;
  depth[1] = flat ? at(p, 2, 2) * forward : at(p, 2, 3);
  if (flat || with_depth)
    error = z_error(p, flat ? depth[1] : -depth[1], reversed);
  if (error)
    return error;
  if (conventions & HBIL_MATRIX_SIGNED_DEPTH) {
    depth[0] = 0.5 * depth[0] + 0.5;
    depth[1] *= 0.5;
  }
  if (!flat && with_depth && !ends_outside(depth[0], reversed))
    return conventions & HBIL_MATRIX_SIGNED_DEPTH
               ? "projection, conventions: infinite distance has a depth "
                 "inside "
                 "0..1; is clip space 0..1, without HBIL_MATRIX_SIGNED_DEPTH?"
               : "projection, conventions: infinite distance has a depth "
                 "inside "
                 "0..1; is clip space -1..1, HBIL_MATRIX_SIGNED_DEPTH?";
  const double half_width = 0.5 * config->width;
  const double half_height = 0.5 * config->height;
  camera->fx = fabs(at(p, 0, 0)) * half_width;
  camera->fy = fabs(at(p, 1, 1)) * half_height;
  camera->cx = (1 + at(p, 0, shift) * w) * half_width;
  camera->cy = (1 + at(p, 1, shift) * w * down) * half_height;
  const double sign[4] = {at(p, 0, 0) < 0 ? -1 : 1,
                          at(p, 1, 1) * down < 0 ? -1 : 1, forward, 1};
  inverse(view, camera->world_from_view);
  for (int i = 0; i < 16; ++i)
    camera->world_from_view[i] *= sign[i % 4];
  return NULL;
}

hbil_status hbil_camera_from_matrices(
    hbil_camera *camera, double hardware_depth[2], const hbil_config *config,
    const double projection[16], const double view[16], cl_uint conventions) {
  const char *missing = !camera       ? "camera"
                        : !config     ? "config"
                        : !projection ? "projection"
                        : !view       ? "view"
                                      : NULL;
  if (missing)
    return fail_null(NULL, __func__, missing);
  if (config->width < 1 || config->width > HBIL_MAX_SIZE ||
      config->height < 1 || config->height > HBIL_MAX_SIZE)
    return fail(NULL, HBIL_INVALID_ARGUMENT,
                "%s: config.width, config.height: %u, %u; must be 1..%d",
                __func__, config->width, config->height, HBIL_MAX_SIZE);
  if (conventions & ~(cl_uint)HBIL_MATRIX_ALL)
    return fail(NULL, HBIL_INVALID_ARGUMENT,
                "%s: conventions: %u is not a sum of hbil_matrix_convention",
                __func__, conventions);
  hbil_camera result;
  double p[16], v[16], depth[2];
  by_rows(projection, conventions, p);
  by_rows(view, conventions, v);
  const char *error = convert(&result, depth, config, p, v, conventions,
                              hardware_depth != NULL);
  if (error) {
    by_rows(projection, conventions ^ HBIL_MATRIX_COLUMN_MAJOR, p);
    by_rows(view, conventions ^ HBIL_MATRIX_COLUMN_MAJOR, v);
    const bool other_way = !convert(&result, depth, config, p, v, conventions,
                                    hardware_depth != NULL);
    return fail(NULL, HBIL_INVALID_ARGUMENT, "%s: %s%s", __func__, error,
                !other_way ? ""
                : conventions & HBIL_MATRIX_COLUMN_MAJOR
                    ? "; without HBIL_MATRIX_COLUMN_MAJOR it fits"
                    : "; with HBIL_MATRIX_COLUMN_MAJOR it fits");
  }
  char text[RIGID_ERROR_SIZE];
  error = rigid_error(v, text);
  if (error)
    return fail(NULL, HBIL_INVALID_ARGUMENT,
                "%s: view: not a rigid transform: %s", __func__, error);
  *camera = result;
  for (int i = 0; hardware_depth && i < 2; ++i)
    hardware_depth[i] = depth[i];
  return HBIL_SUCCESS;
}

/* ------------------------------------------------------------------------ */
/* What kernels take                                                         */

/* Kernels take a camera as floats, and multiply two such lengths. */
static const double most_length = 1e18;

/* Whether a number lies between `least` and that; false for NaN. */
static bool in_range(double v, double least) {
  return v >= least && v <= most_length;
}

hbil_status camera_check(hbil_context *context, const hbil_camera *camera) {
  const double *m = camera->world_from_view;
  if (!in_range(camera->fx, 1.0 / most_length) ||
      !in_range(camera->fy, 1.0 / most_length))
    return fail(context, HBIL_INVALID_FRAME,
                "camera.fx, camera.fy: %g, %g; focal lengths are positive "
                "numbers of pixels, %g .. %g",
                camera->fx, camera->fy, 1.0 / most_length, most_length);
  if (!in_range(camera->cx, -most_length) ||
      !in_range(camera->cy, -most_length))
    return fail(context, HBIL_INVALID_FRAME,
                "camera.cx, camera.cy: %g, %g; the principal point is within "
                "%g pixels of the corner",
                camera->cx, camera->cy, most_length);
  char text[RIGID_ERROR_SIZE];
  const char *error = rigid_error(m, text);
  if (error)
    return fail(context, HBIL_INVALID_FRAME,
                "camera.world_from_view: not a rigid transform: %s", error);
  for (int r = 0; r < 3; ++r)
    if (!in_range(at(m, r, 3), -most_length))
      return fail(context, HBIL_INVALID_FRAME,
                  "camera.world_from_view[%d]: %g; coordinates are within %g",
                  4 * r + 3, at(m, r, 3), most_length);
  return HBIL_SUCCESS;
}

hbil_view_args camera_view(const hbil_camera *camera,
                           const hbil_config *config) {
  hbil_view_args view;
  view.width = (cl_int)config->width;
  view.height = (cl_int)config->height;
  view.fx = (float)camera->fx;
  view.fy = (float)camera->fy;
  view.cx = (float)camera->cx;
  view.cy = (float)camera->cy;
  view.inv_fx = 1.0f / view.fx;
  view.inv_fy = 1.0f / view.fy;
  return view;
}

static hbil_transform_args rounded(const double m[16]) {
  hbil_transform_args args;
  for (int i = 0; i < 12; ++i)
    args.m[i] = (float)m[i];
  return args;
}

hbil_transform_args camera_to_world(const hbil_camera *camera) {
  return rounded(camera->world_from_view);
}

hbil_transform_args camera_view_from_normals(const hbil_camera *camera,
                                             const hbil_config *config) {
  double m[16] = {0};
  for (int i = 0; i < 4; ++i)
    m[5 * i] = 1;
  if (config->inputs.normal_space == HBIL_SPACE_WORLD)
    inverse(camera->world_from_view, m);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      m[4 * r + c] *= (double)config->inputs.normal_scale[c];
  return rounded(m);
}

hbil_transform_args camera_between(const hbil_camera *from,
                                   const hbil_camera *to) {
  double product[16] = {0}, to_view[16];
  /* A camera that has not moved is exactly the identity, not a product that
   * rounds to nearly that. */
  if (!memcmp(from->world_from_view, to->world_from_view,
              sizeof from->world_from_view)) {
    for (int i = 0; i < 4; ++i)
      product[5 * i] = 1;
    return rounded(product);
  }
  inverse(to->world_from_view, to_view);
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      for (int k = 0; k < 4; ++k)
        product[4 * r + c] +=
            at(to_view, r, k) * at(from->world_from_view, k, c);
  return rounded(product);
}

hbil_transform_args camera_to_cache(const hbil_camera *camera,
                                    const double centre[3], double scale,
                                    double unit) {
  double m[16];
  memcpy(m, camera->world_from_view, sizeof m);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c)
      m[4 * r + c] *= scale / unit;
    m[4 * r + 3] = (m[4 * r + 3] - centre[r]) * scale;
  }
  return rounded(m);
}

hbil_transform_args camera_from_cache(const hbil_camera *camera,
                                      const double centre[3], double scale,
                                      double unit) {
  double m[16], shifted[16];
  memcpy(shifted, camera->world_from_view, sizeof shifted);
  for (int r = 0; r < 3; ++r)
    shifted[4 * r + 3] -= centre[r];
  inverse(shifted, m);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c)
      m[4 * r + c] *= unit / scale;
    m[4 * r + 3] *= unit;
  }
  return rounded(m);
}
