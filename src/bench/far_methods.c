/* Times of the far-field methods. */
#include "bench/far_methods.h"

#include <math.h>
#include <stdlib.h>

#include "bench/radiance_cache.h"
#include "bench/settings.h"

typedef enum method {
  NEAR = 0,    /* the near field alone */
  ENVIRONMENT, /* or the frame's own estimate */
  RAYS,        /* from here on a radiance cache */
  CONES,
  LPV,
  RSM,
  METHODS
} method;

/* Words of hbil process --far, but for the first. */
static const struct {
  const char *name;
  hbil_cache_method method;
} methods[METHODS] = {[NEAR] = {"near field alone", HBIL_CACHE_METHOD_NONE},
                      [ENVIRONMENT] = {"environment", HBIL_CACHE_METHOD_NONE},
                      [RAYS] = {"rays", HBIL_CACHE_METHOD_RAYS},
                      [CONES] = {"cones", HBIL_CACHE_METHOD_CONES},
                      [LPV] = {"lpv", HBIL_CACHE_METHOD_LPV},
                      [RSM] = {"rsm", HBIL_CACHE_METHOD_RSM}};

/* As hbil process has them. */
enum { STEPS_AT_FIRST = 64, STEPS_OF_A_FRAME = 8 };

/* Times of one method, run by run. */
typedef struct run_times {
  double build[BENCH_MAX_RUNS], use[BENCH_MAX_RUNS], frame[BENCH_MAX_RUNS];
} run_times;

typedef struct job {
  const bench_options *options;
  const bench_device *device;
  const bench_content *content;
  bench_fixture *fixture;
  bench_trial near, environment;
  bench_radiance_cache caches[METHODS]; /* from RAYS on */
  run_times *times;                     /* of each method */
  double cache[BENCH_MAX_RUNS];
} job;

/* --- caches and plans --- */

static int open_plans(job *j, image_error *error) {
  const bench_setting standard = bench_setting_default(j->content);
  hbil_config config;
  bench_setting_apply(&standard, j->content, &config);
  if (bench_trial_open(j->fixture, &config, NULL, &j->environment, error) != 0)
    return -1;
  config.model.far_field = HBIL_FAR_NONE;
  return bench_trial_open(j->fixture, &config, NULL, &j->near, error);
}

/* A cache that has seen all frames. */
static int open_cache(job *j, method p, image_error *error) {
  bench_radiance_cache *w = &j->caches[p];
  int failed = bench_radiance_cache_open(j->device, j->content, j->fixture,
                                         methods[p].method, w, error);
  for (unsigned i = 0; i < j->content->frames && !failed; i++)
    failed = bench_radiance_cache_inject(w, i, error);
  if (!failed && p == RSM)
    failed = bench_radiance_cache_light(w, 0, error);
  if (!failed)
    failed = bench_radiance_cache_update(w, BENCH_ROUNDS_AT_FIRST, 1,
                                         STEPS_AT_FIRST, error);
  return failed;
}

static const bench_trial *trial_of(const job *j, method p) {
  return p == NEAR          ? &j->near
         : p == ENVIRONMENT ? &j->environment
                            : &j->caches[p].trial;
}

/* --- one turn --- */

/* Wall-clock time of an update without a bounce, or of a light view. */
static int time_build(const job *j, method p, unsigned run, double *out,
                      image_error *error) {
  const bench_radiance_cache *w = &j->caches[p];
  const double before = bench_clock();
  const int failed =
      p == RSM ? bench_radiance_cache_light(w, run % j->content->frames, error)
               : bench_radiance_cache_update(w, 0, 1, STEPS_OF_A_FRAME, error);
  if (failed || bench_radiance_cache_finish(w, error) != 0)
    return -1;
  *out = bench_clock() - before;
  return 0;
}

static int time_cache(const job *j, unsigned run, double *out,
                      image_error *error) {
  const bench_radiance_cache *w = &j->caches[RAYS];
  const double before = bench_clock();
  if (bench_radiance_cache_inject(w, run % j->content->frames, error) != 0 ||
      bench_radiance_cache_update(w, BENCH_ROUNDS_OF_A_FRAME, 1, 0, error) !=
          0 ||
      bench_radiance_cache_finish(w, error) != 0)
    return -1;
  *out = bench_clock() - before;
  return 0;
}

static int run_turn(job *j, unsigned run, image_error *error) {
  const unsigned slot = run < BENCH_WARM_UP ? 0 : run - BENCH_WARM_UP;
  double pass[METHODS][HBIL_PASS_COUNT], update = 0.0;
  if (time_cache(j, run, &j->cache[slot], error) != 0)
    return -1;
  for (int p = 0; p < METHODS; p++) {
    run_times *t = &j->times[p];
    const bench_trial *trial = trial_of(j, (method)p);
    if (p >= RAYS && time_build(j, (method)p, run, &t->build[slot], error) != 0)
      return -1;
    if (p == RAYS)
      update = t->build[slot]; /* which has no part of a method */
    if (p >= RAYS && p != RSM)
      t->build[slot] -= update;
    if (bench_trial_run(trial, (run + 1) % j->content->frames, 0, 0, error) !=
            0 ||
        bench_trial_passes(trial, pass[p], &t->frame[slot], error) != 0)
      return -1;
    t->use[slot] =
        pass[p][HBIL_PASS_COMPOSITE] - pass[NEAR][HBIL_PASS_COMPOSITE];
  }
  return 0;
}

static double median(double *times, unsigned runs) {
  return bench_spread_of(times, runs).median;
}

/* --- the report --- */

static const bench_column columns[] = {
    {"method", "far light", BENCH_TEXT}, {"cache_ms", "cache, ms", 2},
    {"build_ms", "build, ms", 2},        {"use_ms", "use, ms", 2},
    {"frame_ms", "frame, ms", 2},        {"whole_ms", "whole, ms", 2},
    {"memory_mib", "memory, MiB", 1}};

static void report_method(job *j, method p, double cache,
                          bench_report *report) {
  const unsigned runs = j->options->runs;
  run_times *t = &j->times[p];
  const int has_cache = p >= RAYS;
  const double update = has_cache && p != RSM ? cache : NAN;
  const double build = p > RAYS ? median(t->build, runs) : NAN;
  const double frame = median(t->frame, runs);
  bench_report_row(report);
  bench_report_text(report, methods[p].name);
  bench_report_number(report, update);
  bench_report_number(report, build);
  bench_report_number(report, p > NEAR ? median(t->use, runs) : NAN);
  bench_report_number(report, frame);
  bench_report_number(report, frame + (isnan(update) ? 0.0 : update) +
                                  (isnan(build) ? 0.0 : build));
  bench_report_number(
      report, has_cache ? (double)j->caches[p].memory / 1048576.0 : NAN);
}

static void report_all(job *j, bench_report *report) {
  const double cache = median(j->cache, j->options->runs);
  bench_report_table(report, "methods", "Far-field methods", columns,
                     sizeof columns / sizeof *columns);
  for (int p = 0; p < METHODS; p++)
    report_method(j, (method)p, cache, report);
  bench_report_note(
      report,
      "cache: injection of the frame, and an update with %d bounces, for the "
      "methods that read the cache.  build: the method's own share of an "
      "update, which is the pyramid of cones, or sources and %d steps of lpv; "
      "for rsm, reading a light view of the frame's size.  use: what probes "
      "and composite take beside the near field alone.  frame: the whole "
      "frame, use included; whole: with cache and build.  memory: the cache "
      "with the method's part.  cache and build are wall-clock times.",
      BENCH_ROUNDS_OF_A_FRAME, STEPS_OF_A_FRAME);
}

/* --- all --- */

static int measure(job *j, image_error *error) {
  int failed = open_plans(j, error);
  for (int p = RAYS; p < METHODS && !failed; p++)
    failed = open_cache(j, (method)p, error);
  for (unsigned i = 0; i < BENCH_WARM_UP + j->options->runs && !failed; i++)
    failed = run_turn(j, i, error);
  return failed;
}

int bench_far_methods(const bench_options *options, const bench_device *device,
                      const bench_content *content, bench_fixture *fixture,
                      bench_report *report, image_error *error) {
  job *j = calloc(1, sizeof *j);
  run_times *times = calloc(METHODS, sizeof *times);
  int failed = j && times ? 0 : image_no_memory(error, "times");
  if (!failed) {
    *j = (job){.options = options,
               .device = device,
               .content = content,
               .fixture = fixture,
               .times = times};
    failed = measure(j, error);
    if (!failed)
      report_all(j, report);
    for (int p = RAYS; p < METHODS; p++)
      bench_radiance_cache_close(&j->caches[p]);
    bench_trial_close(&j->environment);
    bench_trial_close(&j->near);
  }
  free(times);
  free(j);
  return failed ? -1 : 0;
}
