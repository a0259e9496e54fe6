/*
 * The estimate of unseen light: what surfaces that the screen does not show
 * send, guessed from those that it shows.
 *
 * A surfel with normal m counts for a receiver with normal n by how much they
 * face each other.  With c = -m.n the weight is the clamped cosine convolved
 * with itself, to order 2; a clamped cosine has the bands 1, 2/3, 1/4 relative
 * to the first, so that is 1 + 3 (2/3)^2 P1(c) + 5 (1/4)^2 P2(c) =
 * 1 + 4/3 P1 + 5/16 P2.  It is -0.02 at c = -1; 0.05 more makes it positive.
 * The addition theorem splits P1 and P2 into products of polynomials of n and
 * of -m, so nine sums over the frame are enough for every receiver.
 *
 * The mean is that of sqrt(L), squared: a few very bright pixels must not light
 * everything that is unseen.  It is never above the mean of L, so light that is
 * fed back loses energy at every bounce.
 */
#include "exact/estimate.h"

#include <string.h>

#include "exact/passes.h"
#include "exact/surface.h"

/* Those of the spherical harmonics of bands 0 to 2, without their factors. */
static void polynomials(vec3 d, double p[9]) {
  const double values[9] = {1.0,
                            d.y,
                            d.z,
                            d.x,
                            d.x * d.y,
                            d.y * d.z,
                            3.0 * d.z * d.z - 1.0,
                            d.z * d.x,
                            d.x * d.x - d.y * d.y};
  memcpy(p, values, sizeof(values));
}

static void add_surfel(exact_estimate *e, const exact_planes *split,
                       const surface *s, int x, int y) {
  double p[9];
  polynomials(vec_scale(-1.0, s->normal), p);
  for (int c = 0; c < 4; ++c) {
    const double light =
        c < 3 ? sqrt(*exact_at(split, HBIL_SPLIT_RED + c, x, y)) : 1.0;
    for (int i = 0; i < 9; ++i)
      e->sum[c][i] += light * p[i];
  }
}

void exact_estimate_frame(exact_frame *frame, const exact_planes *split) {
  memset(&frame->estimate, 0, sizeof(frame->estimate));
  for (int y = 0; y < split->height; y += HBIL_SIDE)
    for (int x = 0; x < split->width; x += HBIL_SIDE) {
      const surface s = exact_surface_at(frame, split, x, y);
      if (s.is)
        add_surfel(&frame->estimate, split, &s, x, y);
    }
}

/* The sum of weight(c) over the surfels.  Multiplied out in the polynomials,
 * 5/16 P2 has the factors 15/16, 5/64 (of 3zz-1) and 15/64 (of xx-yy). */
static double weighted_sum(const double sum[9], vec3 n) {
  const double factor[9] = {1.05,       4.0 / 3.0,   4.0 / 3.0,
                            4.0 / 3.0,  15.0 / 16,   15.0 / 16,
                            5.0 / 64.0, 15.0 / 16.0, 15.0 / 64.0};
  double p[9], total = 0.0;
  polynomials(n, p);
  for (int i = 0; i < 9; ++i)
    total += factor[i] * sum[i] * p[i];
  return total;
}

static double mean_radiance(const exact_frame *frame, int channel, vec3 n) {
  const double root = weighted_sum(frame->estimate.sum[channel], n);
  const double weight = weighted_sum(frame->estimate.sum[3], n);
  return weight > 0.0 ? root / weight * (root / weight) : 0.0;
}

double exact_mean_radiance(const exact_frame *frame, int channel,
                           const double normal[3]) {
  return mean_radiance(frame, channel, vec(normal[0], normal[1], normal[2]));
}

double exact_unseen_radiance(const exact_frame *frame, int channel, vec3 normal,
                             double seen, double share) {
  const double prior = (double)HBIL_UNSEEN_PRIOR;
  return (seen + prior * mean_radiance(frame, channel, normal)) /
         (share + prior);
}
