/* Pictures of layers: tone-mapped, as PNG. */
#ifndef HBIL_TOOL_PREVIEW_H
#define HBIL_TOOL_PREVIEW_H

#include "tool/layers.h"
#include "image/error.h"
#include "image/image.h"
#include "image/picture.h"
#include "image/temporary.h"

/* One exposure for all layers of light, from the layers of one frame. */
float preview_exposure(const image *result);

/* Radiance, times the exposure, as a byte of a picture: Reinhard's curve and
 * sRGB. */
unsigned char preview_light(float value);

/* A layer as a picture, which picture_free() frees.  0, or -1 if memory runs
 * out. */
int preview_picture(const image *result, layer l, float exposure, picture *out);

/* The same as a file.  0, or -1 with `error` filled. */
int preview_write(const char *path, const image *result, layer l,
                  float exposure, existing_file existing, image_error *error);

#endif
