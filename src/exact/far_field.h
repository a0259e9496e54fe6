/* Light from directions that nothing on the screen blocks. */
#ifndef HBIL_EXACT_FAR_FIELD_H
#define HBIL_EXACT_FAR_FIELD_H

#include "exact/exact.h"
#include "exact/vector.h"

/* Irradiance through a pixel's open share `ao`, about the view-space bent
 * normal (0: none). */
double exact_far_irradiance(const exact_frame *frame, int channel, int x, int y,
                            double ao, vec3 bent, double near_irradiance);
/* hbil_frame's, of HBIL_FAR_FRAME; else 0. */
double exact_sky_share(const exact_frame *frame);
/* Direct light over that of a whole hemisphere of the sky that it contains, the
 * largest quotient of the channels; 0 without such a sky. */
double exact_sky_light(const exact_frame *frame, int x, int y);
/* The part of the open directions, a share `ao` of the hemisphere, that such
 * light shows the sky not to light.  lit: 0 if the sky explains the light, up
 * to 1 if something else shines there. */
double exact_unlit_part(double sky_light, double ao, double *lit);
/* The part of the open share `ao` whose light is estimated; 0 unless the far
 * field is HBIL_FAR_FRAME. */
double exact_unlit_share(const exact_frame *frame, int x, int y, double ao);
/* Radiance of a sky pixel. */
double exact_sky_radiance(const exact_frame *frame, int channel, int x, int y);

#endif
