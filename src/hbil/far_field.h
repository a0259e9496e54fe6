/* Far light: spherical harmonics of order 2. */
#ifndef HBIL_FAR_FIELD_H
#define HBIL_FAR_FIELD_H

#include "hbil/hbil.h"
#include "names.h"
#include "shared.h"

/* A frame's environment as composite takes it. */
hbil_environment_args far_field_args(const hbil_config *config,
                                     const float environment[9][3]);

/* Divides an environment by the exposure that a caller gave with it. */
void remove_exposure(float exposure, float environment[9][3]);

/* The radiance of that far field, as coefficients of its polynomials; 0 without
 * one, and with HBIL_FAR_FRAME. */
hbil_environment_args far_radiance_args(hbil_far_field far_field,
                                        const float environment[9][3]);

#endif
