/* How time and memory grow: with the size of the picture, with the samples, and
 * with the threads; and what a plan's first frame costs. */
#include "bench/bench.h"

#include <string.h>

/* Twice the factors of the base's edges: of 1280x720 they make 360p, 720p,
 * 1080p, 2160p, 4320p. */
static const uint32_t twice[BENCH_SIZES] = {1, 2, 3, 6, 12};
enum { BASE = 1 };

static const cl_uint sample_counts[BENCH_SAMPLINGS] = {8, 16, 32, 64, 128};

/* The room in one size, on the device. */
typedef struct room {
  bench_content content;
  bench_lab *lab;
} room;

typedef struct job {
  const bench_options *options;
  const device *device;
  bench_configuration configuration;
  room base;
  bench_scaling *out;
} job;

/* --- rooms --- */

static int open_room(const job *j, uint32_t width, uint32_t height, room *out,
                     image_error *error) {
  bench_options options = *j->options;
  options.width = width;
  options.height = height;
  out->lab = NULL;
  if (bench_content_load(&options, &out->content, error) != 0)
    return -1;
  if (bench_lab_open(j->device, &out->content, &out->lab, error) != 0) {
    bench_content_free(&out->content);
    return -1;
  }
  bench_content_drop_planes(&out->content);
  return 0;
}

static void close_room(room *r) {
  if (!r->lab)
    return;
  bench_lab_close(r->lab);
  bench_content_free(&r->content);
}

static bench_turn turn_of(const job *j, const room *r) {
  bench_turn turn = {.lab = r->lab};
  bench_configure(&r->content, &j->configuration, &turn.config);
  return turn;
}

/* --- sizes --- */

static double gibibytes(cl_ulong bytes) {
  return (double)bytes / 1073741824.0;
}

static cl_ulong needed(const bench_size *size) {
  return (cl_ulong)size->memory.plan + size->memory.images;
}

/* The base stays where it is, to be measured in turns with. */
static void check_fits(const job *j, bench_size *size) {
  cl_ulong there = 0;
  const cl_ulong need = needed(size) + needed(&j->out->size[BASE]);
  clGetDeviceInfo(j->device->id, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof there,
                  &there, NULL);
  if (need > there)
    snprintf(size->skipped, sizeof size->skipped,
             "skipped: plan, inputs and outputs need %.1f GiB beside those it "
             "is compared with, the device has %.1f GiB",
             gibibytes(need), gibibytes(there));
}

static void skip(bench_size *size, const image_error *error) {
  snprintf(size->skipped, sizeof size->skipped, "skipped: %s", error->text);
}

static void set_size(job *j, size_t i) {
  bench_size *size = &j->out->size[i];
  hbil_config config;
  image_error error;
  bench_configure(&j->base.content, &j->configuration, &config);
  config.width = size->width = (config.width * twice[i] + 1) / 2;
  config.height = size->height = (config.height * twice[i] + 1) / 2;
  if (bench_lab_memory(j->base.lab, &config, &j->out->planes, &size->memory,
                       &error) != 0)
    skip(size, &error);
}

/* In turns with the base; by itself if it is that. */
static int time_size(job *j, const room *r, bench_size *size,
                     image_error *error) {
  const bench_turn turns[2] = {turn_of(j, &j->base), turn_of(j, r)};
  bench_timing timing[2];
  const size_t count = r == &j->base ? 1 : 2;
  if (bench_lab_turns(turns, count, j->options->runs, timing, error) != 0)
    return -1;
  size->timing = timing[count - 1];
  return 0;
}

static void measure_size(job *j, size_t i) {
  bench_size *size = &j->out->size[i];
  image_error error;
  room r;
  if (!size->skipped[0])
    check_fits(j, size);
  if (size->skipped[0])
    return;
  if (open_room(j, size->width, size->height, &r, &error) != 0 ||
      time_size(j, &r, size, &error) != 0)
    skip(size, &error);
  close_room(&r);
}

static int measure_sizes(job *j, image_error *error) {
  const bench_turn base = turn_of(j, &j->base);
  if (bench_lab_planes(base.lab, &base.config, &j->out->planes, error) != 0)
    return -1;
  for (size_t i = 0; i < BENCH_SIZES; i++)
    set_size(j, i);
  if (time_size(j, &j->base, &j->out->size[BASE], error) != 0)
    return -1;
  for (size_t i = 0; i < BENCH_SIZES; i++) {
    progress_count("sizes", i, BENCH_SIZES);
    if (i != BASE)
      measure_size(j, i);
  }
  progress_count("sizes", BENCH_SIZES, BENCH_SIZES);
  return 0;
}

double bench_size_cost(const bench_size *size, double milliseconds) {
  return 1e6 * milliseconds / ((double)size->width * size->height);
}

double bench_size_ratio(const bench_scaling *scaling, const bench_size *size,
                        double ratio) {
  const bench_size *base = &scaling->size[scaling->base];
  return ratio * ((double)base->width * base->height) /
         ((double)size->width * size->height);
}

/* --- samples --- */

static int measure_samplings(job *j, image_error *error) {
  bench_turn turns[BENCH_SAMPLINGS];
  bench_timing timing[BENCH_SAMPLINGS];
  for (int i = 0; i < BENCH_SAMPLINGS; i++) {
    turns[i] = turn_of(j, &j->base);
    turns[i].config.steps_per_side = sample_counts[i];
  }
  if (bench_lab_turns(turns, BENCH_SAMPLINGS, j->options->runs, timing,
                      error) != 0)
    return -1;
  for (int i = 0; i < BENCH_SAMPLINGS; i++)
    j->out->sampling[i] = (bench_sampling){sample_counts[i], timing[i]};
  return 0;
}

double bench_sampling_ratio(const bench_scaling *scaling,
                            const bench_sampling *sampling) {
  return sampling->timing.pass_ratio[HBIL_PASS_GATHER] *
         scaling->sampling[0].samples / sampling->samples;
}

/* --- processes of their own --- */

/* What every round tells. */
typedef struct rounds {
  double plan[BENCH_ROUNDS];
  double frame[BENCH_START_FRAMES][BENCH_ROUNDS];
  double extra[BENCH_ROUNDS];
  double total[2][BENCH_ROUNDS], gather[2][BENCH_ROUNDS];
  double total_gain[BENCH_ROUNDS], gather_gain[BENCH_ROUNDS];
} rounds;

static int probe(const job *j, int single, unsigned runs, bench_probe *out,
                 image_error *error) {
  const bench_size *base = &j->out->size[BASE];
  bench_options options = *j->options;
  options.runs = runs;
  return bench_probe_run(&options, base->width, base->height, single, out,
                         error);
}

static void keep_start(const bench_start *start, unsigned round, rounds *r) {
  r->plan[round] = start->plan;
  for (int i = 0; i < BENCH_START_FRAMES; i++)
    r->frame[i][round] = start->frame[i];
  r->extra[round] = start->frame[0] - start->frame[1];
}

static void keep_times(const bench_probe both[2], unsigned round, rounds *r) {
  for (int i = 0; i < 2; i++) {
    r->total[i][round] = both[i].total;
    r->gather[i][round] = both[i].gather;
  }
  r->total_gain[round] = both[0].total / both[1].total;
  r->gather_gain[round] = both[0].gather / both[1].gather;
}

/* Why there is nothing to compare, if there is nothing. */
static void check_threads(const job *j, const bench_probe both[2],
                          bench_threads *out) {
  const char *reason = "";
  if (!bench_is_cpu(j->device))
    reason = "left out: the device is no CPU";
  else if (both[0].units != 1)
    reason = "left out: the threads of this OpenCL can't be limited from "
             "outside (PoCL's can)";
  else if (both[1].units == 1)
    reason = "left out: the device has one compute unit";
  snprintf(out->left_out, sizeof out->left_out, "%s", reason);
  out->count = both[1].units;
}

/* One thread and all of them, one after the other. */
static int run_round(job *j, unsigned round, rounds *r, image_error *error) {
  bench_threads *threads = &j->out->threads;
  bench_probe both[2] = {{.units = 0}, {.units = 0}};
  if (probe(j, 0, j->options->runs, &both[1], error) != 0)
    return -1;
  keep_start(&both[1].start, round, r);
  if (round > 0 && threads->left_out[0])
    return 0;
  if (bench_is_cpu(j->device) &&
      probe(j, 1, j->options->runs, &both[0], error) != 0)
    return -1;
  check_threads(j, both, threads);
  keep_times(both, round, r);
  return 0;
}

static void sum_up(rounds *r, bench_scaling *out) {
  bench_threads *threads = &out->threads;
  out->opening.plan = bench_spread_of(r->plan, out->rounds);
  for (int i = 0; i < BENCH_START_FRAMES; i++)
    out->opening.frame[i] = bench_spread_of(r->frame[i], out->rounds);
  out->opening.extra = bench_spread_of(r->extra, out->rounds);
  if (threads->left_out[0])
    return;
  for (int i = 0; i < 2; i++) {
    threads->total[i] = bench_spread_of(r->total[i], out->rounds);
    threads->gather[i] = bench_spread_of(r->gather[i], out->rounds);
  }
  threads->total_gain = bench_spread_of(r->total_gain, out->rounds).median;
  threads->gather_gain = bench_spread_of(r->gather_gain, out->rounds).median;
}

/* The first process isn't counted: it sees to a warm cache of kernels. */
static void measure_processes(job *j) {
  bench_scaling *out = j->out;
  rounds r = {.plan = {0.0}};
  bench_probe unused;
  image_error error;
  int failed = probe(j, 0, 1, &unused, &error);
  for (unsigned round = 0; round < out->rounds && !failed; round++) {
    progress_count("processes", round, out->rounds);
    failed = run_round(j, round, &r, &error);
  }
  progress_count("processes", out->rounds, out->rounds);
  if (!failed) {
    sum_up(&r, out);
    return;
  }
  snprintf(out->opening.left_out, sizeof out->opening.left_out, "left out: %s",
           error.text);
  snprintf(out->threads.left_out, sizeof out->threads.left_out, "left out: %s",
           error.text);
}

/* --- all --- */

int bench_scaling_measure(const bench_options *options, const device *d,
                          bench_scaling *out, image_error *error) {
  job j = {.options = options,
           .device = d,
           .configuration = bench_default(),
           .out = out};
  memset(out, 0, sizeof *out);
  out->runs = options->runs;
  out->rounds = options->quick ? 1 : BENCH_ROUNDS;
  out->base = BASE;
  bench_label(&j.configuration, out->label, sizeof out->label);
  if (open_room(&j, options->width, options->height, &j.base, error) != 0)
    return -1;
  const int failed =
      measure_sizes(&j, error) != 0 || measure_samplings(&j, error) != 0;
  if (!failed)
    measure_processes(&j);
  close_room(&j.base);
  return failed ? -1 : 0;
}
