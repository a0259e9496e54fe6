/* Times of the providers of far light, each with a cache of its own. */
#include "bench/far_time.h"

#include <math.h>
#include <stdlib.h>

#include "bench/settings.h"
#include "bench/world.h"

/* As hbil process has them. */
enum { STEPS_AT_FIRST = 64, STEPS_OF_A_FRAME = 8 };

/* Times of one provider, run by run. */
typedef struct run_times {
  double build[BENCH_MAX_RUNS], use[BENCH_MAX_RUNS], frame[BENCH_MAX_RUNS];
} run_times;

typedef struct job {
  const bench_options *options;
  const bench_device *device;
  const bench_content *content;
  bench_fixture *fixture;
  bench_trial near, environment;
  bench_world worlds[FAR_PROVIDERS]; /* from FAR_RAYS on */
  run_times *times;                  /* of each provider */
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
static int open_world(job *j, far_provider p, image_error *error) {
  bench_world *w = &j->worlds[p];
  int failed = bench_world_open(j->device, j->content, j->fixture,
                                far_provider_of_library(p), w, error);
  for (unsigned i = 0; i < j->content->frames && !failed; i++)
    failed = bench_world_inject(w, i, error);
  if (!failed && p == FAR_RSM)
    failed = bench_world_light(w, 0, error);
  if (!failed)
    failed =
        bench_world_update(w, BENCH_ROUNDS_AT_FIRST, 1, STEPS_AT_FIRST, error);
  return failed;
}

static const bench_trial *trial_of(const job *j, far_provider p) {
  return p == FAR_NEAR          ? &j->near
         : p == FAR_ENVIRONMENT ? &j->environment
                                : &j->worlds[p].trial;
}

/* --- one turn --- */

/* Wall-clock time of an update without a bounce, or of a light view. */
static int time_build(const job *j, far_provider p, unsigned run, double *out,
                      image_error *error) {
  const bench_world *w = &j->worlds[p];
  const double before = bench_clock();
  const int failed = p == FAR_RSM
                         ? bench_world_light(w, run % j->content->frames, error)
                         : bench_world_update(w, 0, 1, STEPS_OF_A_FRAME, error);
  if (failed || bench_world_finish(w, error) != 0)
    return -1;
  *out = bench_clock() - before;
  return 0;
}

static int time_cache(const job *j, unsigned run, double *out,
                      image_error *error) {
  const bench_world *w = &j->worlds[FAR_RAYS];
  const double before = bench_clock();
  if (bench_world_inject(w, run % j->content->frames, error) != 0 ||
      bench_world_update(w, BENCH_ROUNDS_OF_A_FRAME, 1, 0, error) != 0 ||
      bench_world_finish(w, error) != 0)
    return -1;
  *out = bench_clock() - before;
  return 0;
}

static int run_turn(job *j, unsigned run, image_error *error) {
  const unsigned slot = run < BENCH_WARM_UP ? 0 : run - BENCH_WARM_UP;
  double pass[FAR_PROVIDERS][HBIL_PASS_COUNT], update = 0.0;
  if (time_cache(j, run, &j->cache[slot], error) != 0)
    return -1;
  for (int p = 0; p < FAR_PROVIDERS; p++) {
    run_times *t = &j->times[p];
    const bench_trial *trial = trial_of(j, (far_provider)p);
    if (p >= FAR_RAYS &&
        time_build(j, (far_provider)p, run, &t->build[slot], error) != 0)
      return -1;
    if (p == FAR_RAYS)
      update = t->build[slot]; /* which has no part of a provider */
    if (p >= FAR_RAYS && p != FAR_RSM)
      t->build[slot] -= update;
    if (bench_trial_run(trial, (run + 1) % j->content->frames, 0, 0, error) !=
            0 ||
        bench_trial_passes(trial, pass[p], &t->frame[slot], error) != 0)
      return -1;
    t->use[slot] =
        pass[p][HBIL_PASS_COMPOSITE] - pass[FAR_NEAR][HBIL_PASS_COMPOSITE];
  }
  return 0;
}

/* --- all --- */

static double median(double *times, unsigned runs) {
  return bench_spread_of(times, runs).median;
}

static void sum_up(job *j, far_time out[FAR_PROVIDERS]) {
  const unsigned runs = j->options->runs;
  const double cache = median(j->cache, runs);
  for (int p = 0; p < FAR_PROVIDERS; p++) {
    far_time *t = &out[p];
    const int has_cache = p >= FAR_RAYS;
    t->cache = has_cache && p != FAR_RSM ? cache : NAN;
    t->build = p > FAR_RAYS ? median(j->times[p].build, runs) : NAN;
    t->use = p > FAR_NEAR ? median(j->times[p].use, runs) : NAN;
    t->frame = median(j->times[p].frame, runs);
    t->whole = t->frame + (isnan(t->cache) ? 0.0 : t->cache) +
               (isnan(t->build) ? 0.0 : t->build);
    t->memory = has_cache ? (double)j->worlds[p].memory / 1048576.0 : NAN;
  }
}

static int measure(job *j, far_time out[FAR_PROVIDERS], image_error *error) {
  int failed = open_plans(j, error);
  for (int p = FAR_RAYS; p < FAR_PROVIDERS && !failed; p++)
    failed = open_world(j, (far_provider)p, error);
  for (unsigned i = 0; i < BENCH_WARM_UP + j->options->runs && !failed; i++)
    failed = run_turn(j, i, error);
  if (!failed)
    sum_up(j, out);
  return failed;
}

int far_times_measure(const bench_options *options, const bench_device *device,
                      const bench_content *content, bench_fixture *fixture,
                      far_time out[FAR_PROVIDERS], image_error *error) {
  job *j = calloc(1, sizeof *j);
  run_times *times = calloc(FAR_PROVIDERS, sizeof *times);
  int failed = j && times ? 0 : image_no_memory(error, "times");
  if (!failed) {
    *j = (job){.options = options,
               .device = device,
               .content = content,
               .fixture = fixture,
               .times = times};
    failed = measure(j, out, error);
    for (int p = FAR_RAYS; p < FAR_PROVIDERS; p++)
      bench_world_close(&j->worlds[p]);
    bench_trial_close(&j->environment);
    bench_trial_close(&j->near);
  }
  free(times);
  free(j);
  return failed ? -1 : 0;
}

/* --- the report --- */

static const bench_column columns[] = {
    {"provider", "far light", BENCH_TEXT}, {"cache_ms", "cache, ms", 2},
    {"build_ms", "build, ms", 2},          {"use_ms", "use, ms", 2},
    {"frame_ms", "frame, ms", 2},          {"whole_ms", "whole, ms", 2},
    {"memory_mib", "memory, MiB", 1}};

void far_times_note(bench_report *report) {
  bench_report_note(
      report,
      "cache: injection of the frame, and an update of %d rounds, for the "
      "providers that read the cache.  build: the provider's "
      "own share of an update, which is the pyramid of cones, or sources and "
      "%d steps of lpv; for rsm, reading a light view of the frame's size.  "
      "use: what probes and composite take beside the near field alone.  "
      "frame: the whole frame, use included; whole: with cache and build.  "
      "memory: the cache with the provider's part.  "
      "cache and build are wall-clock times.",
      BENCH_ROUNDS_OF_A_FRAME, STEPS_OF_A_FRAME);
}

void far_times_report(const far_time times[FAR_PROVIDERS],
                      bench_report *report) {
  bench_report_table(report, "providers", "Providers of far light", columns,
                     sizeof columns / sizeof *columns);
  for (int p = 0; p < FAR_PROVIDERS; p++) {
    const far_time *t = &times[p];
    const double cells[] = {t->cache, t->build, t->use,
                            t->frame, t->whole, t->memory};
    bench_report_row(report);
    bench_report_text(report, far_provider_name((far_provider)p));
    for (size_t i = 0; i < sizeof cells / sizeof *cells; i++)
      bench_report_number(report, cells[i]);
  }
  far_times_note(report);
}
