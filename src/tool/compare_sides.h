/* The two images of `hbil compare`, and which of their channels are compared.
 */
#ifndef HBIL_TOOL_COMPARE_SIDES_H
#define HBIL_TOOL_COMPARE_SIDES_H

#include "image/error.h"
#include "image/image.h"

#include <stddef.h>

/* ------------------------------------------------------------------------ */
/* Which channels the name of a layer stands for                             */

/*
 * Writes the names of the channels that `wanted` stands for to out, which has
 * room for header->count, and their number to *count.  NULL: all channels; "":
 * those without a layer.  Otherwise a layer or a channel by its whole name,
 * else by the end of it ("DiffInd" for "ViewLayer.DiffInd"), else by a part
 * ("DiffInd" for "ViewLayer.DiffInd.left").  The alpha of a layer is coverage,
 * and left out.  Returns 0, or -1 with `error` filled if the name stands for
 * nothing or for several layers.  path: for messages.
 */
int compare_layer_select(const char *path, const image *header,
                         const char *wanted, const char **out, size_t *count,
                         image_error *error);

/* Whether a name stands for some channel. */
int compare_layer_exists(const image *header, const char *wanted);

/* The part of a channel's name behind the last dot. */
const char *channel_letter(const char *channel);

/* ------------------------------------------------------------------------ */
/* The two images                                                            */

typedef struct compare_side {
  char *path;        /* owned */
  const char *layer; /* see compare_layer_select() */
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
