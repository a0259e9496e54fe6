/* The user's choice of passes: --map ROLE=[FILE:]LAYER,..., or
 * ROLE=CHANNEL,CHANNEL,CHANNEL,... */
#ifndef HBIL_DUMP_CHOSEN_PASSES_H
#define HBIL_DUMP_CHOSEN_PASSES_H

#include "dump/channel_map.h"
#include "image/error.h"
#include "image/image.h"

/*
 * Puts the passes that the text names into the map of a frame.  header: that of
 * the frame.  A FILE is looked for beside the frame; a # in it stands for the
 * frame's number.  ROLE= without a value takes the role out of the map.
 * Returns 0, or -1 with `error` filled.
 */
int chosen_passes_take(const char *frame, const image *header, const char *text,
                       channel_map *out, image_error *error);

/* Takes a pass from a file of its own: the layer `group` of it, or, if "", its
 * channels without a layer or its first one.  path: malloc'd; the map owns it
 * in any case.  Returns 0, or -1 with `error` filled. */
int chosen_passes_take_file(const char *frame, const image *header, char *path,
                            const char *group, role r, channel_map *out,
                            image_error *error);

#endif
