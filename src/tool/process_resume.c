/* What is there already of a job, and the light to go on with. */
#define _POSIX_C_SOURCE 200809L
#include "tool/process.h"

#include <stdlib.h>
#include <unistd.h>

int process_find_key(const process *p, job *j, image_error *error) {
  if (j->key)
    return 0;
  j->key = j == p->jobs ? p->settings : j[-1].key;
  return resume_frame(j->path, &j->map, &j->camera, &j->key, error);
}

char *process_preview_path(const job *j, layer l) {
  char *stem = process_join(j->stem, ".", layer_table[l].name);
  char *path = stem ? process_join(stem, "", ".png") : NULL;
  free(stem);
  return path;
}

static int has_previews(const process *p, const job *j) {
  int all = 1;
  for (int l = 0; l < LAYER_COUNT && all; l++) {
    char *path = p->layers >> l & 1 ? process_preview_path(j, (layer)l) : NULL;
    all = !(p->layers >> l & 1) || (path && access(path, F_OK) == 0);
    free(path);
  }
  return all;
}

static int look_for_result(process *p, job *j) {
  char *path = process_join(j->stem, "", ".exr");
  if (!path)
    return image_no_memory(&p->error, j->path);
  const int failed = process_find_key(p, j, &p->error);
  j->finished = !failed && resume_is_finished(path, j->key) &&
                (!p->options->preview || has_previews(p, j));
  free(path);
  return failed;
}

/* Light that was saved behind a frame up to which nothing is missing. */
static int give_light(process *p, int missing) {
  int from = missing - 1;
  if (!p->light.size || !resume_load(p->options->output, &p->light))
    return 0;
  while (from >= 0 && p->jobs[from].key != p->light.key)
    from--;
  if (from < 0)
    return 0;
  const camera_file *camera = &p->jobs[from].camera;
  p->first = from + 1;
  p->exposure = p->light.exposure;
  if (!p->exact)
    return sequence_give_light(p->sequence, camera, p->environment,
                               p->light.bytes, &p->error);
  exact_sequence_give_light(p->exact, camera, p->light.bytes);
  return 0;
}

int process_is_needed(const process *p, const job *j) {
  const int i = (int)(j - p->jobs);
  return !j->finished || (i >= p->first && i < p->end &&
                          (p->light.size || (p->options->preview && i == 0)));
}

static void expect(process *p) {
  unsigned frames = 0, runs = 0;
  for (int i = p->first; i < p->end; i++)
    if (process_is_needed(p, &p->jobs[i])) {
      frames++;
      runs += p->options->repeat + (i == 0 ? p->options->warm_up : 0);
    }
  exact_sequence_expect(p->exact, frames, runs);
}

int process_resume(process *p) {
  int missing = p->count;
  if (!p->options->dry_run)
    resume_sweep(p->options->output);
  p->end = 0;
  for (int i = 0; i < p->count; i++) {
    if (look_for_result(p, &p->jobs[i]) != 0)
      return -1;
    if (p->jobs[i].finished)
      continue;
    p->end = i + 1;
    missing = i < missing ? i : missing;
  }
  if (give_light(p, missing) != 0)
    return -1;
  if (p->exact)
    expect(p);
  return 0;
}
