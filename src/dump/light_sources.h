/*
 * Lamps and sky in a picture of direct light.
 *
 * Integrators of direct light also show the lamps and the sky that the eye sees
 * directly.  That is radiance which is emitted, and no light that falls on
 * something.
 */
#ifndef HBIL_DUMP_LIGHT_SOURCES_H
#define HBIL_DUMP_LIGHT_SOURCES_H

#include "dump/gbuffer.h"

/* Moves the radiance of lamps and sky from direct light to a new plane of
 * emission, and divides the rest by the albedo.  Where a pixel shows both, its
 * irradiance is that of its neighbours.  0, or -1 if memory runs out. */
int light_sources_split(gbuffer *g);

#endif
