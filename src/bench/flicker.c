/* hbil-bench flicker: how much light changes between frames where nothing does.
 */
#include <math.h>
#include <stdlib.h>

#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/flicker_measure.h"
#include "bench/radiance_cache.h"
#include "bench/report.h"
#include "bench/settings.h"
#include "image/quantile.h"

enum {
  /* The light of frames before the first pair has settled: bounces, cache. */
  SETTLE = 5,
  FRAMES = SETTLE + 11,
  QUICK_FRAMES = 4,
  WIDTH = 320,
  HEIGHT = 180,
  SHARED = 2 /* frames that share the slices of a pixel */
};

static const scene_kind scenes[] = {SCENE_CORNER, SCENE_ROOM};
enum { SCENES = sizeof scenes / sizeof *scenes };

/* A row: how a sequence is lit. */
typedef struct way {
  const char *name;
  int cache;
  unsigned slice_frames;
} way;
static const way ways[] = {{"no cache", 0, 1},
                           {"no cache, shared slices", 0, SHARED},
                           {"cache", 1, 1},
                           {"cache, shared slices", 1, SHARED}};
enum { WAYS = sizeof ways / sizeof *ways };

typedef struct job {
  const bench_device *device;
  bench_report *report;
  bench_content content;
  bench_fixture *fixture;
  float *light[2]; /* RGB of two frames in turns */
} job;

static const bench_column columns[] = {
    {"scene", "scene", BENCH_TEXT},    {"light", "light", BENCH_TEXT},
    {"rms", "change, RMS", 4},         {"patches", "patches", 4},
    {"worst", "of the worst pair", 4}, {"compared", "pixels compared", 2}};

/* --- a sequence --- */

/* Lights a frame, after it has been injected as hbil process does. */
static int light_frame(const job *j, const bench_trial *t,
                       const bench_radiance_cache *cache, unsigned frame,
                       image_error *error) {
  const cl_uint rounds =
      frame ? BENCH_ROUNDS_OF_A_FRAME : BENCH_ROUNDS_AT_FIRST;
  if (cache->cache &&
      (bench_radiance_cache_inject(cache, frame, error) != 0 ||
       bench_radiance_cache_update(cache, rounds, 1, 0, error) != 0))
    return -1;
  return bench_trial_run(t, frame, frame, 0, error) != 0
             ? -1
             : bench_trial_read(t, BENCH_INDIRECT, j->light[frame & 1], error);
}

static void report_changes(const job *j, const way *w,
                           const flicker_change *list, unsigned count) {
  double rms[FRAMES], patches[FRAMES], compared = 0.0;
  for (unsigned i = 0; i < count; i++) {
    rms[i] = list[i].rms;
    patches[i] = list[i].patches;
    compared += list[i].compared / count;
  }
  bench_report_row(j->report);
  bench_report_text(j->report, j->content.name);
  bench_report_text(j->report, w->name);
  bench_report_number(j->report, quantile(rms, count, 0.5));
  bench_report_number(j->report, quantile(patches, count, 0.5));
  bench_report_number(j->report, quantile(patches, count, 1.0));
  bench_report_number(j->report, compared);
}

static int measure_frames(const job *j, const way *w, const bench_trial *t,
                          const bench_radiance_cache *cache,
                          image_error *error) {
  const unsigned frames = j->content.frames;
  const unsigned first = frames > SETTLE + 1 ? SETTLE : 0;
  flicker_change list[FRAMES];
  unsigned count = 0;
  for (unsigned f = 0; f < frames; f++) {
    if (light_frame(j, t, cache, f, error) != 0)
      return -1;
    if (f <= first || count == FRAMES)
      continue;
    const float *const pair[2] = {j->light[(f - 1) & 1], j->light[f & 1]};
    if (flicker_measure(&j->content, f - 1, pair, &list[count++], error) != 0)
      return -1;
  }
  report_changes(j, w, list, count);
  return 0;
}

static int measure_way(const job *j, const way *w, image_error *error) {
  const bench_setting standard = bench_setting_default(&j->content);
  bench_radiance_cache cache = {.cache = NULL};
  bench_trial t = {.plan = NULL};
  hbil_config config;
  bench_setting_apply(&standard, &j->content, &config);
  int failed = 0;
  if (w->cache) {
    failed = bench_radiance_cache_open(j->device, &j->content, j->fixture,
                                       HBIL_CACHE_METHOD_RAYS, &cache, error);
    config = cache.trial.config;
  }
  config.sampling.slice_frames = w->slice_frames;
  failed =
      failed || bench_trial_open(j->fixture, &config, NULL, &t, error) != 0;
  if (!failed) {
    t.cache = cache.cache;
    failed = measure_frames(j, w, &t, &cache, error);
  }
  bench_trial_close(&t);
  bench_radiance_cache_close(&cache);
  return failed ? -1 : 0;
}

/* Measures the loaded content. */
static int measure(job *j, image_error *error) {
  const size_t floats = 3 * bench_pixels(&j->content);
  const char *lacks = flicker_lacks(&j->content);
  if (lacks)
    return image_fail(error, "%s: %s is needed to find points again",
                      j->content.name, lacks);
  j->light[0] = malloc(2 * floats * sizeof *j->light[0]);
  if (!j->light[0])
    return image_no_memory(error, j->content.name);
  j->light[1] = j->light[0] + floats;
  int failed = bench_fixture_open(j->device, &j->content, &j->fixture, error);
  for (int i = 0; i < WAYS && !failed; i++)
    failed = measure_way(j, &ways[i], error);
  return failed ? -1 : 0;
}

static void forget(job *j) {
  bench_fixture_close(j->fixture);
  bench_content_free(&j->content);
  free(j->light[0]);
  j->fixture = NULL;
  j->light[0] = NULL;
}

/* --- all --- */

static int measure_all(job *j, const bench_options *options,
                       image_error *error) {
  bench_options own = *options;
  const unsigned frames = options->quick ? QUICK_FRAMES : FRAMES;
  const int count = options->frame_count ? 1 : SCENES;
  int failed = 0;
  if (!own.frame_count && !own.width) {
    own.width = WIDTH;
    own.height = HEIGHT;
  }
  for (int i = 0; i < count && !failed; i++) {
    failed = options->frame_count
                 ? bench_content_load(&own, 0, 0, &j->content, error)
                 : bench_content_load_scene(&own, scenes[i], frames,
                                            &j->content, error);
    if (!failed && i == 0)
      bench_report_subject(j->report,
                           options->frame_count ? j->content.name
                                                : "procedural scenes",
                           j->content.width, j->content.height, 0);
    if (!failed && i == 0)
      bench_report_table(j->report, "changes", "Changes of indirect light",
                         columns, sizeof columns / sizeof *columns);
    failed = failed || measure(j, error) != 0;
    forget(j);
  }
  return failed ? -1 : 0;
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.device = device, .report = report};
  if (measure_all(&j, options, error) != 0)
    return -1;
  bench_report_note(
      report,
      "The change of indirect light from one frame to the next at points that "
      "don't move and that both show, over its mean: medians over the pairs of "
      "frames.  patches: after a blur of %g pixels and without the change of "
      "the whole picture.  shared slices: %d frames share four slices of 40 "
      "steps.",
      FLICKER_SIGMA, SHARED);
  return 0;
}

const bench_command bench_flicker = {
    .name = "flicker",
    .about = "how much light changes from frame to frame where nothing does",
    .details =
        "How much does indirect light change from frame to frame at points\n"
        "that don't move, while the camera does?  FRAME.exr... are a "
        "sequence;\n"
        "without any, the camera moves through the demo's corner and room\n"
        "(320x180).\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_FRAMES,
    .run = run};
