/*
 * Colour images in EXR.  OpenImageIO, which reads all other formats, lets a
 * header of a few bytes ask for gigabytes and minutes.
 */
#ifndef HBIL_EXR_RGB_H
#define HBIL_EXR_RGB_H

#include "image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Whether the file begins like one. */
int exr_recognise(const char *path);

/* As formats_read_rgb(). */
int exr_read_rgb(const char *path, float **rgb, uint32_t *width,
                 uint32_t *height, image_error *error);

#ifdef __cplusplus
}
#endif

#endif
