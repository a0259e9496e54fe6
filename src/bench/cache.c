/* hbil-bench cache: what a radiance cache costs, and each far-field method. */
#include "bench/content.h"
#include "bench/far_methods.h"
#include "bench/fixture.h"
#include "bench/radiance_cache.h"
#include "bench/report.h"

/* Of the voxels, in an update where time is scarce. */
enum { SHARE = 16 };

/* As many updates again let light settle as there are injections. */
enum { FRAMES_TO_REST = 2 * HBIL_STATIC_VIEWS };

typedef struct job {
  const bench_options *options;
  const bench_device *device;
  bench_content content;
  bench_fixture *fixture;
  bench_radiance_cache cache;
  bench_report *report;
} job;

static const bench_column columns[] = {{"name", "", BENCH_TEXT},
                                       {"median_ms", "median, ms", 2},
                                       {"low_ms", "lowest", 2},
                                       {"high_ms", "highest", 2}};

static int library_failed(const job *j, image_error *error) {
  return image_fail(error, "device %s: %s", j->device->name,
                    hbil_context_message(bench_fixture_context(j->fixture)));
}

static void report_row(const job *j, const char *name, double *times) {
  const bench_spread t = bench_spread_of(times, j->options->runs);
  bench_report_row(j->report);
  bench_report_text(j->report, name);
  bench_report_number(j->report, t.median);
  bench_report_number(j->report, t.low);
  bench_report_number(j->report, t.high);
}

/* --- commands --- */

static int inject(job *j, unsigned run, image_error *error) {
  return bench_radiance_cache_inject(&j->cache, run % j->content.frames, error);
}

static int nothing(job *j, unsigned run, image_error *error) {
  (void)j, (void)run, (void)error;
  return 0;
}

static int update_share(job *j, unsigned run, image_error *error) {
  (void)run;
  return bench_radiance_cache_update(&j->cache, 1, SHARE, 0, error);
}

static int update_all(job *j, unsigned run, image_error *error) {
  (void)run;
  return bench_radiance_cache_update(&j->cache, 1, 1, 0, error);
}

static int update_frame(job *j, unsigned run, image_error *error) {
  (void)run;
  return bench_radiance_cache_update(&j->cache, BENCH_ROUNDS_OF_A_FRAME, 1, 0,
                                     error);
}

/* What a resting camera costs. */
static int rest(job *j, unsigned run, image_error *error) {
  (void)run;
  return bench_radiance_cache_inject_static(&j->cache, 0, error) != 0 ||
                 update_frame(j, run, error) != 0
             ? -1
             : 0;
}

typedef int command(job *, unsigned, image_error *);

/* Wall-clock time of a call and its commands, behind another one. */
static int time_call(job *j, const char *name, command *first, command *call,
                     image_error *error) {
  double times[BENCH_MAX_RUNS];
  for (unsigned i = 0; i < BENCH_WARM_UP + j->options->runs; i++) {
    if (first(j, i, error) != 0 ||
        bench_radiance_cache_finish(&j->cache, error) != 0)
      return -1;
    const double before = bench_clock();
    if (call(j, i, error) != 0 ||
        bench_radiance_cache_finish(&j->cache, error) != 0)
      return -1;
    times[i < BENCH_WARM_UP ? 0 : i - BENCH_WARM_UP] = bench_clock() - before;
  }
  report_row(j, name, times);
  return 0;
}

static int measure(job *j, image_error *error) {
  for (unsigned i = 0; i < j->content.frames; i++)
    if (inject(j, i, error) != 0)
      return -1;
  if (bench_radiance_cache_update(&j->cache, BENCH_ROUNDS_AT_FIRST, 1, 0,
                                  error) != 0)
    return -1;
  int failed = time_call(j, "inject a view", nothing, inject, error) != 0 ||
               time_call(j, "update: one bounce, every 16th voxel", inject,
                         update_share, error) != 0 ||
               time_call(j, "update: one bounce, all voxels", inject,
                         update_all, error) != 0 ||
               time_call(j, "update: four bounces, as hbil process does",
                         inject, update_frame, error) != 0;
  for (unsigned i = 0; i < FRAMES_TO_REST && !failed; i++)
    failed = rest(j, i, error);
  return failed || time_call(j, "both, camera and light at rest", nothing, rest,
                             error) != 0
             ? -1
             : 0;
}

static int report_notes(const job *j, image_error *error) {
  const bench_radiance_cache *w = &j->cache;
  hbil_cache_counts known;
  if (hbil_cache_statistics(w->cache, j->device->queue, &known) != HBIL_SUCCESS)
    return library_failed(j, error);
  bench_report_note(
      j->report,
      "The cache has %u levels of %u voxels each way, %.1f MiB on the device; "
      "its views show %zu surfaces and %zu empty voxels.",
      (unsigned)w->config.levels, (unsigned)w->config.voxels,
      (double)w->memory / 1048576.0, known.surfaces, known.empty);
  return 0;
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.options = options, .device = device, .report = report};
  if (bench_content_load(options, 2, 0, &j.content, error) != 0)
    return -1;
  bench_report_subject(report, j.content.name, j.content.width,
                       j.content.height, options->runs);
  bench_report_table(report, "cache", "A radiance cache", columns,
                     sizeof columns / sizeof *columns);
  int failed = bench_fixture_open(device, &j.content, &j.fixture, error);
  failed =
      failed ||
      bench_radiance_cache_open(device, &j.content, j.fixture,
                                HBIL_CACHE_METHOD_RAYS, &j.cache, error) != 0 ||
      measure(&j, error) != 0 || report_notes(&j, error) != 0;
  bench_radiance_cache_close(&j.cache);
  failed = failed || bench_far_methods(options, device, &j.content, j.fixture,
                                       report, error) != 0;
  bench_fixture_close(j.fixture);
  bench_content_free(&j.content);
  return failed ? -1 : 0;
}

const bench_command bench_cache = {
    .name = "cache",
    .about = "what a radiance cache and each far-field method cost",
    .details =
        "What do a view and a bounce of a radiance cache cost, and what does\n"
        "each far-field method (hbil process --far) add to a frame?\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_TIMES |
               BENCH_TAKES_FRAMES,
    .runs = 9,
    .run = run};
