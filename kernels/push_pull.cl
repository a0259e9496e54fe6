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

/* v holds coarser texels, from the one left of the first texel's parent on.
 * PARENTS gives each texel's parent, BESIDE_PARENTS the parent's neighbour on
 * the side that the texel lies on: left for even texels, right for odd ones. */
#if HBIL_WIDTH == 4
#define PARENTS(v) v.s1122
#define BESIDE_PARENTS(v) v.s0213
#elif HBIL_WIDTH == 8
#define PARENTS(v) v.s11223344
#define BESIDE_PARENTS(v) v.s02132435
#elif HBIL_WIDTH == 16
#define PARENTS(v) v.s1122334455667788
#define BESIDE_PARENTS(v) v.s0213243546576879
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

/* In a row of the coarser level: the parents of the texels from x on, and for
 * each the parent's neighbour that is nearer to the texel.  At the border,
 * where there is none, that is the parent itself. */
INLINE void coarser_row(global const float *row, int columns, int x,
                        realv *nearest, realv *beside) {
#if HBIL_WIDTH == 1
  const int parent = x >> 1;
  *nearest = row[parent];
  *beside = row[clamp(x & 1 ? parent + 1 : parent - 1, 0, columns - 1)];
#else
  /* The load begins one texel left of the first parent and may run past the
   * row's end.  Both are inside of the chain: a finer level comes before, and
   * other rows or levels follow, except for the coarsest level, whose row is
   * long enough.  What belongs to other rows is never used. */
  const realv v = LOADV(row + (x >> 1) - 1);
  const intv border = (x + EACH_LANE == 0) | (x + EACH_LANE == 2 * columns - 1);
  *nearest = PARENTS(v);
  *beside = select(BESIDE_PARENTS(v), *nearest, border);
#endif
}

/* For each texel from (x, y) on, the four nearest ones of the coarser level,
 * plane by plane: its parent, then the neighbours in x, in y and in both. */
INLINE void coarser_texels(const hbil_chain_args coarse,
                           global const float *chain, int x, int y,
                           realv texel[4][CARRIED_PLANES]) {
  const int y1 = y >> 1;
  const int y0 = clamp(y & 1 ? y1 + 1 : y1 - 1, 0, coarse.height - 1);
  chain += coarse.offset;
#pragma unroll
  for (uint p = 0u; p < CARRIED_PLANES; ++p) {
    coarser_row(chain + p * coarse.plane + (uint)y1 * coarse.row, coarse.width,
                x, &texel[0][p], &texel[1][p]);
    coarser_row(chain + p * coarse.plane + (uint)y0 * coarse.row, coarse.width,
                x, &texel[2][p], &texel[3][p]);
  }
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
  coarser_texels(coarse, chain, x, y, texel);
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
