/*
 * How an OpenEXR file is stored: its compression, its further attributes, and
 * whether it may replace another file.
 */
#ifndef HBIL_IMAGE_EXR_STYLE_H
#define HBIL_IMAGE_EXR_STYLE_H

#include "image/temporary.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The names of the compressions: none, rle, zips, zip, piz, pxr24, b44, b44a,
 * dwaa, dwab, then "input", which means that of the file exr_style.like.  Ends
 * with NULL. */
extern const char *const exr_compressions[];
enum {
  EXR_COMPRESSION_OF_NONE = 0,
  EXR_COMPRESSION_OF_ZIP = 3,
  EXR_COMPRESSION_OF_INPUT = 10
};

typedef struct exr_style {
  int compression;  /* index in exr_compressions */
  const char *like; /* a file whose header attributes are copied, except those
                     * that describe its storage, or NULL.  Only the first part
                     * counts.  A file of another format has no attributes. */
  existing_file existing; /* a file that has the name already */
} exr_style;

#ifdef __cplusplus
}
#endif

#endif
