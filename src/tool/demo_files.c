/* The names of all files that hbil demo writes. */
#include "tool/demo_files.h"

#include "dump/frame_camera.h"
#include "tool/file_kind.h"
#include "tool/job.h"
#include "tool/paths.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* Names                                                                     */

/* FOLDER/WORD_0001.exr and so on; NULL if memory runs out. */
static char **name_list(const char *folder, const char *word, unsigned count) {
  char **list = calloc(count + 1, sizeof *list);
  for (unsigned i = 0; list && i < count; i++) {
    char name[64];
    snprintf(name, sizeof name, "%s_%04u.exr", word, i + 1);
    list[i] = path_join(folder, "/", name);
  }
  return list;
}

static int is_complete(char *const *list, unsigned count) {
  for (unsigned i = 0; list && i < count; i++)
    if (!list[i])
      return 0;
  return list != NULL;
}

int demo_files_name(const char *output, const demo_content *content,
                    demo_files *out, image_error *error) {
  *out = (demo_files){.output = output,
                      .folder = path_join(output, "/", "gbuffer"),
                      .frame_count = content->frames,
                      .view_count = content->views};
  if (!out->folder)
    return image_no_memory(error, output);
  out->frames = name_list(out->folder, "frame", content->frames);
  out->views = name_list(out->folder, "view", content->views);
  if (content->light_view)
    out->light_view = path_join(out->folder, "/", "light_view.exr");
  if (content->sky)
    out->sky = path_join(output, "/", "sky.exr");
  return is_complete(out->frames, content->frames) &&
                 is_complete(out->views, content->views) &&
                 !out->light_view == !content->light_view &&
                 !out->sky == !content->sky
             ? 0
             : image_no_memory(error, output);
}

static void free_list(char **list, unsigned count) {
  for (unsigned i = 0; list && i < count; i++)
    free(list[i]);
  free(list);
}

void demo_files_free(demo_files *files) {
  free_list(files->frames, files->frame_count);
  free_list(files->views, files->view_count);
  free(files->light_view);
  free(files->sky);
  free(files->folder);
  memset(files, 0, sizeof *files);
}

/* ------------------------------------------------------------------------ */
/* What is there already                                                     */

/* expected: what a demo would have left there. */
static int check(const char *path, file_kind there, file_kind expected,
                 image_error *error) {
  return there == FILE_ABSENT || there == FILE_BLANK || there == expected
             ? 0
             : image_fail(error,
                          "%s: is there already, and no earlier demo wrote it; "
                          "another -o DIR is needed",
                          path);
}

/* A G-buffer and the camera beside it, which nothing marks. */
static int check_traced(const char *path, image_error *error) {
  const file_kind there = file_kind_of(path);
  if (check(path, there, FILE_DEMO, error) != 0)
    return -1;
  if (there == FILE_DEMO)
    return 0;
  char *camera = camera_file_beside(path);
  if (!camera)
    return image_no_memory(error, path);
  const int failed = check(camera, file_kind_of(camera), FILE_BLANK, error);
  free(camera);
  return failed;
}

/* Takes over the malloc'd path; NULL means that memory ran out. */
static int check_written(char *path, file_kind expected, image_error *error) {
  const int failed = path ? check(path, file_kind_of(path), expected, error)
                          : image_no_memory(error, "demo");
  free(path);
  return failed;
}

/* was_demo: whether the folder is that of an earlier demo.  In others, results
 * are those of another job. */
static int check_result(const demo_files *files, unsigned index, int was_demo,
                        image_error *error) {
  const job_frame f = {.stem =
                           path_stem_in(files->output, files->frames[index])};
  int failed = f.stem
                   ? check_written(job_result_path(&f),
                                   was_demo ? FILE_RESULT : FILE_ABSENT, error)
                   : image_no_memory(error, files->output);
  for (int l = 0; l < LAYER_COUNT && !failed; l++)
    failed = check_written(job_preview_path(&f, (layer)l),
                           was_demo ? FILE_PICTURE : FILE_ABSENT, error);
  free(f.stem);
  return failed;
}

int demo_files_check(const demo_files *files, image_error *error) {
  const int was_demo = file_kind_of(files->frames[0]) == FILE_DEMO;
  int failed = 0;
  for (unsigned i = 0; i < files->frame_count && !failed; i++)
    failed = check_traced(files->frames[i], error) != 0 ||
             check_result(files, i, was_demo, error) != 0;
  for (unsigned i = 0; i < files->view_count && !failed; i++)
    failed = check_traced(files->views[i], error);
  if (!failed && files->light_view)
    failed = check_traced(files->light_view, error);
  if (!failed && files->sky)
    failed = check(files->sky, file_kind_of(files->sky), FILE_DEMO, error);
  return failed ? -1 : 0;
}
