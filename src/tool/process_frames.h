/*
 * Frames on their way through a job: process_frames.c reads and lights them,
 * process_encode.c writes them.
 */
#ifndef HBIL_TOOL_PROCESS_FRAMES_H
#define HBIL_TOOL_PROCESS_FRAMES_H

/* goes first: the kernels' header has parameters named layer */
#include "tool/process.h"

#include "tool/contact_sheet.h"

/* A frame on its way. */
typedef struct slot {
  gbuffer g;
  uint64_t hash; /* of what the library is given */
  image kept;    /* its own channels that go on into the result */
  image result;
  resume_light light; /* what it hands on */
} slot;

typedef struct lighting {
  process *process;
  slot slots[PIPELINE_SLOTS];
  contact_sheet sheet;
  image whole; /* what is lit, where not all of it is written */
  progress progress;
  size_t needed, done; /* frames that are lit */
} lighting;

slot *process_slot(lighting *l, size_t item);
/* Whether the light of a frame is kept for the frames that are left. */
int process_hands_on(const process *p, size_t item);

/* --- process_encode.c --- */

/* A stage of the pipeline; user is a lighting. */
int process_encode(void *user, size_t item, image_error *error);
/* Before the first frame and after the last; fill process.error. */
int process_open_sheet(lighting *l);
int process_write_sheet(lighting *l);

#endif
