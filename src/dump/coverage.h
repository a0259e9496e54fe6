/* Passes that are multiplied with a pixel's coverage. */
#ifndef HBIL_DUMP_COVERAGE_H
#define HBIL_DUMP_COVERAGE_H

#include "dump/gbuffer.h"

/* Divides depth, normals, positions and albedo by the coverage, if the map says
 * that they are multiplied with it.  light_sources.h is for the light. */
void coverage_divide(gbuffer *g);

#endif
