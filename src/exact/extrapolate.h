/* What lies between the samples of a half-slice. */
#ifndef HBIL_EXACT_EXTRAPOLATE_H
#define HBIL_EXACT_EXTRAPOLATE_H

#include "exact/samples.h"

/* Scales what a march found, after its last sample and before it ends, by what
 * half of the samples would have missed. */
void exact_extrapolate(const receiver *r, const sampling *how, march *m);

#endif
