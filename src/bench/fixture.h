/*
 * The library on the content: planes on the device, plans that run frames, and
 * plans that are timed in turns.
 */
#ifndef HBIL_BENCH_FIXTURE_H
#define HBIL_BENCH_FIXTURE_H

#include "bench/content.h"
#include "bench/opencl.h"
#include "bench/statistics.h"
#include "hbil/hbil.h"

/* The outputs that plans write: all of them with HBIL_MODE_HBIL, AO alone
 * else.  The estimate only if the configuration has a format for it. */
typedef enum bench_output {
  BENCH_AO = 0,
  BENCH_NEAR, /* near_irradiance */
  BENCH_INDIRECT,
  BENCH_FAR,
  BENCH_BENT_NORMAL,
  BENCH_CONE_COSINE,
  BENCH_BEAUTY,
  BENCH_ERROR_ESTIMATE,
  BENCH_OUTPUTS
} bench_output;

/* Inputs of all frames, and one set of outputs, on a device.  Both the device
 * and the content must outlive it. */
typedef struct bench_fixture bench_fixture;

int bench_fixture_open(const bench_device *d, const bench_content *content,
                       bench_fixture **out, image_error *error);
void bench_fixture_close(bench_fixture *f); /* allowed on NULL */

/* The library on the device. */
hbil_context *bench_fixture_context(const bench_fixture *f);

/* --- one plan --- */

/* A plan with the fixture's formats. */
typedef struct bench_trial {
  bench_fixture *fixture;
  hbil_plan *plan;
  hbil_config config;
  size_t memory; /* bytes on the device */
  /* Set after opening, else 0: inputs that are read in place of the fixture's,
   * in the formats of the configuration; and as hbil_frame has it. */
  cl_mem replaced[BENCH_INPUTS];
  double hardware_depth[2];
  hbil_cache *cache; /* likewise */
} bench_trial;

/* config: settings; formats are filled in where it has none.  kernels: the
 * folder that kernels are read from, or NULL: where the library has them. */
int bench_trial_open(bench_fixture *f, const hbil_config *config,
                     const char *kernels, bench_trial *out, image_error *error);
/* Waits for the plan's commands; allowed on a zeroed trial. */
void bench_trial_close(bench_trial *t);
/* Runs a frame of the content.  frame_index and is_static as in hbil_frame. */
int bench_trial_run(const bench_trial *t, unsigned frame, unsigned frame_index,
                    int is_static, image_error *error);
/* A frame of the content as a view of a cache whose inputs are those of the
 * trial's configuration. */
void bench_trial_view(const bench_trial *t, unsigned frame, hbil_view *out);
/* The channels of an output of the last frame, plane after plane. */
int bench_trial_read(const bench_trial *t, bench_output output, float *out,
                     image_error *error);
/* Milliseconds of each pass of the last frame; *total: of all of them. */
int bench_trial_passes(const bench_trial *t,
                       double milliseconds[HBIL_PASS_COUNT], double *total,
                       image_error *error);

/* --- plans in turns --- */

/* Which frames a turn runs. */
typedef enum bench_play {
  BENCH_PLAY_FRAMES = 0, /* all of the content, over and over */
  BENCH_PLAY_STATIC      /* the first one, declared as a static frame */
} bench_play;

typedef struct bench_turn {
  bench_fixture *fixture;
  hbil_config config;
  bench_play play;
  unsigned settle;     /* frames to run before the first that is timed */
  const char *kernels; /* as in bench_trial_open() */
} bench_turn;

typedef struct bench_timing {
  bench_spread total, pass[HBIL_PASS_COUNT]; /* device milliseconds */
  bench_spread host; /* milliseconds that hbil_enqueue_frame() takes */
  double mean;       /* of the total */
  /* over those of the first plan, turn by turn: medians */
  double total_ratio, pass_ratio[HBIL_PASS_COUNT];
  hbil_statistics statistics; /* of the last frame */
  size_t memory;              /* of the plan, bytes */
} bench_timing;

enum { BENCH_MAX_TURNS = 12 };

/* Runs a frame of each plan in turn, `runs` times after the warm-up.  What
 * slows the machine down for a while then slows all of them, and their ratios
 * stay what they are. */
int bench_time_turns(const bench_turn *list, size_t count, unsigned runs,
                     bench_timing *out, image_error *error);

#endif
