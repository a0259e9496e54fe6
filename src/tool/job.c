/* What can be told from a job alone. */
#include "tool/job.h"

#include "tool/paths.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

static void free_frames(job_frame *list, int count) {
  for (int i = 0; list && i < count; i++) {
    free(list[i].camera_path);
    free(list[i].stem);
    channel_map_free(&list[i].map);
  }
  free(list);
}

void job_free(job *j) {
  free_frames(j->frames, j->count);
  free_frames(j->views, j->view_count);
  free_frames(j->lights, j->light_count);
  free_frames(j->decider, 1);
  held_planes_free(&j->held);
  free(j->places);
  j->places = NULL;
  j->lights = j->views = j->frames = j->decider = NULL;
}

job job_of_place(const job *whole, int place) {
  const job_place *p = &whole->places[place];
  const int pre_roll = (int)whole->pre_roll - p->first;
  job out = *whole;
  out.frames += p->first;
  out.count = p->count;
  out.before = p->first;
  out.pre_roll = (unsigned)(pre_roll < 0          ? 0
                            : pre_roll < p->count ? pre_roll
                                                  : p->count);
  if (place > 0) /* those are of the first frame of all */
    memset(&out.held, 0, sizeof out.held);
  return out;
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
  return index < (int)j->pre_roll;
}

unsigned job_runs(const job *j, int index) {
  return j->settings->repeat + (index == 0 ? j->settings->warm_up : 0);
}

unsigned job_lit_layers(const job *j) {
  const unsigned of_frame = 1u << LAYER_BEAUTY | 1u << LAYER_ALPHA;
  return (j->layers & ~(j->replaces ? of_frame : 0u)) | j->hidden;
}

unsigned job_halves(const job *j) {
  const process_settings *s = j->settings;
  int floats = !j->half || s->exact || s->preview || s->contact_sheet != NULL ||
               j->shown.width != j->width || j->shown.height != j->height;
  const unsigned of_picture =
      1u << LAYER_INDIRECT | 1u << LAYER_BEAUTY | 1u << LAYER_ALPHA;
  for (int i = 0; i < j->count && !floats; i++)
    floats = j->frames[i].map.exposure > 0.0;
  return floats ? 0u
                : j->layers &
                      ~(1u << LAYER_UNKNOWN | (j->replaces ? of_picture : 0u));
}
