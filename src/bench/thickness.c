/* hbil-bench thickness: the sampling error by the occluders' thickness. */
#include <math.h>
#include <stdlib.h>

#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/integrals.h"
#include "bench/plot.h"
#include "bench/report.h"
#include "bench/settings.h"
#include "tool/report.h"

/* hbil_config.model.thickness, world units; there is no relative one.  The room
 * is eight units wide. */
static const float thicknesses[] = {1e-6f, 1e-5f, 1e-4f, 1e-3f,
                                    .003f, .01f,  .03f,  .1f,
                                    .3f,   1.0f,  3.0f,  INFINITY};
static const float quick_thicknesses[] = {1e-6f, .03f, INFINITY};

typedef struct row {
  float thickness;
  double closed, exact; /* means of 1 - AO */
  double ao, light;     /* sampling errors */
} row;

/* Pixels that are compared by default; there are twelve exact integrals. */
enum { COMPARED = 2000 };

enum { MOST = sizeof thicknesses / sizeof *thicknesses };

typedef struct job {
  bench_options options; /* a copy */
  bench_content content;
  bench_fixture *fixture;
  float *planes; /* three, for reading results back */
  row rows[MOST];
  size_t count;
} job;

static const bench_column columns[] = {
    {"thickness", "thickness", BENCH_TEXT},
    {"closed", "closed share", 6},
    {"closed_exact", "exact", 6},
    {"ao_error", "AO, RMSE", 5},
    {"light_error", "E_near, RMSE / mean", 4}};

/* --- measuring --- */

static int measure_plan(const job *j, const hbil_config *config,
                        const float *ao, const float *light, row *out,
                        image_error *error) {
  const bench_content *content = &j->content;
  bench_trial t;
  int failed = bench_trial_open(j->fixture, config, NULL, &t, error) != 0 ||
               bench_trial_run(&t, content->measured, 0, 0, error) != 0 ||
               bench_trial_read(&t, BENCH_AO, j->planes, error) != 0;
  if (!failed) {
    out->closed = 1.0 - bench_ao_mean(content, j->planes);
    out->exact = 1.0 - bench_ao_mean(content, ao);
    out->ao = bench_ao_error(content, j->planes, ao);
    failed = bench_trial_read(&t, BENCH_NEAR, j->planes, error) != 0;
  }
  if (!failed)
    out->light = bench_light_error(content, j->planes, light);
  bench_trial_close(&t);
  return failed ? -1 : 0;
}

static int measure_row(const job *j, row *out, image_error *error) {
  const bench_setting s = bench_setting_default(&j->content);
  float *ao = NULL, *light = NULL;
  hbil_config config;
  bench_setting_apply(&s, &j->content, &config);
  config.model.thickness = out->thickness;
  config.model.relative_thickness = INFINITY;
  const int failed = bench_integral_make(&j->content, &config,
                                         bench_integral_slices(&j->options),
                                         &ao, &light, error) != 0 ||
                     measure_plan(j, &config, ao, light, out, error) != 0;
  free(ao);
  free(light);
  return failed ? -1 : 0;
}

static int measure(job *j, const bench_device *device, image_error *error) {
  const int quick = j->options.quick;
  const size_t pixels_of_rgb = 3;
  j->count = quick ? sizeof quick_thicknesses / sizeof *quick_thicknesses
                   : (size_t)MOST;
  if (bench_content_load(&j->options, 1, 0, &j->content, error) != 0 ||
      bench_fixture_open(device, &j->content, &j->fixture, error) != 0)
    return -1;
  j->planes =
      malloc(pixels_of_rgb * bench_pixels(&j->content) * sizeof *j->planes);
  if (!j->planes)
    return image_no_memory(error, j->content.name);
  for (size_t i = 0; i < j->count; i++) {
    progress_count("thicknesses", i, j->count);
    j->rows[i].thickness = quick ? quick_thicknesses[i] : thicknesses[i];
    if (measure_row(j, &j->rows[i], error) != 0)
      return -1;
  }
  progress_count("thicknesses", j->count, j->count);
  return 0;
}

/* --- the report --- */

/* An infinite thickness is drawn at this one. */
static const double drawn_infinity = 100.0;

static void write_data(const void *context, FILE *out) {
  const job *j = context;
  for (size_t i = 0; i < j->count; i++) {
    const row *r = &j->rows[i];
    fprintf(out, "%g %g %g %g %g\n",
            isfinite(r->thickness) ? (double)r->thickness : drawn_infinity,
            r->closed, r->exact, r->ao, r->light);
  }
}

static void report_row(const row *r, bench_report *report) {
  char label[32];
  if (isfinite(r->thickness))
    snprintf(label, sizeof label, "%g", (double)r->thickness);
  else
    snprintf(label, sizeof label, "infinite");
  bench_report_row(report);
  bench_report_text(report, label);
  bench_report_number(report, r->closed);
  bench_report_number(report, r->exact);
  bench_report_number(report, r->ao);
  bench_report_number(report, r->light);
}

static int report_all(const job *j, bench_report *report, image_error *error) {
  char label[BENCH_LABEL];
  const bench_setting s = bench_setting_default(&j->content);
  bench_setting_label(&s, label);
  bench_report_subject(report, j->content.name, j->content.width,
                       j->content.height, 0);
  bench_report_table(report, "thickness", "Error by thickness", columns,
                     sizeof columns / sizeof *columns);
  for (size_t i = 0; i < j->count; i++)
    report_row(&j->rows[i], report);
  bench_report_note(
      report,
      "The setting is the default, %s.  thickness is that of occluders in "
      "world units, whatever their depth is.  The closed share is the mean of "
      "1 - AO; it is followed by that of the exact integral (%d slices, every "
      "pixel that a slice crosses, double precision), against which the errors "
      "are taken, at %zu pixels.",
      label, bench_integral_slices(&j->options), j->content.compared_count);
  if (j->content.note[0])
    bench_report_note(report, "%s", j->content.note);
  return bench_plot_files(&j->options, "thickness.gnuplot", write_data, j,
                          error);
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job *j = calloc(1, sizeof *j);
  if (!j)
    return image_no_memory(error, "thickness");
  j->options = *options;
  if (!options->pixels && !options->quick)
    j->options.pixels = COMPARED;
  const int failed =
      measure(j, device, error) != 0 || report_all(j, report, error) != 0;
  bench_fixture_close(j->fixture);
  bench_content_free(&j->content);
  free(j->planes);
  free(j);
  return failed ? -1 : 0;
}

const bench_command bench_thickness = {
    .name = "thickness",
    .about = "error by the thickness of occluders",
    .details =
        "How does the error of the result depend on how thick occluders are?\n"
        "Measures the default sampling against the exact integral, which "
        "takes\n"
        "the CPU minutes, from a thickness of a millionth of a unit to an\n"
        "infinite one; without --pixels, at 2000 pixels.  Also writes "
        "NAME.dat\n"
        "and NAME.gnuplot, and NAME.png where gnuplot is installed.\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_FRAMES |
               BENCH_TAKES_ERRORS | BENCH_TAKES_WINDOW,
    .run = run};
