/*
 * The history that the last frame hands on, in a file beside the results.  With
 * it an interrupted job can be continued.  The file exists while the job runs.
 */
#ifndef HBIL_TOOL_SAVED_HISTORY_H
#define HBIL_TOOL_SAVED_HISTORY_H

#include <stddef.h>
#include <stdint.h>

#include "image/error.h"
#include "tool/job.h"

typedef struct saved_history {
  uint64_t key;   /* of the frame whose history it is (job_key.h) */
  float exposure; /* of all previews */
  size_t size;    /* of bytes; 0: there is no history */
  void *bytes;    /* see lighting_history_save(); owned by the caller */
} saved_history;

/* Writes the file (job_history_path()).  0, or -1 with `error` filled. */
int saved_history_write(const char *path, const saved_history *h,
                        image_error *error);

typedef enum saved_state {
  SAVED_NOTHING = 0, /* no such file, or a whole one of another size */
  SAVED_DAMAGED,     /* its bytes are not those that this version wrote */
  SAVED_WHOLE
} saved_state;

/* Reads the file if its size is h->size, and compares it with its checksum:
 * fills in key, exposure and bytes if it is whole. */
saved_state saved_history_read(const char *path, saved_history *h);

/* Removes the file. */
void saved_history_remove(const char *path);

#endif
