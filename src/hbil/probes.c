/* Probes: what the radiance cache knows, at places all over the picture. */
#include "passes.h"

#include <math.h>

#include "cache.h"
#include "camera.h"
#include "far_field.h"

hbil_status enqueue_probes(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  const hbil_config *c = &plan->config;
  hbil_cache *cache = frame->cache;
  const hbil_probe_grid_args *grid = &plan->layout.probe_grid;
  if (!plan->layout.probes || !(cache || chain->trial))
    return HBIL_SUCCESS;
  hbil_probes_args args = {
      .grid = *grid,
      .view = camera_view(&frame->camera, c),
      .split = plan->layout.split,
      .environment = far_radiance_args(c->model.far_field, frame->environment),
      .rays = HBIL_PROBE_RAYS};
  cl_mem states = NULL, ways = NULL, bricks = NULL;
  cl_mem voxels = NULL, radiance = NULL;
  if (cache) {
    double centre[3];
    const double scale = cache_scale(cache);
    cache_centre(cache, centre);
    args.cache = cache_args(cache);
    args.to_cache = camera_to_cache(&frame->camera, centre, scale, 1.0);
    args.to_view = camera_from_cache(&frame->camera, centre, scale, 1.0);
    args.scale = (cl_float)scale;
    /* finite, like all arguments of kernels */
    args.radius = (cl_float)fmin((double)c->model.radius * scale, 1e30);
    states = cache->buffers[CACHE_STATES];
    ways = cache->buffers[CACHE_WAYS];
    bricks = cache->buffers[CACHE_BRICKS];
    voxels = cache->buffers[CACHE_VOXELS];
    radiance = cache->buffers[CACHE_RADIANCE];
  }
  const argument list[] = {ARG(args),     BUFFER_ARG(plan, BUFFER_SPLIT),
                           ARG(states),   ARG(ways),
                           ARG(bricks),   ARG(voxels),
                           ARG(radiance), BUFFER_ARG(plan, BUFFER_PROBES)};
  const argument filter[] = {ARG(args), BUFFER_ARG(plan, BUFFER_PROBES),
                             BUFFER_ARG(plan, BUFFER_FILTERED_PROBES)};
  const hbil_status status =
      LAUNCH(chain, KERNEL_MAKE_PROBES, list, (size_t)grid->columns,
             (size_t)grid->rows, 1);
  return status == HBIL_SUCCESS
             ? LAUNCH(chain, KERNEL_FILTER_PROBES, filter,
                      (size_t)grid->columns, (size_t)grid->rows, 1)
             : status;
}
