/*
 * A visible point and its tangent plane.
 *
 * The plane through P with normal n is met by the ray r' at depth z' with
 * z' n.r' = n.P, so its inverse depth there is w' = n.r' / n.P: an affine
 * function of the ray's x and y, with the gradient (n.x, n.y) / n.P.  For an
 * orthographic camera, going e along the image changes z by -n.e / n.z, so the
 * gradient of w = -z is (n.x, n.y) / n.z.
 */
#include "exact/surface.h"

#include "exact/camera.h"
#include "exact/planes.h"
#include "exact/settings.h"
#include "shared.h"

#include <string.h>

surface exact_surface_at(const exact_frame *frame, const exact_planes *split,
                         int x, int y) {
  const bool parallel = exact_is_orthographic(frame->config);
  surface s;
  memset(&s, 0, sizeof(s));
  s.w = exact_planes_contain(split, x, y) ? *exact_at(split, HBIL_SPLIT_W, x, y)
                                          : (double)HBIL_NOTHING;
  s.is = exact_is_surface(frame->config, s.w);
  if (!s.is)
    return s;
  s.unit = parallel ? 1.0 : s.w;
  s.ray = exact_ray(frame, x, y);
  s.at = exact_point(frame, x, y, exact_depth_of_w(frame->config, s.w));
  s.normal = vec_normalize(vec(*exact_at(split, HBIL_SPLIT_NORMAL, x, y),
                               *exact_at(split, HBIL_SPLIT_NORMAL + 1, x, y),
                               *exact_at(split, HBIL_SPLIT_NORMAL + 2, x, y)));
  const double to_plane = parallel ? s.normal.z : vec_dot(s.normal, s.at);
  s.grad_x = s.normal.x / to_plane;
  s.grad_y = s.normal.y / to_plane;
  return s;
}

double exact_w_at(const exact_frame *frame, const exact_planes *split, int x,
                  int y) {
  if (!exact_planes_contain(split, x, y))
    return NAN;
  const double w = *exact_at(split, HBIL_SPLIT_W, x, y);
  return exact_is_surface(frame->config, w) ? w : NAN;
}

double exact_slope_along(const exact_frame *frame, const exact_planes *split,
                         int x, int y, int dx, int dy, double otherwise) {
  const double w = exact_w_at(frame, split, x, y);
  double step[2], bend[2];
  for (int side = 0; side < 2; ++side) {
    const int sx = side ? dx : -dx, sy = side ? dy : -dy;
    const double first = exact_w_at(frame, split, x + sx, y + sy);
    const double second = exact_w_at(frame, split, x + 2 * sx, y + 2 * sy);
    step[side] = first - w;
    bend[side] = fabs((isnan(second) ? 0.0 : second - first) - step[side]);
  }
  if (isnan(step[0]) || isnan(step[1]))
    return !isnan(step[0]) ? -step[0] : !isnan(step[1]) ? step[1] : otherwise;
  if (fabs(bend[0] - bend[1]) <= ldexp(bend[0] + bend[1], -16))
    return 0.5 * (step[1] - step[0]);
  return bend[1] < bend[0] ? step[1] : -step[0];
}

void exact_surface_slope(const exact_frame *frame, const exact_planes *split,
                         int x, int y, surface *s) {
  const double fx = frame->camera.fx, fy = frame->camera.fy;
  s->slope_x = fx * exact_slope_along(frame, split, x, y, 1, 0, s->grad_x / fx);
  s->slope_y = fy * exact_slope_along(frame, split, x, y, 0, 1, s->grad_y / fy);
}
