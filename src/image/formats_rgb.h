/*
 * Colour images of any format, for environment maps.
 */
#ifndef HBIL_IMAGE_FORMATS_RGB_H
#define HBIL_IMAGE_FORMATS_RGB_H

#include "image/error.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads OpenEXR, and every format that OpenImageIO reads, as width*height
 * interleaved RGB floats, which the caller frees.  Grey becomes R = G = B, and
 * alpha is dropped.  RGB_MAX_PIXELS (exr_rgb.h) is the largest size. */
int formats_read_rgb(const char *path, float **rgb, uint32_t *width,
                     uint32_t *height, image_error *error);

#ifdef __cplusplus
}
#endif

#endif
