/* Which role feeds which input of the library, and in which format. */
#include "tool/formats.h"

#include "image/error.h"
#include "tool/layers.h"

#define INPUT(role, field)                                                     \
  { role, offsetof(hbil_config, inputs.field), offsetof(hbil_frame, field) }

const input_info input_table[INPUTS] = {
    INPUT(ROLE_DEPTH, depth),       INPUT(ROLE_NORMAL, normal),
    INPUT(ROLE_ALBEDO, albedo),     INPUT(ROLE_DIRECT, direct),
    INPUT(ROLE_EMISSION, emission), INPUT(ROLE_MOTION, motion),
};

static hbil_plane_format *format_at(hbil_config *config, size_t offset) {
  return (hbil_plane_format *)((char *)config + offset);
}

size_t formats_channels(const hbil_config *config, const channel_map *map,
                        int input) {
  const role r = input_table[input].role;
  if (r == ROLE_MOTION &&
      config->history.reprojection != HBIL_REPROJECTION_MOTION)
    return 0;
  return map->count[r];
}

void formats_choose(hbil_config *config, const channel_map *map,
                    unsigned layers) {
  const hbil_plane_format planes_of_floats = {HBIL_FLOAT32, 1};
  for (int i = 0; i < INPUTS; i++)
    if (formats_channels(config, map, i))
      *format_at(config, input_table[i].format) = planes_of_floats;
  for (int l = 0; l < LAYER_COUNT; l++)
    if (layers >> l & 1)
      *format_at(config, layer_table[l].format) = planes_of_floats;
}
