/*
 * Finite thickness in sectors.
 *
 * An occluder that ends hides the angles between its front and its back, and
 * lets light pass behind it; one horizon cannot describe that.  The kernels
 * divide a half-slice into HBIL_SECTORS sectors of equal measure A, one bit
 * each.  An angle a lies at the sector position
 *   A(a) / A(tangent plane) HBIL_SECTORS + dither,
 * rounded down, and an occluder sets the bits between the positions of its
 * front and its back.  The dither is different at each site of the pattern
 * (hbil_site()), so that the mean over all of them has no steps.
 */
#include "exact/sectors.h"

#include "shared.h"

sectors exact_sectors(const half_slice *h, double dither) {
  const sectors s = {0u, dither, exact_bent_integral(h, h->start)};
  return s;
}

/* The bits of the sectors between wo and an angle. */
static unsigned bits_up_to(const sectors *s, const half_slice *h, angle a) {
  const double position =
      exact_measure(h, a) / fmax(h->whole, 1e-6) * HBIL_SECTORS + s->dither;
  return (1u << (int)clamp(position, 0.0, HBIL_SECTORS)) - 1u;
}

double exact_sectors_cover(sectors *s, const half_slice *h, angle front,
                           angle back) {
  unsigned fresh =
      bits_up_to(s, h, back) & ~bits_up_to(s, h, front) & ~s->covered;
  int count = 0;
  s->covered |= fresh;
  for (; fresh; fresh &= fresh - 1)
    ++count;
  const double share = h->whole * count / HBIL_SECTORS;
  /* The newly covered part is taken to have the interval's mean direction. */
  const double part =
      share / fmax(exact_measure(h, back) - exact_measure(h, front), 1e-5);
  s->bent = vec_add(s->bent, part, exact_bent_integral(h, front));
  s->bent = vec_add(s->bent, -part, exact_bent_integral(h, back));
  return share;
}
