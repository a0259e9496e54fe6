/*
 * push_pull: fills the holes that reprojection leaves (Mayaux 2018, 3.2; Kraus
 * 2009).
 *
 * push: a coarser texel is the weighted mean of its valid children, and its
 * weight is their share.  pull: texels without weight take the bilinear value
 * of the coarser level, which has been filled before.  Valid texels are never
 * changed, nor is the sky, whose weight is below 0 because it needs no light.
 *
 * If the finest level has no holes, both return at once, and the coarser
 * levels are not read.
 *
 * Launch: x = vectors of HBIL_WIDTH texels of the level that is written
 * (find_holes: read), y = its rows.  Planes per level: light (lib/radiance.clh)
 * and weight, rows padded to 4 HBIL_WIDEST.
 */
#include "lib/radiance.clh"

#if HBIL_WIDTH == 1
#define PAIRS(p, left, right)                                                  \
  left = (p)[0];                                                               \
  right = (p)[1]
#else
/* Splits 2 HBIL_WIDTH neighbours into those at even and those at odd places. */
#define PAIRS(p, left, right)                                                  \
  left = (realv)(LOADV(p).even, LOADV((p) + HBIL_WIDTH).even);                 \
  right = (realv)(LOADV(p).odd, LOADV((p) + HBIL_WIDTH).odd)
#endif

/* Raises HBIL_FLAG_HOLES, which the host has cleared, where a texel of the
 * finest level has no weight.  It is for carried light that a caller's own pass
 * wrote; the kernel reproject raises the flag itself. */
kernel void find_holes(const hbil_push_pull_args args,
                       global const float *chain, global uint *flags) {
  const hbil_chain_args finest = args.fine;
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= finest.width || y >= finest.height)
    return;
  const realv weight =
      LOADV(chain + finest.offset + CARRIED_WEIGHT * finest.plane +
            (uint)y * finest.row + (uint)x);
  if (ANY((weight == 0.0f) & (x + EACH_LANE < finest.width)))
    flags[HBIL_FLAG_HOLES] = 1u; /* all work-items write the same value */
}

/* Children past the right edge or below the last row have no weight, whatever
 * the padding holds. */
kernel void push(const hbil_push_pull_args args, global float *chain,
                 global const uint *flags) {
  const hbil_chain_args fine = args.fine, coarse = args.coarse;
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= coarse.width || y >= coarse.height || !flags[HBIL_FLAG_HOLES])
    return;
  global const float *children =
      chain + fine.offset + (uint)(2 * y) * fine.row + (uint)(2 * x);
  global const float *below =
      2 * y + 1 < fine.height ? children + fine.row : children;
  const float there = 2 * y + 1 < fine.height ? 1.0f : 0.0f;
  realv weight[4];
  PAIRS(children + CARRIED_WEIGHT * fine.plane, weight[0], weight[1]);
  PAIRS(below + CARRIED_WEIGHT * fine.plane, weight[2], weight[3]);
#pragma unroll
  for (int i = 0; i < 4; ++i)
    weight[i] = max(weight[i], (realv)0.0f);
  const intv inside = 2 * (x + EACH_LANE) + 1 < fine.width;
  weight[1] = select((realv)0.0f, weight[1], inside);
  weight[2] *= there;
  weight[3] = select((realv)0.0f, weight[3] * there, inside);
  const realv total = weight[0] + weight[1] + weight[2] + weight[3];
  chain += coarse.offset + (uint)y * coarse.row + (uint)x;
  realv child[4][RADIANCE_PLANES], light[4][3], mean[3];
#pragma unroll
  for (int p = 0; p < RADIANCE_PLANES; ++p) {
    PAIRS(children + p * fine.plane, child[0][p], child[1][p]);
    PAIRS(below + p * fine.plane, child[2][p], child[3][p]);
    child[1][p] = select((realv)0.0f, child[1][p], inside);
    child[3][p] = select((realv)0.0f, child[3][p], inside);
  }
#pragma unroll
  for (int i = 0; i < 4; ++i)
    unpack_radiance(child[i], light[i]);
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    realv sum = weight[0] * light[0][c];
#pragma unroll
    for (int i = 1; i < 4; ++i)
      sum = fma(weight[i], light[i][c], sum);
    mean[c] = select((realv)0.0f, sum / total, total > 0.0f);
  }
  pack_radiance(mean, child[0]);
#pragma unroll
  for (int p = 0; p < RADIANCE_PLANES; ++p)
    STOREV(child[0][p], chain + p * coarse.plane);
  STOREV(total * 0.25f, chain + CARRIED_WEIGHT * coarse.plane);
}

/* The four texels of the coarser level about those of `holes`, plane by plane.
 * The nearest one comes first, then its neighbours in x, in y and in both. */
INLINE void coarser_texels(const hbil_chain_args coarse,
                           global const float *chain, intv holes, int x, int y,
                           realv texel[4][CARRIED_PLANES]) {
  float lanes[4][CARRIED_PLANES][HBIL_WIDTH] = {{{0.0f}}};
  int is_hole[HBIL_WIDTH];
  STORE_INTV(holes, is_hole);
  const int y1 = y >> 1;
  const int y0 = clamp((y & 1) ? y1 + 1 : y1 - 1, 0, coarse.height - 1);
  for (int i = 0; i < HBIL_WIDTH; ++i) {
    if (!is_hole[i])
      continue;
    const int x1 = (x + i) >> 1;
    const int x0 = clamp(((x + i) & 1) ? x1 + 1 : x1 - 1, 0, coarse.width - 1);
    for (int t = 0; t < 4; ++t)
      for (int p = 0; p < CARRIED_PLANES; ++p)
        lanes[t][p][i] =
            chain[coarse.offset + (uint)p * coarse.plane +
                  (uint)(t & 2 ? y0 : y1) * coarse.row + (t & 1 ? x0 : x1)];
  }
#pragma unroll
  for (int t = 0; t < 4; ++t)
#pragma unroll
    for (int p = 0; p < CARRIED_PLANES; ++p)
      texel[t][p] = LOADV(lanes[t][p]);
}

INLINE realv bilinear(realv nearest, realv across, realv down, realv diagonal) {
  return 0.75f * (0.75f * nearest + 0.25f * across) +
         0.25f * (0.75f * down + 0.25f * diagonal);
}

/* Fills the finer level in place. */
kernel void pull(const hbil_push_pull_args args, global float *chain,
                 global const uint *flags) {
  const hbil_chain_args fine = args.fine, coarse = args.coarse;
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= fine.width || y >= fine.height || !flags[HBIL_FLAG_HOLES])
    return;
  global float *const out = chain + fine.offset + (uint)y * fine.row + (uint)x;
  const realv valid = LOADV(out + CARRIED_WEIGHT * fine.plane);
  const intv holes = (valid == 0.0f) & (x + EACH_LANE < fine.width);
  if (!ANY(holes))
    return;
  realv texel[4][CARRIED_PLANES], light[4][3], mean[3];
  coarser_texels(coarse, chain, holes, x, y, texel);
#pragma unroll
  for (int t = 0; t < 4; ++t)
    unpack_radiance(texel[t], light[t]);
#pragma unroll
  for (int c = 0; c < 3; ++c)
    mean[c] = bilinear(light[0][c], light[1][c], light[2][c], light[3][c]);
  pack_radiance(mean, texel[0]);
#pragma unroll
  for (int p = 0; p < RADIANCE_PLANES; ++p)
    STOREV(select(LOADV(out + p * fine.plane), texel[0][p], holes),
           out + p * fine.plane);
  STOREV(select(valid,
                bilinear(texel[0][CARRIED_WEIGHT], texel[1][CARRIED_WEIGHT],
                         texel[2][CARRIED_WEIGHT], texel[3][CARRIED_WEIGHT]),
                holes),
         out + CARRIED_WEIGHT * fine.plane);
}
