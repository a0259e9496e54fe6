/*
 * Pixels, rays and points.
 *
 * View space is right-handed: x right, y down, z forward.  A pixel's ray is
 * r = ((x + 0.5 - cx) / fx, (y + 0.5 - cy) / fy, 1), and the point it shows at
 * planar depth z is z r.  The passes store w = 1/z, because inverse depth is an
 * affine function of the pixel's position on every plane: n.P = d and P = r / w
 * give w = n.r / d.
 *
 * An orthographic camera has the ray (0, 0, 1) everywhere and the point
 * ((x + 0.5 - cx) / fx, (y + 0.5 - cy) / fy, z).  There z itself is affine on
 * planes, so w is -z, which also grows towards the eye.
 */
#include "exact/camera.h"

#include "exact/passes.h"

vec3 exact_to_view(const hbil_camera *camera, vec3 v) {
  const double *m = camera->world_from_view;
  return vec(m[0] * v.x + m[4] * v.y + m[8] * v.z,
             m[1] * v.x + m[5] * v.y + m[9] * v.z,
             m[2] * v.x + m[6] * v.y + m[10] * v.z);
}

vec3 exact_to_world(const hbil_camera *camera, vec3 v) {
  const double *m = camera->world_from_view;
  return vec(m[0] * v.x + m[1] * v.y + m[2] * v.z,
             m[4] * v.x + m[5] * v.y + m[6] * v.z,
             m[8] * v.x + m[9] * v.y + m[10] * v.z);
}

hbil_view_args exact_view(const hbil_config *config,
                          const hbil_camera *camera) {
  hbil_view_args v;
  v.width = (int)config->width;
  v.height = (int)config->height;
  v.fx = (float)camera->fx;
  v.fy = (float)camera->fy;
  v.cx = (float)camera->cx;
  v.cy = (float)camera->cy;
  v.inv_fx = 1.0f / v.fx;
  v.inv_fy = 1.0f / v.fy;
  return v;
}
