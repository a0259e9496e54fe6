/* Light that the screen does not show. */
#ifndef HBIL_EXACT_ESTIMATE_H
#define HBIL_EXACT_ESTIMATE_H

#include "exact/exact.h"
#include "exact/vector.h"

/* The radiance that is assumed for directions whose light the screen does not
 * show: the mean of what the pixel does see, `shown` from a `share` of its
 * hemisphere, after all bounces, and of the frame's light towards `normal`,
 * which counts as HBIL_UNSEEN_PRIOR of a hemisphere.  What a radiance cache
 * knows counts like what the screen shows, but has all bounces already:
 * `cached` from a `cached_share`. */
double exact_unseen_radiance(const exact_frame *frame, int channel, vec3 normal,
                             double shown, double share, double cached,
                             double cached_share);

#endif
