/* The pyramid, which cones read. */
#include "cache.h"

hbil_status build_pyramid(commands *chain, hbil_cache *cache) {
  if (cache->config.method != HBIL_CACHE_METHOD_CONES)
    return HBIL_SUCCESS;
  const hbil_cache_args args = cache_args(cache);
  const cl_int levels = (cl_int)cache->config.levels;
  size_t across = cache->config.voxels / 2;
  hbil_status status = HBIL_SUCCESS;
  for (cl_int step = 0; step < levels && status == HBIL_SUCCESS; ++step) {
    const argument level[] = {ARG(args),
                              ARG(step),
                              ARG(cache->buffers[CACHE_CLEARANCE]),
                              ARG(cache->buffers[CACHE_VOXELS]),
                              ARG(cache->buffers[CACHE_RADIANCE]),
                              ARG(cache->buffers[CACHE_PYRAMID])};
    status =
        LAUNCH(chain, CACHE_KERNEL_LEVEL_STEP, level, across, across, across);
  }
  for (cl_int step = levels; across > 1 && status == HBIL_SUCCESS; ++step) {
    const argument next[] = {ARG(args), ARG(step),
                             ARG(cache->buffers[CACHE_PYRAMID])};
    across /= 2;
    status =
        LAUNCH(chain, CACHE_KERNEL_NEXT_STEP, next, across, across, across);
  }
  return status;
}
