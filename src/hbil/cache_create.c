/* Creates and destroys radiance caches: their kernels and buffers. */
#include "cache.h"

#include <stdlib.h>

#include "cache_config.h"
#include "kernel_table.h"
#include "memory.h"

/* --- programs and kernels --- */

/* Views are read pixel by pixel, because these may be far apart, and moves
 * are rare. */
static const program_kind programs[CACHE_PROGRAM_COUNT] = {
    [CACHE_PROGRAM_VIEW] = {"cache/view",
                            .defines = "-DORTHOGRAPHIC=0 -DHBIL_WIDTH=1"},
    [CACHE_PROGRAM_VIEW_FLAT] = {"cache/view",
                                 .defines = "-DORTHOGRAPHIC=1 -DHBIL_WIDTH=1"},
    [CACHE_PROGRAM_INJECT] = {"cache/inject", .defines = "-DORTHOGRAPHIC=0"},
    [CACHE_PROGRAM_INJECT_FLAT] = {"cache/inject",
                                   .defines = "-DORTHOGRAPHIC=1"},
    [CACHE_PROGRAM_CLEARANCE] = {"cache/clearance",
                                 .defines = "-DHBIL_WIDTH=1"},
    [CACHE_PROGRAM_RAY_HITS] = {"cache/ray_hits", .defines = ""},
    [CACHE_PROGRAM_BOUNCE] = {"cache/bounce", .relaxed = true, .defines = ""},
    [CACHE_PROGRAM_MOVE] = {"cache/move", .defines = "-DHBIL_WIDTH=1"},
    [CACHE_PROGRAM_PYRAMID] = {"cache/pyramid", .defines = "-DHBIL_WIDTH=1"},
    [CACHE_PROGRAM_VOLUMES] = {"cache/volumes", .defines = "-DHBIL_WIDTH=1"},
    [CACHE_PROGRAM_PROPAGATE] = {"cache/propagate", .defines = ""},
};

static const kernel_kind kernels[CACHE_KERNEL_COUNT] = {
    [CACHE_KERNEL_READ_VIEW] = {"read_view", CACHE_PROGRAM_VIEW},
    [CACHE_KERNEL_READ_VIEW_FLAT] = {"read_view", CACHE_PROGRAM_VIEW_FLAT},
    [CACHE_KERNEL_INJECT] = {"inject", CACHE_PROGRAM_INJECT},
    [CACHE_KERNEL_INJECT_FLAT] = {"inject", CACHE_PROGRAM_INJECT_FLAT},
    [CACHE_KERNEL_RESOLVE_STATES] = {"resolve_states", CACHE_PROGRAM_CLEARANCE},
    [CACHE_KERNEL_CLEARANCE_ALONG_X] = {"clearance_along_x",
                                        CACHE_PROGRAM_CLEARANCE},
    [CACHE_KERNEL_CLEARANCE_ALONG] = {"clearance_along",
                                      CACHE_PROGRAM_CLEARANCE},
    [CACHE_KERNEL_LIST_PARTS] = {"list_parts", CACHE_PROGRAM_RAY_HITS},
    [CACHE_KERNEL_LIST_SURFACES] = {"list_surfaces", CACHE_PROGRAM_RAY_HITS},
    [CACHE_KERNEL_TRACE_RAYS] = {"trace_rays", CACHE_PROGRAM_RAY_HITS},
    [CACHE_KERNEL_MEAN_PART] = {"mean_part", CACHE_PROGRAM_BOUNCE},
    [CACHE_KERNEL_MEAN_SUM] = {"mean_sum", CACHE_PROGRAM_BOUNCE},
    [CACHE_KERNEL_BOUNCE] = {"bounce", CACHE_PROGRAM_BOUNCE},
    [CACHE_KERNEL_UPDATE_RADIANCE] = {"update_radiance", CACHE_PROGRAM_BOUNCE},
    [CACHE_KERNEL_FORGET] = {"forget", CACHE_PROGRAM_MOVE},
    [CACHE_KERNEL_LEVEL_STEP] = {"level_step", CACHE_PROGRAM_PYRAMID},
    [CACHE_KERNEL_NEXT_STEP] = {"next_step", CACHE_PROGRAM_PYRAMID},
    [CACHE_KERNEL_VOLUME_SOURCES] = {"volume_sources", CACHE_PROGRAM_VOLUMES},
    [CACHE_KERNEL_VOLUME_BORDER] = {"volume_border", CACHE_PROGRAM_PROPAGATE},
    [CACHE_KERNEL_PROPAGATE] = {"propagate", CACHE_PROGRAM_PROPAGATE},
};

static const kernel_table table = {programs, kernels, CACHE_PROGRAM_COUNT,
                                   CACHE_KERNEL_COUNT};

/* Some kernels are for one provider only. */
static bool kernel_needed(const hbil_cache *cache, int kernel) {
  switch (kernels[kernel].program) {
  case CACHE_PROGRAM_PYRAMID:
    return cache_has(&cache->config, HBIL_PROVIDER_CONES);
  case CACHE_PROGRAM_VOLUMES:
  case CACHE_PROGRAM_PROPAGATE:
    return cache_has(&cache->config, HBIL_PROVIDER_LPV);
  }
  return true;
}

static hbil_status build_kernels(hbil_cache *cache,
                                 binary_identity identity[]) {
  const hbil_plan *like = &cache->views;
  bool needed[CACHE_KERNEL_COUNT];
  for (int i = 0; i < CACHE_KERNEL_COUNT; ++i)
    needed[i] = kernel_needed(cache, i);
  return kernels_build(cache->context, &table, needed, &like->config,
                       &like->layout, cache->programs, cache->kernels,
                       identity);
}

/* --- buffers --- */

static hbil_status allocate_buffers(hbil_cache *cache) {
  for (int i = 0; i < CACHE_BUFFER_COUNT; ++i) {
    cl_int error = CL_SUCCESS;
    const size_t bytes = cache_buffer_bytes(&cache->config, i);
    if (!bytes)
      continue;
    cache->buffers[i] = memory_create(cache->context, bytes, &error);
    if (!cache->buffers[i])
      return fail_cl(cache->context, error, "clCreateBuffer");
  }
  return HBIL_SUCCESS;
}

/* --- the first commands --- */

/* Launches every kernel once, without any work. */
static hbil_status try_kernels(hbil_cache *cache, cl_command_queue queue) {
  trial_launches trial = {.launched = {{false}}};
  commands chain = commands_of_cache(cache, queue);
  const cl_long moved[3] = {0, 0, 0};
  hbil_cache_update update;
  hbil_view view;
  chain.in_order = true;
  chain.trial = &trial;
  hbil_cache_update_init(&update);
  hbil_view_init(&view);
  view.width = view.height = 1;
  view.camera.fx = view.camera.fy = 1.0;
  for (int i = 0; i < 4; ++i)
    view.camera.world_from_view[5 * i] = 1.0;
  hbil_status status = inject_view(&chain, cache, &view);
  view.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
  if (status == HBIL_SUCCESS)
    status = inject_view(&chain, cache, &view);
  if (status == HBIL_SUCCESS)
    status = update_cache(&chain, cache, &update);
  if (status == HBIL_SUCCESS)
    status = forget_outside(&chain, cache, moved);
  cache->updates = 0;
  return status;
}

/* Forgets everything. */
static hbil_status prepare(void *object, cl_command_queue queue) {
  hbil_cache *cache = object;
  commands chain = commands_of_cache(cache, queue);
  chain.in_order = true;
  const hbil_status status = forget_all(&chain, cache);
  return status == HBIL_SUCCESS ? try_kernels(cache, queue) : status;
}

/* --- public --- */

hbil_status hbil_cache_create(hbil_context *context,
                              const hbil_cache_config *config,
                              hbil_cache **out) {
  hbil_cache_config own;
  hbil_config views;
  binary_identity identity[CACHE_PROGRAM_COUNT];
  if (out)
    *out = NULL;
  if (!context || !config || !out)
    return fail_null(context, __func__,
                     !context  ? "context"
                     : !config ? "config"
                               : "out");
  hbil_status status = cache_config_take(context, config, &own, &views);
  if (status == HBIL_SUCCESS)
    status = cache_check_memory(context, &own);
  if (status != HBIL_SUCCESS)
    return status;
  hbil_cache *cache = calloc(1, sizeof *cache);
  if (!cache)
    return fail(context, HBIL_OUT_OF_HOST_MEMORY, "no memory for a cache");
  cache->context = context;
  context_retain(context);
  cache->config = own;
  cache->views.context = context;
  cache->views.config = views;
  cache->views.config.execution.vector_width = context->vector_width;
  cache->views.layout.span = HBIL_SPAN;
  cache->views.layout.line = HBIL_WIDEST;
  cache_middle(&own, own.centre, cache->middle);
  if ((status = build_kernels(cache, identity)) != HBIL_SUCCESS ||
      (status = allocate_buffers(cache)) != HBIL_SUCCESS ||
      (status = run_first_commands(context, prepare, cache)) != HBIL_SUCCESS) {
    hbil_cache_destroy(cache);
    return status;
  }
  kernels_store(context, &table, cache->programs, identity);
  *out = cache;
  return HBIL_SUCCESS;
}

void hbil_cache_destroy(hbil_cache *cache) {
  if (!cache)
    return;
  timeline_end(&cache->line);
  kernels_release(&table, cache->programs, cache->kernels);
  for (int i = 0; i < CACHE_BUFFER_COUNT; ++i)
    if (cache->buffers[i])
      clReleaseMemObject(cache->buffers[i]);
  context_release(cache->context);
  free(cache);
}
