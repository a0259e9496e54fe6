/* hbil-bench passes: the time of each pass; and two sets of kernels in turns,
 * which tells what a change of them brings. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/report.h"
#include "bench/settings.h"
#include "tool/report.h"

/* What is measured; CASES[0] is what the others are compared to. */
enum { CASES = 10, FOLLOWED = 2, ALONE = 7, NEAR = 8, NEAR_AND_AO = 9 };

typedef struct variant {
  char label[BENCH_LABEL + 40];
  hbil_config config;
} variant;

typedef struct job {
  const bench_options *options;
  const bench_device *device;
  bench_report *report;
  bench_content content;
  variant cases[CASES];
  bench_fixture *fixture[2]; /* [1]: for the second set of kernels */
} job;

/* The default; the paper's setting; motion vectors and two other models, which
 * have kernels of their own; half resolution, or full where half is the
 * default; the fastest preset; `indirect` alone, where the others have all
 * outputs of their model; a near field as beside a radiance cache, with its own
 * occlusion as output and with that of all that the screen shows. */
static void choose_cases(job *j) {
  bench_setting s[CASES];
  for (int i = 0; i < CASES; i++)
    s[i] = bench_setting_default(&j->content);
  s[1] = bench_setting_paper();
  s[3].model = BENCH_MODEL_ENDLESS;
  s[4].model = BENCH_MODEL_GTAO;
  s[5].flags ^= BENCH_HALF_RESOLUTION;
  s[6] = bench_setting_preset(&j->content, HBIL_QUALITY_FAST);
  for (int i = 0; i < CASES; i++) {
    char label[BENCH_LABEL];
    bench_setting_label(&s[i], label);
    bench_setting_apply(&s[i], &j->content, &j->cases[i].config);
    snprintf(j->cases[i].label, sizeof j->cases[i].label, "%s%s", label,
             i == FOLLOWED      ? ", motion vectors"
             : i == ALONE       ? ", indirect alone"
             : i == NEAR        ? ", near field and ao of a radius"
             : i == NEAR_AND_AO ? ", near field of a radius, ao of all"
                                : "");
  }
  j->cases[ALONE].config.outputs.indirect =
      (hbil_plane_format){HBIL_FLOAT32, 4};
  for (int i = NEAR; i <= NEAR_AND_AO; i++) {
    hbil_model *model = &j->cases[i].config.model;
    model->radius = (float)j->content.radius;
    model->ao_radius = i == NEAR ? model->radius : INFINITY;
  }
  if (j->content.frame[0].plane[BENCH_MOTION])
    j->cases[FOLLOWED].config.history.reprojection = HBIL_REPROJECTION_MOTION;
}

/* --- one set of kernels --- */

static const bench_column columns[] = {
    {"label", "setting", BENCH_TEXT},
    {"reproject_ms", "reproject, ms", 3},
    {"push_pull_ms", "push_pull", 3},
    {"split_ms", "split", 3},
    {"gather_ms", "gather", 3},
    {"recompose_ms", "recompose", 3},
    {"composite_ms", "composite", 3},
    {"import_ms", NULL, 3},
    {"export_ms", NULL, 3},
    {"total_ms", "frame", 3},
    {"total_min_ms", NULL, 3},
    {"total_max_ms", NULL, 3},
    {"gather_ratio", "gather, of the first row's", 2},
    {"total_ratio", "frame, of the first row's", 2},
    {"host_ms", NULL, 3}};
_Static_assert(sizeof columns / sizeof *columns == HBIL_PASS_COUNT + 7,
               "a column for each pass");

static void report_case(const job *j, const variant *v, const bench_timing *t) {
  bench_report_row(j->report);
  bench_report_text(j->report, v->label);
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    bench_report_number(j->report, t->pass[p].median);
  bench_report_spread(j->report, t->total);
  bench_report_number(j->report, t->pass_ratio[HBIL_PASS_GATHER]);
  bench_report_number(j->report, t->total_ratio);
  bench_report_number(j->report, t->host.median);
}

/* All in turns.  out: CASES. */
static int measure_cases(const job *j, bench_timing *out, image_error *error) {
  bench_turn turns[CASES];
  for (int i = 0; i < CASES; i++)
    turns[i] =
        (bench_turn){.fixture = j->fixture[0], .config = j->cases[i].config};
  return bench_time_turns(turns, CASES, j->options->runs, out, error);
}

/* --- passes that memory limits --- */

static const bench_column copy_columns[] = {{"pass", "pass", BENCH_TEXT},
                                            {"milliseconds", "ms", 3},
                                            {"mib", "MiB moved", 1},
                                            {"copies", "times of a copy", 2}};

static int run_copy(const job *j, cl_kernel kernel, const cl_mem buffers[2],
                    size_t bytes, size_t width, bench_spread *out,
                    image_error *error) {
  enum { GROUP = 64 };
  const float one = 1.0f;
  const size_t local[2] = {GROUP, 1};
  const size_t global[2] = {bytes / sizeof one / width, 1};
  cl_int status = CL_SUCCESS;
  for (cl_uint i = 0; i < 2 && status == CL_SUCCESS; i++) {
    /* pages become memory when they are first written */
    status = clEnqueueFillBuffer(j->device->queue, buffers[i], &one, sizeof one,
                                 0, bytes, 0, NULL, NULL);
    if (status == CL_SUCCESS)
      status = clSetKernelArg(kernel, i, sizeof *buffers, &buffers[i]);
  }
  if (status != CL_SUCCESS)
    return bench_opencl_failed(j->device, status, "preparing a copy", error);
  return bench_kernel_time(j->device, kernel, global, local, j->options->runs,
                           out, error);
}

/* Milliseconds a byte, read or written, of a copy as large as eight planes. */
static int measure_copy(const job *j, double *out, image_error *error) {
  const size_t width = j->device->is_cpu ? 16 : 4, step = 64 * width;
  const size_t floats = (8 * bench_pixels(&j->content) / step + 1) * step;
  const size_t bytes = floats * sizeof(float);
  cl_mem buffers[2] = {NULL, NULL};
  cl_kernel kernel = NULL;
  bench_spread time = {NAN, NAN, NAN};
  const int failed =
      bench_kernel_new(j->device, "copy",
                       width == 16 ? "-DWIDTH=16" : "-DWIDTH=4", &kernel,
                       error) != 0 ||
      bench_buffer_new(j->device, bytes, NULL, &buffers[0], error) != 0 ||
      bench_buffer_new(j->device, bytes, NULL, &buffers[1], error) != 0 ||
      run_copy(j, kernel, buffers, bytes, width, &time, error) != 0;
  for (int i = 0; i < 2; i++)
    if (buffers[i])
      clReleaseMemObject(buffers[i]);
  if (kernel)
    clReleaseKernel(kernel);
  *out = time.median / (2.0 * (double)bytes);
  return failed ? -1 : 0;
}

static double input_channels(const job *j, bench_input input) {
  return j->content.frame[0].plane[input] ? (double)bench_input_channels(input)
                                          : 0.0;
}

/*
 * Bytes that a pass must move at least, with each plane read or written once:
 *   reproject   by motion: depth, 2 of motion, 2 of history in; 2 of carried
 *               light out
 *   push_pull   light and weight, in all levels (4/3 of the finest), in and out
 *   split       inputs and 2 of carried light in; 3 out
 *   composite   inputs and 7 of resolved planes in; 17 outputs and 2 of history
 *               out
 */
static double least_bytes(const job *j, hbil_pass pass) {
  const double surface = input_channels(j, BENCH_DEPTH) +
                         input_channels(j, BENCH_ALBEDO) +
                         input_channels(j, BENCH_DIRECT);
  const double planes =
      pass == HBIL_PASS_REPROJECT   ? 1.0 + 2.0 + 2.0 + 2.0
      : pass == HBIL_PASS_PUSH_PULL ? 2.0 * 2.0 * 4.0 / 3.0
      : pass == HBIL_PASS_SPLIT
          ? surface + input_channels(j, BENCH_NORMAL) + 2.0 + 3.0
          : surface + input_channels(j, BENCH_EMISSION) + 7.0 + 17.0 + 2.0;
  return planes * (double)bench_pixels(&j->content) * sizeof(float);
}

static void report_copies(const job *j, const bench_timing *with_motion,
                          double copy) {
  static const hbil_pass passes[] = {HBIL_PASS_REPROJECT, HBIL_PASS_PUSH_PULL,
                                     HBIL_PASS_SPLIT, HBIL_PASS_COMPOSITE};
  const int has_motion = j->cases[FOLLOWED].config.history.reprojection ==
                         HBIL_REPROJECTION_MOTION;
  bench_report_table(j->report, "copies",
                     "Passes that memory limits, beside a plain copy",
                     copy_columns, sizeof copy_columns / sizeof *copy_columns);
  for (int i = has_motion ? 0 : 1; i < 4; i++) {
    const double time = with_motion->pass[passes[i]].median;
    const double bytes = least_bytes(j, passes[i]);
    bench_report_row(j->report);
    bench_report_text(j->report, hbil_pass_name(passes[i]));
    bench_report_number(j->report, time);
    bench_report_number(j->report, bytes / 1048576.0);
    bench_report_number(j->report, time / (bytes * copy));
  }
  bench_report_note(j->report, "A copy moves %.1f GB/s.", 1e-6 / copy);
}

static int measure_passes(const job *j, image_error *error) {
  bench_timing timing[CASES];
  double copy;
  if (measure_cases(j, timing, error) != 0 ||
      measure_copy(j, &copy, error) != 0)
    return -1;
  bench_report_table(j->report, "passes", "Time of each pass", columns,
                     sizeof columns / sizeof *columns);
  for (int i = 0; i < CASES; i++)
    report_case(j, &j->cases[i], &timing[i]);
  report_copies(j, &timing[FOLLOWED], copy);
  return 0;
}

/* --- two sets of kernels --- */

static const bench_column kernel_columns[] = {
    {"label", "setting", BENCH_TEXT},  {"pass", "pass", BENCH_TEXT},
    {"first_ms", "first, ms", 3},      {"second_ms", "second, ms", 3},
    {"ratio", "second over first", 3}, {"first_min_ms", NULL, 3},
    {"second_min_ms", NULL, 3}};

static void report_pair(const job *j, const char *label, const char *pass,
                        bench_spread first, bench_spread second, double ratio) {
  if (!(first.high > 0.0 || second.high > 0.0))
    return;
  bench_report_row(j->report);
  bench_report_text(j->report, label);
  bench_report_text(j->report, pass);
  bench_report_number(j->report, first.median);
  bench_report_number(j->report, second.median);
  bench_report_number(j->report, ratio);
  bench_report_number(j->report, first.low);
  bench_report_number(j->report, second.low);
}

static int compare_kernels(const job *j, image_error *error) {
  const char *const *kernels = j->options->kernels;
  bench_report_table(j->report, "kernels", "Two sets of kernels in turns",
                     kernel_columns,
                     sizeof kernel_columns / sizeof *kernel_columns);
  for (int i = 0; i < CASES; i++) {
    bench_turn turns[2];
    bench_timing t[2];
    progress_count("kernels", (size_t)i, CASES);
    for (int k = 0; k < 2; k++)
      turns[k] = (bench_turn){.fixture = j->fixture[k],
                              .config = j->cases[i].config,
                              .kernels = kernels[k]};
    if (bench_time_turns(turns, 2, j->options->runs, t, error) != 0)
      return -1;
    for (int p = 0; p < HBIL_PASS_COUNT; p++)
      report_pair(j, j->cases[i].label, hbil_pass_name((hbil_pass)p),
                  t[0].pass[p], t[1].pass[p], t[1].pass_ratio[p]);
    report_pair(j, j->cases[i].label, "frame", t[0].total, t[1].total,
                t[1].total_ratio);
  }
  progress_count("kernels", CASES, CASES);
  bench_report_note(j->report, "first: kernels in %s; second: %s%s.",
                    kernels[0], kernels[1] ? "kernels in " : "",
                    kernels[1] ? kernels[1] : "those of the library");
  return 0;
}

/* --- all --- */

/* Kernels belong to a library context, and each fixture has its own. */
static int measure(job *j, image_error *error) {
  const int compared = j->options->kernel_count > 0;
  if (bench_fixture_open(j->device, &j->content, &j->fixture[0], error) != 0 ||
      (compared &&
       bench_fixture_open(j->device, &j->content, &j->fixture[1], error) != 0))
    return -1;
  choose_cases(j);
  return compared ? compare_kernels(j, error) : measure_passes(j, error);
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.options = options, .device = device, .report = report};
  if (bench_content_load(options, 2, 0, &j.content, error) != 0)
    return -1;
  bench_report_subject(report, j.content.name, j.content.width,
                       j.content.height, options->runs);
  const int failed = measure(&j, error);
  bench_fixture_close(j.fixture[0]);
  bench_fixture_close(j.fixture[1]);
  bench_content_free(&j.content);
  return failed;
}

const bench_command bench_passes = {
    .name = "passes",
    .about = "the time of each pass, and of two sets of kernels in turns",
    .details =
        "How long does each pass take, in a few settings, and how far is that\n"
        "from a plain copy of the same bytes?  With --kernels: what does a\n"
        "change of the kernels bring, pass by pass?\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_TIMES |
               BENCH_TAKES_FRAMES | BENCH_TAKES_KERNELS,
    .runs = 9,
    .run = run};
