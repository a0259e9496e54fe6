/* Makes the channel map of a frame from its header and the user's options. */
#ifndef HBIL_DUMP_READ_CHANNEL_MAP_H
#define HBIL_DUMP_READ_CHANNEL_MAP_H

#include "dump/channel_map.h"
#include "image/error.h"
#include "image/image.h"

/*
 * Guesses what the options leave open.  header: that of the frame `path`.  The
 * files that --map names are opened for their headers.  Returns 0 and a map
 * that channel_map_free() frees, or -1 with `error` filled and nothing to free.
 */
int channel_map_read(const char *path, const image *header,
                     const source_options *options, channel_map *out,
                     image_error *error);

#endif
