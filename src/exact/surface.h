/* A visible point of the scene, from SPLIT. */
#ifndef HBIL_EXACT_SURFACE_H
#define HBIL_EXACT_SURFACE_H

#include "exact/exact.h"
#include "exact/vector.h"

typedef struct surface {
  bool is;     /* false: sky, or outside the picture; only w is set then */
  double w;    /* inverse depth; orthographic: -z */
  double unit; /* what rounding of w is relative to: w; orthographic: 1 */
  double grad_x, grad_y; /* gradient of the tangent plane's w, per unit of the
                    ray's x and y; orthographic: per world unit */
  vec3 ray, at, normal;  /* the pixel's ray, the point, the unit normal */
} surface;

surface exact_surface_at(const exact_frame *frame, const exact_planes *split,
                         int x, int y);

#endif
