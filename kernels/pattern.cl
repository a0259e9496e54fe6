/*
 * pattern: the table of steps that the gather walks, one entry per level,
 * site, half-slice and sample: a few thousand entries.  It is computed again
 * when the camera or hbil_frame.frame_index changes.
 *
 * Entry k of a half-slice has the index
 *   ((level * sites + site) * 2 slices + half) * (steps + 1) + k
 * where half = 2 slice + (0: along u, 1: along -u).  Entry 0 has only the
 * direction, in ux and uy; the samples follow.
 *
 * Launch: x = level * sites + site (hbil_site()), y = half-slice.
 */
#include "lib/sampling_pattern.h"

/* Floats from x + y * row to the pixel that lies (x, y) from that pixel of the
 * layer, which may be in another layer. */
static inline int offset_of(const hbil_layer_args layout, int layer, int x,
                            int y) {
  const int to_x = (layer & 3) + x, to_y = (layer >> 2) + y;
  return (int)(((uint)(to_y & 3) * 4u + (uint)(to_x & 3)) * layout.layer +
               layout.origin) +
         (to_y >> 2) * (int)layout.row + (to_x >> 2);
}

/* |e| of an offset in pixels, in units of ray slope. */
static inline float length_of(const hbil_view_args view, int x, int y) {
  const float ex = (float)x * view.inv_fx, ey = (float)y * view.inv_fy;
  return sqrt(fma(ex, ex, ey * ey));
}

kernel void make_pattern(const hbil_make_pattern_args args,
                         global hbil_step *steps) {
  const hbil_view_args view = args.view;
  const hbil_pattern_args pattern = args.pattern;
  const hbil_layer_args layout = args.split;
  const int sites = hbil_sites(pattern.gathered);
  const int level = (int)get_global_id(0) / sites;
  const int site = (int)get_global_id(0) % sites, layer = site & 15;
  const int half_slice = (int)get_global_id(1);
  if (level >= pattern.levels || half_slice >= 2 * pattern.slices)
    return;
  float ux, uy;
  hbil_slice_direction(site, half_slice >> 1, pattern, &ux, &uy);
  if (half_slice & 1) {
    ux = -ux;
    uy = -uy;
  }
  steps += (get_global_id(0) * (uint)(2 * pattern.slices) + (uint)half_slice) *
           (uint)(pattern.steps + 1);
  /* the receiver itself, which is what comes before the first sample */
  hbil_step direction = {0};
  direction.ux = ux;
  direction.uy = uy;
  *steps++ = direction;
  int x, y, before = 0;
  hbil_sample_offset(site, 0, level, ux, uy, view, pattern, &x, &y);
  for (int k = 0; k < pattern.steps; ++k) {
    int next_x = x, next_y = y;
    if (k + 1 < pattern.steps)
      hbil_sample_offset(site, k + 1, level, ux, uy, view, pattern, &next_x,
                         &next_y);
    hbil_step step;
    step.dx = ((layer & 3) + x) >> 2;
    step.dy = ((layer >> 2) + y) >> 2;
    step.offset = offset_of(layout, layer, x, y);
    step.ex = (float)x * view.inv_fx;
    step.ey = (float)y * view.inv_fy;
    const float e = length_of(view, x, y);
    step.inv_e = 1.0f / e;
    step.ux = step.ex * step.inv_e;
    step.uy = step.ey * step.inv_e;
    const int length = hbil_offset_length(x, y);
    const int after = hbil_offset_length(next_x, next_y);
    step.subsets = hbil_sample_subsets(site, pattern.gathered, k, pattern.steps,
                                       before, after);
    /* what follows the last sample is taken to be as far as what is before */
    const int gap = length - before;
    const int next_gap = k + 1 < pattern.steps ? after - length : gap;
    const float near = hbil_half_gap(gap, length) * e;
    const float far = hbil_half_gap(next_gap, length) * e;
    int slope_x, slope_y;
    hbil_slope_offset(x, y, length, gap + next_gap, &slope_x, &slope_y);
    const float per_slope = 1.0f / fma((float)slope_x * view.inv_fx, step.ux,
                                       (float)slope_y * view.inv_fy * step.uy);
    step.nearer = offset_of(layout, layer, x - slope_x, y - slope_y);
    step.farther = offset_of(layout, layer, x + slope_x, y + slope_y);
    step.farther_dx = ((layer & 3) + x + slope_x) >> 2;
    step.farther_dy = ((layer >> 2) + y + slope_y) >> 2;
    step.to_near = near * per_slope;
    step.to_far = far * per_slope;
    step.inv_near = 1.0f / (e - near);
    step.inv_far = 1.0f / (e + far);
    steps[k] = step;
    before = length;
    x = next_x;
    y = next_y;
  }
}
