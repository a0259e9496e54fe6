/* Reads the G-buffer of a frame from its files. */
#ifndef HBIL_DUMP_READ_GBUFFER_H
#define HBIL_DUMP_READ_GBUFFER_H

#include "dump/gbuffer.h"
#include "image/error.h"

/*
 * Reads the roles of the bit mask (1 << role) that the map has, places them in
 * the map's window, and converts what the library can't read (convert.h).
 * A background pass is added to the emission.  Returns 0 and a G-buffer that
 * gbuffer_free() frees, or -1 with `error` filled and nothing to free.
 */
int gbuffer_read(const char *path, const channel_map *map, unsigned roles,
                 gbuffer *out, image_error *error);

/* The same without any conversion of numbers: planes as they are stored. */
int gbuffer_read_as_stored(const char *path, const channel_map *map,
                           unsigned roles, gbuffer *out, image_error *error);

/* Bytes that the planes take in an image_memory while they are read. */
size_t gbuffer_read_bytes(const channel_map *map, unsigned roles);

#endif
