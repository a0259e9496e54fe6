/*
 * A job: all that is known about what is to be done before the first pixel is
 * computed.  prepare_job.h makes it; afterwards it doesn't change.
 */
#ifndef HBIL_TOOL_JOB_H
#define HBIL_TOOL_JOB_H

#include "dump/frame_camera.h"
#include "dump/held_planes.h"
#include "tool/cache_file.h"
#include "tool/layers.h"
#include "tool/settings.h"
#include "image/camera_json.h"
#include "image/temporary.h"
#include "image/window.h"

#include <stdint.h>

typedef struct job_frame {
  const char *path;
  char *camera_path; /* its camera's JSON file; NULL: none is read */
  char *stem;        /* DIR/NAME of its results, without an ending */
  channel_map map;
  frame_camera seen;
  camera_file camera; /* fitted to the pixels that are computed */
} job_frame;

/* The frames from one cut to the next, which show one place. */
typedef struct job_place {
  int first, count;
} job_place;

typedef struct job {
  const process_settings *settings;
  hbil_config config; /* those of the settings, with all choices made */
  unsigned layers;    /* a set (layers.h) */
  unsigned hidden;    /* layers that are computed, but not written */
  int half;           /* 1: layers are stored as half floats */
  int replaces;       /* 1: beauty is the frame's picture (beauty.h) */
  far_light far;
  job_frame *frames;
  int count;
  int before;        /* frames of earlier places */
  unsigned pre_roll; /* of the frames, the first ones, which aren't written */
  job_place *places; /* see job_cuts.h; owned by the whole job */
  int place_count;
  held_planes held;   /* of the first frame's file, until that is read */
  job_frame *decider; /* the frame of --decide-by, without a stem; or NULL */
  job_frame *views;   /* without stems */
  int view_count;
  job_frame *lights; /* likewise, from where lights are */
  int light_count;
  int has_cache;           /* 1: frames ask a radiance cache */
  hbil_cache_config cache; /* of that; without formats */
  cache_file loaded;       /* what it begins with, if settings->cache_load */
  image_window window;     /* computed pixels: all that any frame has */
  image_window shown;      /* written pixels */
  image_window display;    /* of the results: the picture, or --crop's part */
  uint32_t width, height;  /* of window */
  unsigned folders_made;   /* the output folder and parents that were missing */
} job;

/* The job of a place alone, as if it had no other frames.  It has the frames,
 * views and files of the whole job, which frees them. */
job job_of_place(const job *whole, int place);

/* Frees what the job owns.  It may be called on a zeroed job. */
void job_free(job *j);

/* Files of a frame's results; malloc'd, NULL if memory runs out. */
char *job_result_path(const job_frame *f);
char *job_preview_path(const job_frame *f, layer l);

/* The file of the light to carry on, for a job whose first written frame has
 * this index.  Chunks in one folder have their own.  malloc'd, NULL if memory
 * runs out. */
char *job_history_path(const job *j, int index);

/* What becomes of files that have the names of what the job writes. */
existing_file job_existing(const job *j);

/* The frame that decides what no option says. */
job_frame *job_first(const job *j);

/* Whether the frame with this index is lit for the sake of those behind it, and
 * not written. */
int job_is_pre_roll(const job *j, int index);

/* The layers that light is computed for, a set. */
unsigned job_lit_layers(const job *j);

/* The layers that the device makes halves of, a set: none where the program
 * itself looks at their floats, or changes them. */
unsigned job_halves(const job *j);

/* How often the frame with this index runs. */
unsigned job_runs(const job *j, int index);

#endif
