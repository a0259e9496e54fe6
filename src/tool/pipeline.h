/*
 * Stages that work side by side, each on another item: while one frame is
 * computed, the next is read and the last one written.
 */
#ifndef HBIL_TOOL_PIPELINE_H
#define HBIL_TOOL_PIPELINE_H

#include "image/error.h"

#include <stddef.h>

/* Items under way at once: one a stage, and one that waits, so that a stage
 * whose time varies keeps the next one busy.  What an item needs meanwhile
 * belongs in slot item % PIPELINE_SLOTS, which only one item uses at a time. */
enum { PIPELINE_STAGES = 3, PIPELINE_SLOTS = PIPELINE_STAGES + 1 };

/* Returns 0, or fills error. */
typedef int pipeline_stage(void *user, size_t item, image_error *error);

typedef struct pipeline {
  pipeline_stage *stages[PIPELINE_STAGES];
  void *user; /* what the stages are given */
  size_t items;
  double (*seconds)[PIPELINE_STAGES]; /* of each item; filled in */
} pipeline;

/*
 * Every stage takes the items in order, each after the stage before it is done
 * with it; the middle stage runs on the calling thread.  An item that fails
 * goes no further, nor does any behind it, while those before it are finished:
 * what is done, and the error, are the same in every run.
 */
int pipeline_run(const pipeline *p, image_error *error);

#endif
