/* Errors of the providers of far light on one scene with truth and views. */
#ifndef HBIL_BENCH_FAR_SCENE_H
#define HBIL_BENCH_FAR_SCENE_H

#include "bench/far_provider.h"
#include "bench/truth_process.h"
#include "bench/truth_scene.h"

typedef struct far_scene {
  truth_scene scene;
  truth_settings settings[FAR_PROVIDERS];
  int has[FAR_PROVIDERS]; /* 0: rsm without a light view */
  double floor;           /* RMSE of the truth's mean colour */
  /* RMSE over the floor, and mean over the truth's; NAN: not measured */
  double rmse[FAR_PROVIDERS], mean[FAR_PROVIDERS];
} far_scene;

/* Finds the files of an argument (truth_scene.h), views/face_*.exr and, if it
 * is there, views/light.exr beside the frames, and checks all that hbil process
 * checks.  results: a folder for these (truth_folder_make()).  Returns 0, or -1
 * with `error` filled; far_scene_free() frees it in both cases. */
int far_scene_open(const bench_options *options, const char *argument,
                   const char *results, far_scene *out, image_error *error);
void far_scene_free(far_scene *s);

/* Runs one provider after the other.  show: called after each, or before one
 * that the scene hasn't. */
int far_scene_measure(far_scene *s, void (*show)(void *context), void *context,
                      image_error *error);

#endif
