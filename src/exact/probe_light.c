/*
 * What the radiance cache knows of a pixel's open directions.
 *
 * These are a cone about the bent normal b, as for the far field.  With
 * t = cos alpha, the cosine-weighted integrals of 1 and of the direction over
 * it, over pi, are AO = 1 - t^2 and 2/3 (1 - t^3) b.  Their quotient is the
 * mean direction d b, and the mean of an order-1 function f is f0 + d b.f.
 *
 * Of the probes around a pixel, those count that are on its surface and see
 * what it sees.
 */
#include "exact/cache.h"
#include "exact/camera.h"
#include "exact/input.h"

/* Where less than this share of the rays counts, probes say nothing. */
#define LEAST_SHARE 1e-3

void exact_open_mean(double ao, vec3 bent, double mean[4]) {
  const double t = sqrt(fmax(0.0, 1.0 - ao));
  /* (1 - t^3) / (1 - t^2), which is 3/2 at t = 1 */
  const double d = 2.0 / 3.0 * (1.0 + t + t * t) / (1.0 + t);
  mean[0] = 1.0;
  mean[1] = d * bent.x;
  mean[2] = d * bent.y;
  mean[3] = d * bent.z;
}

static double mean_of(const double f[4], const double mean[4]) {
  return f[0] * mean[0] + f[1] * mean[1] + f[2] * mean[2] + f[3] * mean[3];
}

double exact_probe_tent(const exact_probes *probes, int i, double across,
                        double down, double reach) {
  const int line = i / probes->columns;
  const double x = i % probes->columns + (line % 2 ? 0.5 : 0.0);
  return fmax(0.0, 1.0 - fabs(across - x) / reach) *
         fmax(0.0, 1.0 - fabs(down - line / 2.0) / reach);
}

double exact_probe_corner(const exact_probes *probes, int i, int x, int y) {
  const double size = probes->spacing;
  return probes->probe[i].valid
             ? exact_probe_tent(probes, i, x / size, y / size, 1.0)
             : 0.0;
}

/* The addend: probes of other surfaces are better than none. */
double exact_probe_weight(const exact_frame *frame, const exact_probe *probe,
                          vec3 p, vec3 bent) {
  const double unit = exact_depth_unit(frame->config, &frame->camera, p.z);
  const double off = vec_dot(vec_add(p, -1.0, probe->place), probe->normal) /
                     ((double)HBIL_PROBE_TOLERANCE * unit);
  const double facing = fmax(0.0, vec_dot(bent, probe->normal));
  return pow(facing, 8.0) / pow(1.0 + off * off, 2.0) + 1e-6;
}

exact_probe_light exact_light_of_probes(const exact_frame *frame, int x, int y,
                                        double ao, vec3 bent) {
  const exact_probes *probes = frame->probes;
  exact_probe_light light = {.share = 0.0};
  double mean[4], total = 0.0, known = 0.0, unknown = 0.0;
  double sent[3] = {0.0, 0.0, 0.0}, unseen = 0.0;
  double told[4] = {0.0, 0.0, 0.0, 0.0};
  if (!probes || exact_is_sky(frame, x, y))
    return light;
  const vec3 p = exact_point(frame, x, y, exact_planar_depth(frame, x, y));
  exact_open_mean(ao, bent, mean);
  for (int i = 0; i < probes->count; ++i) {
    const exact_probe *probe = probes->probe + i;
    const double corner = exact_probe_corner(probes, i, x, y);
    if (!(corner > 0.0))
      continue;
    const double weight = corner * exact_probe_weight(frame, probe, p, bent);
    total += weight;
    known += weight * mean_of(probe->known, mean);
    unknown += weight * mean_of(probe->unknown, mean);
    for (int c = 0; c < 3; ++c)
      sent[c] += weight * mean_of(probe->light[c], mean);
    unseen += weight * probe->unknown[0];
    for (int c = 0; c < 4; ++c)
      told[c] += weight * probe->guess[c];
  }
  if (unseen > LEAST_SHARE * total) {
    const double scale = (double)HBIL_AREA_WEIGHT / unseen;
    light.guess_share = scale * told[3];
    for (int c = 0; c < 3; ++c)
      light.guess[c] = exact_exposure(frame) * scale * told[c];
  }
  /* order 1 may be negative where little counts */
  known = fmax(0.0, known);
  const double all = known + fmax(0.0, unknown);
  if (!(all > LEAST_SHARE * total))
    return light;
  light.share = known / all;
  for (int c = 0; c < 3; ++c)
    light.light[c] = exact_exposure(frame) * ao * fmax(0.0, sent[c]) / all;
  return light;
}
