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

surface exact_surface_at(const exact_frame *frame, const exact_planes *split,
                         int x, int y) {
  const bool parallel = exact_is_orthographic(frame->config);
  surface s = {false, 0.0, 0.0, 0.0, 0.0, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
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
