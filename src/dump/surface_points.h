/* The points of a frame's surfaces, from its depth and camera. */
#ifndef HBIL_DUMP_SURFACE_POINTS_H
#define HBIL_DUMP_SURFACE_POINTS_H

#include "dump/gbuffer.h"
#include "dump/matrix3.h"

typedef struct surface_points {
  const gbuffer *g; /* converted (convert.h) */
  const hbil_camera *camera;
  float sky_depth; /* as in hbil_config */
} surface_points;

/* Whether all rays are parallel: the camera is orthographic. */
int surface_rays_are_parallel(const surface_points *s);

/* The planar depth of a pixel; 0 if it shows no surface. */
double surface_depth(const surface_points *s, size_t x, size_t y);

/* The point of a pixel in view space.  other: the point that it would be if the
 * file's depth were along the ray where it was taken as planar, or the other
 * way round.  Both are the same for parallel rays. */
void surface_point(const surface_points *s, size_t x, size_t y, int other,
                   double out[3]);

/* The rotation that brings vectors of that space into view space. */
matrix3 surface_view_from(const surface_points *s, dump_space space);

#endif
