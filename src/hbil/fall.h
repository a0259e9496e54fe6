/*
 * The factors by which light has fallen since the last frame, as far as the
 * radiance cache knows (kernels/lib/fallen_light.clh).  split multiplies the
 * light that the last frame hands on, gather that of slices which frames share.
 */
#ifndef HBIL_FALL_H
#define HBIL_FALL_H

#include "lib/cache_args.h"
#include "plan.h"

hbil_fall_args fall_args(const hbil_plan *plan, const hbil_frame *frame);

/* The factors; NULL without a cache. */
cl_mem fall_ratios(const hbil_frame *frame);

#endif
