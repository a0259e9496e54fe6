/* Cameras: what kernels need of them, computed in double and rounded once. */
#include "camera.h"

#include <math.h>
#include <string.h>

/* Element (row, column) of a row-major 4x4. */
static double at(const double m[16], int row, int column) {
  return m[4 * row + column];
}

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

static bool positive(double v) {
  return isfinite(v) && v > 0.0;
}

static double determinant(const double m[16]) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    const int d = (c + 1) % 3, e = (c + 2) % 3;
    sum +=
        at(m, 0, c) * (at(m, 1, d) * at(m, 2, e) - at(m, 1, e) * at(m, 2, d));
  }
  return sum;
}

/* Columns of the rotation are unit and at right angles, to 1e-3: beyond any
 * rounding of a float matrix, below any real scale or shear. */
static bool rigid(const double m[16]) {
  const double last[4] = {0, 0, 0, 1};
  for (int i = 0; i < 16; ++i)
    if (!isfinite(m[i]))
      return false;
  for (int i = 0; i < 4; ++i)
    if (fabs(at(m, 3, i) - last[i]) > 1e-3)
      return false;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      double dot = 0;
      for (int r = 0; r < 3; ++r)
        dot += at(m, r, a) * at(m, r, b);
      if (fabs(dot - (a == b)) > 1e-3)
        return false;
    }
  return determinant(m) > 0;
}

hbil_status camera_check(hbil_context *context, const hbil_camera *camera) {
  if (!positive(camera->fx) || !positive(camera->fy))
    return fail(context, HBIL_INVALID_FRAME,
                "camera.fx, camera.fy: %g, %g; focal lengths are positive "
                "numbers of pixels",
                camera->fx, camera->fy);
  if (!isfinite(camera->cx) || !isfinite(camera->cy))
    return fail(context, HBIL_INVALID_FRAME,
                "camera.cx, camera.cy: the principal point is not finite");
  if (!rigid(camera->world_from_view))
    return fail(context, HBIL_INVALID_FRAME,
                "camera.world_from_view: not a rigid transform (finite, unit "
                "columns at right angles, not mirrored, last row 0 0 0 1)");
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

static hbil_transform_args rounded(const double m[16]) {
  hbil_transform_args args;
  for (int i = 0; i < 12; ++i)
    args.m[i] = (float)m[i];
  return args;
}

hbil_transform_args camera_to_world(const hbil_camera *camera) {
  return rounded(camera->world_from_view);
}

hbil_transform_args camera_from_world(const hbil_camera *camera) {
  double m[16];
  inverse(camera->world_from_view, m);
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
