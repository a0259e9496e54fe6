/* A radiance cache: what it takes, and where it is. */
#include "cache.h"

#include <math.h>
#include <string.h>

#include "buffers.h"
#include "checks.h"

/* --- memory --- */

size_t cache_voxel_count(const hbil_cache_config *config) {
  const size_t n = config->voxels;
  return n * n * n * config->levels;
}

size_t cubes_of_steps(const hbil_cache_config *config, size_t across) {
  size_t count = config->voxels / across;
  size_t sum = (config->levels - 1) * count * count * count;
  for (; count > 0; count /= 2)
    sum += count * count * count;
  return sum;
}

/* Of all levels' volumes of so many planes, with room for a vector behind. */
static size_t volume_bytes(const hbil_cache_config *config, size_t planes) {
  const size_t across = config->voxels / 2 + 2;
  return config->method == HBIL_CACHE_METHOD_LPV
             ? sizeof(cl_float) *
                   (planes * across * across * across * config->levels +
                    HBIL_WIDEST)
             : 0;
}

hbil_status cache_sizes(hbil_context *context, const hbil_cache_config *c,
                        size_t bytes[CACHE_BUFFER_COUNT]) {
  const size_t voxels = cache_voxel_count(c);
#define SIZE(id, size) [id] = (size),
  const size_t sizes[] = {CACHE_BUFFERS(SIZE)};
#undef SIZE
  buffer_limits limits;
  const hbil_status status = memory_limits(context, &limits);
  if (status != HBIL_SUCCESS)
    return status;
  for (int i = 0; i < CACHE_BUFFER_COUNT; ++i)
    if (sizes[i] > limits.largest)
      return fail(context, HBIL_OUT_OF_DEVICE_MEMORY,
                  "voxels, levels: %u, %u need a buffer of %zu bytes, the "
                  "device allows %zu",
                  (unsigned)c->voxels, (unsigned)c->levels, sizes[i],
                  limits.largest);
  memcpy(bytes, sizes, sizeof sizes);
  return HBIL_SUCCESS;
}

hbil_status hbil_cache_memory(hbil_context *context,
                              const hbil_cache_config *config, size_t *bytes) {
  hbil_cache_config own;
  hbil_config views;
  size_t sizes[CACHE_BUFFER_COUNT];
  if (!context || !config || !bytes)
    return fail_null(context, __func__,
                     !context  ? "context"
                     : !config ? "config"
                               : "bytes");
  hbil_status status = cache_config_take(context, config, &own, &views);
  if (status == HBIL_SUCCESS)
    status = cache_sizes(context, &own, sizes);
  if (status != HBIL_SUCCESS)
    return status;
  *bytes = 0;
  for (int i = 0; i < CACHE_BUFFER_COUNT; ++i)
    *bytes += sizes[i];
  return HBIL_SUCCESS;
}

/* --- where it is --- */

/* World units across a voxel of the coarsest level. */
static double coarsest(const hbil_cache_config *config) {
  return ldexp(config->voxel_size, (int)config->levels - 1);
}

void cache_middle(const hbil_cache_config *config, const double centre[3],
                  cl_long middle[3]) {
  for (int i = 0; i < 3; ++i)
    middle[i] = llrint(centre[i] / coarsest(config));
}

void cache_centre(const hbil_cache *cache, double centre[3]) {
  for (int i = 0; i < 3; ++i)
    centre[i] = (double)cache->middle[i] * coarsest(&cache->config);
}

double cache_scale(const hbil_cache *cache) {
  return 1.0 / cache->config.voxel_size;
}

hbil_cache_args cache_args(const hbil_cache *cache) {
  const cl_long n = cache->config.voxels;
  hbil_cache_args args = {.voxels = (cl_int)n,
                          .levels = (cl_int)cache->config.levels};
  while (1 << args.log2_voxels < args.voxels)
    ++args.log2_voxels;
  /* cell 0 begins at the centre; in memory it is at the middle's number */
  for (int i = 0; i < 3; ++i)
    args.shift[i] = (cl_int)((cache->middle[i] % n + n) % n);
  return args;
}

/* --- commands --- */

commands commands_of_cache(hbil_cache *cache, cl_command_queue queue) {
  return (commands){.context = cache->context,
                    .kernels = &cache->kernels,
                    .line = {&cache->line, NULL},
                    .queue = queue};
}

hbil_status begin_cache_commands(const char *function, hbil_cache *cache,
                                 cl_command_queue queue, cl_uint wait_count,
                                 const cl_event *wait_list, bool with_event,
                                 commands *chain) {
  if (!cache || !queue)
    return fail_null(cache ? cache->context : NULL, function,
                     cache ? "queue" : "cache");
  *chain = commands_of_cache(cache, queue);
  hbil_status status =
      check_wait_list(cache->context, function, wait_count, wait_list);
  if (status == HBIL_SUCCESS)
    status = check_queue(cache->context, queue, false, &chain->in_order);
  if (status != HBIL_SUCCESS)
    return status;
  chain->events = with_event || !chain->in_order;
  status = begin_commands(chain, wait_count, wait_list);
  if (status != HBIL_SUCCESS)
    end_commands(chain);
  return status;
}
