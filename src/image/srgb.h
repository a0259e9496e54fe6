/* The encoding of sRGB. */
#ifndef HBIL_IMAGE_SRGB_H
#define HBIL_IMAGE_SRGB_H

/* The value that an encoded one stands for.  The curve goes on above 1, and its
 * straight part below 0. */
float linear_of_srgb(float v);

#endif
