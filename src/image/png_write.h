/*
 * Writes PNG files, through OpenImageIO.
 */
#ifndef HBIL_IMAGE_PNG_WRITE_H
#define HBIL_IMAGE_PNG_WRITE_H

#include "image/error.h"
#include "image/temporary.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Writes width*height sRGB pixels of 3 bytes each, the top row first, and the
 * mark by which png_look() recognises the file (png_mark.h).  The file
 * appears complete or not at all. */
int png_write(const char *path, const unsigned char *rgb, uint32_t width,
              uint32_t height, existing_file existing, image_error *error);

#ifdef __cplusplus
}
#endif

#endif
