/* Creates and destroys radiance caches: their kernels and buffers. */
#include "cache.h"

#include <stdlib.h>
#include <string.h>

#include "buffers.h"
#include "defines.h"

/* --- programs and kernels --- */

static const program_kind programs[] = {CACHE_PROGRAMS(LISTED_PROGRAM)};
static const kernel_kind kernels[] = {CACHE_KERNELS(LISTED_KERNEL)};
static const kernel_table table = {programs, kernels, CACHE_PROGRAM_COUNT,
                                   CACHE_KERNEL_COUNT};

static hbil_status build_kernels(hbil_cache *cache) {
  const hbil_cache_config *c = &cache->config;
  const bool needed_programs[] = {CACHE_PROGRAMS(PROGRAM_NEEDED)};
  const bool needed_kernels[] = {CACHE_KERNELS(KERNEL_NEEDED)};
  char defines[MOST_DEFINES];
  const hbil_status status = write_view_defines(cache->context, &cache->views,
                                                defines, sizeof defines);
  return status == HBIL_SUCCESS
             ? kernels_build(cache->context, &table, needed_programs,
                             needed_kernels, defines, &cache->kernels)
             : status;
}

static hbil_status allocate(hbil_cache *cache) {
  hbil_status status = HBIL_SUCCESS;
  for (int i = 0; i < CACHE_BUFFER_COUNT && status == HBIL_SUCCESS; ++i)
    if (cache->bytes[i])
      status =
          buffer_create(cache->context, cache->bytes[i], &cache->buffers[i]);
  return status;
}

/* --- the first commands --- */

/* Launches every kernel once, without any work. */
static hbil_status try_kernels(hbil_cache *cache, cl_command_queue queue) {
  trial_launches trial = {.launched = {false}};
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
  cache->updates = cache->changes = 0;
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
  size_t bytes[CACHE_BUFFER_COUNT];
  if (out)
    *out = NULL;
  if (!context || !config || !out)
    return fail_null(context, __func__,
                     !context  ? "context"
                     : !config ? "config"
                               : "out");
  hbil_status status = cache_config_take(context, config, &own, &views);
  if (status == HBIL_SUCCESS)
    status = cache_sizes(context, &own, bytes);
  if (status != HBIL_SUCCESS)
    return status;
  hbil_cache *cache = calloc(1, sizeof *cache);
  if (!cache)
    return fail(context, HBIL_OUT_OF_HOST_MEMORY, "no memory for a cache");
  cache->context = context;
  context_retain(context);
  cache->config = own;
  cache->views = views;
  cache->views.execution.vector_width = context->vector_width;
  memcpy(cache->bytes, bytes, sizeof bytes);
  cache_middle(&own, own.centre, cache->middle);
  if ((status = build_kernels(cache)) != HBIL_SUCCESS ||
      (status = allocate(cache)) != HBIL_SUCCESS ||
      (status = run_first_commands(context, prepare, cache)) != HBIL_SUCCESS) {
    hbil_cache_destroy(cache);
    return status;
  }
  kernels_share(context, &cache->kernels);
  *out = cache;
  return HBIL_SUCCESS;
}

void hbil_cache_destroy(hbil_cache *cache) {
  if (!cache)
    return;
  timeline_end(&cache->line);
  kernels_release(&cache->kernels);
  buffers_release(cache->buffers, CACHE_BUFFER_COUNT);
  context_release(cache->context);
  free(cache);
}
