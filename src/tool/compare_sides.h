/* The two images of `hbil compare`, and which of their channels are compared.
 */
#ifndef HBIL_TOOL_COMPARE_SIDES_H
#define HBIL_TOOL_COMPARE_SIDES_H

#include "image/error.h"
#include "image/image.h"

typedef struct compare_side {
  char *path;        /* owned */
  const char *layer; /* a part of the argument, or NULL for all channels */
  image header, planes;
} compare_side;

/* Reads both sides, given as FILE or FILE:LAYER.  Channels are paired by their
 * last letter, or, without any layer, by name.  Returns 0, or -1 with `error`
 * filled if they don't fit; compare_side_free() frees both in both cases. */
int compare_sides_read(const char *first, const char *second, compare_side *a,
                       compare_side *b, image_error *error);

/* It may be called on a zeroed side. */
void compare_side_free(compare_side *s);

/* The plane of b that belongs to channel `name` of a; NULL: none. */
const image_plane *compare_partner(const compare_side *a, const compare_side *b,
                                   const char *name);

/* The part of a channel's name behind the last dot. */
const char *channel_letter(const char *channel);

#endif
