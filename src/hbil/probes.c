/* Probes: what the radiance cache knows, at places all over the picture. */
#include "passes.h"

#include <math.h>

#include "cache.h"
#include "camera.h"
#include "far_field.h"
#include "glossy.h"

/* A buffer of the cache; in trial launches there is none. */
static cl_mem of_cache(const hbil_cache *cache, int buffer) {
  return cache ? cache->buffers[buffer] : NULL;
}

/* What all methods need of a frame. */
static hbil_probes_args probes_args(const hbil_plan *plan,
                                    const hbil_frame *frame) {
  const hbil_config *c = &plan->config;
  const hbil_cache *cache = frame->cache;
  hbil_probes_args args = {
      .grid = plan->layout.probe_grid,
      .view = camera_view(&frame->camera, c),
      .split = plan->layout.split,
      .environment = far_radiance_args(c->model.far_field, frame->environment),
      .lobe = glossy_lobe(c)};
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
  }
  return args;
}

/* --- methods --- */

typedef hbil_status method(const hbil_plan *plan, commands *chain,
                           const hbil_cache *cache,
                           const hbil_probes_args *args);

/* Launches a method's kernel for all probes. */
#define LAUNCH_PROBES(chain, kernel, list, args)                               \
  LAUNCH(chain, kernel, list, (size_t)(args)->grid.columns,                    \
         (size_t)(args)->grid.rows, 1)

/* Launches a kernel of rays.  probes: the buffer that it fills. */
static hbil_status cast_rays(const hbil_plan *plan, commands *chain,
                             const hbil_cache *cache,
                             const hbil_probes_args *args, int kernel,
                             int probes) {
  const cl_mem clearance = of_cache(cache, CACHE_CLEARANCE);
  const cl_mem voxels = of_cache(cache, CACHE_VOXELS);
  const cl_mem radiance = of_cache(cache, CACHE_RADIANCE);
  const argument list[] = {ARG(*args),     BUFFER_ARG(plan, BUFFER_SPLIT),
                           ARG(clearance), ARG(voxels),
                           ARG(radiance),  BUFFER_ARG(plan, probes)};
  return LAUNCH_PROBES(chain, kernel, list, args);
}

static hbil_status probe_by_rays(const hbil_plan *plan, commands *chain,
                                 const hbil_cache *cache,
                                 const hbil_probes_args *args) {
  return cast_rays(plan, chain, cache, args, KERNEL_PROBE_RAYS, BUFFER_PROBES);
}

static hbil_status probe_by_cones(const hbil_plan *plan, commands *chain,
                                  const hbil_cache *cache,
                                  const hbil_probes_args *args) {
  const cl_mem clearance = of_cache(cache, CACHE_CLEARANCE);
  const cl_mem voxels = of_cache(cache, CACHE_VOXELS);
  const cl_mem radiance = of_cache(cache, CACHE_RADIANCE);
  const cl_mem pyramid = of_cache(cache, CACHE_PYRAMID);
  const argument list[] = {ARG(*args),
                           BUFFER_ARG(plan, BUFFER_SPLIT),
                           ARG(clearance),
                           ARG(voxels),
                           ARG(radiance),
                           ARG(pyramid),
                           BUFFER_ARG(plan, BUFFER_PROBES)};
  return LAUNCH_PROBES(chain, KERNEL_PROBE_CONES, list, args);
}

static hbil_status probe_by_lpv(const hbil_plan *plan, commands *chain,
                                const hbil_cache *cache,
                                const hbil_probes_args *args) {
  const cl_mem volumes = of_cache(cache, CACHE_VOLUMES);
  const argument list[] = {ARG(*args), BUFFER_ARG(plan, BUFFER_SPLIT),
                           ARG(volumes), BUFFER_ARG(plan, BUFFER_PROBES)};
  return LAUNCH_PROBES(chain, KERNEL_PROBE_LPV, list, args);
}

static hbil_status probe_by_rsm(const hbil_plan *plan, commands *chain,
                                const hbil_cache *cache,
                                const hbil_probes_args *args) {
  const hbil_light_views_args lights =
      cache ? light_views_args(cache) : (hbil_light_views_args){0};
  const cl_mem texels = of_cache(cache, CACHE_LIGHT_VIEWS);
  const argument list[] = {ARG(*args), BUFFER_ARG(plan, BUFFER_SPLIT),
                           ARG(lights), ARG(texels),
                           BUFFER_ARG(plan, BUFFER_PROBES)};
  return LAUNCH_PROBES(chain, KERNEL_PROBE_RSM, list, args);
}

static method *const methods[] = {[HBIL_CACHE_METHOD_RAYS] = probe_by_rays,
                                  [HBIL_CACHE_METHOD_CONES] = probe_by_cones,
                                  [HBIL_CACHE_METHOD_LPV] = probe_by_lpv,
                                  [HBIL_CACHE_METHOD_RSM] = probe_by_rsm};

hbil_status enqueue_probes(hbil_plan *plan, commands *chain,
                           const hbil_frame *frame) {
  if (!plan->layout.probes || !(frame->cache || chain->trial))
    return HBIL_SUCCESS;
  const hbil_probes_args args = probes_args(plan, frame);
  const argument filter[] = {ARG(args), BUFFER_ARG(plan, BUFFER_PROBES),
                             BUFFER_ARG(plan, BUFFER_FILTERED_PROBES)};
  hbil_status status = methods[plan->config.model.cache_method](
      plan, chain, frame->cache, &args);
  if (status == HBIL_SUCCESS && plan->layout.glossy)
    status = cast_rays(plan, chain, frame->cache, &args, KERNEL_PROBE_GLOSSY,
                       BUFFER_GLOSSY_PROBES);
  return status == HBIL_SUCCESS
             ? LAUNCH_PROBES(chain, KERNEL_FILTER_PROBES, filter, &args)
             : status;
}
