/* Folders with frames and the path-traced light of the last one. */
#ifndef HBIL_BENCH_TRUTH_SCENE_H
#define HBIL_BENCH_TRUTH_SCENE_H

#include <stddef.h>

#include "image/error.h"
#include "tool/compare_sides.h"

/* All members are owned. */
typedef struct truth_scene {
  char *name;    /* the last part of the argument; the last two if the truth is
                    that of the folder above */
  char **frames; /* files, in order; the last one is compared */
  size_t count;  /* of frames, at least 1 */
  char *truth;   /* a file with its light; it may be that frame */
} truth_scene;

/*
 * Finds the files of an argument, which is one of
 *   a folder with frame_NNNN.exr, and truth_avg_NNNN.exr of the last one; or
 *     else the last one has the light itself; or else the folder above has
 *     it: its last truth_avg_NNNN.exr, whose frame_NNNN.json must be the camera
 *     of the last frame;
 *   a folder with one NAME_truth.exr, and NAME.exr;
 *   FOLDER/NAME of FOLDER/NAME.exr.  Its truth is NAME_truth.exr, where NAME
 *     loses parts that begin with an underscore until there is such a file.
 * Returns 0, or -1 with `error` filled; truth_scene_free() frees it in both
 * cases.
 */
int truth_scene_find(const char *argument, truth_scene *out,
                     image_error *error);
void truth_scene_free(truth_scene *s);

/* The scene's truth as bench_colour_read() gives it. */
int truth_scene_read(const truth_scene *s, compare_side *out,
                     image_error *error);

#endif
