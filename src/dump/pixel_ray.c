/* Where a pixel looks. */
#include "dump/pixel_ray.h"

pixel_ray pixel_ray_at(hbil_projection projection, const hbil_camera *camera,
                       size_t x, size_t y) {
  const double right = ((double)x + 0.5 - camera->cx) / camera->fx;
  const double down = ((double)y + 0.5 - camera->cy) / camera->fy;
  return projection == HBIL_PROJECTION_ORTHOGRAPHIC
             ? (pixel_ray){.from = {right, down, 0}, .along = {0, 0, 1}}
             : (pixel_ray){.from = {0, 0, 0}, .along = {right, down, 1}};
}
