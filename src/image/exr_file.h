/*
 * An OpenEXR file that is open for reading, with its header parsed and checked.
 *
 * The file is parsed by OpenEXRCore and not by OpenEXR's C++ library, because
 * only the former lets the caller limit its memory (exr_budget.h).
 *
 * Flat scanline and tiled files are accepted, single and multi-part; parts with
 * deep data are ignored.  The first flat part defines the data window.  Parts
 * with another data window are ignored.
 */
#ifndef HBIL_IMAGE_EXR_FILE_H
#define HBIL_IMAGE_EXR_FILE_H

#include "image/error.h"
#include "image/exr_budget.h"
#include "image/exr_stream.h"

#include <openexr.h>

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The largest side of a window in pixels.  A file that claims more is damaged.
 */
enum { EXR_MAX_SIDE = 1 << 24 };

/* The `what` of exr_file_fail() for pixels that can't be decoded. */
#define EXR_DAMAGED_PIXELS "truncated or damaged pixel data"

typedef struct exr_file {
  exr_stream stream;
  exr_budget budget;
  exr_context_t context;
  int parts;
  exr_attr_box2i_t window; /* the data window */
  uint32_t width, height;  /* of the data window */
  image_error *error;      /* receives the messages of all functions below */
} exr_file;

/* Opens a file.  `path` and `error` must remain valid until it is closed. */
int exr_file_open(exr_file *f, const char *path, image_error *error);
void exr_file_close(exr_file *f);

/* Returns the channels of a part, or NULL if the part is ignored. */
const exr_attr_chlist_t *exr_file_channels(const exr_file *f, int part);

/* Number of pixels from the first to the last, both included. */
int64_t exr_extent(int32_t first, int32_t last);

/* Reports what is wrong with the file, and why the library gave up.  Always
 * returns -1. */
int exr_file_fail(const exr_file *f, const char *what, exr_result_t result);

#ifdef __cplusplus
}
#endif

#endif
