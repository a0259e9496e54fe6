/* Takes the frames of a job through reading, computing and writing. */
#ifndef HBIL_TOOL_RUN_FRAMES_H
#define HBIL_TOOL_RUN_FRAMES_H

#include "tool/encode.h"
#include "tool/frame_source.h"
#include "tool/job.h"
#include "tool/lighting.h"
#include "tool/pipeline.h"
#include "tool/resume.h"
#include "image/error.h"

/* What was measured, of all places. */
typedef struct frame_times {
  timing_row *rows;                  /* of each frame; owned */
  double (*stages)[PIPELINE_STAGES]; /* seconds of each frame; owned */
  double wall;                       /* seconds for all frames */
  size_t computed;                   /* frames */
} frame_times;

/* 0, or -1 with `error` filled; frame_times_free() frees them in both cases. */
int frame_times_make(frame_times *times, const job *whole, image_error *error);

/* Computes all frames of a place that are needed, writes what is missing, and
 * adds to the times.  Returns 0, or -1 with `error` filled. */
int run_frames(const job *j, first_frame *first, lighting *l, resume *r,
               encoder *e, frame_times *times, image_error *error);

void frame_times_free(frame_times *times);

#endif
