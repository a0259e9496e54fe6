/*
 * By what factors the last frame's light has fallen, as far as the radiance
 * cache knows (kernels/lib/fallen_light.clh): for the light that frames hand on
 * (split) and for that of slices that they share (gather).
 */
#ifndef HBIL_FALL_H
#define HBIL_FALL_H

#include "lib/cache_args.h"
#include "plan.h"

hbil_fall_args fall_args(const hbil_plan *plan, const hbil_frame *frame);

/* The factors; NULL without a cache. */
cl_mem fall_ratios(const hbil_frame *frame);

#endif
