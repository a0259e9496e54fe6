/*
 * Files that appear complete or not at all: they are written under a temporary
 * name in the same folder and then renamed.
 *
 *   char *temporary = temporary_name(path, error);
 *   ... write the file `temporary`, then
 *   temporary_commit(temporary, path, error), or temporary_discard(temporary)
 */
#ifndef HBIL_IMAGE_TEMPORARY_H
#define HBIL_IMAGE_TEMPORARY_H

#include "image/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Returns a name beside `path`, or NULL if memory runs out.  The caller passes
 * it to one of the two functions below, which free it. */
char *temporary_name(const char *path, image_error *error);

/* Renames the file to `path`.  Removes it if that fails. */
int temporary_commit(char *name, const char *path, image_error *error);

/* Removes the file if it exists.  A NULL name is allowed. */
void temporary_discard(char *name);

#ifdef __cplusplus
}
#endif

#endif
