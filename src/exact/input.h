/* A frame's inputs, with everything that cannot be used replaced by the rules
 * that hbil_config states.  channel: 0 red, 1 green, 2 blue. */
#ifndef HBIL_EXACT_INPUT_H
#define HBIL_EXACT_INPUT_H

#include "exact/exact.h"

/* The value as it is; the plane must be there. */
float exact_input(const exact_frame *frame, int plane, int x, int y);
/* The depth input in the camera's units. */
float exact_scaled_depth(const exact_frame *frame, int x, int y);
bool exact_is_sky(const exact_frame *frame, int x, int y);
/* Distance along the camera's axis; the pixel is not sky. */
double exact_planar_depth(const exact_frame *frame, int x, int y);
/* Light of an input plane; 0 where the plane is missing. */
double exact_light(const exact_frame *frame, int plane, int x, int y);
/* Diffuse reflectance, 0..1. */
double exact_albedo(const exact_frame *frame, int channel, int x, int y);
/* 1 - F0: the share of the light that enters the surface, 0..1. */
double exact_transmittance(const exact_frame *frame, int channel, int x, int y);
/* Irradiance of direct light. */
double exact_direct(const exact_frame *frame, int channel, int x, int y);
/* hbil_frame.exposure, 1 where it is 0. */
double exact_exposure(const exact_frame *frame);
/* The part of the emitted radiance that lights other surfaces. */
double exact_gathered_emission(const exact_frame *frame, int channel, int x,
                               int y);

#endif
