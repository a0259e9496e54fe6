/*
 * The checksum of an OpenEXR file, stored in the file's header. It covers all
 * bytes of the file except its own digits. It covers bytes rather than pixels
 * because lossy compression changes the pixels that were written, and because
 * bytes can be checked without decoding.
 */
#ifndef HBIL_IMAGE_EXR_CHECKSUM_H
#define HBIL_IMAGE_EXR_CHECKSUM_H

#include "image/error.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The attribute, a text, and what it holds until the file is complete: room for
 * the checksum. */
#define EXR_CHECKSUM "hbilChecksum"
#define EXR_CHECKSUM_ROOM "----------------"

typedef enum exr_checksum_state {
  EXR_CHECKSUM_MISSING = 0, /* the header has none or cannot be read */
  EXR_CHECKSUM_WRONG,       /* the file is damaged or was changed */
  EXR_CHECKSUM_RIGHT
} exr_checksum_state;

typedef struct exr_checksum exr_checksum;

/* NULL if memory runs out. */
exr_checksum *exr_checksum_new(void);
void exr_checksum_free(exr_checksum *c);

/* Takes in the next bytes behind the table of chunks. */
void exr_checksum_add(exr_checksum *c, const void *bytes, size_t size);

/* Fills in the checksum of a complete file of one part, open for reading and
 * writing, whose header has room for it.  chunks: where the first one begins,
 * from which on all has been added.  path: for messages.  0, or -1 with `error`
 * filled. */
int exr_checksum_store(exr_checksum *c, int fd, uint64_t chunks,
                       const char *path, image_error *error);

/* Compares a file with its checksum. */
exr_checksum_state exr_checksum_look(const char *path);

#ifdef __cplusplus
}
#endif

#endif
