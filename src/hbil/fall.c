/* Light of the last frame that has fallen since. */
#include "fall.h"

#include "cache.h"
#include "camera.h"

hbil_fall_args fall_args(const hbil_plan *plan, const hbil_frame *frame) {
  const hbil_cache *cache = frame->cache;
  const hbil_plan *last = plan->followed ? plan->followed : plan;
  hbil_fall_args args = {.changed = CL_FALSE};
  double centre[3];
  if (!cache)
    return args;
  cache_centre(cache, centre);
  args.cache = cache_args(cache);
  args.to_cache =
      camera_to_cache(&frame->camera, centre, cache_scale(cache), 1.0);
  /* A resumed job has adopted its light and updated the cache since, like one
   * that was never interrupted.  If it has not, its last update had no new
   * views, so no light has fallen. */
  args.changed =
      (plan->has_history || plan->slices.has) &&
      (plan->adopted ? cache->changes > 0
                     : last->last_cache == cache &&
                           last->last_cache_changes != cache->changes);
  return args;
}

cl_mem fall_ratios(const hbil_frame *frame) {
  return frame->cache ? frame->cache->buffers[CACHE_RATIOS] : NULL;
}
