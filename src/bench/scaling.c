/* hbil-bench scaling: how time and memory grow with pixels, samples and
 * threads, and what a process's first frame costs. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/pilot.h"
#include "bench/report.h"
#include "bench/settings.h"
#include "tool/report.h"

/* Twice the factors of the base's edges: of 1280x720 they make 360p, 720p,
 * 1080p, 2160p and 4320p. */
static const uint32_t edges[] = {1, 2, 3, 6, 12};
static const cl_uint step_counts[] = {8, 16, 32, 64, 128};
enum {
  SIZES = sizeof edges / sizeof *edges,
  BASE = 1,
  SAMPLINGS = sizeof step_counts / sizeof *step_counts,
  PROCESSES = 5,
  /* Floats a pixel of all inputs of two frames, and of the outputs. */
  PLANES = 2 * 15 + 19
};

/* The room in one size, on the device. */
typedef struct room {
  bench_content content;
  bench_turn turn; /* of the default setting */
} room;

typedef struct job {
  const bench_options *options;
  const bench_device *device;
  bench_report *report;
  room base;
} job;

static int open_room(const job *j, uint32_t width, uint32_t height, room *out,
                     image_error *error) {
  bench_options options = *j->options;
  options.width = width;
  options.height = height;
  memset(out, 0, sizeof *out);
  if (bench_content_load(&options, 2, 0, &out->content, error) != 0)
    return -1;
  /* of the first room's size, so that all rooms have the same setting */
  const bench_setting standard = bench_setting_default(&j->base.content);
  bench_setting_apply(&standard, &out->content, &out->turn.config);
  const int failed =
      bench_fixture_open(j->device, &out->content, &out->turn.fixture, error);
  bench_content_drop_planes(&out->content);
  return failed;
}

static void close_room(room *r) {
  bench_fixture_close(r->turn.fixture);
  bench_content_free(&r->content);
}

/* --- pixels --- */

static const bench_column size_columns[] = {
    {"size", "pixels", BENCH_TEXT},
    {"total_ms", "frame, ms", 3},
    {"gather_ms", "gather, ms", 3},
    {"host_ms", "host, ms", 3},
    {"total_ns_per_pixel", "frame, ns/pixel", 2},
    {"total_ratio", "frame a pixel, of the base's", 3},
    {"gather_ratio", "gather a pixel, of the base's", 3},
    {"memory_mib", "plan, MiB", 1},
    {"bytes_per_pixel", "bytes/pixel", 1},
    {"left_out", "left out", BENCH_TEXT}};

static void report_size(const job *j, uint32_t width, uint32_t height,
                        const bench_timing *t, const char *left_out) {
  const double pixels = (double)width * height;
  const double share = (double)bench_pixels(&j->base.content) / pixels;
  char size[32];
  snprintf(size, sizeof size, "%u x %u", width, height);
  bench_report_row(j->report);
  bench_report_text(j->report, size);
  bench_report_number(j->report, t ? t->total.median : NAN);
  bench_report_number(j->report, t ? t->pass[HBIL_PASS_GATHER].median : NAN);
  bench_report_number(j->report, t ? t->host.median : NAN);
  bench_report_number(j->report, t ? 1e6 * t->total.median / pixels : NAN);
  bench_report_number(j->report, t ? t->total_ratio * share : NAN);
  bench_report_number(j->report,
                      t ? t->pass_ratio[HBIL_PASS_GATHER] * share : NAN);
  bench_report_number(j->report, t ? (double)t->memory / 1048576.0 : NAN);
  bench_report_number(j->report, t ? (double)t->memory / pixels : NAN);
  bench_report_text(j->report, left_out);
}

/* In turns with the base.  A size that fails is left out, with the reason. */
static void measure_size(const job *j, uint32_t width, uint32_t height) {
  const double bytes = 4.0 * PLANES * (double)width * height;
  bench_timing t[2];
  image_error error;
  room r;
  if (2.0 * bytes > (double)j->device->memory) {
    report_size(j, width, height, NULL, "inputs and plan need more memory");
    return;
  }
  int failed = open_room(j, width, height, &r, &error);
  if (!failed) {
    const bench_turn turns[2] = {j->base.turn, r.turn};
    failed = bench_time_turns(turns, 2, j->options->runs, t, &error);
  }
  report_size(j, width, height, failed ? NULL : &t[1],
              failed ? error.text : "");
  close_room(&r);
}

static int measure_sizes(const job *j, image_error *error) {
  const bench_content *base = &j->base.content;
  bench_timing t;
  bench_report_table(j->report, "sizes", "Pixels", size_columns,
                     sizeof size_columns / sizeof *size_columns);
  for (size_t i = 0; i < SIZES; i++) {
    const uint32_t width = (base->width * edges[i] + 1) / 2;
    const uint32_t height = (base->height * edges[i] + 1) / 2;
    progress_count("sizes", i, SIZES);
    if (i != BASE)
      measure_size(j, width, height);
    else if (bench_time_turns(&j->base.turn, 1, j->options->runs, &t, error) !=
             0)
      return -1;
    else
      report_size(j, width, height, &t, "");
  }
  progress_count("sizes", SIZES, SIZES);
  return 0;
}

/* --- samples --- */

static const bench_column sampling_columns[] = {
    {"steps_per_side", "steps per side", 0},
    {"gather_ms", "gather, ms", 3},
    {"gather_ms_per_step", "ms a step", 4},
    {"ratio", "a step, of the first row's", 3}};

static int measure_samplings(const job *j, image_error *error) {
  bench_turn turns[SAMPLINGS];
  bench_timing t[SAMPLINGS];
  for (int i = 0; i < SAMPLINGS; i++) {
    turns[i] = j->base.turn;
    turns[i].config.sampling.steps_per_side = step_counts[i];
  }
  if (bench_time_turns(turns, SAMPLINGS, j->options->runs, t, error) != 0)
    return -1;
  bench_report_table(j->report, "samples", "Samples, in the base's size",
                     sampling_columns,
                     sizeof sampling_columns / sizeof *sampling_columns);
  for (int i = 0; i < SAMPLINGS; i++) {
    const double gather = t[i].pass[HBIL_PASS_GATHER].median;
    bench_report_row(j->report);
    bench_report_number(j->report, step_counts[i]);
    bench_report_number(j->report, gather);
    bench_report_number(j->report, gather / step_counts[i]);
    bench_report_number(j->report, t[i].pass_ratio[HBIL_PASS_GATHER] *
                                       step_counts[0] / step_counts[i]);
  }
  return 0;
}

/* --- processes of their own --- */

static const bench_column start_columns[] = {
    {"what", "a new process", BENCH_TEXT},
    {"median_ms", "ms", 1},
    {"min_ms", "least", 1},
    {"max_ms", "most", 1},
    {"cold_ms", "no kernels in the cache, ms", 1},
    {"of_third", "cold, of its third frame", 2}};

static const bench_column thread_columns[] = {
    {"threads", "threads", 0},
    {"total_ms", "frame, ms", 3},
    {"gather_ms", "gather, ms", 3},
    {"total_gain", "frame, times faster", 2},
    {"gather_gain", "gather, times faster", 2}};

typedef struct processes {
  unsigned count;
  int compared; /* with one thread, too */
  bench_pilot_times all[PROCESSES], one[PROCESSES], cold;
} processes;

/* The first of the usual processes is not counted: it fills the cache of
 * kernels. */
static int start_processes(const job *j, processes *p, image_error *error) {
  const bench_options *options = j->options;
  const bench_content *base = &j->base.content;
  p->count = options->quick ? 1 : PROCESSES;
  p->compared = j->device->is_cpu && j->device->units > 1;
  if (bench_pilot_start(options, base->width, base->height, 1, BENCH_PILOT_COLD,
                        &p->cold, error) != 0 ||
      bench_pilot_start(options, base->width, base->height, 1,
                        BENCH_PILOT_USUAL, &p->all[0], error) != 0)
    return -1;
  for (unsigned i = 0; i < p->count; i++) {
    progress_count("processes", i, p->count);
    if (bench_pilot_start(options, base->width, base->height, options->runs,
                          BENCH_PILOT_USUAL, &p->all[i], error) != 0 ||
        (p->compared &&
         bench_pilot_start(options, base->width, base->height, options->runs,
                           BENCH_PILOT_SINGLE_THREAD, &p->one[i], error) != 0))
      return -1;
    p->compared = p->compared && p->one[i].units == 1;
  }
  progress_count("processes", p->count, p->count);
  return 0;
}

static void report_start(const job *j, const processes *p) {
  static const char *const names[] = {"plan", "first frame", "second frame",
                                      "third frame"};
  bench_report_table(j->report, "start", "First frames", start_columns,
                     sizeof start_columns / sizeof *start_columns);
  for (int what = 0; what < 1 + BENCH_PILOT_FRAMES; what++) {
    double values[PROCESSES];
    for (unsigned i = 0; i < p->count; i++)
      values[i] = what ? p->all[i].frame[what - 1] : p->all[i].plan;
    bench_report_row(j->report);
    bench_report_text(j->report, names[what]);
    bench_report_spread(j->report, bench_spread_of(values, p->count));
    const double cold = what ? p->cold.frame[what - 1] : p->cold.plan;
    bench_report_number(j->report, cold);
    bench_report_number(j->report,
                        cold / p->cold.frame[BENCH_PILOT_FRAMES - 1]);
  }
}

static void report_threads(const job *j, const processes *p) {
  double total[2][PROCESSES], gather[2][PROCESSES];
  if (!p->compared) {
    bench_report_note(j->report,
                      "Threads are left out: the device is no CPU, has one "
                      "compute unit, or its OpenCL is not PoCL, which can be "
                      "limited to one thread.");
    return;
  }
  for (unsigned i = 0; i < p->count; i++) {
    total[0][i] = p->one[i].total;
    total[1][i] = p->all[i].total;
    gather[0][i] = p->one[i].gather;
    gather[1][i] = p->all[i].gather;
  }
  const double gains[2][2] = {
      {1.0, 1.0},
      {bench_median_ratio(total[0], total[1], p->count),
       bench_median_ratio(gather[0], gather[1], p->count)}};
  bench_report_table(j->report, "threads", "Threads", thread_columns,
                     sizeof thread_columns / sizeof *thread_columns);
  for (int i = 0; i < 2; i++) {
    bench_report_row(j->report);
    bench_report_number(j->report, i ? p->all[0].units : 1);
    bench_report_number(j->report, bench_spread_of(total[i], p->count).median);
    bench_report_number(j->report, bench_spread_of(gather[i], p->count).median);
    bench_report_number(j->report, gains[i][0]);
    bench_report_number(j->report, gains[i][1]);
  }
}

/* --- all --- */

static int measure(const job *j, image_error *error) {
  const bench_setting standard = bench_setting_default(&j->base.content);
  char label[BENCH_LABEL];
  processes p;
  bench_setting_label(&standard, label);
  bench_report_subject(j->report, j->base.content.name, j->base.content.width,
                       j->base.content.height, j->options->runs);
  if (measure_sizes(j, error) != 0 || measure_samplings(j, error) != 0 ||
      start_processes(j, &p, error) != 0)
    return -1;
  report_start(j, &p);
  report_threads(j, &p);
  bench_report_note(j->report,
                    "The setting is %s.  Sizes and samples are timed in turns "
                    "with what they are compared to; processes run one after "
                    "the other, %u of each kind.",
                    label, p.count);
  return 0;
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.options = options, .device = device, .report = report};
  int failed = open_room(&j, options->width, options->height, &j.base, error);
  if (!failed)
    failed = measure(&j, error);
  close_room(&j.base);
  return failed;
}

const bench_command bench_scaling = {
    .name = "scaling",
    .about = "pixels, samples, threads, memory, first frame",
    .details =
        "How do time and memory grow with pixels, samples and threads, and\n"
        "what does the first frame of a process cost?  The size of --size is\n"
        "the base that 1/2, 3/2, 3 and 6 times its edges are compared to.\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_TIMES,
    .runs = 9,
    .run = run};
