/*
 * regather: E_near of a frame in which nothing but light is new, of the form
 * factors that the gather has kept of the frame before (horizon_cache.clh). AO,
 * bent normals and all else it has left stay.
 *
 * Builds: GATHER_RADIANCE, FALLBACK_LAST_ACCEPTED, EXTRAPOLATE, STORAGE.
 *
 * Launch: as the gather's, of the rows that form factors are kept of.
 * In: split planes, form factors, what spans were spared.  Out: E_near
 * in the light planes.
 */

/* What a half-slice's samples send. */
INLINE shine half_slice(factors *kept, const realv own[3],
                        global const float *from, uint plane) {
  shine s = no_light(own);
  const int hits = *kept->entry;
  NEXT_ENTRY(kept);
  for (int i = 0; i < hits; ++i) {
    global const float *sample = from + *kept->entry;
    NEXT_ENTRY(kept);
    const realv share = kept_factor(kept);
    realv accept = 1.0f;
#if FALLBACK_LAST_ACCEPTED
    accept = kept_factor(kept);
#endif
    add_radiance(&s, share, accept, sample, plane);
  }
  return s;
}

/* Asks for a vector's form factors, for which nothing else tells where they
 * begin: as many as there are where a third of the samples rise. */
INLINE void fetch_factors(factors kept, uint vectors, uint entries) {
#if HBIL_WIDTH > 1
  for (uint i = 0u; i < vectors; ++i)
    FETCH_LINE(kept.vector + i * HBIL_WIDTH);
  for (uint i = 0u; i < entries; i += 16u)
    FETCH_LINE(kept.entry + i);
#endif
}

kernel void regather(const hbil_gather_args args, global const float *split,
                     global float *light, global const uchar *spans,
                     global const uint *flags,
                     const hbil_factor_args factor_args,
                     global float *all_kept) {
  const hbil_layer_args in = args.split;
  const int x = (int)get_global_id(0) * (SPAN_VECTORS * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  const int layer = (int)get_global_id(2);
  if (x >= in.width || y >= (int)factor_args.rows || !flags[HBIL_FLAG_CHANGED])
    return;
  const uint span = (uint)(x / (SPAN_VECTORS * HBIL_WIDTH));
  if (spans[(uint)(layer * in.height + y) * args.spans + span])
    return;
  const uint first = first_vector(factor_args, args.spans, layer, y, span);
  split += (uint)y * in.row + (uint)x;
  light += (uint)layer * args.light.layer + args.light.origin +
           (uint)y * args.light.row + (uint)x;
  for (uint v = 0u; v < SPAN_VECTORS; ++v) {
    factors kept = factors_of(factor_args, all_kept, first + v);
    fetch_factors(factors_of(factor_args, all_kept, first + v + 2u),
                  factor_args.factors / 3u, factor_args.entries);
    global const float *from = split + v * HBIL_WIDTH;
    realv own[3] = {0.0f, 0.0f, 0.0f}, sum[3] = {0.0f, 0.0f, 0.0f};
#if FALLBACK_LAST_ACCEPTED
    split_radiance(from + (uint)layer * in.layer + in.origin, in.plane, own);
#endif
    for (int slice = 0; slice < args.slices; ++slice) {
      realv both[3] = {0.0f, 0.0f, 0.0f};
      for (int side = 0; side < 2; ++side) {
        const shine s = half_slice(&kept, own, from, in.plane);
        realv more = 1.0f;
#if EXTRAPOLATE
        more = kept_factor(&kept);
#endif
        both[0] = fma(more, s.red, both[0]);
        both[1] = fma(more, s.green, both[1]);
        both[2] = fma(more, s.blue, both[2]);
      }
      const realv jacobian = kept_factor(&kept);
#pragma unroll
      for (int c = 0; c < 3; ++c)
        sum[c] = fma(jacobian, both[c], sum[c]);
    }
    const realv scale = kept_factor(&kept);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      sum[c] *= scale;
    store_gathered_near(sum, light + v * HBIL_WIDTH, args.light.plane);
  }
}
