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
 * (find_holes: read), y = its rows.  Planes per level: RGB and weight, rows
 * padded to 4 HBIL_WIDEST.
 */
#include "lib/vectors.clh"

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
 * wrote; the reprojections raise the flag themselves. */
kernel void find_holes(const hbil_push_pull_args args,
                       global const float *chain, global uint *flags) {
  const hbil_chain_args finest = args.fine;
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= finest.width || y >= finest.height)
    return;
  const realv weight =
      LOADV(chain + finest.offset + HBIL_CARRIED_WEIGHT * finest.plane +
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
  PAIRS(children + HBIL_CARRIED_WEIGHT * fine.plane, weight[0], weight[1]);
  PAIRS(below + HBIL_CARRIED_WEIGHT * fine.plane, weight[2], weight[3]);
#pragma unroll
  for (int i = 0; i < 4; ++i)
    weight[i] = max(weight[i], (realv)0.0f);
  const intv inside = 2 * (x + EACH_LANE) + 1 < fine.width;
  weight[1] = select((realv)0.0f, weight[1], inside);
  weight[2] *= there;
  weight[3] = select((realv)0.0f, weight[3] * there, inside);
  const realv total = weight[0] + weight[1] + weight[2] + weight[3];
  chain += coarse.offset + (uint)y * coarse.row + (uint)x;
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    realv child[4];
    PAIRS(children + c * fine.plane, child[0], child[1]);
    PAIRS(below + c * fine.plane, child[2], child[3]);
    realv sum = weight[0] * child[0];
    sum = fma(weight[1], select((realv)0.0f, child[1], inside), sum);
    sum = fma(weight[2], child[2], sum);
    sum = fma(weight[3], select((realv)0.0f, child[3], inside), sum);
    STOREV(select((realv)0.0f, sum / total, total > 0.0f),
           chain + c * coarse.plane);
  }
  STOREV(total * 0.25f, chain + HBIL_CARRIED_WEIGHT * coarse.plane);
}

/* Fills the finer level in place. */
kernel void pull(const hbil_push_pull_args args, global float *chain,
                 global const uint *flags) {
  const hbil_chain_args fine = args.fine, coarse = args.coarse;
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= fine.width || y >= fine.height || !flags[HBIL_FLAG_HOLES])
    return;
  global float *texel = chain + fine.offset + (uint)y * fine.row + (uint)x;
  const realv valid = LOADV(texel + HBIL_CARRIED_WEIGHT * fine.plane);
  if (!ANY((valid == 0.0f) & (x + EACH_LANE < fine.width)))
    return;
  const int y1 = y >> 1;
  const int y0 = clamp((y & 1) ? y1 + 1 : y1 - 1, 0, coarse.height - 1);
  for (int i = 0; i < HBIL_WIDTH && x + i < fine.width; ++i) {
    if (texel[HBIL_CARRIED_WEIGHT * fine.plane + i] != 0.0f)
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
