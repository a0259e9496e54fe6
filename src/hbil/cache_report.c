/* Reads back what a cache knows, as counts or whole. */
#include "cache.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "voxel_repair.h"

/* --- counts --- */

hbil_status hbil_cache_statistics(hbil_cache *cache, cl_command_queue queue,
                                  hbil_cache_counts *out) {
  commands chain;
  if (cache && !out)
    return fail_null(cache->context, __func__, "out");
  hbil_status status =
      begin_cache_commands(__func__, cache, queue, 0, NULL, false, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  const size_t bytes = cache->bytes[CACHE_STATES];
  unsigned char *states = malloc(bytes);
  status =
      states ? read_memory(&chain, cache->buffers[CACHE_STATES], bytes, states)
             : fail(cache->context, HBIL_OUT_OF_HOST_MEMORY,
                    "no memory to count in");
  if (status == HBIL_SUCCESS) {
    size_t counts[4] = {0, 0, 0, 0};
    for (size_t i = 0; i < 4 * bytes; ++i)
      counts[states[i / 4] >> 2 * (i % 4) & 3]++;
    out->unseen = counts[HBIL_VOXEL_UNKNOWN];
    out->empty = counts[HBIL_VOXEL_EMPTY] + counts[HBIL_VOXEL_SKY];
    out->surfaces = counts[HBIL_VOXEL_SURFACE];
  }
  free(states);
  end_commands(&chain);
  return status;
}

/* --- all of it --- */

/* What bounces have made, and what views have shown, in the order that
 * hbil_cache_saved_head states.  Everything else follows from these. */
static const int saved[] = {CACHE_STATES, CACHE_UNLIT, CACHE_VOXELS};
enum { SAVED = sizeof saved / sizeof *saved };

/* FNV-1a, eight bytes at a time. */
static cl_ulong hash_of(const unsigned char *bytes, size_t size,
                        cl_ulong hash) {
  cl_ulong word;
  for (; size >= sizeof word; bytes += sizeof word, size -= sizeof word) {
    memcpy(&word, bytes, sizeof word);
    hash = (hash ^ word) * 0x100000001b3u;
    hash ^= hash >> 29;
  }
  for (; size > 0; ++bytes, --size)
    hash = (hash ^ *bytes) * 0x100000001b3u;
  return hash;
}

static cl_ulong hash_of_saved(const unsigned char *bytes, size_t size) {
  hbil_cache_saved_head head;
  memcpy(&head, bytes, sizeof head);
  head.hash = 0;
  const cl_ulong start =
      hash_of((const unsigned char *)&head, sizeof head, 0xcbf29ce484222325u);
  return hash_of(bytes + sizeof head, size - sizeof head, start);
}

static hbil_cache_saved_head head_of(const hbil_cache *cache) {
  hbil_cache_saved_head head;
  memset(&head, 0, sizeof head);
  snprintf(head.magic, sizeof head.magic, "hbil %s", hbil_version());
  head.voxels = cache->config.voxels;
  head.levels = cache->config.levels;
  head.updates = cache->updates;
  head.voxel_size = cache->config.voxel_size;
  memcpy(head.middle, cache->middle, sizeof head.middle);
  return head;
}

size_t hbil_cache_size(const hbil_cache *cache) {
  size_t size = sizeof(hbil_cache_saved_head);
  for (int i = 0; cache && i < SAVED; ++i)
    size += cache->bytes[saved[i]];
  return cache ? size : 0;
}

/* Begins to save or load, for the public `function`. */
static hbil_status begin(const char *function, hbil_cache *cache,
                         cl_command_queue queue, const void *bytes, size_t size,
                         commands *chain) {
  if (cache && !bytes)
    return fail_null(cache->context, function, "bytes");
  if (cache && size != hbil_cache_size(cache))
    return fail(cache->context, HBIL_INVALID_ARGUMENT,
                "size: %zu bytes; this cache has %zu (hbil_cache_size())", size,
                hbil_cache_size(cache));
  return begin_cache_commands(function, cache, queue, 0, NULL, false, chain);
}

hbil_status hbil_cache_save(hbil_cache *cache, cl_command_queue queue,
                            void *bytes, size_t size) {
  commands chain;
  unsigned char *at = bytes;
  hbil_status status = begin(__func__, cache, queue, bytes, size, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  hbil_cache_saved_head head = head_of(cache);
  size_t offset = sizeof head;
  for (int i = 0; i < SAVED && status == HBIL_SUCCESS; ++i) {
    const size_t part = cache->bytes[saved[i]];
    status = read_memory(&chain, cache->buffers[saved[i]], part, at + offset);
    offset += part;
  }
  end_commands(&chain);
  if (status != HBIL_SUCCESS)
    return status;
  memcpy(at, &head, sizeof head);
  head.hash = hash_of_saved(at, size);
  memcpy(at, &head, sizeof head);
  return HBIL_SUCCESS;
}

static hbil_status check_saved(hbil_cache *cache, const unsigned char *bytes,
                               size_t size) {
  const hbil_cache_saved_head own = head_of(cache);
  hbil_cache_saved_head head;
  memcpy(&head, bytes, sizeof head);
  if (memcmp(head.magic, own.magic, sizeof own.magic))
    return fail(cache->context, HBIL_INVALID_ARGUMENT,
                "bytes: not a cache of hbil %s", hbil_version());
  if (head.voxels != own.voxels || head.levels != own.levels ||
      memcmp(&head.voxel_size, &own.voxel_size, sizeof own.voxel_size))
    return fail(cache->context, HBIL_INVALID_ARGUMENT,
                "bytes: a cache of %u voxels, %u levels and voxel_size %g; "
                "this one has %u, %u and %g",
                (unsigned)head.voxels, (unsigned)head.levels, head.voxel_size,
                (unsigned)own.voxels, (unsigned)own.levels, own.voxel_size);
  if (head.hash != hash_of_saved(bytes, size))
    return fail(cache->context, HBIL_INVALID_ARGUMENT,
                "bytes: damaged: they are not those that hbil_cache_save() "
                "wrote");
  for (int i = 0; i < 3; ++i)
    if (!(fabs((double)head.middle[i]) < CACHE_FARTHEST_MIDDLE))
      return fail(cache->context, HBIL_INVALID_ARGUMENT,
                  "bytes: a cache 2^52 voxels away or more");
  return HBIL_SUCCESS;
}

static hbil_status write_buffer(const commands *chain, cl_mem buffer,
                                size_t offset, size_t bytes, const void *in) {
  const cl_int error =
      clEnqueueWriteBuffer(chain->queue, buffer, CL_TRUE, offset, bytes, in,
                           chain->wait_count, chain->wait_list, NULL);
  return error == CL_SUCCESS
             ? HBIL_SUCCESS
             : fail_cl(chain->context, error, "clEnqueueWriteBuffer");
}

/* Writes voxels, repaired in a copy of some of them at a time. */
static hbil_status write_voxels(const commands *chain, cl_mem buffer,
                                size_t bytes, const unsigned char *in) {
  enum { BLOCK = 1 << 14 }; /* voxels */
  const size_t voxel = HBIL_VOXEL_FLOATS * sizeof(cl_float);
  hbil_status status = HBIL_SUCCESS;
  float *copy = malloc(BLOCK * voxel);
  if (!copy)
    return fail(chain->context, HBIL_OUT_OF_HOST_MEMORY,
                "no memory to load a cache in");
  for (size_t at = 0; at < bytes && status == HBIL_SUCCESS;
       at += BLOCK * voxel) {
    const size_t part = bytes - at < BLOCK * voxel ? bytes - at : BLOCK * voxel;
    memcpy(copy, in + at, part);
    voxels_repair(copy, part / voxel);
    status = write_buffer(chain, buffer, at, part, copy);
  }
  free(copy);
  return status;
}

hbil_status hbil_cache_load(hbil_cache *cache, cl_command_queue queue,
                            const void *bytes, size_t size) {
  static const hbil_cache_update no_bounces = {.phases = 1};
  commands chain;
  const unsigned char *at = bytes;
  hbil_status status = begin(__func__, cache, queue, bytes, size, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  status = check_saved(cache, at, size);
  hbil_cache_saved_head head;
  memcpy(&head, at, sizeof head);
  size_t offset = sizeof head;
  for (int i = 0; i < SAVED && status == HBIL_SUCCESS; ++i) {
    const size_t part = cache->bytes[saved[i]];
    const cl_mem buffer = cache->buffers[saved[i]];
    status = saved[i] == CACHE_VOXELS
                 ? write_voxels(&chain, buffer, part, at + offset)
                 : write_buffer(&chain, buffer, 0, part, at + offset);
    offset += part;
  }
  cache_changed(cache, false);
  if (status == HBIL_SUCCESS) {
    memcpy(cache->middle, head.middle, sizeof head.middle);
    cache->updates = head.updates;
    status = empty_volumes(&chain, cache);
  }
  if (status == HBIL_SUCCESS)
    status = update_cache(&chain, cache, &no_bounces);
  end_commands(&chain);
  return status;
}
