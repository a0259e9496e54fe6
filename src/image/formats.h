/*
 * PNG, TIFF and Radiance HDR files as planes, through OpenImageIO, which a
 * module of its own loads at first use (formats_module.h).
 *
 * Channels have the names that OpenImageIO gives them (R, G, B, A, Y).  Values
 * are not converted: colours stay in their encoding (image.gamma) and alpha is
 * not multiplied in.  Integers become 0..1.
 */
#ifndef HBIL_IMAGE_FORMATS_H
#define HBIL_IMAGE_FORMATS_H

#include "image/error.h"
#include "image/image.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The largest image that is read: pixels x channels. */
enum { FORMATS_MAX_VALUES = 1 << 27 };

/* Whether the module is there, also for png_write.h and picture.h.  0, or -1
 * with `error` filled. */
int formats_check(image_error *error);

/* Do what exr_read_header() and exr_read() do, for these formats. */
int formats_read_header(const char *path, image *out, image_error *error);
int formats_read(const char *path, const char *const *names, size_t count,
                 image *out, image_error *error);

#ifdef __cplusplus
}
#endif

#endif
