/*
 * The sampling pattern: slice directions, sample offsets, how far a sample's
 * step extends.
 *
 * Host C and OpenCL C compile the same expressions, with every rounding spelled
 * out (HBIL_FMA, no contraction elsewhere).  The double-precision passes of
 * src/exact therefore visit exactly the pixels that the kernels visit.
 */
#ifndef HBIL_SAMPLING_PATTERN_H
#define HBIL_SAMPLING_PATTERN_H

#include "shared.h"

/* Each further level reaches half as far. */
#define HBIL_MAX_LEVELS 12

/*
 * The level with the smallest reach that covers `need` (a length in ray slope:
 * radius times the span's largest inverse depth).
 */
static inline hbil_int hbil_level(hbil_float reach, hbil_float need,
                                  hbil_int levels) {
  hbil_int level = 0;
  while (level + 1 < levels && 0.5f * reach >= need) {
    reach *= 0.5f;
    ++level;
  }
  return level;
}

/*
 * The layers that are gathered: all 16 of them, or the 4 of every second pixel
 * in x and y at half resolution (hbil_config.sampling.resolution).
 */
static inline hbil_int hbil_is_gathered(hbil_int layer, hbil_int gathered) {
  hbil_int x = layer & 3, y = layer >> 2;
  return gathered == HBIL_LAYERS || !((x | y) & 1);
}
/* The i-th of them, 0..gathered-1. */
static inline hbil_int hbil_gathered_layer(hbil_int i, hbil_int gathered) {
  return gathered == HBIL_LAYERS ? i : 8 * (i >> 1) + 2 * (i & 1);
}

/* If the gather leaves out the pixel, the nearest surfaces have at least this
 * weight: too little to count unless no neighbour shows the same surface. */
#define HBIL_LEAST_WEIGHT 1e-4f
/* A surface that no gathered one is next to is open: AO 1 has this weight, far
 * below HBIL_LEAST_WEIGHT times the smallest weight of a slice, 1e-6. */
#define HBIL_ALONE_WEIGHT 1e-16f

/*
 * Where a pixel stands in the pattern.  At full resolution the pattern has 4x4
 * pixels, one of each layer.  At half resolution it has 4x8, which are 2x4 that
 * are gathered: those of a layer take turns, row by row.
 */
static inline hbil_int hbil_site(hbil_int layer, hbil_int row,
                                 hbil_int gathered) {
  return gathered == HBIL_LAYERS ? layer : layer + 16 * (row & 1);
}
/* hbil_sites(): how many there are, which the table of steps has rows for;
 * hbil_gathered_sites(): how many of them are gathered. */
static inline hbil_int hbil_sites(hbil_int gathered) {
  return gathered == HBIL_LAYERS ? 16 : 32;
}
static inline hbil_int hbil_gathered_sites(hbil_int gathered) {
  return gathered == HBIL_LAYERS ? 16 : 8;
}

/* 4x4 Bayer matrix: interleaves the bits of (x xor y) and y, most significant
 * last.  At half resolution, the gathered layers have the lowest numbers. */
static inline hbil_int hbil_bayer(hbil_int x, hbil_int y) {
  hbil_int v = x ^ y;
  return ((v & 1) << 3) | ((y & 1) << 2) | (v & 2) | ((y & 2) >> 1);
}

/*
 * Order in which the gathered pixels of the pattern take as many directions
 * (neighbours get directions far apart), and in which they take as many shifts
 * along the slice (the same matrix, mirrored and turned, so that direction and
 * shift are not tied to each other).
 */
static inline hbil_int hbil_direction_order(hbil_int site, hbil_int gathered) {
  hbil_int order = hbil_bayer(site & 3, site >> 2 & 3);
  return gathered == HBIL_LAYERS ? order : ((order & 3) << 1) | (site >> 4);
}
static inline hbil_int hbil_shift_order(hbil_int site, hbil_int gathered) {
  hbil_int order = hbil_bayer(3 - (site >> 2 & 3), site & 3) * 5 + 3;
  return gathered == HBIL_LAYERS ? order & 15
                                 : ((order & 3) << 1) | (site >> 4);
}

/* The orders as numbers between 0 and 1 that are 1/2 on average. */
static inline hbil_float hbil_direction_share(hbil_int site,
                                              hbil_int gathered) {
  return ((hbil_float)hbil_direction_order(site, gathered) + 0.5f) /
         (hbil_float)hbil_gathered_sites(gathered);
}
static inline hbil_float hbil_shift_share(hbil_int site, hbil_int gathered) {
  return ((hbil_float)hbil_shift_order(site, gathered) + 0.5f) /
         (hbil_float)hbil_gathered_sites(gathered);
}

/*
 * cos and sin of pi v for v in [0,1), by polynomials on |angle| <= pi/4 (error
 * below 1e-7), so that host and device agree to the last bit.
 */
static inline void hbil_cos_sin_pi(hbil_float v, hbil_float *c, hbil_float *s) {
  hbil_int quarter = (hbil_int)HBIL_RINT(v * 2.0f); /* 0, 1, 2 */
  hbil_float a = HBIL_FMA((hbil_float)quarter, -0.5f, v) * 3.14159274f;
  hbil_float q = a * a;
  hbil_float p, r;
  p = HBIL_FMA(q, 2.75573192e-6f, -1.98412698e-4f); /* Taylor, 1/9!, 1/7! */
  p = HBIL_FMA(q, p, 8.33333333e-3f);
  p = HBIL_FMA(q, p, -1.66666667e-1f);
  p = HBIL_FMA(a * q, p, a);
  r = HBIL_FMA(q, 2.48015873e-5f, -1.38888889e-3f); /* 1/8!, 1/6! */
  r = HBIL_FMA(q, r, 4.16666667e-2f);
  r = HBIL_FMA(q, r, -0.5f);
  r = HBIL_FMA(q, r, 1.0f);
  *c = quarter == 0 ? r : quarter == 1 ? -p : -r;
  *s = quarter == 0 ? p : quarter == 1 ? r : -p;
}

/*
 * Direction u (unit, ray-slope space) of a slice at a site.  The half-slices
 * go along u and -u.  Over the gathered sites the directions are equally
 * spaced.
 */
static inline void hbil_slice_direction(hbil_int site, hbil_int slice,
                                        const hbil_pattern_args p,
                                        hbil_float *ux, hbil_float *uy) {
  hbil_float t = hbil_direction_share(site, p.gathered) + p.turn;
  t = t >= 1.0f ? t - 1.0f : t;
  hbil_cos_sin_pi(((hbil_float)slice + t) / (hbil_float)p.slices, ux, uy);
}

/*
 * Pixel offset of sample k (0..samples-1) along (ux, uy) (already negated for
 * the second half-slice).
 *
 * With t = (k + shift)/samples in (0,1), the distance is reach * t /
 * (1 + growth (1-t)): equal steps for growth 0, steps growing from
 * 1/(1+growth) to (1+growth) times the mean otherwise.  No two samples of a
 * half-slice share a pixel: sample k is at least k+1 grid steps away.
 */
static inline void hbil_sample_offset(hbil_int site, hbil_int k, hbil_int level,
                                      hbil_float ux, hbil_float uy,
                                      const hbil_view_args v,
                                      const hbil_pattern_args p, hbil_int *x,
                                      hbil_int *y) {
  hbil_float grid = (hbil_float)p.grid;
  /* pixels per unit of slope along u, and the larger of its components */
  hbil_float px = ux * v.fx, py = uy * v.fy;
  hbil_float ax = HBIL_FABS(px), ay = HBIL_FABS(py);
  hbil_float major = ax > ay ? ax : ay;
  /* no pixel of the image is farther along u than this */
  hbil_float to_x =
      (hbil_float)v.width / (ax > 1e-6f * major ? ax : 1e-6f * major);
  hbil_float to_y =
      (hbil_float)v.height / (ay > 1e-6f * major ? ay : 1e-6f * major);
  hbil_float edge = to_x < to_y ? to_x : to_y;
  hbil_float reach = p.reach;
  hbil_float t, least, d;
  hbil_int i;
  for (i = 0; i < level; ++i)
    reach *= 0.5f;
  reach = reach < edge ? reach : edge;
  t = hbil_shift_share(site, p.gathered) + p.shift;
  t = t >= 1.0f ? t - 1.0f : t;
  t = ((hbil_float)k + t) / (hbil_float)p.steps;
  d = reach * t / HBIL_FMA(p.growth, 1.0f - t, 1.0f);
  least = (hbil_float)(k + 1) * grid / major;
  d = d > least ? d : least;
  *x = (hbil_int)HBIL_RINT(d * px / grid) * p.grid;
  *y = (hbil_int)HBIL_RINT(d * py / grid) * p.grid;
}

/* Pixels that an offset spans along its longer axis. */
static inline hbil_int hbil_offset_length(hbil_int x, hbil_int y) {
  /* absolute values of floats: those of ints are an intrinsic that oclgrind
   * doesn't know */
  x = (hbil_int)HBIL_FABS((hbil_float)x);
  y = (hbil_int)HBIL_FABS((hbil_float)y);
  return x > y ? x : y;
}

/*
 * What sample k of finite thickness stands for: its step.  If n pixels lie
 * between two samples, the step of each extends 0.6 n pixels towards the
 * other.  Before the first sample, the receiver takes the place of a sample;
 * the last step extends as far outwards as inwards.
 *
 * near, far: how far the step extends inwards and outwards, over the sample's
 * distance.  beside: how many pixels of the step lie on either side of the
 * sample, on average.  slope_x, slope_y: the offset from the sample to the
 * pixel behind it that tells the slope of its surface, a quarter of the step
 * away and at least one pixel.  The pixel before it lies at the opposite
 * offset, and never beyond the receiver.  With nearer pixels, rounding of
 * depths makes the slope less exact; farther ones lie on other surfaces more
 * often.
 */
typedef struct hbil_extent {
  hbil_float near, far, beside;
  hbil_int slope_x, slope_y;
} hbil_extent;

/* Factor on how far a step extends towards its neighbours; 1: half-way.  With 1
 * too much would stay open, as things between the samples are missed
 * (doc/measurements.md, "How defaults were chosen"). */
#define HBIL_STEP_WIDENING 1.2f

/* How far a step extends into the pixels between two samples that are `gap`
 * pixels apart, over the distance of one of them, `length` pixels. */
static inline hbil_float hbil_reach_into_gap(hbil_int gap, hbil_int length) {
  return gap > 1 ? 0.5f * HBIL_STEP_WIDENING * (hbil_float)(gap - 1) /
                       (hbil_float)length
                 : 0.0f;
}

/* (x, y): the sample's offset, `length` pixels; before, after: the lengths of
 * the samples before and behind it; 0 before the first one, its own after the
 * last one. */
static inline hbil_extent hbil_sample_extent(hbil_int x, hbil_int y, hbil_int k,
                                             hbil_int samples, hbil_int before,
                                             hbil_int length, hbil_int after) {
  hbil_int gap = length - before;
  hbil_int next_gap = k + 1 < samples ? after - length : gap;
  hbil_extent e;
  /* from half-way to half-way a step is (gap + next_gap) / 2 wide */
  hbil_int quarter = (gap + next_gap + 4) / 8;
  quarter = quarter < 1 ? 1 : quarter < length ? quarter : length;
  e.near = hbil_reach_into_gap(gap, length);
  e.far = hbil_reach_into_gap(next_gap, length);
  e.beside = 0.5f * (hbil_float)length * (e.near + e.far);
  /* x * quarter / length and y * quarter / length, rounded to the nearest */
  e.slope_x = (2 * x * quarter + (x < 0 ? -length : length)) / (2 * length);
  e.slope_y = (2 * y * quarter + (y < 0 ? -length : length)) / (2 * length);
  return e;
}

#endif
