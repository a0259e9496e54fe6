/* Reads the frames of a job. */
#ifndef HBIL_TOOL_FRAME_SOURCE_H
#define HBIL_TOOL_FRAME_SOURCE_H

#include "dump/frame_check.h"
#include "dump/gbuffer.h"
#include "image/error.h"
#include "image/image.h"
#include "image/image_memory.h"
#include "tool/job.h"

#include <pthread.h>

/* ------------------------------------------------------------------------ */
/* The first frame                                                           */

typedef struct first_frame {
  const job *job;
  channel_map map; /* of the frame, whose file names the job owns */
  gbuffer g;
  frame_check check;
  image_error error;
  int is_read, is_checked; /* g, check: are there */
  int failed;              /* reading failed, as `error` says */
  int runs;                /* 1: a thread is at work */
  pthread_t thread;
  double seconds; /* that first_frame_read() took */
} first_frame;

/* Reads frame 0 of the job, with its positions, which only a check needs.  f is
 * zeroed before.  0, or -1 with `error` filled. */
int first_frame_read(first_frame *f, job *j, image_error *error);

/* Begins to read the frame, if it isn't there, and to check it, on a thread.
 * From here on, nothing of the job changes that either reads. */
void first_frame_begin(first_frame *f, job *j);

/* Waits for the check and prints what it found, for jobs that take no frame.
 * 0, or -1 with `error` filled if the frame can't be read. */
int first_frame_tell(first_frame *f, image_error *error);

/* Frees what nobody has taken.  It may be called on a zeroed first_frame. */
void first_frame_free(first_frame *f);

/* ------------------------------------------------------------------------ */
/* All frames                                                                */

typedef struct frame_source {
  const job *job;
  first_frame *first; /* which may be there already */
  int warned; /* 1: a frame's mistakes were told; other frames are alike */
} frame_source;

/* Bytes of memory that the planes of a frame take. */
size_t frame_source_bytes(const job *j, size_t item);

/* Reads the planes that the computation uses, and warns if they don't fit
 * together.  Frames are read one after the other.  memory: for the planes; it
 * is emptied, and must stay until the G-buffer is freed.  Returns 0 and a
 * G-buffer that gbuffer_free() frees, or -1 with `error` filled. */
int frame_source_read(frame_source *s, size_t item, image_memory *memory,
                      gbuffer *out, image_error *error);

/* Reads the planes of these roles of a view, or of a frame that --learn reads,
 * for the radiance cache.  Warns once of a view whose planes don't fit
 * together. Returns 0 and a G-buffer that gbuffer_free() frees, or -1 with
 * `error` filled.
 */
int frame_source_read_learnt(const job *j, const job_frame *f, int is_view,
                             unsigned roles, gbuffer *out, image_error *error);

/* Reads the frame's channels that no layer of the result replaces, in their own
 * types.  Returns 0 and an image that image_free() frees, or -1. */
int frame_source_read_copied(const frame_source *s, size_t item, image *out,
                             image_error *error);

#endif
