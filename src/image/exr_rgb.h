/*
 * Colour images in OpenEXR files, for environment maps.
 *
 * OpenImageIO reads these too, but a damaged header of a few bytes makes it
 * take gigabytes and minutes.
 */
#ifndef HBIL_IMAGE_EXR_RGB_H
#define HBIL_IMAGE_EXR_RGB_H

#include "image/error.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The largest colour image that is read: 16384 x 8192 pixels. */
enum { RGB_MAX_PIXELS = 1 << 27 };

/* Reads the first R, G and B of the same layer, else Y, else the only channel,
 * as width*height interleaved RGB floats, which the caller frees. */
int exr_read_rgb(const char *path, float **rgb, uint32_t *width,
                 uint32_t *height, image_error *error);

#ifdef __cplusplus
}
#endif

#endif
