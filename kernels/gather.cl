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
 * hbil_plan_statistics(), which work was left out.
 * Where frames share slices (gather/past_slices.clh): In: what the last frame
 * found, motion vectors, what the cache says of light that has fallen.  Out:
 * the same for the next frame.
 */
#include "gather/hemisphere.clh"
#include "lib/cache_args.h"

#if SHARES_SLICES
#include "gather/past_slices.clh"
#endif

/* One slice of a span: both sides, added to the totals.  steps: an entry
 * with the direction of the first side, then the side's samples; then the same
 * for the other side, in side_steps entries each. */
INLINE void gather_slice(const hbil_gather_args args, const receiver *c,
                         global const hbil_step *steps, int side_steps,
                         const span_march *how, totals *t, intv *untouched) {
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
    }
    const uint quadrant =
        hbil_quadrant((ux > 0.0f) != side, (uy > 0.0f) != side);
    march_half_slice(args, c, s, h, m, top, quadrant, steps + 1, how);
    for (int v = 0; v < SPAN_VECTORS; ++v) {
      end_march(&c[v], &s[v], &h[v], &m[v], top[v], how->dither);
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
  for (int v = 0; v < SPAN_VECTORS; ++v)
    add_slice(&t[v], &s[v], ux, uy);
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

#if SHARES_SLICES
/* Where a span is, and what its search leaves out. */
typedef struct span_place {
  int x, y, layer, site;
  int gathered; /* the layer's number among those that are gathered */
  bool sky, skips_all;
} span_place;

/* What every SLICE_FRAMES-th slice from `first` on finds. */
INLINE void search_set(const hbil_gather_args args, const receiver *c,
                       global const hbil_step *table, int first,
                       const span_march *how, const span_place *at,
                       slice_set *set) {
  const uint slice = 2u * (uint)(args.steps + 1);
  totals t[SPAN_VECTORS];
  intv untouched[SPAN_VECTORS];
  for (int v = 0; v < SPAN_VECTORS; ++v) {
    t[v] = no_totals();
    untouched[v] = TRUE_LANES;
  }
  for (int i = first; i < args.slices && !at->sky; i += SLICE_FRAMES) {
    global const hbil_step *steps = table + (uint)i * slice;
    if (at->skips_all)
      weigh_slice(c, steps, t);
    else
      gather_slice(args, c, steps, args.steps + 1, how, t, untouched);
  }
  for (int v = 0; v < SPAN_VECTORS; ++v) {
    finish_totals(&c[v], &t[v], untouched[v],
                  (float)(args.slices / SLICE_FRAMES), set[v].value,
                  set[v].missing);
    set[v].known = TRUE_LANES;
  }
}

/* Gathers a span by this frame's slices and those of the last frames; by all
 * slices, where too many pixels have no others.  next: the whole buffer. */
INLINE void gather_shared(const hbil_gather_args args, const receiver *c,
                          global const hbil_step *table, const span_march *how,
                          const span_place *at, const slice_past *past,
                          global float *light, global float *next) {
  slice_set sets[SLICE_FRAMES * SPAN_VECTORS];
  int shown = 0, missing = 0, turn = 0; /* turn: of frames */
  if (args.has_past)
    turn = ((int)past->sets[0] + 1) % SLICE_FRAMES;
  for (int v = 0; v < SPAN_VECTORS; ++v) {
    const intv solid = c[v].w > SKY;
    for (int age = 1; age < SLICE_FRAMES; ++age)
      sets[age * SPAN_VECTORS + v].known = 0;
    shown += lanes_true(solid);
    missing += lanes_true(
        args.has_past && ANY(solid)
            ? solid & ~recall_sets(args, &c[v], at->x + v * HBIL_WIDTH, at->y,
                                   at->layer, past, sets + v)
            : solid);
  }
  const int ages = MOST_MISSING * missing > shown ? SLICE_FRAMES : 1;
  for (int age = 0; age < ages; ++age)
    search_set(args, c, table, (turn + SLICE_FRAMES - age) % SLICE_FRAMES, how,
               at, sets + age * SPAN_VECTORS);
  if (at->x == 0 && at->y == 0 && at->layer == 0)
    next[0] = (float)turn;
  next += (uint)at->gathered * args.past.layer + args.past.origin +
          (uint)at->y * args.past.row + (uint)at->x;
  for (int v = 0; v < SPAN_VECTORS; ++v) {
    realv value[HBIL_GATHERED_PLANES];
    join_sets(sets + v, ages, (float)args.slices, value);
    if (!args.has_past) /* all pixels have all slices, and count the same */
      value[HBIL_LIGHT_WEIGHT] = 1.0f;
    hand_on(args, &c[v], sets + v, at->site, next + v * HBIL_WIDTH);
    store_gathered(value, at->site, light + v * HBIL_WIDTH, args.light.plane);
  }
}
#endif

kernel void gather(const hbil_gather_args args, global const float *split,
                   global const hbil_step *steps, global float *light,
                   global const uint *bounds, global const uint *used_groups,
                   global uchar *span_states, global const uint *flags,
                   global const float *past, global float *next,
                   global const void *motion, const hbil_fall_args fall,
                   global const float *ratios) {
  const hbil_layer_args in = args.split;
  const int x = (int)get_global_id(0) * (SPAN_VECTORS * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  const int gathered_index = (int)get_global_id(2);
  const int layer = hbil_gathered_layer(gathered_index, GATHERED);
  const int site = hbil_site(layer, y, GATHERED);
  if (x >= in.width || y >= in.height ||
      (args.is_static && !flags[HBIL_FLAG_CHANGED]))
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
#if SHARES_SLICES
  const span_place place = {
      x, y, layer, site, gathered_index, skipped & HBIL_SPAN_SKY, skips_all};
  const slice_past last = {
      past, motion, fall,
      PROBES && args.has_past && light_falls(fall, ratios) ? ratios : 0};
  gather_shared(args, c, steps, &how, &place, &last, light, next);
#else
  const int slices = skipped & HBIL_SPAN_SKY ? 0 : args.slices;
  for (int i = 0; i < slices; ++i) {
    if (!skips_all || OUT_GLOSSY) /* whole lobes are summed up in any case */
      gather_slice(args, c, steps, args.steps + 1, &how, t, untouched);
    else if (WEIGHT_PLANE)
      weigh_slice(c, steps, t);
    steps += 2 * (args.steps + 1);
  }
  for (int v = 0; v < SPAN_VECTORS; ++v)
    store_totals(&c[v], &t[v], untouched[v], args.slices, site,
                 light + v * HBIL_WIDTH, args.light.plane);
#endif
}
