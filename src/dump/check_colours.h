/* Checks that colours are linear and that direct light is direct light. */
#ifndef HBIL_DUMP_CHECK_COLOURS_H
#define HBIL_DUMP_CHECK_COLOURS_H

#include "dump/findings.h"
#include "dump/surface_points.h"

/* is_lit: the frame gets a result, so surfaces that will be black in it are
 * told. */
void check_colours(const surface_points *s, int is_lit, findings *out);

#endif
