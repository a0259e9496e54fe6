/*
 * The channels of an OpenEXR file, over all of its parts, under unique names.
 *
 * A channel is listed under its own name.  It is listed as PART.NAME if an
 * earlier part already has a channel of that name, or if it has no layer and is
 * not in the first part, because such a part is a layer by itself.
 */
#ifndef HBIL_IMAGE_EXR_CHANNELS_H
#define HBIL_IMAGE_EXR_CHANNELS_H

#include "image/exr_file.h"
#include "image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where the values of a plane are stored. */
typedef struct exr_source {
  int part;
  int channel; /* index in exr_file_channels() of the part */
  image_type type;
} exr_source;

/* Declares a plane without pixels, of the channel's type, for every channel. */
int exr_channels_list(const exr_file *f, image *out);

/* Finds a channel by its own name or by PART.NAME.  Reports an error if there
 * is none, or if it lacks values for some pixels (chroma subsampling). */
int exr_channels_find(const exr_file *f, const char *name, exr_source *out);

#ifdef __cplusplus
}
#endif

#endif
