/* Three stages that work at the same time, each on another item: while one
 * frame is computed, the next one is read and the previous one is written. */
#ifndef HBIL_TOOL_PIPELINE_H
#define HBIL_TOOL_PIPELINE_H

#include "image/error.h"

#include <stddef.h>

#include <stddef.h>

/* How many items are in the pipeline at most: one in each stage and one that
 * waits, so that a stage whose time varies doesn't stop the next one.  Item i
 * may use slot i % PIPELINE_SLOTS of a caller's array; no other item uses it
 * meanwhile. */
enum { PIPELINE_STAGES = 3, PIPELINE_SLOTS = PIPELINE_STAGES + 1 };

/* Returns 0, or -1 with `error` filled. */
typedef int pipeline_stage(void *user, size_t item, image_error *error);

typedef struct pipeline {
  pipeline_stage *stages[PIPELINE_STAGES];
  void *user; /* handed to the stages */
  size_t items;
  double (*seconds)[PIPELINE_STAGES]; /* of each item; filled in */
} pipeline;

/*
 * Every stage takes the items in order, each after the previous stage is done
 * with it.  The middle stage runs on the calling thread.  If an item fails, it
 * and those behind it go no further, and those in front of it are finished.  So
 * what is done, and the error, are the same in every run.  Returns 0, or -1
 * with `error` filled.
 */
int pipeline_run(const pipeline *p, image_error *error);

#endif
