/*
 * judge: how many samples is each tile worth?  The gather has looked at a few
 * layers of it, each along a single slice of its own direction.  How far these
 * differ from one another tells how much a tile's light depends on where one
 * looks, and that is what samples miss; hbil_config.max_error has the measured
 * relation (HACKING.md, "Adaptive sampling").
 *
 * A tile is HBIL_TILE pixels of a layer row in all layers, 128x4 of the
 * picture: the same for every width, so the same samples are taken everywhere.
 *
 * Builds: ORTHOGRAPHIC, GATHER_RADIANCE, STORAGE.
 * In: split planes, light planes of the probe.  Out: tiles[rows][across][4]
 * (HBIL_JUDGED), behind it HBIL_JUDGE_PARTS pairs of sums; rungs[rows][across].
 * In a still frame whose light has not changed all three leave at once.
 */

/* Launch: x = tiles across, y = rows of the layers. */
kernel void judge_tiles(const hbil_layer_args in, global const float *split,
                        const hbil_layer_args lit, global const float *light,
                        global float *tiles, global const uint *flags,
                        const int still) {
  const int tile = (int)get_global_id(0), y = (int)get_global_id(1);
  const int across = hbil_tiles(in.width);
  if (tile >= across || y >= in.height || (still && !flags[HBIL_FLAG_CHANGED]))
    return;
  const uint at = (uint)y * in.row + in.origin + (uint)(tile * HBIL_TILE);
  const uint from = (uint)y * lit.row + lit.origin + (uint)(tile * HBIL_TILE);
  /* variances of AO and of E_near's channels, their count, E_near, its count */
  realv variance[4], counted = 0.0f, near_light = 0.0f, shown = 0.0f;
#pragma unroll
  for (int p = 0; p < 4; ++p)
    variance[p] = 0.0f;
  for (int x = 0; x < HBIL_TILE; x += HBIL_WIDTH) {
    realv value[HBIL_PROBE_LAYERS][HBIL_GATHERED_PLANES];
    realv one[HBIL_PROBE_LAYERS], count = 0.0f;
    for (int i = 0; i < HBIL_PROBE_LAYERS; ++i) {
      const uint layer = (uint)hbil_probe_layer(i);
      const realv w = LOADV(split + layer * in.layer + at + (uint)x);
      one[i] = select((realv)0.0f, (realv)1.0f, w > SKY);
      count += one[i];
      gathered_light(light + layer * lit.layer + from + (uint)x, lit.plane,
                     value[i]);
    }
    const intv several = count > 1.5f;
    const realv inv_count = 1.0f / max(count, (realv)1.0f);
    const realv inv_free = 1.0f / max(count - 1.0f, (realv)1.0f);
#define ADD_VARIANCE(p)                                                        \
  {                                                                            \
    realv mean = 0.0f, square = 0.0f;                                          \
    for (int i = 0; i < HBIL_PROBE_LAYERS; ++i)                                \
      mean = fma(one[i], value[i][p], mean);                                   \
    if (p > 0)                                                                 \
      near_light += mean;                                                      \
    mean *= inv_count;                                                         \
    for (int i = 0; i < HBIL_PROBE_LAYERS; ++i) {                              \
      const realv off = one[i] * (value[i][p] - mean);                         \
      square = fma(off, off, square);                                          \
    }                                                                          \
    variance[p] += select((realv)0.0f, square * inv_free, several);            \
  }
    ADD_VARIANCE(0)
    IF_RADIANCE(ADD_VARIANCE)
    counted += select((realv)0.0f, (realv)1.0f, several);
    shown += count;
  }
  const float inv = 1.0f / max(lanes_sum(counted), 1.0f);
  tiles += (uint)(y * across + tile) * HBIL_JUDGED;
  tiles[0] = lanes_sum(variance[0]) * inv;
  /* of the channel that differs most */
  tiles[1] = max(max(lanes_sum(variance[1]), lanes_sum(variance[2])),
                 lanes_sum(variance[3])) *
             inv;
  tiles[2] = lanes_sum(near_light);
  tiles[3] = lanes_sum(shown);
}

/* Launch: x = HBIL_JUDGE_PARTS work-items, each takes every so many tiles. */
kernel void judge_sum(const hbil_layer_args in, global float *tiles,
                      global const uint *flags, const int still) {
  const int part = (int)get_global_id(0);
  const int across = hbil_tiles(in.width);
  const int count = across * in.height;
  if (part >= HBIL_JUDGE_PARTS || get_global_id(1) > 0 ||
      (still && !flags[HBIL_FLAG_CHANGED]))
    return;
  float near_light = 0.0f, shown = 0.0f;
  for (int i = part; i < count; i += HBIL_JUDGE_PARTS) {
    near_light += tiles[i * HBIL_JUDGED + 2];
    shown += tiles[i * HBIL_JUDGED + 3];
  }
  tiles += count * HBIL_JUDGED + 2 * part;
  tiles[0] = near_light;
  tiles[1] = shown;
}

/* Launch: x = tiles across, y = rows of the layers. */
kernel void judge_rungs(const hbil_layer_args in, global const float *tiles,
                        global const hbil_rung *ladder, const int count,
                        global uint *rungs, global const uint *flags,
                        const int still) {
  const int tile = (int)get_global_id(0), y = (int)get_global_id(1);
  const int across = hbil_tiles(in.width);
  if (tile >= across || y >= in.height || (still && !flags[HBIL_FLAG_CHANGED]))
    return;
  global const float *sums = tiles + across * in.height * HBIL_JUDGED;
  float near_light = 0.0f, shown = 0.0f;
  for (int part = 0; part < HBIL_JUDGE_PARTS; ++part) {
    near_light += sums[2 * part];
    shown += sums[2 * part + 1];
  }
  /* three channels a pixel */
  const float mean = near_light / max(3.0f * shown, 1.0f);
  tiles += (uint)(y * across + tile) * HBIL_JUDGED;
  const float ao = sqrt(tiles[0]), spread = sqrt(tiles[1]);
  int rung = 0;
  while (rung + 1 < count &&
         (ao > ladder[rung].ao || spread > ladder[rung].near_light * mean))
    ++rung;
  rungs[y * across + tile] = (uint)rung;
}
