/*
 * A job of `hbil process`, as the files that do it share it: process.c checks
 * and opens, process_resume.c finds what is there already, process_frames.c and
 * process_encode.c take the frames through it.
 */
#ifndef HBIL_TOOL_PROCESS_H
#define HBIL_TOOL_PROCESS_H

#include "tool/exact.h"
#include "tool/pipeline.h"
#include "tool/resume.h"
#include "tool/tool.h"

#include <sys/types.h>

/* One frame of the job. */
typedef struct job {
  const char *path;
  dev_t disk; /* where the file is, whatever its name */
  ino_t inode;
  char *stem; /* DIR/NAME, without .exr */
  channel_map map;
  view view;
  camera_file camera; /* of the pixels that are lit */
  uint64_t key;       /* resume.h; 0: not known yet */
  int finished;       /* its result is there */
} job;

typedef struct process {
  const process_options *options;
  hbil_config config;
  unsigned layers;
  float environment[9][3];
  job *jobs;
  timing_row *rows;
  double (*seconds)[PIPELINE_STAGES]; /* of each frame in each stage */
  double wall;                        /* seconds for all of them */
  size_t lit;                         /* frames that were lit */
  int count;
  image_window window;    /* pixels that are lit: all that any frame has */
  image_window shown;     /* pixels that are written */
  uint32_t width, height; /* of window */
  int folder_created;
  device device;
  sequence *sequence; /* one of both */
  exact_sequence *exact;
  float exposure;
  uint64_t settings;  /* the key before the first frame */
  resume_light light; /* what frames hand on */
  int first, end;     /* of the frames that are lit */
  int warned;         /* of what a frame's pixels show */
  image_error error;
} process;

/* The three, one after the other; malloc'd. */
char *process_join(const char *a, const char *between, const char *b);

/* "hbil: PATH: warning: WHAT" */
void process_warn(const char *path, const char *what);

/* --- process_resume.c --- */

/* Fills in the job's key, and those of the jobs before it. */
int process_find_key(const process *p, job *j, image_error *error);
/* The file of a layer's picture; malloc'd. */
char *process_preview_path(const job *j, layer l);
/* Leaves out what need not be done again. */
int process_resume(process *p);
/* Whether a frame must be lit though its result may be there: for those that
 * come after it, and for the exposure of their previews. */
int process_is_needed(const process *p, const job *j);

/* --- process_frames.c --- */

/* Lights all frames that are needed and writes what is missing. */
int process_frames(process *p);

#endif
