/* Checks that positions fit depth and camera. */
#ifndef HBIL_DUMP_CHECK_POSITIONS_H
#define HBIL_DUMP_CHECK_POSITIONS_H

#include "dump/findings.h"
#include "dump/surface_points.h"

/* Returns the largest distance between the file's positions and those computed
 * from depth and camera, as a share of the distance from the eye, or, with
 * parallel rays, of the picture's width; NaN if there are no positions, or the
 * depth comes from them.  Adds what is probably wrong to the findings. */
double check_positions(const surface_points *s, findings *out);

#endif
