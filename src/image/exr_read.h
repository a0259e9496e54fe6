/*
 * Reads OpenEXR files: flat scanline and tiled files, single and multi-part.
 *
 * exr_file.h says which parts are read, exr_channels.h how their channels are
 * named, and exr_budget.h how much memory that takes at most.
 */
#ifndef HBIL_IMAGE_EXR_READ_H
#define HBIL_IMAGE_EXR_READ_H

#include "image/error.h"
#include "image/image.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads the header only: the size, the channel names and what image.h lists. */
int exr_read_header(const char *path, image *out, image_error *error);

/* Reads the named channels and the windows.  Fails if the file lacks one of the
 * names.  All values are converted to float. */
int exr_read(const char *path, const char *const *names, size_t count,
             image *out, image_error *error);

/* Does the same, but sets image_plane.type to the type in the file and leaves
 * integers unconverted. */
int exr_read_as_is(const char *path, const char *const *names, size_t count,
                   image *out, image_error *error);

#ifdef __cplusplus
}
#endif

#endif
