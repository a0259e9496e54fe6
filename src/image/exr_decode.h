/*
 * Pixels of one part, decoded by OpenEXRCore.
 */
#ifndef HBIL_IMAGE_EXR_DECODE_H
#define HBIL_IMAGE_EXR_DECODE_H

#include "image/exr_channels.h"
#include "image/exr_file.h"
#include "image/image.h"

/* Fills the planes of `img` whose source is in this part; sources[i] belongs to
 * plane i.  A plane of type IMAGE_UINT receives integers, any other floats.
 * Large images in scanlines are decoded on all processors. */
int exr_decode(exr_file *f, int part, const image *img,
               const exr_source *sources);

#endif
