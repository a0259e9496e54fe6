/*
 * OpenEXRCore before 3.2 cannot decompress DWAA and DWAB, and some later ones
 * do so wrongly where channels have layer names (openexr issue 1682).  Such
 * parts are therefore read through OpenEXR's C++ library (formats.cpp).
 */
#ifndef HBIL_EXR_DWA_H
#define HBIL_EXR_DWA_H

#include "image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct exr_target {
  const char *channel; /* its name in the part */
  float *pixels;       /* width*height floats to fill */
  int integers;        /* or as many uint32_t */
} exr_target;

int exr_dwa_read(const char *path, int part, uint32_t width, uint32_t height,
                 const exr_target *targets, size_t count, image_error *error);

#ifdef __cplusplus
}
#endif

#endif
