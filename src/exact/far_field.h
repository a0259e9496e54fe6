/* Light from directions that nothing on the screen blocks. */
#ifndef HBIL_EXACT_FAR_FIELD_H
#define HBIL_EXACT_FAR_FIELD_H

#include "exact/cache.h"
#include "exact/exact.h"
#include "exact/vector.h"

/* The share of the hemisphere whose far light is estimated, of a pixel's open
 * share `ao`; cached: what a radiance cache knows of that. */
double exact_estimated_share(const exact_frame *frame, int x, int y, double ao,
                             const exact_probe_light *cached);
/* Irradiance through a pixel's open share `ao`, about the view-space bent
 * normal (0: none).  What the radiance cache knows counts as it is; the other
 * open directions get what they get without it. */
double exact_far_irradiance(const exact_frame *frame, int channel, int x, int y,
                            double ao, vec3 bent, double near_irradiance,
                            const exact_probe_light *cached);
/* Radiance of a sky pixel. */
double exact_sky_radiance(const exact_frame *frame, int channel, int x, int y);

#endif
