/*
 * Converts what of a renderer's planes the library can't read.  Depth of any
 * kind and unit, and normals in any space with any signs, stay as they are
 * stored; channel_map_configure() describes them to the library.  Converted
 * are, because no renderer has them on its device or because it is a sum over
 * planes:
 *   depth      from positions, or with the part in front of the near plane
 *   normals    from (n + 1) / 2 in floats
 *   positions  to world space, for checks alone
 *   light      from sRGB; direct and indirect light divided by albedo; lamps
 * and sky that direct light shows become emission all        what is multiplied
 * with a pixel's coverage is divided by it motion     with another zero
 */
#ifndef HBIL_DUMP_CONVERT_H
#define HBIL_DUMP_CONVERT_H

#include "dump/gbuffer.h"
#include "image/error.h"

/* g: planes as they were read; its map describes them and has the camera that
 * the conversion needs.  If depth is computed from positions, a depth plane is
 * added.  Returns 0, or -1 with `error` filled if memory runs out. */
int convert_planes(const char *path, gbuffer *g, image_error *error);

#endif
