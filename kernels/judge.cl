/*
 * judge: how many samples does the picture need?  The gather has looked at a
 * few tiles with many samples, the ruler, and then does so with one rung after
 * another, fewest samples first.  Pixels in the middle of blocks of 4x4, which
 * look along all directions, are brought together with their block as recompose
 * will do it, and held against what the ruler makes of them; the first rung
 * with which no more than 5 % of them are off by more than the limits is the
 * frame's (HACKING.md, "Adaptive sampling").
 *
 * Recompose looks at 5x5 pixels; those outside of the block have directions
 * that others in it have, too.
 *
 * Builds: GATHER_RADIANCE, STORAGE, WEIGHT_PLANE, ORTHOGRAPHIC.
 * Launch: x = tiles that are measured.
 * In: split planes, light planes.  Out: ruler (HBIL_RULER_); tried[][2]
 * (HBIL_TRIED_).  In a still frame whose light has not changed both leave at
 * once, and so does judge_rung once a rung before was good enough.
 */

/* Planes of the ruler that are in use. */
#if GATHER_RADIANCE
#define JUDGED_PLANES HBIL_RULER_PLANES
#else
#define JUDGED_PLANES HBIL_RULER_RED
#endif

/* Values of a tile in the ruler. */
#define RULER_TILE (HBIL_JUDGED * HBIL_RULER_PLANES * HBIL_SPAN)

/* The pixels (at, at) of a vector of blocks, filtered with their blocks;
 * returns 1 where they show a surface. */
INLINE realv filtered(const hbil_judge_args args, const hbil_view_args view,
                      global const float *split, global const float *light,
                      int at, int x, int y, realv *mean) {
  const hbil_layer_args in = args.in, lit = args.lit;
  global const float *self = split + place(in, at, at, x, y);
  realv total = 0.0f, normal[3];
  const realv w = LOADV(self);
  const intv solid = w > SKY;
  split_normal(self, in.plane, normal);
  const middle m =
      middle_of(view, w, normal, HBIL_SIDE * x + at, HBIL_SIDE * y + at);
  for (int p = 0; p < JUDGED_PLANES; ++p)
    mean[p] = 0.0f;
  for (int j = 0; j < HBIL_SIDE; ++j)
    for (int i = 0; i < HBIL_SIDE; ++i) {
      global const float *there = split + place(in, i, j, x, y);
      realv other[3], value[HBIL_GATHERED_PLANES];
      const realv other_w = LOADV(there);
      split_normal(there, in.plane, other);
      gathered_light(light + place(lit, i, j, x, y), lit.plane, value);
      const realv weight =
          select((realv)0.0f,
                 guide_weight(&m, other_w, other, i - at, j - at) *
                     value[HBIL_LIGHT_WEIGHT],
                 solid & (other_w > SKY));
      total += weight;
      for (int p = 0; p < JUDGED_PLANES; ++p)
        mean[p] = fma(weight, value[p], mean[p]);
    }
  /* a slice weighs 1e-6 at least, see gather.cl */
  const realv inv_total = 1.0f / max(total, (realv)1e-6f);
  for (int p = 0; p < JUDGED_PLANES; ++p)
    mean[p] *= inv_total;
  return select((realv)0.0f, (realv)1.0f, solid);
}

/* What the ruler says; and no rung has been tried yet. */
kernel void judge_ruler(const hbil_judge_args args, const hbil_view_args view,
                        global const float *split, global const float *light,
                        global float *ruler, global uint *tried,
                        global const uint *flags, const int still) {
  const int tile = (int)get_global_id(0), tiles = args.tiles;
  if (tile >= tiles || get_global_id(1) > 0 ||
      (still && !flags[HBIL_FLAG_CHANGED]))
    return;
  if (tile == 0)
    for (int i = 0; i < HBIL_MOST_RUNGS * HBIL_TRIED; ++i)
      tried[i] = 0u;
  int column, y;
  hbil_measured_tile(tile, tiles, hbil_spans(args.in.width), args.in.height,
                     &column, &y);
  global float *own = ruler + (uint)(tile * RULER_TILE);
  realv near_irradiance = 0.0f, shown = 0.0f;
  for (int k = 0; k < HBIL_JUDGED; ++k)
    for (int x = 0; x < HBIL_SPAN; x += HBIL_WIDTH) {
      realv mean[HBIL_RULER_PLANES];
      const realv count = filtered(args, view, split, light, 1 + k,
                                   column * HBIL_SPAN + x, y, mean);
      for (int p = 0; p < JUDGED_PLANES; ++p)
        STOREV(mean[p], own + (k * HBIL_RULER_PLANES + p) * HBIL_SPAN + x);
      for (int p = HBIL_RULER_RED; p < JUDGED_PLANES; ++p)
        near_irradiance = fma(count, mean[p], near_irradiance);
      shown += count;
    }
  ruler += (uint)(tiles * RULER_TILE + 2 * tile);
  ruler[0] = lanes_sum(near_irradiance);
  ruler[1] = 3.0f * lanes_sum(shown);
}

/* How many pixels the rung leaves beyond the limits. */
kernel void judge_rung(const hbil_judge_args args, const hbil_view_args view,
                       global const float *split, global const float *light,
                       global const float *ruler, global uint *tried,
                       global const uint *flags, const int still) {
  const int tile = (int)get_global_id(0), tiles = args.tiles;
  if (tile >= tiles || get_global_id(1) > 0 ||
      (still && !flags[HBIL_FLAG_CHANGED]) ||
      good_rung(tried, args.rung) < args.rung)
    return;
  global const float *sums = ruler + (uint)(tiles * RULER_TILE);
  float near_irradiance = 0.0f, values = 0.0f;
  for (int i = 0; i < tiles; ++i) {
    near_irradiance += sums[2 * i];
    values += sums[2 * i + 1];
  }
  /* 1: where there is no light, nothing is off */
  const float most =
      args.limit.near_irradiance * near_irradiance / max(values, 1.0f);
  int column, y;
  hbil_measured_tile(tile, tiles, hbil_spans(args.in.width), args.in.height,
                     &column, &y);
  global const float *own = ruler + (uint)(tile * RULER_TILE);
  realv beyond = 0.0f, pixels = 0.0f;
  for (int k = 0; k < HBIL_JUDGED; ++k)
    for (int x = 0; x < HBIL_SPAN; x += HBIL_WIDTH) {
      realv mean[HBIL_RULER_PLANES];
      const realv count = filtered(args, view, split, light, 1 + k,
                                   column * HBIL_SPAN + x, y, mean);
      global const float *right = own + k * HBIL_RULER_PLANES * HBIL_SPAN + x;
      intv off = fabs(mean[HBIL_RULER_AO] - LOADV(right)) > args.limit.ao;
      for (int p = HBIL_RULER_RED; p < JUDGED_PLANES; ++p)
        off |= fabs(mean[p] - LOADV(right + p * HBIL_SPAN)) > most;
      beyond += select((realv)0.0f, count, off);
      pixels += count;
    }
  tried += args.rung * HBIL_TRIED;
  atomic_add(tried + HBIL_TRIED_BEYOND, (uint)lanes_sum(beyond));
  atomic_add(tried + HBIL_TRIED_PIXELS, (uint)lanes_sum(pixels));
}
