/*
 * Files that appear complete or not at all: they are written under a temporary
 * name in the same folder and then renamed.  temporary_write() does all of it,
 * for what a stream can take; for other writers,
 *
 *   temporary t;
 *   if (temporary_open(path, &t, error) != 0) ...
 *   write the file, through temporary_stream(&t), or through t.fd or a copy of
 *   it; then temporary_commit(&t, path, existing, error), or
 *   temporary_discard(&t)
 *
 * Any number of jobs may do so in one folder: names are drawn at random and are
 * nobody else's, and the file is locked while its job lives.  A job that is
 * killed leaves a file without a lock, which the next job removes
 * (temporary_sweep.h).
 */
#ifndef HBIL_IMAGE_TEMPORARY_H
#define HBIL_IMAGE_TEMPORARY_H

#include "image/error.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct temporary {
  char *name; /* the path of the file */
  int fd;     /* for reading and writing; it holds the lock */
} temporary;

/* What becomes of a file that has the name already. */
typedef enum existing_file {
  EXISTING_REPLACED = 0,
  EXISTING_STAYS /* the new file is given up, which is an error */
} existing_file;

/* Creates the file beside `path`.  0, or -1 with `error` filled. */
int temporary_open(const char *path, temporary *out, image_error *error);

/* A stream that writes to the file; fclose() leaves the file locked.  NULL with
 * errno set on failure. */
FILE *temporary_stream(const temporary *t);

/* Renames the file to `path`.  If several jobs want one name and replace
 * nothing, exactly one of them gets it.  Removes the file if that fails.  0, or
 * -1 with `error` filled. */
int temporary_commit(temporary *t, const char *path, existing_file existing,
                     image_error *error);

/* Removes the file. */
void temporary_discard(temporary *t);

/* Writes a file's content.  Failures are those of the stream. */
typedef void file_writer(const void *content, FILE *out);

/* All of the above: a file of what `write` writes.  0, or -1 with `error`
 * filled. */
int temporary_write(const char *path, existing_file existing,
                    file_writer *write, const void *content,
                    image_error *error);

#ifdef __cplusplus
}
#endif

#endif
