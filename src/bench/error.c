/* hbil-bench error: how the error of the result falls with the time spent. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/baseline.h"
#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/integrals.h"
#include "bench/plot.h"
#include "bench/report.h"
#include "bench/settings.h"
#include "tool/report.h"

typedef struct row {
  char label[BENCH_LABEL];
  bench_timing timing; /* ratios: over the paper's setting, in turns */
  double paper;        /* milliseconds of the paper's setting in these turns */
  double light, ao;    /* sampling errors; NAN where there is none */
  double band;         /* of AO, likewise (bench_ao_band()) */
  int front[BENCH_PANELS];
} row;

typedef struct job {
  const bench_options *options;
  const bench_device *device;
  bench_content content;
  bench_setting list[BENCH_MAX_SETTINGS];
  size_t count;
  bench_integrals integrals;
  bench_fixture *fixture;
  bench_baseline baseline;
  row rows[BENCH_MAX_SETTINGS];
  float *planes; /* three, for reading results back */
} job;

/* --- measuring --- */

/* A plan's first frame has one bounce, like the exact integral. */
static int measure_sampling(job *j, const bench_trial *t, bench_model model,
                            row *out, image_error *error) {
  const bench_content *content = &j->content;
  out->light = NAN;
  if (bench_trial_run(t, content->measured, 0, 0, error) != 0 ||
      bench_trial_read(t, BENCH_AO, j->planes, error) != 0)
    return -1;
  out->ao = bench_ao_error(content, j->planes, j->integrals.ao[model]);
  out->band = bench_ao_band(content, j->planes, j->integrals.ao[model]);
  if (bench_model_is_ao(model))
    return 0;
  if (bench_trial_read(t, BENCH_NEAR, j->planes, error) != 0)
    return -1;
  out->light = bench_light_error(content, j->planes, j->integrals.light[model]);
  return 0;
}

static int measure_row(job *j, const bench_setting *s, row *out,
                       image_error *error) {
  const bench_setting paper = bench_setting_paper();
  bench_turn turns[2] = {{.fixture = j->fixture}, {.fixture = j->fixture}};
  bench_timing timing[2];
  bench_trial trial;
  bench_setting_label(s, out->label);
  bench_setting_apply(&paper, &j->content, &turns[0].config);
  bench_setting_apply(s, &j->content, &turns[1].config);
  const int failed = bench_trial_open(j->fixture, &turns[1].config, NULL,
                                      &trial, error) != 0 ||
                     measure_sampling(j, &trial, s->model, out, error) != 0;
  bench_trial_close(&trial);
  if (failed ||
      bench_time_turns(turns, 2, j->options->runs, timing, error) != 0)
    return -1;
  out->timing = timing[1];
  out->paper = timing[0].total.median;
  return 0;
}

/* Whether no other row of the model is at least as good in both and better in
 * one.  Times are relative to the paper's, because rows are timed minutes
 * apart, and the machine may be slower then. */
static int is_on_front(const job *j, size_t at, int panel) {
  const row *own = &j->rows[at];
  const double off = panel == BENCH_PANEL_AO ? own->ao : own->light;
  for (size_t i = 0; i < j->count; i++) {
    const row *r = &j->rows[i];
    const double e = panel == BENCH_PANEL_AO ? r->ao : r->light;
    const double faster = own->timing.total_ratio - r->timing.total_ratio;
    if (j->list[i].model == j->list[at].model && faster >= 0.0 && e <= off &&
        (faster > 0.0 || e < off))
      return 0;
  }
  return isfinite(off);
}

static int measure_rows(job *j, image_error *error) {
  j->planes = malloc(3 * bench_pixels(&j->content) * sizeof *j->planes);
  if (!j->planes)
    return image_no_memory(error, j->content.name);
  for (size_t i = 0; i < j->count; i++) {
    progress_count("settings", i, j->count);
    if (measure_row(j, &j->list[i], &j->rows[i], error) != 0)
      return -1;
  }
  progress_count("settings", j->count, j->count);
  for (size_t i = 0; i < j->count; i++)
    for (int panel = 0; panel < BENCH_PANELS; panel++)
      j->rows[i].front[panel] = is_on_front(j, i, panel);
  return 0;
}

static int measure(job *j, image_error *error) {
  const bench_model paper = BENCH_MODEL_PAPER;
  if (bench_content_load(j->options, 2, 0, &j->content, error) != 0)
    return -1;
  j->count = bench_settings(j->options->quick, &j->content, j->list);
  return bench_integrals_make(j->options, &j->content, j->list, j->count,
                              &j->integrals, error) != 0 ||
                 bench_baseline_measure(
                     j->device, &j->content, j->options->runs,
                     j->integrals.ao[paper], j->integrals.light[paper],
                     &j->baseline, error) != 0 ||
                 bench_fixture_open(j->device, &j->content, &j->fixture,
                                    error) != 0 ||
                 measure_rows(j, error) != 0
             ? -1
             : 0;
}

/* --- the report --- */

static const bench_column columns[] = {
    {"label", "setting", BENCH_TEXT},
    {"total_ms", "frame, ms", 3},
    {"total_min_ms", NULL, 3},
    {"total_max_ms", NULL, 3},
    {"gather_ms", "gather, ms", 3},
    {"total_ratio", "of the paper's", 2},
    {"gather_ratio", NULL, 2},
    {"host_ms", NULL, 3},
    {"light_error", "E_near, RMSE / mean", 4},
    {"ao_error", "AO, RMSE", 4},
    {"ao_band", "AO band", 4},
    {"front", "front", BENCH_TEXT},
    {"memory_mib", "MiB", 1},
    {"model", NULL, BENCH_TEXT},
    {"preset", NULL, BENCH_TEXT},
    {"slices", NULL, 0},
    {"steps_per_side", NULL, 0},
    {"growth", NULL, 2}};

static void report_row(const bench_setting *s, const row *r,
                       bench_report *report) {
  const char *const fronts[] = {"", "E_near", "AO", "E_near, AO"};
  bench_report_row(report);
  bench_report_text(report, r->label);
  bench_report_spread(report, r->timing.total);
  bench_report_number(report, r->timing.pass[HBIL_PASS_GATHER].median);
  bench_report_number(report, r->timing.total_ratio);
  bench_report_number(report, r->timing.pass_ratio[HBIL_PASS_GATHER]);
  bench_report_number(report, r->timing.host.median);
  bench_report_number(report, r->light);
  bench_report_number(report, r->ao);
  bench_report_number(report, r->band);
  bench_report_text(
      report,
      fronts[r->front[BENCH_PANEL_LIGHT] + 2 * r->front[BENCH_PANEL_AO]]);
  bench_report_number(report, (double)r->timing.memory / 1048576.0);
  bench_report_text(report, bench_model_name(s->model));
  bench_report_text(report, s->preset ? s->preset : "");
  bench_report_number(report, s->slices);
  bench_report_number(report, s->steps);
  bench_report_number(report, (double)s->growth);
}

static const char baseline_label[] = "the paper as one plain kernel";

static void report_baseline(const job *j, bench_report *report) {
  bench_report_row(report);
  bench_report_text(report, baseline_label);
  bench_report_spread(report, j->baseline.milliseconds);
  for (int i = 0; i < 4; i++)
    bench_report_number(report, NAN);
  bench_report_number(report, j->baseline.light_error);
  bench_report_number(report, j->baseline.ao_error);
}

static void report_notes(const job *j, bench_report *report) {
  bench_report_note(
      report,
      "Errors are those of one bounce against the exact integral of the same "
      "model (%d slices, every pixel that a slice crosses, double precision), "
      "at %zu pixels.",
      j->integrals.slices, j->content.compared_count);
  bench_report_note(
      report,
      "A setting is slices x steps per side of a slice; g is the growth of the "
      "steps; half: at half resolution.  Where no model is named it is the "
      "default one; paper is the paper's; thin, thick and endless occluders "
      "are 2 %%, 30 %% and "
      "infinitely thick; gtao and hbao "
      "(radius %.3g) compute AO alone.",
      (double)j->content.radius);
  bench_report_note(
      report,
      "front: no setting of the same model has a lower error and is faster.  "
      "Times are compared as multiples of the paper's, which is timed in turns "
      "with each setting; the plot shows these multiples of the paper's "
      "median.");
  if (j->content.window[2])
    bench_report_note(
        report,
        "These pixels are the window of %u x %u at (%u, %u).  AO band: RMSE of "
        "AO's error there between Gaussian blurs of 1.5 and 8 pixels.",
        (unsigned)j->content.window[2], (unsigned)j->content.window[3],
        (unsigned)j->content.window[0], (unsigned)j->content.window[1]);
  if (j->content.note[0])
    bench_report_note(report, "%s", j->content.note);
}

static bench_kind kind_of(const bench_setting *s) {
  return s->model == BENCH_MODEL_DEFAULT ? BENCH_KIND_DEFAULT
         : s->model == BENCH_MODEL_PAPER ? BENCH_KIND_PAPER
                                         : BENCH_KIND_OTHER;
}

/* Milliseconds of the paper's setting, over all turns. */
static double paper_milliseconds(const job *j) {
  double times[BENCH_MAX_SETTINGS];
  for (size_t i = 0; i < j->count; i++)
    times[i] = j->rows[i].paper;
  return bench_spread_of(times, (unsigned)j->count).median;
}

static int draw(const job *j, image_error *error) {
  const bench_setting standard = bench_setting_default(&j->content);
  const double paper = paper_milliseconds(j);
  bench_point points[BENCH_MAX_SETTINGS + 1];
  for (size_t i = 0; i < j->count; i++) {
    const bench_setting *s = &j->list[i];
    const row *r = &j->rows[i];
    points[i] =
        (bench_point){.milliseconds = paper * r->timing.total_ratio,
                      .error = {r->light, r->ao},
                      .front = {r->front[0], r->front[1]},
                      .kind = kind_of(s),
                      .label = s->preset ? s->preset
                               : i == 0  ? "paper 2 x 8"
                               : bench_setting_same(s, &standard) ? "default"
                                                                  : NULL};
  }
  points[j->count] =
      (bench_point){.milliseconds = j->baseline.milliseconds.median,
                    .error = {j->baseline.light_error, j->baseline.ao_error},
                    .kind = BENCH_KIND_BASELINE,
                    .label = baseline_label};
  return bench_plot_write(j->options, points, j->count + 1, error);
}

static int report_all(job *j, bench_report *report, image_error *error) {
  bench_report_subject(report, j->content.name, j->content.width,
                       j->content.height, j->options->runs);
  bench_report_table(report, "settings", "Error against time", columns,
                     sizeof columns / sizeof *columns);
  report_baseline(j, report);
  for (size_t i = 0; i < j->count; i++)
    report_row(&j->list[i], &j->rows[i], report);
  report_notes(j, report);
  return draw(j, error);
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job *j = calloc(1, sizeof *j);
  if (!j)
    return image_no_memory(error, "error");
  j->options = options;
  j->device = device;
  int failed = measure(j, error);
  if (!failed)
    failed = report_all(j, report, error);
  bench_fixture_close(j->fixture);
  bench_integrals_free(&j->integrals);
  bench_content_free(&j->content);
  free(j->planes);
  free(j);
  return failed;
}

const bench_command bench_error = {
    .name = "error",
    .about = "error against time: settings, presets, models, storages",
    .details =
        "How does the error of the result fall with the time spent?  Measures\n"
        "a list of settings beside the paper's method as one plain kernel.\n"
        "Errors are taken against the exact integral, which takes the CPU a\n"
        "while at first.  Also writes NAME.dat and NAME.gnuplot, and NAME.png\n"
        "where gnuplot is installed.\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_TIMES |
               BENCH_TAKES_FRAMES | BENCH_TAKES_ERRORS | BENCH_TAKES_WINDOW,
    .runs = 9,
    .run = run};
