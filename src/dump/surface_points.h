/* The points of a frame's surfaces, from its depth and camera. */
#ifndef HBIL_DUMP_SURFACE_POINTS_H
#define HBIL_DUMP_SURFACE_POINTS_H

#include "dump/gbuffer.h"
#include "dump/matrix3.h"

typedef struct surface_points {
  const gbuffer *g; /* converted (convert.h) */
  const hbil_camera *camera;
  hbil_inputs inputs;       /* how the library reads its planes */
  double hardware_depth[2]; /* as in hbil_frame */
  size_t row_step;          /* see surface_next() */
} surface_points;

/* camera: of g's map, or another one that is tried. */
surface_points surface_points_of(const gbuffer *g, const hbil_camera *camera);

/* Whether all rays are parallel: the camera is orthographic. */
int surface_rays_are_parallel(const surface_points *s);

/* The pixel after i that a check looks at.  Checks tell shares of a picture,
 * for which some hundred thousand pixels are enough.  Of larger pictures they
 * see every row_step-th row: 90 of 720, 34 of 2160. */
size_t surface_next(const surface_points *s, size_t i);

/* How many pixels that are, from the first one on. */
size_t surface_looks(const surface_points *s);

/* The planar depth of a pixel; 0 if it shows no surface.  The library decodes
 * depth on the device.  The host does it here alone, for what happens before a
 * plan exists or without one: recognising conventions, checking frames, the
 * exact integral, and means over surfaces. */
double surface_depth(const surface_points *s, size_t x, size_t y);

/* Whether a value of the depth plane is that of a surface. */
int surface_is_shown(const surface_points *s, float stored);

/* The point of a pixel in view space.  other: the point that it would be if the
 * file's depth were along the ray where it was taken as planar, or the other
 * way round.  Both are the same for parallel rays. */
void surface_point(const surface_points *s, size_t x, size_t y, int other,
                   double out[3]);

/* The rotation that brings vectors of that space into view space. */
matrix3 surface_view_from(const surface_points *s, dump_space space);

/* What brings the G-buffer's normals into view space. */
matrix3 surface_view_from_normals(const surface_points *s);

/* Replaces depths by planar ones in camera units, 0 where there is no surface,
 * and changes the map to say so. */
void surface_depths_make_planar(gbuffer *g);

#endif
