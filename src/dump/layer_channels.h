/* Finds the channels of a layer in a file's header and gives them a role. */
#ifndef HBIL_DUMP_LAYER_CHANNELS_H
#define HBIL_DUMP_LAYER_CHANNELS_H

#include "dump/channel_map.h"
#include "image/image.h"

/* Each returns 1 if the header has such channels and the map now names them for
 * the role, otherwise 0 and the map is unchanged. */

/* The channels LAYER.LETTER, with the letters that renderers use for one, two
 * or three components.  layer "": the channels without a layer.  A role of one
 * channel may also be named by its whole name. */
int layer_channels_take(const image *header, const char *layer, role r,
                        channel_map *out);

/* One channel by its whole name.  For a colour it stands for all three
 * components. */
int layer_channels_take_one(const image *header, const char *name, role r,
                            channel_map *out);

/* Writes the names of the layers whose last word is `word`, NULL for any, and
 * that have as many channels as the role, with commas, as far as `size` allows.
 * Returns how many there are. */
size_t layer_channels_list(const image *header, const char *word, role r,
                           char *text, size_t size);

/* Whether a layer has some of a colour's channels and not all; `missing`, of
 * 256 characters, receives the first that isn't there, otherwise "". */
int layer_channels_lack(const image *header, const char *layer, char *missing);

/* The first channel whose name ends in `ending`. */
int layer_channels_take_ending(const image *header, const char *ending, role r,
                               channel_map *out);

/* The channel A of a layer, or that without a layer, as ROLE_ALPHA. */
int layer_channels_take_alpha(const image *header, const char *layer,
                              channel_map *out);

/* The first layer, with a name, that has the channels R, G, B and A. */
int layer_channels_take_with_alpha(const image *header, role r,
                                   channel_map *out);

#endif
