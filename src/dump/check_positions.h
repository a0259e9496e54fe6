/* Checks that positions fit depth and camera. */
#ifndef HBIL_DUMP_CHECK_POSITIONS_H
#define HBIL_DUMP_CHECK_POSITIONS_H

#include "dump/findings.h"
#include "dump/surface_points.h"

/* Compares the file's positions with those computed from depth and camera.
 * Returns the distance between both that nine tenths of them don't exceed, as a
 * share of the distance from the eye, or, with parallel rays, of the picture's
 * width; NaN if there are no positions, or the depth comes from them.  Single
 * ones may be off: at edges, and where samples are not in the pixels' middles.
 * Adds what is probably wrong to the findings. */
double check_positions(const surface_points *s, findings *out);

/* Adds what is wrong with the camera by the positions alone.  Returns whether
 * something is; nothing else can then be told from the frame. */
int check_positions_camera(const surface_points *s, findings *out);

#endif
