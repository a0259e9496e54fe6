/* The planes of a frame's own file, held from one reading of it to the next:
 * the camera, the conventions, the light and at last the frame itself are each
 * made of some of them, and decompressing a file takes longer than all this. */
#ifndef HBIL_DUMP_HELD_PLANES_H
#define HBIL_DUMP_HELD_PLANES_H

#include "dump/channel_map.h"
#include "image/error.h"
#include "image/image.h"

typedef struct held_planes {
  image planes;   /* as the file has them */
  int is_read;    /* whether they are there */
  int is_last;    /* set by the caller: the next reader may take them along */
  int is_over;    /* nothing is held any more */
  double seconds; /* that reading the file took */
} held_planes;

/* Does what image_read() does, with the map's held planes if it has some.  The
 * first call reads all channels of the frame's own file that the map names. */
int held_planes_read(const char *path, const channel_map *map,
                     const char *const *names, size_t count, image *out,
                     image_error *error);

/* Frees the planes.  It may be called on zeroed ones, and twice. */
void held_planes_free(held_planes *h);

#endif
