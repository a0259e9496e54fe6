/*
 * The attributes of an OpenEXR header that describe the image as a whole.
 */
#ifndef HBIL_IMAGE_EXR_ATTRIBUTES_H
#define HBIL_IMAGE_EXR_ATTRIBUTES_H

#include "image/exr_file.h"
#include "image/image.h"

/* Set members of `out` from the first part's header.  A missing attribute
 * leaves its member as it was. */

/* The data window of the file, and the display window. */
void exr_attributes_windows(const exr_file *f, image *out);

/* Everything else: the key, the camera matrices and the program's name. */
void exr_attributes_describe(exr_file *f, image *out);

#endif
