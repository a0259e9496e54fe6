/*
 * The samples that the kernels take along a half-slice.
 *
 * Direction and offsets of the samples come from sampling_pattern.h, which
 * host and kernels compile from the same text, so both look at the same pixels.
 * They depend on the pixel's layer, its position modulo 4 in x and y, and,
 * where the radius is limited, on a level: each level halves the reach.  The
 * level follows from the nearest surface among HBIL_SPAN pixels of a layer row,
 * because the kernels take those together.
 */
#include "exact/samples.h"
#include "lib/sampling_pattern.h"

#include "exact/passes.h"
#include "exact/planes.h"
#include "exact/settings.h"

hbil_pattern_args exact_pattern(const exact_frame *frame) {
  const hbil_config *c = frame->config;
  const hbil_view_args v = exact_view(c, &frame->camera);
  hbil_pattern_args p;
  p.slices = (int)c->sampling.slices;
  p.steps = (int)exact_steps(c);
  p.levels = isinf(exact_radius(c)) ? 1 : HBIL_MAX_LEVELS;
  p.grid = c->sampling.sample_grid == HBIL_GRID_SAME_LAYER ? HBIL_SIDE : 1;
  p.reach = fmaxf((float)v.width / v.fx, (float)v.height / v.fy);
  p.growth = c->sampling.step_growth;
  p.gathered = exact_gathered_layers(c);
  /* Both run through (0,1) evenly for any number of frames. */
  p.turn = (float)fmod(frame->frame_index * 0.6457513, 1.0);
  p.shift = (float)fmod(frame->frame_index * 0.7548777, 1.0);
  return p;
}

static int level_at(const receiver *r, const hbil_pattern_args *pattern) {
  const int span = HBIL_SIDE * HBIL_SPAN; /* in pixels of the picture */
  const int first = r->x % HBIL_SIDE + r->x / span * span;
  float nearest = 0.0f;
  if (pattern->levels == 1)
    return 0;
  for (int i = 0; i < HBIL_SPAN; ++i) {
    const int x = first + i * HBIL_SIDE;
    if (x < r->split->width)
      nearest =
          fmaxf(nearest, (float)*exact_at(r->split, HBIL_SPLIT_W, x, r->y));
  }
  if (exact_is_orthographic(r->frame->config))
    nearest = 1.0f;
  return hbil_level(pattern->reach,
                    (float)exact_radius(r->frame->config) * nearest,
                    pattern->levels);
}

sampling exact_sampling(const receiver *r) {
  sampling how;
  how.view = exact_view(r->frame->config, &r->frame->camera);
  how.pattern = exact_pattern(r->frame);
  how.site = exact_site(r->frame->config, r->x, r->y);
  how.level = level_at(r, &how.pattern);
  return how;
}

void exact_slice_direction(const sampling *how, int slice, double *ux,
                           double *uy) {
  float x, y;
  hbil_slice_direction(how->site, slice, how->pattern, &x, &y);
  *ux = (double)x;
  *uy = (double)y;
}

void exact_visit_samples(const receiver *r, const sampling *how, march *m) {
  const float ux = (float)m->h.u.x, uy = (float)m->h.u.y;
  const int samples = how->pattern.steps;
  int x, y, before = 0;
  hbil_sample_offset(how->site, 0, how->level, ux, uy, how->view, how->pattern,
                     &x, &y);
  for (int k = 0; k < samples; ++k) {
    int next_x = x, next_y = y;
    if (k + 1 < samples)
      hbil_sample_offset(how->site, k + 1, how->level, ux, uy, how->view,
                         how->pattern, &next_x, &next_y);
    const int length = hbil_offset_length(x, y);
    const int after = hbil_offset_length(next_x, next_y);
    const hbil_extent step =
        hbil_sample_extent(x, y, k, samples, before, length, after);
    if (exact_planes_contain(r->split, r->x + x, r->y + y))
      exact_march_visit(r, m, r->x + x, r->y + y, &step);
    before = length;
    x = next_x;
    y = next_y;
  }
}
