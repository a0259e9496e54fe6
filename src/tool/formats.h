/* Which role feeds which input of the library, and the one pixel format that
 * the programs use: planes of floats. */
#ifndef HBIL_TOOL_FORMATS_H
#define HBIL_TOOL_FORMATS_H

#include "dump/channel_map.h"
#include "image/error.h"
#include "image/image.h"

typedef struct input_info {
  role role;
  size_t format, image; /* offsets in hbil_config and hbil_frame */
} input_info;

enum { INPUTS = 6 }; /* the last one is motion */
extern const input_info input_table[INPUTS];

/* The number of channels of an input that these settings use; 0: none. */
size_t formats_channels(const hbil_config *config, const channel_map *map,
                        int input);

/* Fills in the formats of the inputs that are used and of a set of layers
 * (layers.h). */
void formats_choose(hbil_config *config, const channel_map *map,
                    unsigned layers);

#endif
