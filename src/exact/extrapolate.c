/*
 * Extrapolation: what lies between the samples of a half-slice.
 *
 * Samples miss occluders, so the open measure that N of them leave is too
 * large, by an amount that falls about as 1/N:  open(N) = open + c/N.  Every
 * other sample gives open(N/2) = open + 2c/N, so open = 2 open(N) - open(N/2)
 * (Richardson's extrapolation; as an estimator, the jackknife).  Either subset
 * of the samples serves, and the mean of both is taken.  The result stays
 * between nothing and the whole; covered measure and its light grow alike.
 */
#include "exact/extrapolate.h"

void exact_extrapolate(const receiver *r, const sampling *how, march *m) {
  const double whole = m->h.whole, open = whole - m->covered;
  double open_of_subset = 0.0;
  for (int subset = HBIL_SUBSET_EVEN; subset <= HBIL_SUBSET_ODD; ++subset) {
    march part = exact_march_begin(r, m->h.u.x, m->h.u.y);
    exact_visit_samples(r, how, subset, &part);
    open_of_subset += 0.5 * (part.h.whole - part.covered);
  }
  const double left = fmax(2.0 * open - open_of_subset, 0.0);
  const double more = m->covered > 0.0 ? (whole - left) / m->covered : 1.0;
  /* where all sectors are covered, a rounding error is left of open */
  m->open_scale = open > 1e-12 * whole ? left / open : 1.0;
  m->blocked *= more;
  m->got.unknown *= more;
  m->got.lobe_known *= more;
  for (int i = 0; i < 3; ++i) {
    m->got.light[i] *= more;
    m->got.lobe_light[i] *= more;
  }
}
