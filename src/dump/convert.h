/*
 * Converts planes from a renderer's conventions to the library's: depth along
 * the camera's axis, normals of full range in world or view space, positions in
 * world space, linear light.  Planes that already follow the library's
 * conventions are passed through unchanged.
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
