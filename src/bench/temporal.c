/* hbil-bench temporal: what averaging over frames takes off the sampling error,
 * and what it costs. */
#include <math.h>
#include <stdlib.h>

#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/integrals.h"
#include "bench/report.h"
#include "bench/settings.h"

static const unsigned lengths[] = {1, 2, 4, 8, 16}; /* frames averaged */
enum {
  LENGTHS = sizeof lengths / sizeof *lengths,
  LONGEST = 16,
  SETTINGS = 2,
  ROOM_FRAMES = 16,
  QUICK_FRAMES = 4
};

typedef struct deviation {
  double ao, light; /* NAN: not measured */
} deviation;

typedef struct job {
  const bench_options *options;
  bench_content content;
  bench_setting list[SETTINGS];
  bench_integrals integrals;
  bench_fixture *fixture;
  bench_report *report;
  float *planes; /* three */
} job;

static const bench_column columns[] = {
    {"label", "setting", BENCH_TEXT},      {"frames", "frames averaged", 0},
    {"static_ao", "static: AO", 4},        {"static_light", "E_near", 4},
    {"moving_ao", "moving: AO", 4},        {"moving_light", "E_near", 4},
    {"motion_ao", "motion vectors: AO", 4}};

static const bench_column cost_columns[] = {
    {"label", "setting", BENCH_TEXT},
    {"pass_ms", "filter, ms", 3},
    {"total_ratio", "frame, of one without it", 3}};

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

static int open_trial(const job *j, const bench_setting *s, unsigned length,
                      hbil_reprojection reprojection, bench_trial *out,
                      image_error *error) {
  hbil_config config;
  bench_setting_apply(s, &j->content, &config);
  config.history.max_frames = length;
  config.history.reprojection = reprojection;
  return bench_trial_open(j->fixture, &config, NULL, out, error);
}

/* --- the measured frame, again and again --- */

/* A mean over many frames passes through all shorter ones. */
static int static_frames(const job *j, const bench_setting *s,
                         deviation out[LENGTHS], image_error *error) {
  bench_trial t;
  int failed = open_trial(j, s, LONGEST, HBIL_REPROJECTION_NONE, &t, error);
  for (unsigned n = 1, at = 0; n <= LONGEST && !failed; n++) {
    failed = bench_trial_run(&t, j->content.measured, n - 1, n > 1, error);
    if (!failed && n == lengths[at])
      failed = deviation_of(j, &t, s->model, &out[at++], error);
  }
  bench_trial_close(&t);
  return failed;
}

/* --- the whole sequence --- */

static int sequence(const job *j, const bench_setting *s, unsigned length,
                    hbil_reprojection reprojection, deviation *out,
                    image_error *error) {
  bench_trial t;
  int failed = open_trial(j, s, length, reprojection, &t, error);
  for (unsigned f = 0; f < j->content.frames && !failed; f++)
    failed = bench_trial_run(&t, f, f, 0, error);
  if (!failed)
    failed = deviation_of(j, &t, s->model, out, error);
  bench_trial_close(&t);
  return failed;
}

static int measure_length(const job *j, const bench_setting *s, unsigned length,
                          deviation still, image_error *error) {
  const int has_motion =
      j->content.frame[j->content.measured].plane[BENCH_MOTION] != NULL;
  deviation moving, followed = {NAN, NAN};
  char label[BENCH_LABEL];
  if (sequence(j, s, length, HBIL_REPROJECTION_NONE, &moving, error) != 0 ||
      (has_motion &&
       sequence(j, s, length, HBIL_REPROJECTION_MOTION, &followed, error) != 0))
    return -1;
  bench_setting_label(s, label);
  bench_report_row(j->report);
  bench_report_text(j->report, label);
  bench_report_number(j->report, length);
  bench_report_number(j->report, still.ao);
  bench_report_number(j->report, still.light);
  bench_report_number(j->report, moving.ao);
  bench_report_number(j->report, moving.light);
  bench_report_number(j->report, followed.ao);
  return 0;
}

/* --- what it costs --- */

/* The frames of the sequence, in turns with a plan that has no filter. */
static int measure_cost(const job *j, const bench_setting *s,
                        image_error *error) {
  bench_turn turns[2] = {{.fixture = j->fixture}, {.fixture = j->fixture}};
  bench_timing t[2];
  char label[BENCH_LABEL];
  bench_setting_label(s, label);
  bench_setting_apply(s, &j->content, &turns[0].config);
  turns[1].config = turns[0].config;
  turns[1].config.history.max_frames = LONGEST;
  if (bench_time_turns(turns, 2, j->options->runs, t, error) != 0)
    return -1;
  bench_report_row(j->report);
  bench_report_text(j->report, label);
  bench_report_number(j->report, t[1].pass[HBIL_PASS_TEMPORAL].median);
  bench_report_number(j->report, t[1].total_ratio);
  return 0;
}

/* --- all --- */

static int measure(job *j, image_error *error) {
  const size_t longest = j->options->quick ? 3 : LENGTHS;
  bench_report_table(j->report, "errors", "Means over frames", columns,
                     sizeof columns / sizeof *columns);
  for (int i = 0; i < SETTINGS; i++) {
    deviation still[LENGTHS];
    if (static_frames(j, &j->list[i], still, error) != 0)
      return -1;
    for (size_t n = 0; n < longest; n++)
      if (measure_length(j, &j->list[i], lengths[n], still[n], error) != 0)
        return -1;
  }
  bench_report_table(j->report, "cost", "What the filter costs", cost_columns,
                     sizeof cost_columns / sizeof *cost_columns);
  for (int i = 0; i < SETTINGS; i++)
    if (measure_cost(j, &j->list[i], error) != 0)
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
      "compared.",
      j->integrals.slices, j->content.frames);
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.options = options, .report = report};
  if (bench_content_load(options, options->quick ? QUICK_FRAMES : ROOM_FRAMES,
                         1, &j.content, error) != 0)
    return -1;
  j.list[0] = j.list[1] = bench_setting_default(&j.content);
  j.list[1].steps /= 2;
  bench_report_subject(report, j.content.name, j.content.width,
                       j.content.height, options->runs);
  j.planes = malloc(3 * bench_pixels(&j.content) * sizeof *j.planes);
  int failed = j.planes ? 0 : image_no_memory(error, j.content.name);
  failed = failed ||
           bench_integrals_make(options, &j.content, j.list, SETTINGS,
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
    .about = "what the history filter brings, and what it costs",
    .details =
        "How much of the sampling error does averaging over frames remove,\n"
        "with a static camera and with a moving one, and what does it cost?\n"
        "FRAME.exr... are a sequence whose last frame is measured; without\n"
        "any, the camera moves through the room.\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_TIMES |
               BENCH_TAKES_FRAMES | BENCH_TAKES_ERRORS,
    .runs = 9,
    .run = run};
