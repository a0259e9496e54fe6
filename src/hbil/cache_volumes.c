/* Light propagation volumes: light spreads from cell to cell. */
#include "cache.h"

#include "far_field.h"

/* Nothing of another place may be in them.  Their planes' ends, which nothing
 * writes, are read beside cells and must be numbers. */
hbil_status empty_volumes(commands *chain, hbil_cache *cache) {
  hbil_status status = HBIL_SUCCESS;
  for (int i = CACHE_SOURCES;
       i <= CACHE_VOLUMES_NEXT && cache->buffers[i] && status == HBIL_SUCCESS;
       ++i)
    status = fill_memory(chain, cache->buffers[i], 0, 0, cache->bytes[i]);
  return status;
}

static hbil_status step_once(commands *chain, hbil_cache *cache,
                             const hbil_environment_args *environment) {
  const hbil_cache_args args = cache_args(cache);
  const size_t levels = cache->config.levels, across = cache->config.voxels / 2;
  const size_t width = cache->context->vector_width;
  const cl_mem before = cache->buffers[CACHE_VOLUMES];
  const cl_mem after = cache->buffers[CACHE_VOLUMES_NEXT];
  const argument border[] = {ARG(args), ARG(*environment), ARG(before)};
  const argument step[] = {ARG(args), ARG(cache->buffers[CACHE_SOURCES]),
                           ARG(cache->buffers[CACHE_OPACITIES]), ARG(before),
                           ARG(after)};
  hbil_status status = LAUNCH(chain, CACHE_KERNEL_VOLUME_BORDER, border,
                              across + 2, across + 2, 6 * levels);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, CACHE_KERNEL_PROPAGATE, step,
                    (across + width - 1) / width, across, across * levels);
  /* in a trial, too: nothing is in them yet */
  cache->buffers[CACHE_VOLUMES] = after;
  cache->buffers[CACHE_VOLUMES_NEXT] = before;
  return status;
}

hbil_status spread_light(commands *chain, hbil_cache *cache,
                         const hbil_cache_update *update) {
  const hbil_cache_args args = cache_args(cache);
  const size_t across = cache->config.voxels / 2;
  const hbil_environment_args environment =
      far_radiance_args(update->far_field, update->environment);
  const argument sources[] = {ARG(args),
                              ARG(cache->buffers[CACHE_CLEARANCE]),
                              ARG(cache->buffers[CACHE_VOXELS]),
                              ARG(cache->buffers[CACHE_RADIANCE]),
                              ARG(cache->buffers[CACHE_SOURCES]),
                              ARG(cache->buffers[CACHE_OPACITIES])};
  hbil_status status = LAUNCH(chain, CACHE_KERNEL_VOLUME_SOURCES, sources,
                              across, across, across * cache->config.levels);
  for (cl_uint i = 0; i < update->steps && status == HBIL_SUCCESS; ++i)
    status = step_once(chain, cache, &environment);
  return status;
}
