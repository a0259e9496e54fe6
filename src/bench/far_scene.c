/* Errors of the providers of far light on one scene. */
#define _POSIX_C_SOURCE 200809L
#include "bench/far_scene.h"

#include <glob.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/truth_measure.h"
#include "tool/paths.h"

/* The words of hbil process (truth_words.h); all that ask a cache see the same
 * views, which decide the near field's radius, too. */
enum { MOST_WORDS = 6 };
static char far_option[] = "--far", view[] = "--view",
            faces[] = "{scene}/views/face_*.exr", light_view[] = "--light-view",
            light[] = "{scene}/views/light.exr", rays[] = "rays",
            cones[] = "cones", lpv[] = "lpv", rsm[] = "rsm",
            environment[] = "environment", none[] = "none";
static char *const words[FAR_PROVIDERS][MOST_WORDS + 1] = {
    [FAR_NEAR] = {far_option, none},
    [FAR_ENVIRONMENT] = {far_option, environment},
    [FAR_RAYS] = {view, faces, far_option, rays},
    [FAR_CONES] = {view, faces, far_option, cones},
    [FAR_LPV] = {view, faces, far_option, lpv},
    [FAR_RSM] = {view, faces, far_option, rsm, light_view, light}};

/* --- files --- */

/* Whether a folder has files of that pattern. */
static int matches(const char *folder, const char *pattern) {
  glob_t found;
  char *path = path_join(folder, "/", pattern);
  const int is = path && glob(path, 0, NULL, &found) == 0;
  if (is)
    globfree(&found);
  free(path);
  return is;
}

static int read_settings(const bench_options *options, const char *folder,
                         const char *results, far_provider p, far_scene *out,
                         image_error *error) {
  bench_options o = *options;
  truth_settings *s = &out->settings[p];
  o.process = (char **)words[p];
  o.process_count = 0;
  while (words[p][o.process_count])
    o.process_count++;
  if (truth_settings_read(&o, folder, 0, s, error) != 0)
    return -1;
  s->settings.output = results;
  return 0;
}

static int check(const far_scene *s, far_provider p, image_error *error) {
  const truth_scene *scene = &s->scene;
  compare_side truth;
  uint32_t width, height;
  if (truth_process_check(&s->settings[p].settings, scene->frames, scene->count,
                          &width, &height, error) != 0)
    return -1;
  int failed = truth_scene_read(scene, &truth, error);
  if (!failed && (truth.planes.width != width || truth.planes.height != height))
    failed = image_fail(error,
                        "%s: %u x %u pixels, but %s has %u x %u; the truth of "
                        "this frame is needed",
                        scene->truth, truth.planes.width, truth.planes.height,
                        scene->frames[scene->count - 1], width, height);
  compare_side_free(&truth);
  return failed;
}

static int open_in(const bench_options *options, const char *folder,
                   const char *results, far_scene *out, image_error *error) {
  if (!matches(folder, "views/face_*.exr"))
    return image_fail(error,
                      "%s: no views; views/face_*.exr of what is around the "
                      "camera are needed",
                      folder);
  for (int p = 0; p < FAR_PROVIDERS; p++) {
    out->has[p] = p != FAR_RSM || matches(folder, "views/light.exr");
    if (out->has[p] && (read_settings(options, folder, results, (far_provider)p,
                                      out, error) != 0 ||
                        check(out, (far_provider)p, error) != 0))
      return -1;
  }
  return 0;
}

int far_scene_open(const bench_options *options, const char *argument,
                   const char *results, far_scene *out, image_error *error) {
  memset(out, 0, sizeof *out);
  if (truth_scene_find(argument, &out->scene, error) != 0)
    return -1;
  char *folder = path_parent(out->scene.frames[out->scene.count - 1]);
  if (!folder)
    return image_no_memory(error, argument);
  const int failed = open_in(options, folder, results, out, error);
  free(folder);
  return failed;
}

void far_scene_free(far_scene *s) {
  for (int p = 0; p < FAR_PROVIDERS; p++)
    truth_settings_free(&s->settings[p]);
  truth_scene_free(&s->scene);
}

/* --- errors --- */

static int light_of(far_scene *s, far_provider p, const compare_side *truth,
                    const compare_mask *mask, const truth_figures *constant,
                    image_error *error) {
  const process_settings *settings = &s->settings[p].settings;
  const truth_scene *scene = &s->scene;
  compare_side answer = {0};
  truth_figures f;
  int failed = truth_process(settings, scene->frames, scene->count, error);
  if (!failed)
    failed = truth_process_read(settings, scene->frames[scene->count - 1],
                                "indirect", &answer, error);
  if (!failed)
    failed = truth_measure(&answer, truth, mask, &f, error);
  compare_side_free(&answer);
  if (failed)
    return -1;
  s->rmse[p] = f.rmse / constant->rmse;
  s->mean[p] = f.mean / constant->mean;
  return 0;
}

static int measure(far_scene *s, const compare_side *truth,
                   const compare_mask *mask, void (*show)(void *),
                   void *context, image_error *error) {
  double mean[3];
  truth_figures constant;
  truth_mean_colour(truth, mask, mean);
  if (truth_measure_constant(mean, truth, mask, &constant, error) != 0)
    return -1;
  s->floor = constant.rmse;
  for (int p = 0; p < FAR_PROVIDERS; p++) {
    s->rmse[p] = s->mean[p] = NAN;
    if (s->has[p] &&
        light_of(s, (far_provider)p, truth, mask, &constant, error) != 0)
      return -1;
    show(context);
  }
  return 0;
}

int far_scene_measure(far_scene *s, void (*show)(void *context), void *context,
                      image_error *error) {
  compare_side truth;
  compare_mask mask = {.albedo = 0};
  int failed = truth_scene_read(&s->scene, &truth, error);
  if (!failed)
    failed = compare_mask_read(s->scene.frames[s->scene.count - 1], 1,
                               &truth.planes, &mask, error);
  if (!failed)
    failed = measure(s, &truth, &mask, show, context, error);
  compare_mask_free(&mask);
  compare_side_free(&truth);
  return failed;
}
