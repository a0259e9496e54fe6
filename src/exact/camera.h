/* Pixels, rays and points; inverse depth. */
#ifndef HBIL_EXACT_CAMERA_H
#define HBIL_EXACT_CAMERA_H

#include "exact/exact.h"
#include "exact/settings.h"
#include "exact/vector.h"
#include "shared.h"

/* A direction in world space to view space, and back. */
vec3 exact_to_view(const hbil_camera *camera, vec3 direction);
vec3 exact_to_world(const hbil_camera *camera, vec3 direction);

/* Those that follow are called for every sample, so they are inline. */

/* The pixel's position in the image plane: perspective, at depth 1. */
static inline vec3 exact_image_position(const hbil_camera *camera, double x,
                                        double y) {
  return vec((x + 0.5 - camera->cx) / camera->fx,
             (y + 0.5 - camera->cy) / camera->fy, 0.0);
}

/* The ray through a pixel, with z = 1.  x, y: pixels, fractions allowed; 0 is
 * the centre of the first pixel. */
static inline vec3 exact_ray(const exact_frame *frame, double x, double y) {
  const vec3 ray = vec(0.0, 0.0, 1.0);
  return exact_is_orthographic(frame->config)
             ? ray
             : vec_add(ray, 1.0, exact_image_position(&frame->camera, x, y));
}

/* The view-space point that a pixel shows at planar depth z. */
static inline vec3 exact_point(const exact_frame *frame, double x, double y,
                               double z) {
  const vec3 point = vec(0.0, 0.0, z);
  return vec_add(point, exact_is_orthographic(frame->config) ? 1.0 : z,
                 exact_image_position(&frame->camera, x, y));
}

/* w of a planar depth. */
static inline double exact_w_of_depth(const hbil_config *config, double z) {
  return exact_is_orthographic(config) ? -z : 1.0 / z;
}

/* Planar depth of a w. */
static inline double exact_depth_of_w(const hbil_config *config, double w) {
  return exact_is_orthographic(config) ? -w : 1.0 / w;
}

/* Whether a w is that of a surface, not HBIL_NOTHING. */
static inline bool exact_is_surface(const hbil_config *config, double w) {
  return exact_is_orthographic(config) ? w > 0.5 * (double)HBIL_NOTHING
                                       : w > 0.0;
}

/* The length that a relative depth is a share of: the depth z itself, or the
 * width of an orthographic picture. */
static inline double exact_depth_unit(const hbil_config *config,
                                      const hbil_camera *camera, double z) {
  return exact_is_orthographic(config) ? config->width / camera->fx : z;
}

#endif
