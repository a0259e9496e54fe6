/*
 * Keys: what a result was made from, as one number.  Every result stores its
 * key as an attribute of its file: a hash of the settings, of its frame and of
 * all frames before it.  So an existing result is known to be the right one.
 */
#ifndef HBIL_TOOL_JOB_KEY_H
#define HBIL_TOOL_JOB_KEY_H

#include "tool/job.h"
#include "image/error.h"
#include "image/image.h"

#include <stdint.h>

/* The key before the first frame: a hash of the tool's version, the device (its
 * name and driver; "" for none) and all that changes a bit of a result, with
 * what the radiance cache knows before the first frame.  0, or -1 with `error`
 * filled. */
int job_key_begin(const job *j, const char *device, uint64_t *key,
                  image_error *error);

/* The key of a frame, from that of the frame before it: takes in the frame's
 * files, how they are read, and its camera.  0, or -1 with `error` filled. */
int job_key_next(const job_frame *f, uint64_t *key, image_error *error);

/* Whether a text is the key of a result. */
int job_key_is_valid(const char *text);

/* Stores the key in a result that is about to be written. */
void job_key_sign(image *result, uint64_t key);

typedef enum result_state {
  RESULT_MISSING = 0, /* no such file, or it has no key */
  RESULT_OTHER,       /* it has another key */
  RESULT_DAMAGED,     /* it has this key, and its bytes are not those that were
                       * written; or nothing tells whether they are, since an
                       * older version wrote no checksum */
  RESULT_FINISHED     /* it has this key and is whole */
} result_state;

/* Looks at the file of a result.  Its bytes are read, its pixels not decoded.
 */
result_state job_key_look(const char *result, uint64_t key);

#endif
