/* The files that a command reads and those that it writes, and whether it would
 * lose one of them. */
#ifndef HBIL_TOOL_FILE_USES_H
#define HBIL_TOOL_FILE_USES_H

#include "image/error.h"
#include "tool/file_kind.h"

#include <stddef.h>
#include <sys/types.h>

/* Which file a path leads to, whether that file exists or not. */
typedef struct file_place {
  dev_t disk; /* with inode: the file, or the nearest folder that exists */
  ino_t inode;
  char *rest; /* the way from that folder; "" if the file exists; owned */
} file_place;

typedef struct file_use {
  char *path;        /* owned */
  const char *what;  /* "the frame"; "the result"; "--cache-save" */
  const char *frame; /* of what is written: the frame it is made of; or NULL */
  const char *need;  /* of what is written: what the error message asks for,
                      * in front of its word "needed", such as "another name
                      * is"; NULL: it is read */
  file_kind kind; /* of what is written; FILE_ABSENT: the name is hbil's own */
  size_t index;   /* in the order in which files were added */
  file_place place;
} file_use;

typedef struct file_uses {
  file_use *list;
  size_t count, room;
} file_uses;

/* Appends a file, and takes over use->path, malloc'd; NULL means that memory
 * ran out.  The other texts must outlive the list.  All files that are read
 * come before those that are written.  0, or -1 with `error` filled. */
int file_uses_add(file_uses *uses, file_use use, image_error *error);

/* The same for a file that is read.  The path is copied. */
int file_uses_read(file_uses *uses, const char *path, const char *what,
                   image_error *error);

/* The same for a file that is written because an option names it.  The path is
 * copied. */
int file_uses_write(file_uses *uses, const char *path, const char *option,
                    const char *need, file_kind kind, image_error *error);

/* Whether a file that an option names may replace what is there: only its own
 * kind, or nothing; and whether its name says what it is.  0, or -1 with
 * `error` filled. */
int file_use_may_replace(const file_use *use, file_kind there,
                         image_error *error);

/* Whether each written file has a place that no other one of the list has.
 * 0, or -1 with `error` filled. */
int file_uses_check(file_uses *uses, image_error *error);

/* It may be called on a zeroed list. */
void file_uses_free(file_uses *uses);

/* Whether a folder that is missing is there once another one is: it is that one
 * or lies above it. */
int file_place_is_made_with(const char *folder, const char *other);

#endif
