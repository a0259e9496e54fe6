/* Which channels a layer's name stands for. */
#ifndef HBIL_TOOL_COMPARE_LAYER_H
#define HBIL_TOOL_COMPARE_LAYER_H

#include "image/error.h"
#include "image/image.h"

#include <stddef.h>

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

#endif
