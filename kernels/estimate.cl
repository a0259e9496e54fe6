/*
 * estimate: the light of surfaces that the screen doesn't show.
 *
 * The guess is what the visible surfaces send on average: for a receiver of
 * normal n, a mean over the visible pixels, each weighted by how much it faces
 * the receiver.  With c = -n_i.n the weight is the clamped cosine convolved
 * with itself, to order 2: 1 + 4/3 c + 5/16 P2(c).  frame_light() adds a
 * twentieth, which makes it positive everywhere.  So 4 x 9 numbers are enough:
 * sums of (sqrt L, 1) times the order-2 polynomials of -n_i.
 *
 * The mean is that of sqrt(L), squared, so that a few very bright pixels (those
 * near a lamp) don't light everything that is unseen.  It is never above the
 * arithmetic mean, so feeding it back loses energy at every bounce.
 *
 * Every fourth pixel in x and y (layer 0) is enough.
 * In: split planes.  Out: estimate[4][9]: red, green, blue, weight; behind it
 * the HBIL_ESTIMATE_PARTS partial sums that it is the sum of.
 */
#include "lib/camera.clh"
#include "lib/split_planes.clh"

/* The polynomials of the real basis in order (0,0) (1,-1..1) (2,-2..2). */
INLINE void polynomials(realv x, realv y, realv z, realv *p) {
  p[0] = 1.0f;
  p[1] = y;
  p[2] = z;
  p[3] = x;
  p[4] = x * y;
  p[5] = y * z;
  p[6] = 3.0f * z * z - 1.0f;
  p[7] = z * x;
  p[8] = x * x - y * y;
}

/* Launch: x = HBIL_ESTIMATE_PARTS work-items; each takes every
 * HBIL_ESTIMATE_PARTS-th row. */
kernel void estimate_part(const hbil_estimate_args args,
                          global const float *split, global float *estimate) {
  const hbil_layer_args in = args.split;
  const int part = (int)get_global_id(0);
  if (part >= HBIL_ESTIMATE_PARTS || get_global_id(1) > 0)
    return;
  realv sum[HBIL_ESTIMATE_SIZE];
  for (int i = 0; i < HBIL_ESTIMATE_SIZE; ++i)
    sum[i] = 0.0f;
  for (int y = part; y < in.height; y += HBIL_ESTIMATE_PARTS) {
    for (int x = 0; x < in.width; x += HBIL_WIDTH) {
      global const float *here = split + in.origin + (uint)y * in.row + (uint)x;
      const realv w = LOADV(here);
      const intv solid = w > SKY;
      if (!ANY(solid))
        continue;
      realv n[3], radiance[3], p[9];
      split_normal(here, in.plane, n);
      split_radiance(here, in.plane, radiance);
      polynomials(-n[0], -n[1], -n[2], p);
      for (int c = 0; c < 4; ++c) {
        const realv light = c < 3 ? sqrt(radiance[c]) : 1.0f;
        for (int k = 0; k < 9; ++k)
          sum[9 * c + k] += select((realv)0.0f, light * p[k], solid);
      }
    }
  }
  for (int i = 0; i < HBIL_ESTIMATE_SIZE; ++i)
    estimate[(part + 1) * HBIL_ESTIMATE_SIZE + i] = lanes_sum(sum[i]);
}

/* Launch: x = HBIL_ESTIMATE_SIZE work-items.  The order of the sum is fixed. */
kernel void estimate_sum(global float *estimate) {
  const int i = (int)get_global_id(0);
  if (i >= HBIL_ESTIMATE_SIZE || get_global_id(1) > 0)
    return;
  /* the constants of the basis functions times the weight's coefficients */
  const float factor[9] = {1.0f,        1.33333333f, 1.33333333f,
                           1.33333333f, 0.9375f,     0.9375f,
                           0.078125f,   0.9375f,     0.234375f};
  float sum = 0.0f;
  for (int part = 0; part < HBIL_ESTIMATE_PARTS; ++part)
    sum += estimate[(part + 1) * HBIL_ESTIMATE_SIZE + i];
  estimate[i] = factor[i % 9] * sum;
}
