/* The lobe of a rough mirror. */
#ifndef HBIL_EXACT_LOBE_H
#define HBIL_EXACT_LOBE_H

#include "exact/slice.h"

/* Whether the settings ask for glossy light. */
bool exact_is_glossy(const hbil_config *config);
/* k of the lobe 1 / (1 + k (1 - cosine))^2 on a surface that is seen at a
 * cosine. */
double exact_lobe(const hbil_config *config, double cosine);
/* The direction that reflects to the eye; both of unit length, and so is the
 * result. */
vec3 exact_reflected(vec3 normal, vec3 to_eye);
/* Integral of the half-slice's lobe over the solid angle between wo and an
 * angle, per unit of azimuth. */
double exact_lobe_integral(const half_slice *h, angle a);
/* Means of the lobe's Legendre polynomials of order 0 to 2. */
void exact_lobe_bands(double k, double bands[3]);

#endif
