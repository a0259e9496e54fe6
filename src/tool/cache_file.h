/* A radiance cache in a file. */
#ifndef HBIL_TOOL_CACHE_FILE_H
#define HBIL_TOOL_CACHE_FILE_H

#include "hbil/hbil.h"
#include "image/error.h"
#include "image/temporary.h"

#include <stdint.h>

/* What a file says of its cache. */
typedef struct cache_file {
  uint32_t voxels, levels;
  double voxel_size;
  double centre[3];
  uint64_t size; /* bytes of hbil_cache_save() */
  uint64_t hash; /* of everything in the file */
} cache_file;

/* Whether a file begins like a radiance cache, of any version and damaged or
 * not. */
int cache_file_recognise(const char *path);

/* Reads what the file says of its cache, and checks that it is complete, was
 * written by this version, and says something possible.  0, or -1 with `error`
 * filled. */
int cache_file_read(const char *path, cache_file *out, image_error *error);

/* Reads the bytes for hbil_cache_load(), file->size of them, and checks that
 * the file has not changed and is not damaged.  0, or -1 with `error` filled.
 */
int cache_file_read_bytes(const char *path, const cache_file *file, void *bytes,
                          image_error *error);

/* Writes the file, which appears complete or not at all.  file->hash is filled
 * in.  0, or -1 with `error` filled. */
int cache_file_write(const char *path, cache_file *file, const void *bytes,
                     existing_file existing, image_error *error);

#endif
