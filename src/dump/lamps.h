/* Which pixels of a picture of direct light show lamps. */
#ifndef HBIL_DUMP_LAMPS_H
#define HBIL_DUMP_LAMPS_H

#include "dump/gbuffer.h"

/*
 * From which radiance over albedo on pixels show lamps; 0 if none do.
 *
 * Lamps are evenly bright, far brighter than everything else, and the light
 * that they send is the light that other surfaces receive.  The last point
 * tells them from patches of sunlight, which are surfaces.
 *
 * g: depth, normals, albedo, coverage if there is any, and direct light as
 * radiance.
 */
float lamps_find(const gbuffer *g);

#endif
