/* hbil-bench estimate: how far the output error_estimate is from the sampling
 * error, with many settings. */
#include <math.h>
#include <stdlib.h>

#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/integrals.h"
#include "bench/report.h"
#include "bench/settings.h"
#include "image/quantile.h"

static const bench_model models[] = {BENCH_MODEL_DEFAULT, BENCH_MODEL_ENDLESS};
static const unsigned resolutions[] = {0, BENCH_HALF_RESOLUTION};
static const cl_uint slice_counts[] = {1, 2, 3, 4};
static const cl_uint step_counts[] = {8, 16, 32, 64, 96, 128};
enum {
  MODELS = sizeof models / sizeof *models,
  RESOLUTIONS = sizeof resolutions / sizeof *resolutions,
  SLICES = sizeof slice_counts / sizeof *slice_counts,
  STEPS = sizeof step_counts / sizeof *step_counts,
  SETTINGS = MODELS * RESOLUTIONS * SLICES * STEPS,
  /* indices of the only steps and slices of the short list */
  QUICK_STEP = 3,
  QUICK_SLICES = 1
};

/* Errors below this are rounding: in AO, and as a share of the mean E_near. */
static const double rounding = 1e-3;

typedef struct job {
  const bench_options *options;
  bench_content content;
  bench_setting list[SETTINGS];
  size_t count;
  bench_integrals integrals;
  bench_fixture *fixture;
  bench_report *report;
  float *planes;    /* three of a result, two of the estimate */
  double *quotient; /* error over estimate, of the compared surfaces */
} job;

static const bench_column columns[] = {
    {"label", "setting", BENCH_TEXT},
    {"ao_beyond", "AO: beyond the estimate, %", 1},
    {"ao_quotient", "error / estimate", 2},
    {"light_beyond", "E_near: beyond the estimate, %", 1},
    {"light_quotient", "error / estimate", 2}};

static size_t choose_settings(int quick, bench_setting *list) {
  size_t count = 0;
  for (int m = 0; m < MODELS; m++)
    for (int r = 0; r < RESOLUTIONS; r++)
      for (int s = 0; s < SLICES; s++)
        for (int k = 0; k < STEPS; k++)
          if (!quick || (k == QUICK_STEP && s == QUICK_SLICES))
            list[count++] = (bench_setting){.model = models[m],
                                            .slices = slice_counts[s],
                                            .steps = step_counts[k],
                                            .growth = 3.0f,
                                            .flags = resolutions[r]};
  return count;
}

/* The largest error of a pixel's channels. */
static double error_of(const float *a, const float *b, size_t pixels,
                       size_t channels, size_t pixel) {
  double most = 0.0;
  for (size_t c = 0; c < channels; c++)
    most = fmax(most, fabs((double)a[c * pixels + pixel] -
                           (double)b[c * pixels + pixel]));
  return most;
}

/* Reports the share of pixels whose errors are beyond their estimates, and the
 * quotient error / estimate that 95 % don't exceed.  tolerance: errors up to
 * this are rounding. */
static void report_quotients(const job *j, const float *exact,
                             const float *estimate, size_t channels,
                             double tolerance) {
  const size_t pixels = bench_pixels(&j->content);
  size_t count = 0, beyond = 0;
  for (size_t i = 0; i < pixels; i++) {
    if (!j->content.compared[i] || !bench_is_surface(&j->content, i))
      continue;
    const double off = error_of(j->planes, exact, pixels, channels, i);
    j->quotient[count] =
        fmax(off - tolerance, 0.0) / fmax((double)estimate[i], 1e-30);
    beyond += j->quotient[count++] > 1.0;
  }
  /* a picture of sky has none */
  bench_report_number(j->report,
                      count ? 100.0 * (double)beyond / (double)count : NAN);
  bench_report_number(j->report, quantile(j->quotient, count, 0.95));
}

static double mean_light(const job *j, const float *light) {
  const size_t pixels = bench_pixels(&j->content);
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < 3 * pixels; i++)
    if (j->content.compared[i % pixels] &&
        bench_is_surface(&j->content, i % pixels)) {
      sum += (double)light[i];
      count += 1.0;
    }
  return sum / count;
}

static int measure_setting(const job *j, const bench_setting *s,
                           image_error *error) {
  float *estimate = j->planes + 3 * bench_pixels(&j->content);
  const float *light = j->integrals.light[s->model];
  char label[BENCH_LABEL];
  hbil_config config;
  bench_trial t;
  bench_setting_apply(s, &j->content, &config);
  config.outputs.error_estimate = (hbil_plane_format){HBIL_FLOAT32, 1};
  int failed =
      bench_trial_open(j->fixture, &config, NULL, &t, error) != 0 ||
      bench_trial_run(&t, j->content.measured, 0, 0, error) != 0 ||
      bench_trial_read(&t, BENCH_ERROR_ESTIMATE, estimate, error) != 0 ||
      bench_trial_read(&t, BENCH_AO, j->planes, error) != 0;
  if (!failed) {
    bench_setting_label(s, label);
    bench_report_row(j->report);
    bench_report_text(j->report, label);
    report_quotients(j, j->integrals.ao[s->model], estimate, 1, rounding);
    failed = bench_trial_read(&t, BENCH_NEAR, j->planes, error) != 0;
  }
  if (!failed)
    report_quotients(j, light, estimate + bench_pixels(&j->content), 3,
                     rounding * mean_light(j, light));
  bench_trial_close(&t);
  return failed ? -1 : 0;
}

static int measure(const job *j, image_error *error) {
  bench_report_table(j->report, "estimates", "Error and its estimate", columns,
                     sizeof columns / sizeof *columns);
  for (size_t i = 0; i < j->count; i++) {
    bench_progress("settings", i, j->count);
    if (measure_setting(j, &j->list[i], error) != 0)
      return -1;
  }
  bench_progress("settings", j->count, j->count);
  bench_report_note(
      j->report,
      "Errors are those of one bounce against the exact integral (%d slices) "
      "at %zu pixels; of E_near, of the channel that is off most.  error / "
      "estimate: not exceeded by 95 %% of the pixels, so an ideal estimate has "
      "1.  endless: infinitely thick occluders; half: at half resolution.",
      j->integrals.slices, j->content.compared_count);
  return 0;
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.options = options, .report = report};
  j.count = choose_settings(options->quick, j.list);
  if (bench_content_load(options, 1, 0, &j.content, error) != 0)
    return -1;
  bench_report_subject(report, j.content.name, j.content.width,
                       j.content.height, 0);
  j.planes = malloc(5 * bench_pixels(&j.content) * sizeof *j.planes);
  j.quotient = malloc(bench_pixels(&j.content) * sizeof *j.quotient);
  int failed =
      j.planes && j.quotient ? 0 : image_no_memory(error, j.content.name);
  failed = failed ||
           bench_integrals_make(options, &j.content, j.list, j.count,
                                &j.integrals, error) != 0 ||
           bench_fixture_open(device, &j.content, &j.fixture, error) != 0 ||
           measure(&j, error) != 0;
  bench_fixture_close(j.fixture);
  bench_integrals_free(&j.integrals);
  bench_content_free(&j.content);
  free(j.planes);
  free(j.quotient);
  return failed ? -1 : 0;
}

const bench_command bench_estimate = {
    .name = "estimate",
    .about = "how reliable the output error_estimate is",
    .details =
        "How many pixels have a larger sampling error than error_estimate\n"
        "says, and by what factor?  It is meant to be exceeded by 5 %.\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_FRAMES |
               BENCH_TAKES_ERRORS,
    .run = run};
