/* Three stages that work at the same time, each on another item: while one
 * frame is computed, the next one is read and the previous one is written. */
#ifndef HBIL_TOOL_PIPELINE_H
#define HBIL_TOOL_PIPELINE_H

#include "image/error.h"

#include <stddef.h>

/* How far a stage may be ahead of the next one: its item may begin when that
 * has done with the item `depth` before.  With 2, a stage works while the next
 * one does, and what it hands on has two places: item i may use i % depth of
 * them.  With 1 there is one place, so neighbours work in turns, and the first
 * stage while the last one does. */
enum { PIPELINE_STAGES = 3, PIPELINE_DEPTH = 2 };

/* How many items are in the pipeline at most.  What an item has from the first
 * stage to the last may be in place i % PIPELINE_SLOTS. */
enum { PIPELINE_SLOTS = 2 * PIPELINE_DEPTH };

/* Returns 0, or -1 with `error` filled. */
typedef int pipeline_stage(void *user, size_t item, image_error *error);

typedef struct pipeline {
  pipeline_stage *stages[PIPELINE_STAGES];
  void *user; /* handed to the stages */
  size_t items;
  size_t depth;                       /* 1..PIPELINE_DEPTH */
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
