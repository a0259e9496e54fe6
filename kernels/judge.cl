/*
 * judge: how many samples does the picture need?  The gather has looked at a
 * few tiles with many samples, the ruler, and then does so with one rung after
 * another, fewest samples first.  A pixel is off by what its block of 4x4,
 * which looks along all directions, is off from the ruler; the first rung with
 * which no more than 5 % of the pixels are off by more than the limits is the
 * frame's (HACKING.md, "Adaptive sampling").
 *
 * A block's AO and light are means over its pixels, weighed as in recompose:
 * without the filter's guides, which are the same for all rungs.
 *
 * Builds: GATHER_RADIANCE, STORAGE, WEIGHT_PLANE.
 * Launch: x = tiles that are measured.
 * In: split planes, light planes.  Out: ruler (HBIL_RULER_); tried[][2]
 * (HBIL_TRIED_).  In a still frame whose light has not changed both leave at
 * once, and so does judge_rung once a rung before was good enough.
 */

/* Planes of the ruler that are in use. */
#if GATHER_RADIANCE
#define JUDGED HBIL_RULER_COUNT
#else
#define JUDGED HBIL_RULER_RED
#endif

/* What a vector of blocks has come to, and how many of the pixels of each show
 * a surface. */
INLINE void block_means(const hbil_judge_args args, global const float *split,
                        global const float *light, int x, int y, realv *mean,
                        realv *count) {
  const hbil_layer_args in = args.in, lit = args.lit;
  realv total = 0.0f;
  *count = 0.0f;
  for (int p = 0; p < JUDGED; ++p)
    mean[p] = 0.0f;
  for (int layer = 0; layer < HBIL_LAYERS; ++layer) {
    const realv w = LOADV(split + (uint)layer * in.layer + in.origin +
                          (uint)y * in.row + (uint)x);
    realv value[HBIL_GATHERED_PLANES];
    gathered_light(light + (uint)layer * lit.layer + lit.origin +
                       (uint)y * lit.row + (uint)x,
                   lit.plane, value);
    const intv solid = w > SKY;
    const realv weight = select((realv)0.0f, value[HBIL_LIGHT_WEIGHT], solid);
    *count += select((realv)0.0f, (realv)1.0f, solid);
    total += weight;
    for (int p = 0; p < JUDGED; ++p)
      mean[p] = fma(weight, value[p], mean[p]);
  }
  /* a slice weighs 1e-6 at least, see gather.cl */
  const realv inv_total = 1.0f / max(total, (realv)1e-6f);
  for (int p = 0; p < JUDGED; ++p)
    mean[p] *= inv_total;
}

/* What the ruler says; and no rung has been tried yet. */
kernel void judge_ruler(const hbil_judge_args args, global const float *split,
                        global const float *light, global float *ruler,
                        global uint *tried, global const uint *flags,
                        const int still) {
  const int tile = (int)get_global_id(0), tiles = args.tiles;
  if (tile >= tiles || get_global_id(1) > 0 ||
      (still && !flags[HBIL_FLAG_CHANGED]))
    return;
  if (tile == 0)
    for (int i = 0; i < HBIL_MOST_RUNGS * HBIL_TRIED; ++i)
      tried[i] = 0u;
  int column, y;
  hbil_measured_tile(tile, tiles, hbil_tiles(args.in.width), args.in.height,
                     &column, &y);
  global float *own = ruler + (uint)(tile * HBIL_RULER_PLANES * HBIL_TILE);
  realv near_light = 0.0f, shown = 0.0f;
  for (int x = 0; x < HBIL_TILE; x += HBIL_WIDTH) {
    realv mean[HBIL_RULER_COUNT], count;
    block_means(args, split, light, column * HBIL_TILE + x, y, mean, &count);
    for (int p = 0; p < JUDGED; ++p)
      STOREV(mean[p], own + p * HBIL_TILE + x);
    STOREV(count, own + HBIL_RULER_COUNT * HBIL_TILE + x);
    for (int p = HBIL_RULER_RED; p < JUDGED; ++p)
      near_light = fma(count, mean[p], near_light);
    shown += count;
  }
  ruler += (uint)(tiles * HBIL_RULER_PLANES * HBIL_TILE + 2 * tile);
  ruler[0] = lanes_sum(near_light);
  ruler[1] = 3.0f * lanes_sum(shown);
}

/* How many pixels the rung leaves beyond the limits. */
kernel void judge_rung(const hbil_judge_args args, global const float *split,
                       global const float *light, global const float *ruler,
                       global uint *tried, global const uint *flags,
                       const int still) {
  const int tile = (int)get_global_id(0), tiles = args.tiles;
  if (tile >= tiles || get_global_id(1) > 0 ||
      (still && !flags[HBIL_FLAG_CHANGED]) ||
      good_rung(tried, args.rung) < args.rung)
    return;
  global const float *sums =
      ruler + (uint)(tiles * HBIL_RULER_PLANES * HBIL_TILE);
  float near_light = 0.0f, values = 0.0f;
  for (int i = 0; i < tiles; ++i) {
    near_light += sums[2 * i];
    values += sums[2 * i + 1];
  }
  /* 1: where there is no light, nothing is off */
  const float most = args.limit.near_light * near_light / max(values, 1.0f);
  int column, y;
  hbil_measured_tile(tile, tiles, hbil_tiles(args.in.width), args.in.height,
                     &column, &y);
  global const float *own =
      ruler + (uint)(tile * HBIL_RULER_PLANES * HBIL_TILE);
  realv beyond = 0.0f, pixels = 0.0f;
  for (int x = 0; x < HBIL_TILE; x += HBIL_WIDTH) {
    realv mean[HBIL_RULER_COUNT], count;
    block_means(args, split, light, column * HBIL_TILE + x, y, mean, &count);
    intv off = fabs(mean[HBIL_RULER_AO] - LOADV(own + x)) > args.limit.ao;
    for (int p = HBIL_RULER_RED; p < JUDGED; ++p)
      off |= fabs(mean[p] - LOADV(own + p * HBIL_TILE + x)) > most;
    beyond += select((realv)0.0f, count, off);
    pixels += count;
  }
  tried += args.rung * HBIL_TRIED;
  atomic_add(tried + HBIL_TRIED_BEYOND, (uint)lanes_sum(beyond));
  atomic_add(tried + HBIL_TRIED_PIXELS, (uint)lanes_sum(pixels));
}
