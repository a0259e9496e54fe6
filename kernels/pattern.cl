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
 * Launch: x = level * sites + site (hbil_site()), y = half-slice, z = entry.
 */
#include "lib/sampling_pattern.h"

/* Writes the offset (dx, dy) within the layer, in layer pixels, to the pixel
 * that lies (x, y) from a pixel of `layer`.  It may be in another layer.
 * Returns the floats to it from x + y * row. */
static inline int offset_of(const hbil_layer_args layout, int layer, int x,
                            int y, int *dx, int *dy) {
  const int to_x = (layer & 3) + x, to_y = (layer >> 2) + y;
  *dx = to_x >> 2;
  *dy = to_y >> 2;
  return (int)(((uint)(to_y & 3) * 4u + (uint)(to_x & 3)) * layout.layer +
               layout.origin + (uint)*dy * layout.row + (uint)*dx);
}

/* The direction of a half-slice. */
static inline hbil_step direction_step(float ux, float uy) {
  hbil_step step = {0};
  step.ux = ux;
  step.uy = uy;
  return step;
}

static inline float length_of(float x, float y) {
  return sqrt(fma(x, x, y * y));
}

/* An end of a step, `slopes` times (slope_x, slope_y) farther than its sample
 * at (ex, ey). */
static inline void end_step(float ex, float ey, float slopes,
                            const hbil_step *step, float *gain, float *reach) {
  const float e =
      length_of(fma(slopes, step->slope_x, ex), fma(slopes, step->slope_y, ey));
  *gain = (step->e - e) / e;
  *reach = slopes / e;
}

/* Sample k of a half-slice. */
static inline hbil_step sample_step(const hbil_make_pattern_args args,
                                    int level, int site, int k, float ux,
                                    float uy) {
  const hbil_view_args view = args.view;
  const hbil_pattern_args pattern = args.pattern;
  const hbil_layer_args layout = args.split;
  const int layer = site & 15;
  int x, y, x_before = 0, y_before = 0;
  hbil_sample_offset(site, k, level, ux, uy, view, pattern, &x, &y);
  int next_x = x, next_y = y;
  if (k > 0)
    hbil_sample_offset(site, k - 1, level, ux, uy, view, pattern, &x_before,
                       &y_before);
  if (k + 1 < pattern.steps)
    hbil_sample_offset(site, k + 1, level, ux, uy, view, pattern, &next_x,
                       &next_y);
  int dx, dy, nearer_dx, nearer_dy, farther_dx, farther_dy;
  hbil_step step = {0};
  step.offset = offset_of(layout, layer, x, y, &dx, &dy);
  step.dx = (short)dx;
  step.dy = (short)dy;
  const float ex = (float)x * view.inv_fx, ey = (float)y * view.inv_fy;
  step.e = length_of(ex, ey);
  step.inv_e = 1.0f / step.e;
  step.ux = ex * step.inv_e;
  step.uy = ey * step.inv_e;
  const int before = k > 0 ? hbil_offset_length(x_before, y_before) : 0;
  const int length = hbil_offset_length(x, y);
  const int after = hbil_offset_length(next_x, next_y);
  const hbil_extent extent =
      hbil_sample_extent(x, y, k, pattern.steps, before, length, after);
  const int slope_x = extent.slope_x, slope_y = extent.slope_y;
  step.slope_x = (float)slope_x * view.inv_fx;
  step.slope_y = (float)slope_y * view.inv_fy;
  const float slopes =
      step.e / fma(step.slope_x, step.ux, step.slope_y * step.uy);
  /* the nearer pixel lies in the picture wherever the sample does */
  step.nearer = offset_of(layout, layer, x - slope_x, y - slope_y, &nearer_dx,
                          &nearer_dy);
  step.farther = offset_of(layout, layer, x + slope_x, y + slope_y, &farther_dx,
                           &farther_dy);
  step.farther_dx = (short)farther_dx;
  step.farther_dy = (short)farther_dy;
  end_step(ex, ey, -extent.near * slopes, &step, &step.near_gain,
           &step.near_reach);
  end_step(ex, ey, extent.far * slopes, &step, &step.far_gain, &step.far_reach);
  step.beside = extent.beside;
  return step;
}

kernel void make_pattern(const hbil_make_pattern_args args,
                         global hbil_step *steps) {
  const hbil_pattern_args pattern = args.pattern;
  const int sites = hbil_sites(pattern.gathered);
  const int level = (int)get_global_id(0) / sites;
  const int site = (int)get_global_id(0) % sites;
  const int half_slice = (int)get_global_id(1), entry = (int)get_global_id(2);
  if (level >= pattern.levels || half_slice >= 2 * pattern.slices ||
      entry > pattern.steps)
    return;
  float ux, uy;
  hbil_slice_direction(site, half_slice >> 1, pattern, &ux, &uy);
  if (half_slice & 1) {
    ux = -ux;
    uy = -uy;
  }
  steps += (get_global_id(0) * (uint)(2 * pattern.slices) + (uint)half_slice) *
           (uint)(pattern.steps + 1);
  steps[entry] = entry == 0 ? direction_step(ux, uy)
                            : sample_step(args, level, site, entry - 1, ux, uy);
}
