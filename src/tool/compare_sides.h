/* The two images of `hbil compare`, and which of their channels are compared.
 */
#ifndef HBIL_TOOL_COMPARE_SIDES_H
#define HBIL_TOOL_COMPARE_SIDES_H

#include "image/error.h"
#include "image/image.h"

typedef struct compare_side {
  char *path;        /* owned */
  const char *layer; /* see compare_layer_select() */
  image header, planes;
} compare_side;

/* Reads both sides, given as FILE or FILE:LAYER, of EXR, TIFF, HDR or PNG
 * files; sRGB becomes linear.  Channels are paired by their
 * last letter, or, without any layer, by name.  Returns 0, or -1 with `error`
 * filled if they don't fit; compare_side_free() frees both in both cases. */
int compare_sides_read(const char *first, const char *second, compare_side *a,
                       compare_side *b, image_error *error);

/* It may be called on a zeroed side. */
void compare_side_free(compare_side *s);

/* The plane of b that belongs to channel `name` of a; NULL: none. */
const image_plane *compare_partner(const compare_side *a, const compare_side *b,
                                   const char *name);

#endif
