/* Several files as the frames of one job. */
#include "tool/info_sequence.h"

#include "dump/frame_camera.h"
#include "tool/report.h"

#include <math.h>
#include <stdio.h>

/* The radiance cache for all frames. */
static int print_cache(const usable *all, image_error *error) {
  hbil_cache_config cache;
  hbil_cache_config_init(&cache);
  if (!all->count)
    return 0;
  if (extent_choose(all->pictures, all->count, NULL, 0, &cache, error) != 0)
    return -1;
  const double coarsest = ldexp(cache.voxel_size, (int)cache.levels - 1);
  printf("radiance cache: %g units wide about %g %g %g, %u x %u x %u voxels of "
         "%.3g units and up (hbil process --cache-size)\n",
         cache.voxels * coarsest, cache.centre[0], cache.centre[1],
         cache.centre[2], (unsigned)cache.voxels, (unsigned)cache.voxels,
         (unsigned)cache.voxels, cache.voxel_size);
  return 0;
}

/* Whether one job can have all of the files as its frames. */
static int check_sequence(const usable *all, image_error *error) {
  const extent_picture *first = &all->pictures[0];
  camera_file camera = {.orthographic = first->map->projection ==
                                        HBIL_PROJECTION_ORTHOGRAPHIC};
  for (size_t i = 1; i < all->count; i++) {
    const extent_picture *p = &all->pictures[i];
    camera_file own = {.orthographic =
                           p->map->projection == HBIL_PROJECTION_ORTHOGRAPHIC};
    if (channel_map_follows(p->map, p->path, first->map, first->path, error) !=
            0 ||
        frame_camera_same_projection(p->path, &own, first->path, &camera,
                                     error) != 0)
      return -1;
  }
  return 0;
}

static void print_sequence(const usable *all) {
  printf("sequence: %zu frames, ", all->count);
  report_text(all->pictures[0].path, stdout);
  fputs(" to ", stdout);
  report_text(all->pictures[all->count - 1].path, stdout);
  puts(", with the first one's channels, size and kind of camera");
}

int info_sequence_print(const usable *all, int told, image_error *error) {
  if (check_sequence(all, error) != 0)
    return -1;
  if (told)
    print_sequence(all);
  return print_cache(all, error);
}
