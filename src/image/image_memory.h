/*
 * Memory for the planes of images that follow each other, such as the frames of
 * a sequence: what is freed and allocated anew for each of them costs the
 * kernel as much time as copying it.  Planes lie in it in the order in which
 * they were added, each behind the one before, so a device can use several of
 * them as one buffer.
 */
#ifndef HBIL_IMAGE_MEMORY_H
#define HBIL_IMAGE_MEMORY_H

#include "image/image.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct image_memory {
  unsigned char *bytes; /* owned */
  size_t size, used;
} image_memory;

/* Bytes between the beginnings of two planes of so many bytes. */
size_t image_memory_plane(size_t bytes);

/* Empties it, and makes it large enough for so many bytes if there is memory.
 * No image may have planes in it. */
void image_memory_empty(image_memory *m, size_t size);
void image_memory_free(image_memory *m); /* it may be called twice */

/* Selects the memory that image_add() takes from on the calling thread until it
 * is full; NULL: none. */
void image_memory_select(image_memory *m);

/* Room for a plane in the selected memory; NULL if there is none. */
void *image_memory_take(size_t bytes);

/* Moves the pixels of an image that are elsewhere into the selected memory, as
 * far as there is room. */
void image_memory_move(image *img);

#ifdef __cplusplus
}
#endif

#endif
