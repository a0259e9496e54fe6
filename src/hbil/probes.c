/* Probes: what the radiance cache knows, at places all over the picture. */
#include "passes.h"

#include <math.h>
#include <string.h>

#include "cache.h"
#include "camera.h"
#include "far_field.h"
#include "glossy.h"

/* What all methods need of a frame. */
static hbil_probes_args probes_args(const hbil_plan *plan,
                                    const hbil_frame *frame) {
  const hbil_config *c = &plan->config;
  const hbil_cache *cache = frame->cache;
  float environment[9][3];
  memcpy(environment, frame->environment, sizeof environment);
  remove_exposure(frame->exposure, environment);
  hbil_probes_args args = {
      .grid = plan->layout.probe_grid,
      .view = camera_view(&frame->camera, c),
      .split = plan->layout.split,
      .environment = far_radiance_args(c->model.far_field, environment),
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

/* --- the kernels that fill probes --- */

enum { MOST_READ = 4, MOST_ARGUMENTS = MOST_READ + 4 };

/* A kernel, and the buffers of the cache that it reads. */
typedef struct probe_kernel {
  int kernel, count, read[MOST_READ];
} probe_kernel;

static const probe_kernel methods[] = {
    [HBIL_CACHE_METHOD_RAYS] = {KERNEL_PROBE_RAYS,
                                4,
                                {CACHE_CLEARANCE, CACHE_VOXELS, CACHE_RADIANCE,
                                 CACHE_AREAS}},
    [HBIL_CACHE_METHOD_CONES] = {KERNEL_PROBE_CONES,
                                 4,
                                 {CACHE_CLEARANCE, CACHE_VOXELS, CACHE_RADIANCE,
                                  CACHE_PYRAMID}},
    [HBIL_CACHE_METHOD_LPV] = {KERNEL_PROBE_LPV, 1, {CACHE_VOLUMES}},
    [HBIL_CACHE_METHOD_RSM] = {KERNEL_PROBE_RSM, 1, {CACHE_LIGHT_VIEWS}}};

static const probe_kernel glossy = {
    KERNEL_PROBE_GLOSSY, 3, {CACHE_CLEARANCE, CACHE_VOXELS, CACHE_RADIANCE}};

/* Fills the buffer `probes`.  In trial launches there is no cache. */
static hbil_status fill_probes(const hbil_plan *plan, commands *chain,
                               const hbil_cache *cache,
                               const hbil_probes_args *args,
                               const probe_kernel *kind, int probes) {
  const hbil_light_views_args lights =
      cache ? light_views_args(cache) : (hbil_light_views_args){0};
  cl_mem read[MOST_READ];
  argument list[MOST_ARGUMENTS];
  cl_uint count = 0;
  list[count++] = (argument)ARG(*args);
  list[count++] = (argument)BUFFER_ARG(plan, BUFFER_SPLIT);
  for (int i = 0; i < kind->count; ++i) {
    read[i] = cache ? cache->buffers[kind->read[i]] : NULL;
    list[count++] = (argument)ARG(read[i]);
  }
  list[count++] = (argument)BUFFER_ARG(plan, probes);
  if (kind->kernel == KERNEL_PROBE_RSM)
    list[count++] = (argument)ARG(lights);
  return launch_kernel(chain, kind->kernel, list, count,
                       (size_t)args->grid.columns, (size_t)args->grid.lines, 1);
}

/* Joins the filtered probes with those of the last frame. */
static hbil_status follow_probes(hbil_plan *plan, commands *chain,
                                 const hbil_frame *frame) {
  alternating *past = &plan->probes;
  const hbil_camera *last = past->has ? &past->camera : &frame->camera;
  const hbil_follow_args args = {.grid = plan->layout.probe_grid,
                                 .before = camera_view(last, &plan->config),
                                 .back = camera_between(&frame->camera, last),
                                 .forth = camera_between(last, &frame->camera),
                                 .has_before = past->has};
  const argument list[] = {
      ARG(args), BUFFER_ARG(plan, BUFFER_FILTERED_PROBES),
      BUFFER_ARG(plan, BUFFER_PROBE_HISTORY + past->last),
      BUFFER_ARG(plan, BUFFER_PROBE_HISTORY + !past->last)};
  const hbil_status status =
      LAUNCH(chain, KERNEL_FOLLOW_PROBES, list, (size_t)args.grid.columns,
             (size_t)args.grid.lines, 1);
  past->written = status == HBIL_SUCCESS;
  return status;
}

hbil_status enqueue_probes(hbil_plan *plan, commands *chain,
                           const hbil_frame *frame) {
  plan->probes.written = false; /* by a frame that was broken off */
  if (!plan->layout.probes || !(frame->cache || chain->trial))
    return HBIL_SUCCESS;
  const hbil_probes_args args = probes_args(plan, frame);
  const argument filter[] = {ARG(args), BUFFER_ARG(plan, BUFFER_PROBES),
                             BUFFER_ARG(plan, BUFFER_FILTERED_PROBES)};
  hbil_status status =
      fill_probes(plan, chain, frame->cache, &args,
                  &methods[plan->config.model.cache_method], BUFFER_PROBES);
  if (status == HBIL_SUCCESS && plan->layout.glossy)
    status = fill_probes(plan, chain, frame->cache, &args, &glossy,
                         BUFFER_GLOSSY_PROBES);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_FILTER_PROBES, filter,
                    (size_t)args.grid.columns, (size_t)args.grid.lines, 1);
  return status == HBIL_SUCCESS ? follow_probes(plan, chain, frame) : status;
}
