/* Decides by the pixels of a first frame what its names left unsure. */
#ifndef HBIL_DUMP_SETTLE_H
#define HBIL_DUMP_SETTLE_H

#include "dump/channel_map.h"
#include "dump/findings.h"
#include "image/error.h"

/* Changes map->how where map->how.unsure allows it; the map's camera must be
 * known.  Adds each decision, and what map->picked says, to the findings, which
 * begin empty.  A fisheye or a panorama is an error.  Returns 0, or -1 with
 * `error` filled. */
int conventions_settle(const char *path, channel_map *map, findings *out,
                       image_error *error);

#endif
