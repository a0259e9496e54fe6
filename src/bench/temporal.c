/* hbil-bench temporal: the error and the time of frames that share slices. */
#include <math.h>
#include <stdlib.h>

#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/integrals.h"
#include "bench/report.h"
#include "bench/settings.h"

/* Slices, steps per side and frames that share them; the first row's times are
 * what the others' are told in. */
static const struct {
  cl_uint slices, steps, frames;
} sharings[] = {{3, 56, 1}, {4, 56, 2}, {4, 40, 2}, {4, 48, 2},
                {4, 64, 2}, {6, 56, 2}, {2, 56, 2}, {2, 20, 2},
                {2, 16, 2}, {3, 56, 3}, {2, 48, 1}, {1, 20, 1}};
enum {
  SHARINGS = sizeof sharings / sizeof *sharings,
  QUICK_SHARINGS = 2,
  STATIC_FRAMES = 5, /* one more than the most that share slices */
  ROOM_FRAMES = 16,
  QUICK_FRAMES = 4
};

_Static_assert((int)SHARINGS <= (int)BENCH_MAX_TURNS, "all are timed in turns");

typedef struct deviation {
  double ao, light; /* NAN: not measured */
} deviation;

typedef struct job {
  const bench_options *options;
  bench_content content;
  bench_setting list[SHARINGS];
  size_t count;
  bench_integrals integrals;
  bench_fixture *fixture;
  bench_report *report;
  float *planes; /* three */
} job;

static const bench_column columns[] = {
    {"label", "slices x steps / frames", BENCH_TEXT},
    {"static_ao", "static: AO", 4},
    {"static_light", "E_near", 4},
    {"moving_ao", "moving: AO", 4},
    {"moving_light", "E_near", 4},
    {"motion_ao", "motion vectors: AO", 4},
    {"gather_ms", "gather, ms", 3},
    {"total_ms", "frame, ms", 3},
    {"total_ratio", "frame, of the first row's", 2}};

/* Of the last frame that ran, in the measured view. */
static int deviation_of(const job *j, const bench_trial *t, bench_model model,
                        deviation *out, image_error *error) {
  if (bench_trial_read(t, BENCH_AO, j->planes, error) != 0)
    return -1;
  out->ao = bench_ao_error(&j->content, j->planes, j->integrals.ao[model]);
  if (bench_trial_read(t, BENCH_NEAR, j->planes, error) != 0)
    return -1;
  out->light =
      bench_light_error(&j->content, j->planes, j->integrals.light[model]);
  return 0;
}

static int open_trial(const job *j, const bench_setting *s,
                      hbil_reprojection reprojection, bench_trial *out,
                      image_error *error) {
  hbil_config config;
  bench_setting_apply(s, &j->content, &config);
  config.history.reprojection = reprojection;
  return bench_trial_open(j->fixture, &config, NULL, out, error);
}

/* The measured frame, again and again. */
static int static_frames(const job *j, const bench_setting *s, deviation *out,
                         image_error *error) {
  bench_trial t;
  int failed = open_trial(j, s, HBIL_REPROJECTION_NONE, &t, error);
  for (unsigned n = 0; n < STATIC_FRAMES && !failed; n++)
    failed = bench_trial_run(&t, j->content.measured, 0, n > 0, error);
  if (!failed)
    failed = deviation_of(j, &t, s->model, out, error);
  bench_trial_close(&t);
  return failed;
}

/* The whole sequence. */
static int sequence(const job *j, const bench_setting *s,
                    hbil_reprojection reprojection, deviation *out,
                    image_error *error) {
  bench_trial t;
  int failed = open_trial(j, s, reprojection, &t, error);
  for (unsigned f = 0; f < j->content.frames && !failed; f++)
    failed = bench_trial_run(&t, f, 0, 0, error);
  if (!failed)
    failed = deviation_of(j, &t, s->model, out, error);
  bench_trial_close(&t);
  return failed;
}

/* All settings, in turns. */
static int time_settings(const job *j, bench_timing times[SHARINGS],
                         image_error *error) {
  bench_turn turns[SHARINGS];
  for (size_t i = 0; i < j->count; i++) {
    turns[i] = (bench_turn){.fixture = j->fixture};
    bench_setting_apply(&j->list[i], &j->content, &turns[i].config);
  }
  return bench_time_turns(turns, j->count, j->options->runs, times, error);
}

static int measure_setting(const job *j, const bench_setting *s,
                           const bench_timing *time, image_error *error) {
  const int has_motion =
      j->content.frame[j->content.measured].plane[BENCH_MOTION] != NULL;
  deviation still, moving, followed = {NAN, NAN};
  char label[BENCH_LABEL];
  if (static_frames(j, s, &still, error) != 0 ||
      sequence(j, s, HBIL_REPROJECTION_NONE, &moving, error) != 0 ||
      (has_motion &&
       sequence(j, s, HBIL_REPROJECTION_MOTION, &followed, error) != 0))
    return -1;
  bench_setting_label(s, label);
  bench_report_row(j->report);
  bench_report_text(j->report, label);
  bench_report_number(j->report, still.ao);
  bench_report_number(j->report, still.light);
  bench_report_number(j->report, moving.ao);
  bench_report_number(j->report, moving.light);
  bench_report_number(j->report, followed.ao);
  bench_report_number(j->report, time->pass[HBIL_PASS_GATHER].median);
  bench_report_number(j->report, time->total.median);
  bench_report_number(j->report, time->total_ratio);
  return 0;
}

static int measure(job *j, image_error *error) {
  bench_timing times[SHARINGS];
  if (time_settings(j, times, error) != 0)
    return -1;
  bench_report_table(j->report, "errors", "Frames that share slices", columns,
                     sizeof columns / sizeof *columns);
  for (size_t i = 0; i < j->count; i++)
    if (measure_setting(j, &j->list[i], &times[i], error) != 0)
      return -1;
  return 0;
}

static void report_notes(const job *j) {
  bench_report_note(
      j->report,
      "RMSE against the exact integral (%d slices) in the last of %u frames, "
      "of E_near over its mean.  static: that frame over and over; moving: the "
      "whole sequence, where surfaces are found again by the cameras; motion "
      "vectors: by these, with light of further bounces, so that only AO is "
      "compared.  3x56/3: of three slices, each frame searches one.",
      j->integrals.slices, j->content.frames);
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.options = options, .report = report};
  if (bench_content_load(options, options->quick ? QUICK_FRAMES : ROOM_FRAMES,
                         1, &j.content, error) != 0)
    return -1;
  j.count = options->quick ? QUICK_SHARINGS : SHARINGS;
  for (size_t i = 0; i < j.count; i++) {
    j.list[i] = bench_setting_default(&j.content);
    j.list[i].slices = sharings[i].slices;
    j.list[i].steps = sharings[i].steps;
    j.list[i].slice_frames = sharings[i].frames;
  }
  bench_report_subject(report, j.content.name, j.content.width,
                       j.content.height, options->runs);
  j.planes = malloc(3 * bench_pixels(&j.content) * sizeof *j.planes);
  int failed = j.planes ? 0 : image_no_memory(error, j.content.name);
  failed = failed ||
           bench_integrals_make(options, &j.content, j.list, j.count,
                                &j.integrals, error) != 0 ||
           bench_fixture_open(device, &j.content, &j.fixture, error) != 0 ||
           measure(&j, error) != 0;
  if (!failed)
    report_notes(&j);
  bench_fixture_close(j.fixture);
  bench_integrals_free(&j.integrals);
  bench_content_free(&j.content);
  free(j.planes);
  return failed ? -1 : 0;
}

const bench_command bench_temporal = {
    .name = "temporal",
    .about = "what frames that share slices cost, and their error",
    .details =
        "How exact are frames that search a part of the slices each and take\n"
        "the others from the frames before, with a static camera and with a\n"
        "moving one, and how long do they take?\n"
        "FRAME.exr... are a sequence whose last frame is measured; without\n"
        "any, the camera moves through the room.\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_TIMES |
               BENCH_TAKES_FRAMES | BENCH_TAKES_ERRORS,
    .runs = 9,
    .run = run};
