/*
 * Writes OpenEXR files.
 */
#ifndef HBIL_IMAGE_EXR_WRITE_H
#define HBIL_IMAGE_EXR_WRITE_H

#include "image/error.h"
#include "image/exr_style.h"
#include "image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Writes all planes, the windows, the matrices, the views and the key as a file
 * of scanlines.  If there is a key, the file also gets a checksum
 * (exr_checksum.h).  The file appears complete or not at all.
 *
 * half[i] says whether plane i is stored as half (1) or in its own type (0);
 * NULL: all in their own types.  Finite values that a half can't hold are
 * clamped to the largest one that it can.
 */
int exr_write_as(const char *path, const image *img, const unsigned char *half,
                 const exr_style *style, image_error *error);

/* Does the same in ZIP compression and without further attributes. */
int exr_write(const char *path, const image *img, const unsigned char *half,
              image_error *error);

#ifdef __cplusplus
}
#endif

#endif
