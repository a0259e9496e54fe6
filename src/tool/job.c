/* What can be told from a job alone. */
#include "tool/job.h"

#include "tool/paths.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

void job_free(job *j) {
  for (int i = 0; j->frames && i < j->count; i++) {
    free(j->frames[i].stem);
    channel_map_free(&j->frames[i].map);
  }
  held_planes_free(&j->held);
  for (int i = 0; j->views && i < j->view_count; i++)
    channel_map_free(&j->views[i].map);
  for (int i = 0; j->lights && i < j->light_count; i++)
    channel_map_free(&j->lights[i].map);
  free(j->lights);
  if (j->decider)
    channel_map_free(&j->decider->map);
  free(j->decider);
  j->decider = NULL;
  free(j->views);
  free(j->frames);
  j->lights = j->views = j->frames = NULL;
}

char *job_result_path(const job_frame *f) {
  return path_join(f->stem, "", ".exr");
}

char *job_preview_path(const job_frame *f, layer l) {
  char *stem = path_join(f->stem, ".", layer_table[l].name);
  char *path = stem ? path_join(stem, "", ".png") : NULL;
  free(stem);
  return path;
}

/* Longer names would lead beyond the 255 bytes of most file systems, and a
 * number stands for them. */
enum { LONGEST_NAME = 200 };

char *job_history_path(const job *j, int index) {
  const char *name = strrchr(j->frames[index].stem, '/') + 1;
  char number[17];
  if (strlen(name) > LONGEST_NAME) {
    snprintf(number, sizeof number, "%016llx",
             (unsigned long long)XXH3_64bits(name, strlen(name)));
    name = number;
  }
  return path_join(j->settings->output, "/.hbil-light.", name);
}

existing_file job_existing(const job *j) {
  return j->settings->overwrite || j->settings->resume ? EXISTING_REPLACED
                                                       : EXISTING_STAYS;
}

job_frame *job_first(const job *j) {
  return j->decider ? j->decider : j->frames;
}

int job_is_pre_roll(const job *j, int index) {
  return index < (int)j->settings->pre_roll;
}

unsigned job_runs(const job *j, int index) {
  return j->settings->repeat + (index == 0 ? j->settings->warm_up : 0);
}
