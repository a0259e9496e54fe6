/*
 * The part of a half-slice that occluders hide.
 *
 * Occluders of infinite thickness hide everything between them and the tangent
 * plane.  So one angle, the horizon, describes what is hidden, and only a
 * sample that lies above the highest one so far hides more.  Its threshold
 * rises with the horizon; for finite thickness, where a lower sample may still
 * hide an open gap, the threshold stays at the rounding error.
 */
#include "exact/coverage.h"

#include "exact/lobe.h"
#include "exact/settings.h"

#include <string.h>

coverage_kind exact_coverage_kind(const hbil_config *config,
                                  coverage_kind finite) {
  return isinf(config->model.thickness) &&
                 isinf(exact_relative_thickness(config))
             ? COVERAGE_HORIZON
             : finite;
}

coverage exact_coverage(coverage_kind kind, const half_slice *h,
                        double threshold, double dither, interval *list) {
  coverage c;
  memset(&c, 0, sizeof(c));
  c.kind = kind;
  c.threshold = threshold;
  c.horizon.top = h->start;
  c.horizon.measure = h->whole;
  c.sectors = exact_sectors(h, dither);
  c.intervals.list = list;
  return c;
}

static double raise_horizon(coverage *c, const half_slice *h, double distance,
                            double excess) {
  const double before = c->horizon.measure;
  const angle top = c->horizon.top;
  c->horizon.top = exact_horizon(h, distance, excess);
  c->horizon.measure = exact_measure(h, c->horizon.top);
  c->threshold = excess;
  if (c->glossy)
    c->lobe =
        exact_lobe_integral(h, top) - exact_lobe_integral(h, c->horizon.top);
  return before - c->horizon.measure;
}

double exact_cover(coverage *c, const half_slice *h, double distance,
                   double front, double back) {
  if (c->kind == COVERAGE_HORIZON)
    return raise_horizon(c, h, distance, front);
  if (c->kind == COVERAGE_INTERVALS)
    return exact_intervals_cover(&c->intervals, h, distance, front, back);
  const angle high = exact_horizon(h, distance, front);
  const angle low = exact_horizon(h, distance, back);
  const double fresh = exact_sectors_cover(&c->sectors, h, high, low);
  /* as much of the interval's lobe as of its measure */
  if (c->glossy)
    c->lobe = fresh /
              fmax(exact_measure(h, low) - exact_measure(h, high), 1e-5) *
              (exact_lobe_integral(h, low) - exact_lobe_integral(h, high));
  return fresh;
}

vec3 exact_open_bent(const coverage *c, const half_slice *h) {
  switch (c->kind) {
  case COVERAGE_SECTORS:
    return c->sectors.bent;
  case COVERAGE_INTERVALS:
    return exact_intervals_bent(&c->intervals, h);
  case COVERAGE_HORIZON:
    break;
  }
  return exact_bent_integral(h, c->horizon.top);
}
