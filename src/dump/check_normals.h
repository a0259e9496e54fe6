/* Checks that normals fit the depth. */
#ifndef HBIL_DUMP_CHECK_NORMALS_H
#define HBIL_DUMP_CHECK_NORMALS_H

#include "dump/findings.h"
#include "dump/surface_points.h"

/* deepest: the largest depth.  Returns the mean cosine between the normals and
 * those that the depth has; NaN if too few pixels tell.  Adds what is probably
 * wrong, and the option that corrects it, to the findings. */
double check_normals(const surface_points *s, double deepest, findings *out);

#endif
