/* The two images of `hbil compare`, and which of their channels are compared.
 */
#ifndef HBIL_TOOL_COMPARE_SIDES_H
#define HBIL_TOOL_COMPARE_SIDES_H

#include "image/error.h"
#include "image/image.h"

/* The part of a channel's name behind the last dot. */
const char *channel_letter(const char *channel);

typedef struct compare_side {
  char *path;        /* owned */
  const char *layer; /* a layer or a channel by its whole name, else by the end
                      * of it ("DiffInd" for "ViewLayer.DiffInd"), else by a
                      * part ("DiffInd" for "ViewLayer.DiffInd.left"); "": the
                      * channels without a layer; NULL: all channels */
  image header, planes;
} compare_side;

/* Takes both names, FILE or FILE:LAYER.  0, or -1 with `error` filled if memory
 * runs out; compare_side_free() frees both in both cases. */
int compare_sides_name(const char *first, const char *second, compare_side *a,
                       compare_side *b, image_error *error);

/* Reads both files, of EXR, TIFF, HDR or PNG; sRGB becomes linear.  Channels
 * are paired by their last letter, or, without any layer, by name.  Returns 0,
 * or -1 with `error` filled if they don't fit. */
int compare_sides_read(compare_side *a, compare_side *b, image_error *error);

/* It may be called on a zeroed side. */
void compare_side_free(compare_side *s);

/* The plane of b that belongs to channel `name` of a; NULL: none. */
const image_plane *compare_partner(const compare_side *a, const compare_side *b,
                                   const char *name);

#endif
