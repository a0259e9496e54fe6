/* Where a pixel looks. */
#ifndef HBIL_DUMP_PIXEL_RAY_H
#define HBIL_DUMP_PIXEL_RAY_H

#include "hbil/hbil.h"

/* In view space: at planar depth z the pixel sees the point from + z * along.
 */
typedef struct pixel_ray {
  double from[3], along[3];
} pixel_ray;

/* The ray through the centre of pixel (x, y). */
pixel_ray pixel_ray_at(hbil_projection projection, const hbil_camera *camera,
                       size_t x, size_t y);

#endif
