/*
 * push_pull: fills the holes that reprojection leaves (paper 3.2; Kraus 2009).
 *
 * push: a coarser texel is the weighted mean of its valid children, its weight
 * their share.  pull: texels without weight take the bilinear value of the
 * coarser level, which has been filled before; valid ones are never changed.
 *
 * Launch: x = vectors of HBIL_WIDTH texels of the level that is written, y =
 * its rows.  Planes per level: RGB and weight, rows padded to HBIL_WIDTH.
 */

kernel void push(global float *chain, const hbil_chain_args fine,
                 const hbil_chain_args coarse) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= coarse.width || y >= coarse.height)
    return;
  float lane[HBIL_CARRIED_PLANES][HBIL_WIDTH];
  for (int i = 0; i < HBIL_WIDTH; ++i) {
    float sum[3] = {0.0f, 0.0f, 0.0f}, total = 0.0f;
    for (int t = 0; t < 4; ++t) {
      const int cx = 2 * (x + i) + (t & 1), cy = 2 * y + (t >> 1);
      if (cx >= fine.width || cy >= fine.height)
        continue;
      global const float *child =
          chain + fine.offset + (uint)cy * fine.row + (uint)cx;
      const float weight = child[HBIL_CARRIED_WEIGHT * fine.plane];
      total += weight;
      for (int c = 0; c < 3; ++c)
        sum[c] = fma(weight, child[c * fine.plane], sum[c]);
    }
    for (int c = 0; c < 3; ++c)
      lane[c][i] = total > 0.0f ? sum[c] / total : 0.0f;
    lane[HBIL_CARRIED_WEIGHT][i] = total * 0.25f;
  }
  chain += coarse.offset + (uint)y * coarse.row + (uint)x;
  for (int c = 0; c < HBIL_CARRIED_PLANES; ++c)
    STOREV(LOADV(lane[c]), chain + c * coarse.plane);
}

/* Fills the finer level in place. */
kernel void pull(global float *chain, const hbil_chain_args fine,
                 const hbil_chain_args coarse) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= fine.width || y >= fine.height)
    return;
  global float *texel = chain + fine.offset + (uint)y * fine.row + (uint)x;
  const realv valid = LOADV(texel + HBIL_CARRIED_WEIGHT * fine.plane);
  if (!ANY((valid <= 0.0f) & (x + EACH_LANE < fine.width)))
    return;
  const int y1 = y >> 1;
  const int y0 = clamp((y & 1) ? y1 + 1 : y1 - 1, 0, coarse.height - 1);
  for (int i = 0; i < HBIL_WIDTH && x + i < fine.width; ++i) {
    if (texel[HBIL_CARRIED_WEIGHT * fine.plane + i] > 0.0f)
      continue;
    const int x1 = (x + i) >> 1;
    const int x0 = clamp(((x + i) & 1) ? x1 + 1 : x1 - 1, 0, coarse.width - 1);
    for (int c = 0; c < HBIL_CARRIED_PLANES; ++c) {
      global const float *plane = chain + coarse.offset + c * coarse.plane;
      global const float *close = plane + (uint)y1 * coarse.row;
      global const float *distant = plane + (uint)y0 * coarse.row;
      texel[c * fine.plane + i] =
          0.75f * (0.75f * close[x1] + 0.25f * close[x0]) +
          0.25f * (0.75f * distant[x1] + 0.25f * distant[x0]);
    }
  }
}
