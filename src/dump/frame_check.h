/* Checks that a frame's depth, normals, positions, camera and colours fit
 * together, and names the option that corrects what doesn't. */
#ifndef HBIL_DUMP_FRAME_CHECK_H
#define HBIL_DUMP_FRAME_CHECK_H

#include "dump/findings.h"
#include "dump/gbuffer.h"

typedef struct frame_check {
  double agreement; /* mean cosine between the normals and those that the depth
                       has; NaN: unknown */
  double facing;    /* share of the normals that face the eye */
  double positions; /* see check_positions() */
  double low, high; /* range of planar depths */
  double surface;   /* share of the pixels that show a surface */
  findings found;   /* empty for frames that fit together */
} frame_check;

/* config: NULL for a view, which gets no result: its radius, surfaces that
 * would be black in it, and a lack of surfaces aren't told.  Of larger pictures
 * only some rows are looked at (surface_next()). */
void frame_check_run(const gbuffer *g, const hbil_config *config,
                     const hbil_camera *camera, frame_check *out);

/* The same from all pixels, for whoever prints the numbers. */
void frame_check_whole(const gbuffer *g, const hbil_config *config,
                       const hbil_camera *camera, frame_check *out);

#endif
