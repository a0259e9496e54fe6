/*
 * The lobe of a rough mirror.
 *
 * GGX of roughness alpha has the density 1 / (cos^2 m (alpha^2 - 1) + 1)^2 of
 * microfacets at the angle m from the normal.  Seen from above, the direction w
 * is reflected by those at half its angle from the reflected direction R, and
 * cos^2 m = (1 + R.w) / 2.  So the lobe about R is, up to a factor,
 *   1 / (1 + k (1 - R.w))^2,  k = (1 - alpha^2) / (2 alpha^2).
 * From the side it is narrower across the plane of reflection, by the cosine.
 * With k / cosine it has the same solid angle.
 *
 * In a half-slice R.w = r cos x with x = t - t0, where r and t0 are R's
 * projection onto the slice's plane.  With b = k r, a = 1 + k and
 * Q = a - b cos x,
 *   integral of sin x / Q^2 = -1 / (b Q)
 *   integral of cos x / Q^2 = (a sin x / Q + b I) / (a^2 - b^2)
 *   I = integral of 1 / Q
 *     = 2 / sqrt(a^2 - b^2) atan(sqrt((a + b) / (a - b)) tan(x / 2))
 * and sin t = sin x cos t0 + cos x sin t0.
 */
#include "exact/lobe.h"

#include "exact/vector.h"
#include "lib/glossy_args.h"

bool exact_is_glossy(const hbil_config *config) {
  return config->outputs.glossy.component != HBIL_NONE;
}

double exact_lobe(const hbil_config *config, double cosine) {
  const double alpha = pow((double)config->model.roughness, 2.0);
  return (1.0 - alpha * alpha) / (2.0 * alpha * alpha) *
         fmin(1.0 / cosine, (double)HBIL_LOBE_STEEPEST);
}

vec3 exact_reflected(vec3 normal, vec3 to_eye) {
  return vec_add(vec_scale(2.0 * vec_dot(normal, to_eye), normal), -1.0,
                 to_eye);
}

/* The part up to x = t - t0, without what doesn't depend on t. */
static double integral_to(double k, double r, double t0, double t) {
  const double turns = rint((t - t0) / (2.0 * PI));
  const double x = t - t0 - 2.0 * PI * turns;
  const double a = 1.0 + k, b = k * r, q = a - b * cos(x), d = a * a - b * b;
  const double inverse =
      2.0 / sqrt(d) *
      (atan(sqrt((a + b) / (a - b)) * tan(0.5 * x)) + PI * turns);
  /* -1 / (b Q) less -1 / (b a), which has no limit where b is 0 */
  const double sines = -cos(x) / (a * q);
  const double cosines = (a * sin(x) / q + b * inverse) / d;
  return cos(t0) * sines + sin(t0) * cosines;
}

double exact_lobe_integral(const half_slice *h, angle a) {
  const vec3 wo = h->wo, n = h->point->normal;
  const vec3 reflected = exact_reflected(n, wo);
  const double along = vec_dot(reflected, h->along);
  const double across = vec_dot(reflected, wo);
  const double r = hypot(along, across), t0 = atan2(along, across);
  return integral_to(h->lobe, r, t0, a.theta) -
         integral_to(h->lobe, r, t0, 0.0);
}

void exact_lobe_bands(double k, double bands[3]) {
  enum { STEPS = 20000 };
  double sum[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < STEPS; ++i) {
    /* the share u of the lobe is nearer to its axis than this */
    const double u = (i + 0.5) / STEPS;
    const double c = 1.0 - 2.0 * u / (1.0 + 2.0 * k * (1.0 - u));
    sum[0] += 1.0;
    sum[1] += c;
    sum[2] += 1.5 * c * c - 0.5;
  }
  for (int i = 0; i < 3; ++i)
    bands[i] = sum[i] / STEPS;
}
