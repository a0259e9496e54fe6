/* How large a job's cache is, and where it lies. */
#include "tool/job_cache.h"

#include "image/error.h"
#include "tool/extent.h"

#include <stdlib.h>
#include <string.h>

static void choose_by_file(job *j) {
  j->cache.voxels = j->loaded.voxels;
  j->cache.levels = j->loaded.levels;
  j->cache.voxel_size = j->loaded.voxel_size;
  memcpy(j->cache.centre, j->loaded.centre, sizeof j->cache.centre);
}

static int choose_by_pictures(job *j, image_error *error) {
  const size_t count = (size_t)j->count, views = (size_t)j->view_count;
  extent_picture *all = calloc(count + views, sizeof *all);
  if (!all)
    return image_no_memory(error, j->frames[0].path);
  for (size_t i = 0; i < count + views; i++) {
    const job_frame *f = i < count ? &j->frames[i] : &j->views[i - count];
    all[i] = (extent_picture){f->path, &f->map};
  }
  const int failed =
      extent_choose(all, count, all + count, views, &j->cache, error);
  free(all);
  return failed;
}

int job_cache_choose(job *j, image_error *error) {
  const process_settings *s = j->settings;
  if (!j->has_cache)
    return 0;
  hbil_cache_config_init(&j->cache);
  if (s->cache_voxels)
    j->cache.voxels = s->cache_voxels;
  if (s->cache_load)
    choose_by_file(j);
  else if (choose_by_pictures(j, error) != 0)
    return -1;
  if (!s->radius_given)
    j->config.model.radius =
        (float)(HBIL_CACHE_NEAR_VOXELS * j->cache.voxel_size);
  return 0;
}
