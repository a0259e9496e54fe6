/* Light from directions that nothing on the screen blocks. */
#ifndef HBIL_EXACT_FAR_FIELD_H
#define HBIL_EXACT_FAR_FIELD_H

#include "exact/exact.h"
#include "exact/vector.h"

/* Irradiance through a pixel's open share `ao`, about the view-space bent
 * normal (0: none). */
double exact_far_irradiance(const exact_frame *frame, int channel, int x, int y,
                            double ao, vec3 bent, double near_irradiance);
/* Radiance of a sky pixel. */
double exact_sky_radiance(const exact_frame *frame, int channel, int x, int y);

#endif
