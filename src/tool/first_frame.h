/* The first frame of a job, which is read before the others: its pixels decide
 * about the light, and with it what the kernels are built for.  It is checked
 * while they are built. */
#ifndef HBIL_TOOL_FIRST_FRAME_H
#define HBIL_TOOL_FIRST_FRAME_H

#include "dump/frame_check.h"
#include "dump/gbuffer.h"
#include "tool/job.h"
#include "image/error.h"

#include <pthread.h>

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

/* The roles of a frame, a bit mask, that the computation uses. */
unsigned frame_roles(const job *j);

/* Reads frame 0 of the job, with its positions, which only a check needs.  f is
 * zeroed before.  0, or -1 with `error` filled. */
int first_frame_read(first_frame *f, job *j, image_error *error);

/* Begins to read the frame, if it isn't there, and to check it, on a thread.
 * From here on, nothing of the job changes that either reads. */
void first_frame_begin(first_frame *f, job *j);

/* Waits for the thread and hands the frame over, which the caller frees, and
 * what the check found; *checked: whether there was one.  Returns 1 for a
 * frame, 0 if the frame has to be read, or -1 with `error` filled. */
int first_frame_take(first_frame *f, gbuffer *out, frame_check *check,
                     int *checked, image_error *error);

/* Frees what nobody has taken.  It may be called on a zeroed first_frame. */
void first_frame_free(first_frame *f);

#endif
