/* The frames of a job, one after the other: read, lit, written. */
#include "tool/process.h"

#include <stdio.h>
#include <stdlib.h>

static int write_preview(process *p, const job *j, const image *result,
                         layer l) {
  char *path = process_preview_path(j, l);
  const int failed =
      path ? preview_write(path, result, l, p->exposure, &p->error)
           : image_no_memory(&p->error, j->path);
  free(path);
  return failed;
}

static int write_previews(process *p, const job *j, const image *result) {
  for (int l = 0; l < LAYER_COUNT; l++)
    if (p->layers >> l & 1 && write_preview(p, j, result, (layer)l) != 0)
      return -1;
  return 0;
}

/* "[3/8] DIR/frame.exr" */
static void tell(const process *p, const job *j, const char *path) {
  if (p->options->quiet)
    return;
  fprintf(stderr, "[%d/%d] ", (int)(j - p->jobs) + 1, p->count);
  tool_show(path, stderr);
  fputs(j->finished ? " is there already\n" : "\n", stderr);
}

/* Writes it unless it is there. */
static int write_result(process *p, const job *j, image *result) {
  char *path = process_join(j->stem, "", ".exr");
  if (!path)
    return image_no_memory(&p->error, j->path);
  resume_sign(result, j->key);
  const int failed = j->finished ? 0 : exr_write(path, result, NULL, &p->error);
  if (!failed)
    tell(p, j, path);
  free(path);
  return failed;
}

/* For the frames that are left, should this process not live to do them. */
static int save_light(process *p, const job *j) {
  if (!p->light.size || j + 1 >= p->jobs + p->end)
    return 0;
  p->light.key = j->key;
  p->light.exposure = p->exposure;
  if (p->exact)
    exact_take_light(p->exact, p->light.bytes);
  else if (sequence_take_light(p->sequence, p->light.bytes, &p->error) != 0)
    return -1;
  return resume_save(p->options->output, &p->light, &p->error);
}

/* Through the library or without it. */
static int light_planes(process *p, const job *j, const gbuffer *g,
                        image *result) {
  timing_row *row = &p->rows[j - p->jobs];
  const unsigned runs =
      p->options->repeat + (j == p->jobs ? p->options->warm_up : 0);
  row->frame = j->path;
  if (!p->exact)
    return sequence_run(p->sequence, g, &j->camera, p->environment, runs,
                        result, row, &p->error);
  exact_run(p->exact, g, &j->camera, p->environment, runs, result);
  return 0;
}

static int light_frame(process *p, const job *j, image *result) {
  enum {
    USED = 1 << ROLE_DEPTH | 1 << ROLE_NORMAL | 1 << ROLE_ALBEDO |
           1 << ROLE_DIRECT | 1 << ROLE_EMISSION | 1 << ROLE_BACKGROUND
  };
  const int moved = p->config.reprojection == HBIL_REPROJECTION_MOTION;
  gbuffer g;
  if (gbuffer_read(j->path, &j->map, USED | (moved ? 1u << ROLE_MOTION : 0u),
                   &g, &p->error) != 0)
    return -1;
  result->x = g.planes.x;
  result->y = g.planes.y;
  const int failed = light_planes(p, j, &g, result);
  gbuffer_free(&g);
  return failed;
}

static int run_frame(process *p, job *j, image *result) {
  if (process_find_key(p, j) != 0)
    return -1;
  if (!process_is_needed(p, j))
    return write_result(p, j, result);
  if (light_frame(p, j, result) != 0)
    return -1;
  if (j == p->jobs && p->options->preview)
    p->exposure = preview_exposure(result);
  if (p->options->preview && !j->finished && write_previews(p, j, result) != 0)
    return -1;
  return write_result(p, j, result) != 0 ? -1 : save_light(p, j);
}

int process_frames(process *p) {
  image result;
  int failed = 0;
  if (layers_image(p->layers, p->width, p->height, &result) != 0)
    return image_no_memory(&p->error, p->jobs[0].path);
  for (int i = 0; i < p->count && !failed; i++)
    failed = run_frame(p, &p->jobs[i], &result);
  image_free(&result);
  if (!failed && p->light.size)
    resume_done(p->options->output);
  return failed;
}
