/*
 * regather: E_near of a frame in which only the light is new, from the horizon
 * cache that the gather has filled in an earlier frame
 * (lib/horizon_cache.clh).  AO and bent normals do not change.
 *
 * Launch: like the gather, for the rows that are in the cache.
 * In: split planes, horizon cache, the work that was left out for each span.
 * Out: E_near in the light planes.
 */
#include "lib/flags.clh"
#include "lib/gathered_planes.clh"
#include "lib/horizon_cache.clh"
#include "lib/light_sum.clh"

#if !defined(FINITE) || FINITE < 0 || FINITE > 3
#error FINITE must be 0..3
#endif

/* The light that a half-slice's samples send. */
INLINE light_sum half_slice_light(cache_cursor *cache, const realv own[3],
                                  global const float *from, uint plane) {
  light_sum s = no_light(own);
#if FINITE
  light_sum whole = s;
#endif
  const int hits = *cache->entry;
  SKIP_ENTRY(cache);
  for (int i = 0; i < hits; ++i) {
    const int offset = *cache->entry;
    SKIP_ENTRY(cache);
#if FINITE
    if (offset == HBIL_INTERVAL_END) {
      const realv scale = cached_float(cache);
      add_scaled(&whole, max(scale, (realv)0.0f), &s, scale >= 0.0f);
      continue;
    }
#endif
    global const float *sample = from + offset;
    const realv share = cached_float(cache);
    realv accept = 1.0f;
#if FALLBACK_LAST_ACCEPTED
    accept = cached_float(cache);
#endif
    add_radiance(&s, share, accept, sample, plane);
  }
#if FINITE
  return whole;
#else
  return s;
#endif
}

/* Prefetches the cache of a vector, since nothing else tells where it begins:
 * as much as there is where a third of the samples rise. */
INLINE void fetch_cache(cache_cursor cache, uint vectors, uint entries) {
#if HBIL_WIDTH > 1
  for (uint i = 0u; i < vectors; ++i)
    FETCH_LINE(cache.next_floats + i * HBIL_WIDTH);
  for (uint i = 0u; i < entries; i += 16u)
    FETCH_LINE(cache.entry + i);
#endif
}

kernel void regather(const hbil_gather_args args, global const float *split,
                     global float *light, global const uchar *spans,
                     global const uint *flags, global float *whole_cache) {
  const hbil_layer_args in = args.split;
  const int x = (int)get_global_id(0) * (SPAN_VECTORS * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  const int gathered_index = (int)get_global_id(2);
  const int layer = hbil_gathered_layer(gathered_index, GATHERED);
  if (x >= in.width || y >= (int)args.cache.rows || !flags[HBIL_FLAG_CHANGED])
    return;
  const uint span = (uint)(x / (SPAN_VECTORS * HBIL_WIDTH));
  if (spans[(uint)(layer * in.height + y) * args.spans + span])
    return;
  const uint first =
      first_vector(args.cache, args.spans, gathered_index, y, span);
  split += (uint)y * in.row + (uint)x;
  light += (uint)layer * args.light.layer + args.light.origin +
           (uint)y * args.light.row + (uint)x;
  for (uint v = 0u; v < SPAN_VECTORS; ++v) {
    cache_cursor cache = cache_at(args.cache, whole_cache, first + v);
    fetch_cache(cache_at(args.cache, whole_cache, first + v + 2u),
                args.cache.floats / 3u, args.cache.entries);
    global const float *from = split + v * HBIL_WIDTH;
    realv own[3] = {0.0f, 0.0f, 0.0f}, sum[3] = {0.0f, 0.0f, 0.0f};
#if FALLBACK_LAST_ACCEPTED
    split_radiance(from + (uint)layer * in.layer + in.origin, in.plane, own);
#endif
    for (int slice = 0; slice < args.slices; ++slice) {
      realv both[3] = {0.0f, 0.0f, 0.0f};
      for (int side = 0; side < 2; ++side) {
        const light_sum s = half_slice_light(&cache, own, from, in.plane);
        both[0] += s.red;
        both[1] += s.green;
        both[2] += s.blue;
      }
      const realv jacobian = cached_float(&cache);
#pragma unroll
      for (int c = 0; c < 3; ++c)
        sum[c] = fma(jacobian, both[c], sum[c]);
    }
    const realv scale = cached_float(&cache);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      sum[c] *= scale;
    store_gathered_near(sum, light + v * HBIL_WIDTH, args.light.plane);
  }
}
