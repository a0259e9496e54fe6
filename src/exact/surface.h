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
  /* The same of the surface itself, whose normal may differ from the shading
   * normal; only where exact_surface_slope() was called. */
  double slope_x, slope_y;
  vec3 ray, at, normal; /* the pixel's ray, the point, the unit normal */
} surface;

surface exact_surface_at(const exact_frame *frame, const exact_planes *split,
                         int x, int y);
/* w of a pixel, or NAN where there is no surface. */
double exact_w_at(const exact_frame *frame, const exact_planes *split, int x,
                  int y);
/* The change of w from the surface at (x, y) to (x + dx, y + dy), its
 * neighbour: the difference to the neighbour on the side where the surface goes
 * on, which is where the second difference is smaller; the mean of both sides
 * where they are alike.  A second neighbour that shows no surface counts as
 * equal to the first.  otherwise: without a neighbour. */
double exact_slope_along(const exact_frame *frame, const exact_planes *split,
                         int x, int y, int dx, int dy, double otherwise);
/* Finds the slope of a surface from the pixels about it. */
void exact_surface_slope(const exact_frame *frame, const exact_planes *split,
                         int x, int y, surface *s);

#endif
