/*
 * gather: AO, E_near and the bent normal of every pixel, layer by layer.
 *
 * For each slice of a pixel and each of its two sides, the kernel marches
 * outwards and lets samples raise the horizon (gather/march.clh).  It sums up
 * what they block and what remains open (gather/hemisphere.clh).
 * gather/variant.clh has the build defines.
 *
 * Launch: x = spans of a layer's row (single pixels if HBIL_WIDTH is 1), y =
 * layer rows, z = gathered layers.
 * In: split planes; the table of steps; bounds; which pixels' light the outputs
 * show (`used_groups`); whether a static frame's light has changed (`flags`).
 * Out: light planes, in the layout of the split planes; for
 * hbil_plan_statistics(), which work was left out; the horizon cache.
 */
#include "gather/hemisphere.clh"

/* One slice of a span: both sides, added to the totals.  steps: an entry
 * with the direction of the first side, then the side's samples; then the same
 * for the other side, in side_steps entries each. */
INLINE void gather_slice(const hbil_gather_args args, const receiver *c,
                         global const hbil_step *steps, int side_steps,
                         const span_march *how, totals *t, intv *untouched,
                         cache_cursor *cache) {
  const float ux = steps->ux, uy = steps->uy;
  slice s[SPAN_VECTORS];
  for (int v = 0; v < SPAN_VECTORS; ++v)
    s[v] = slice_along(&c[v], ux, uy);
  for (int side = 0; side < 2; ++side) {
    half_slice h[SPAN_VECTORS];
    march m[SPAN_VECTORS];
    realv top[SPAN_VECTORS]; /* the highest excess */
    for (int v = 0; v < SPAN_VECTORS; ++v) {
      h[v] = half_of(&c[v], &s[v], side);
      m[v] = start_march(&c[v], &s[v], &h[v]);
      top[v] = h[v].least;
      if (CACHE_HORIZONS)
        cache_list(&cache[v]);
    }
    const uint quadrant =
        hbil_quadrant((ux > 0.0f) != side, (uy > 0.0f) != side);
    march_half_slice(args, c, s, h, m, top, quadrant, steps + 1, how, cache);
    for (int v = 0; v < SPAN_VECTORS; ++v) {
      end_march(&c[v], &s[v], &h[v], &m[v], top[v], how->dither, &cache[v]);
      if (HBAO)
        m[v].a = h[v].start - m[v].blocked;
      if (EACH_RISE_COUNTS)
        untouched[v] &= m[v].a == h[v].start;
      else
        untouched[v] &= top[v] <= h[v].least;
      add_side(&s[v], &m[v], h[v].start, side ? -1.0f : 1.0f);
#if OUT_GLOSSY
      add_glossy_side(&t[v].glossy, &m[v].glossy, &m[v].lobe, s[v].jacobian);
#endif
    }
    steps += side_steps;
  }
  for (int v = 0; v < SPAN_VECTORS; ++v) {
    add_slice(&t[v], &s[v], ux, uy);
    if (CACHE_HORIZONS)
      cache_float(&cache[v], s[v].jacobian);
  }
}

/* The same for a span above which nothing rises, as far as it matters: how much
 * of the hemisphere the slice stands for. */
INLINE void weigh_slice(const receiver *c, global const hbil_step *steps,
                        totals *t) {
  for (int v = 0; v < SPAN_VECTORS; ++v) {
    const slice s = slice_along(&c[v], steps->ux, steps->uy);
    const half_slice along = half_of(&c[v], &s, 0);
    const half_slice against = half_of(&c[v], &s, 1);
    t[v].whole = fma(s.jacobian, along.start + against.start, t[v].whole);
  }
}

/* The table of steps of this site, at the level whose reach covers the radius
 * around the span's nearest pixel. */
INLINE global const hbil_step *steps_of(const hbil_gather_args args,
                                        global const hbil_step *steps,
                                        float nearest, int site) {
  const uint pattern = 2u * (uint)args.slices * (uint)(args.steps + 1);
  int level = 0;
#if LIMITED
  level = hbil_level(
      args.reach, ORTHOGRAPHIC ? args.radius : args.radius * nearest, LEVELS);
#endif
  return steps + (uint)(level * hbil_sites(GATHERED) + site) * pattern;
}

kernel void gather(const hbil_gather_args args, global const float *split,
                   global const hbil_step *steps, global float *light,
                   global const uint *bounds, global const uint *used_groups,
                   global uchar *span_states, global const uint *flags,
                   global float *whole_cache) {
  const hbil_layer_args in = args.split;
  const int x = (int)get_global_id(0) * (SPAN_VECTORS * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  const int gathered_index = (int)get_global_id(2);
  const int layer = hbil_gathered_layer(gathered_index, GATHERED);
  const int site = hbil_site(layer, y, GATHERED);
  if (x >= in.width || y >= in.height ||
      (args.is_static && !flags[HBIL_FLAG_CHANGED]))
    return;
  if (CACHE_HORIZONS && (uint)y >= args.cache.rows)
    return;
  const uint at = (uint)layer * in.layer + in.origin + (uint)y * in.row;
  global const float *here = split + at + (uint)x;
  light += (uint)layer * args.light.layer + args.light.origin +
           (uint)y * args.light.row + (uint)x;

  receiver c[SPAN_VECTORS];
  totals t[SPAN_VECTORS];
  intv solid = 0, sky = 0, untouched[SPAN_VECTORS];
  for (int v = 0; v < SPAN_VECTORS; ++v) {
    c[v] = receiver_at(args, split, x + v * HBIL_WIDTH, y, layer);
    t[v] = no_totals();
    untouched[v] = TRUE_LANES;
    solid |= c[v].w > SKY;
    sky |= c[v].w <= SKY;
  }

  /* what can be left out, noted for the statistics */
  const float nearest = nearest_of(c, split + at, x);
  span_bounds span = bounds_of_span(args, nearest, x, y, layer);
  light_reach found = {LIGHT_ALL, HBIL_ALL_QUADRANTS};
  const uint skipped = skipped_of(args, c, &span, ANY(solid), bounds,
                                  used_groups, x, y, layer, &found);
  const bool skips_all = skipped & ~HBIL_SPAN_DARK;
  const uint span_x = (uint)(x / (SPAN_VECTORS * HBIL_WIDTH));
  span_states += (uint)(layer * in.height + y) * args.spans + span_x;
  span_states[0] = (uchar)skipped;
  span_states[(uint)(HBIL_LAYERS * in.height) * args.spans] =
      (uchar)(ANY(sky) ? count_sky(c) : 0u);

  cache_cursor cache[SPAN_VECTORS];
  if (CACHE_HORIZONS)
    for (uint v = 0u; v < SPAN_VECTORS; ++v)
      cache[v] = cache_at(
          args.cache, whole_cache,
          first_vector(args.cache, args.spans, gathered_index, y, span_x) + v);
#if GATHER_RADIANCE && FALLBACK_LAST_ACCEPTED
  if (!skips_all)
    for (int v = 0; v < SPAN_VECTORS; ++v)
      split_radiance(here + v * HBIL_WIDTH, in.plane, c[v].own);
#endif
  /* Without light in reach, normals and light are not needed.  With a distance
   * of 0 between planes, their prefetches ask for lines that are cached
   * already. A branch around the prefetches would cost more. */
  const bool is_dark = found.how_much == LIGHT_NONE;
  if (is_dark)
    found.quadrants = 0u;
  const span_march how = {split + (uint)y * in.row + (uint)x,
                          is_dark ? 0u : in.plane,
                          x,
                          y,
                          skips_all ? 0 : args.steps,
                          span.reach,
                          hbil_shift_share(site, GATHERED),
                          found};
  steps = steps_of(args, steps, nearest, site);
  const int slices = skipped & HBIL_SPAN_SKY ? 0 : args.slices;
  for (int i = 0; i < slices; ++i) {
    if (!skips_all || OUT_GLOSSY) /* whole lobes are summed up in any case */
      gather_slice(args, c, steps, args.steps + 1, &how, t, untouched, cache);
    else if (WEIGHT_PLANE)
      weigh_slice(c, steps, t);
    steps += 2 * (args.steps + 1);
  }
  for (int v = 0; v < SPAN_VECTORS; ++v)
    store_totals(&c[v], &t[v], untouched[v], args.slices, site,
                 light + v * HBIL_WIDTH, args.light.plane, &cache[v]);
}
