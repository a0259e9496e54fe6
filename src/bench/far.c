/* hbil-bench far: error and time of all ways to find light that the near field
 * doesn't. */
#include <math.h>
#include <stdlib.h>

#include "bench/content.h"
#include "bench/far_plot.h"
#include "bench/far_scene.h"
#include "bench/far_time.h"
#include "bench/fixture.h"
#include "bench/report.h"

typedef struct job {
  const bench_options *options;
  const bench_device *device;
  char *folder; /* of results, for as long as the command runs */
  far_scene *scenes;
  size_t count;
  size_t done, passes; /* of the pipeline, for the progress */
  far_time times[FAR_PROVIDERS];
} job;

/* --- errors --- */

static void show_pass(void *context) {
  job *j = context;
  bench_progress("passes of the pipeline", ++j->done, j->passes);
}

/* Mistakes are told before anything takes time. */
static int open_scenes(job *j, image_error *error) {
  const bench_options *o = j->options;
  j->scenes = calloc(o->frame_count, sizeof *j->scenes);
  if (!j->scenes)
    return image_no_memory(error, "far");
  j->folder = truth_folder_make(error);
  if (!j->folder)
    return -1;
  while (j->count < o->frame_count) {
    const char *argument = o->frames[j->count];
    far_scene *s = &j->scenes[j->count++];
    if (far_scene_open(o, argument, j->folder, s, error) != 0)
      return -1;
  }
  j->passes = j->count * FAR_PROVIDERS;
  return 0;
}

static int measure_errors(job *j, image_error *error) {
  for (size_t i = 0; i < j->count; i++)
    if (far_scene_measure(&j->scenes[i], show_pass, j, error) != 0)
      return -1;
  return 0;
}

/* The geometric mean over scenes of RMSE or, with is_mean, of the mean; of
 * those alone that have a light view, if `lights` is set.  NAN where there is
 * none, or where a provider lacks some of the scenes. */
static double over_scenes(const job *j, far_provider p, int lights,
                          int is_mean) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < j->count; i++) {
    const far_scene *s = &j->scenes[i];
    if (lights && !s->has[FAR_RSM])
      continue;
    sum += log(is_mean ? s->mean[p] : s->rmse[p]);
    count += 1.0;
  }
  return exp(sum / count);
}

/* --- times --- */

static int measure_times(job *j, bench_report *report, image_error *error) {
  bench_options room = *j->options;
  bench_content content;
  bench_fixture *fixture = NULL;
  room.frame_count = 0; /* the folders are no dumps to measure times on */
  if (bench_content_load(&room, 2, 0, &content, error) != 0)
    return -1;
  bench_report_subject(report, content.name, content.width, content.height,
                       room.runs);
  int failed = bench_fixture_open(j->device, &content, &fixture, error);
  if (!failed)
    failed =
        far_times_measure(&room, j->device, &content, fixture, j->times, error);
  bench_fixture_close(fixture);
  bench_content_free(&content);
  return failed;
}

static int draw(const job *j, bench_report *report, image_error *error) {
  far_point points[FAR_PROVIDERS];
  int made = 0;
  for (int p = 0; p < FAR_PROVIDERS; p++)
    points[p] = (far_point){j->times[p].whole,
                            {over_scenes(j, (far_provider)p, 0, 0),
                             over_scenes(j, (far_provider)p, 1, 0)}};
  if (far_plot_write(j->options, points, &made, error) != 0)
    return -1;
  if (!made)
    bench_report_note(report, "There is no plot, because gnuplot is missing or "
                              "has failed.");
  return 0;
}

/* --- the report --- */

static const bench_column columns[] = {
    {"provider", "far light", BENCH_TEXT},
    {"rmse", "RMSE", 3},
    {"mean_ratio", "mean, of the truth's", 3},
    {"rmse_lights", "RMSE, scenes with a light view", 3},
    {"mean_ratio_lights", "mean", 3},
    {"cache_ms", "cache, ms", 2},
    {"build_ms", "build, ms", 2},
    {"use_ms", "use, ms", 2},
    {"frame_ms", "frame, ms", 2},
    {"whole_ms", "whole, ms", 2},
    {"memory_mib", "memory, MiB", 1}};

static const bench_column scene_columns[] = {{"scene", "scene", BENCH_TEXT},
                                             {"floor", "floor, RMSE", 4},
                                             {"near", "near field alone", 3},
                                             {"near_mean", "mean", 2},
                                             {"environment", "environment", 3},
                                             {"environment_mean", "mean", 2},
                                             {"rays", "rays", 3},
                                             {"rays_mean", "mean", 2},
                                             {"cones", "cones", 3},
                                             {"cones_mean", "mean", 2},
                                             {"lpv", "lpv", 3},
                                             {"lpv_mean", "mean", 2},
                                             {"rsm", "rsm", 3},
                                             {"rsm_mean", "mean", 2}};
_Static_assert(sizeof scene_columns / sizeof *scene_columns ==
                   2 + 2 * FAR_PROVIDERS,
               "two columns for each provider");

static void report_providers(const job *j, bench_report *report) {
  bench_report_table(report, "providers", "Providers of far light", columns,
                     sizeof columns / sizeof *columns);
  for (int i = 0; i < FAR_PROVIDERS; i++) {
    const far_provider p = (far_provider)i;
    const far_time *t = &j->times[p];
    bench_report_row(report);
    bench_report_text(report, far_provider_name(p));
    for (int lights = 0; lights < 2; lights++)
      for (int is_mean = 0; is_mean < 2; is_mean++)
        bench_report_number(report, over_scenes(j, p, lights, is_mean));
    const double costs[] = {t->cache, t->build, t->use,
                            t->frame, t->whole, t->memory};
    for (size_t k = 0; k < sizeof costs / sizeof *costs; k++)
      bench_report_number(report, costs[k]);
  }
}

static void report_scenes(const job *j, bench_report *report) {
  bench_report_table(report, "scenes", "Scene by scene", scene_columns,
                     sizeof scene_columns / sizeof *scene_columns);
  for (size_t i = 0; i < j->count; i++) {
    const far_scene *s = &j->scenes[i];
    bench_report_row(report);
    bench_report_text(report, s->scene.name);
    bench_report_number(report, s->floor);
    for (int p = 0; p < FAR_PROVIDERS; p++) {
      bench_report_number(report, s->rmse[p]);
      bench_report_number(report, s->mean[p]);
    }
  }
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.options = options, .device = device};
  for (int p = 0; p < FAR_PROVIDERS; p++)
    j.times[p] = (far_time){NAN, NAN, NAN, NAN, NAN, NAN};
  int failed = open_scenes(&j, error) != 0 || measure_errors(&j, error) != 0 ||
               (!options->no_times && measure_times(&j, report, error) != 0);
  if (!failed) {
    report_providers(&j, report);
    report_scenes(&j, report);
    bench_report_note(
        report,
        "RMSE of indirect light over that of the constant mean (the floor), "
        "and its mean over the truth's; of several scenes their geometric "
        "mean.  All but the first two see the views of the place, and rsm the "
        "view from its light.");
    if (!options->no_times) {
      far_times_note(report);
      failed = draw(&j, report, error);
    }
  }
  for (size_t i = 0; i < j.count; i++)
    far_scene_free(&j.scenes[i]);
  free(j.scenes);
  truth_folder_remove(j.folder);
  return failed ? -1 : 0;
}

const bench_command bench_far = {
    .name = "far",
    .about = "error and time of all providers of far light",
    .details =
        "Which light should open directions get, and what does it cost?  Each\n"
        "FOLDER is a scene with truth, as for hbil-bench truth, and with "
        "views\n"
        "of the place in FOLDER/views/face_*.exr.  Where there is\n"
        "FOLDER/views/light.exr, it is the view from the place of the light.\n"
        "Compared are hbil process --far none (the near field alone), "
        "environment\n"
        "(or the frame's own estimate), rays, cones, lpv and rsm.\n"
        "Times are those of the procedural room.  NAME.png shows error "
        "against\n"
        "time, if gnuplot is installed.\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_TIMES |
               BENCH_TAKES_SCENES,
    .runs = 9,
    .run = run};
