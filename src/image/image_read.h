/*
 * Reads any file of planes: OpenEXR, PNG, TIFF and Radiance HDR.
 */
#ifndef HBIL_IMAGE_READ_H
#define HBIL_IMAGE_READ_H

#include "image/error.h"
#include "image/image.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads the header only, see exr_read_header() and formats_read_header(). */
int image_read_header(const char *path, image *out, image_error *error);

/* Reads the named channels, see exr_read() and formats_read(). */
int image_read(const char *path, const char *const *names, size_t count,
               image *out, image_error *error);

#ifdef __cplusplus
}
#endif

#endif
