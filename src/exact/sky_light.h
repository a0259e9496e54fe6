/* How much of the open directions the sky lights, told by direct light. */
#ifndef HBIL_EXACT_SKY_LIGHT_H
#define HBIL_EXACT_SKY_LIGHT_H

#include "exact/exact.h"

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

#endif
