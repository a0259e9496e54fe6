/*
 * Files that appear whole or not at all: written under a temporary name in
 * the same folder, then renamed.
 */
#ifndef HBIL_TEMPORARY_H
#define HBIL_TEMPORARY_H

#include "image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A name beside `path`, to be given to one of the two below; NULL with
 * `error` filled when out of memory. */
char *temporary_name(const char *path, image_error *error);

/* Renames to `path`; on failure the temporary file is gone.  Frees name. */
int temporary_commit(char *name, const char *path, image_error *error);

/* Removes the file, if any.  Frees name; NULL is allowed. */
void temporary_discard(char *name);

#ifdef __cplusplus
}
#endif

#endif
