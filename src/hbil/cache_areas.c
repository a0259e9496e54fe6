/* What surfaces of each area send (lib/local_light.clh), which rays of probes
 * read. */
#include "cache.h"

hbil_status sum_areas(commands *chain, hbil_cache *cache,
                      hbil_cache_round_args since) {
  if (cache->config.method != HBIL_CACHE_METHOD_RAYS)
    return HBIL_SUCCESS;
  const hbil_cache_config *c = &cache->config;
  const hbil_cache_args args = cache_args(cache);
  const cl_mem last_change = cache->buffers[CACHE_LAST_CHANGE];
  const cl_mem areas = cache->buffers[CACHE_AREAS];
  const size_t across = c->voxels / HBIL_AREA_VOXELS;
  const size_t of_levels = across * across * across * c->levels;
  const argument sum[] = {ARG(args),
                          ARG(cache->buffers[CACHE_STATES]),
                          ARG(cache->buffers[CACHE_VOXELS]),
                          ARG(cache->buffers[CACHE_RADIANCE]),
                          ARG(since),
                          ARG(last_change),
                          ARG(areas)};
  const argument join[] = {ARG(args), ARG(since), ARG(last_change), ARG(areas)};
  const hbil_status status = LAUNCH(chain, CACHE_KERNEL_AREA_LIGHT, sum, across,
                                    across, across * c->levels);
  return status == HBIL_SUCCESS
             ? LAUNCH(chain, CACHE_KERNEL_JOIN_AREAS, join,
                      cubes_of_steps(c, HBIL_AREA_VOXELS) - of_levels, 1, 1)
             : status;
}
