/* Checks that colours are linear and that direct light is direct light. */
#ifndef HBIL_DUMP_CHECK_COLOURS_H
#define HBIL_DUMP_CHECK_COLOURS_H

#include "dump/findings.h"
#include "dump/surface_points.h"

void check_colours(const surface_points *s, findings *out);

#endif
