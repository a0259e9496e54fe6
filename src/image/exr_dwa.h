/*
 * Pixels of one part in DWAA or DWAB compression, decoded by OpenEXR's C++
 * library.
 *
 * OpenEXRCore before 3.2 cannot decompress DWA, and some later versions do so
 * wrongly if channels have layer names (openexr issue 1682).
 */
#ifndef HBIL_IMAGE_EXR_DWA_H
#define HBIL_IMAGE_EXR_DWA_H

#include "image/exr_channels.h"
#include "image/exr_file.h"
#include "image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Whether a part is compressed so. */
int exr_dwa_compressed(const exr_file *f, int part);

/* Does what exr_decode() does. */
int exr_dwa_decode(exr_file *f, int part, const image *img,
                   const exr_source *sources);

#ifdef __cplusplus
}
#endif

#endif
