/* Checks that colours are linear and that direct light is direct light. */
#ifndef HBIL_DUMP_CHECK_COLOURS_H
#define HBIL_DUMP_CHECK_COLOURS_H

#include "dump/findings.h"
#include "dump/surface_points.h"

/* is_lit: whether the frame's result is to have surfaces without albedo, too.
 */
void check_colours(const surface_points *s, int is_lit, findings *out);

#endif
