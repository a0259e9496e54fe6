/* What can be told from a channel map alone. */
#include "dump/channel_map.h"

#include "image/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void channel_map_init(channel_map *out, dump_kind kind) {
  memset(out, 0, sizeof *out);
  out->kind = kind;
  out->how = source_table[kind].how;
}

void channel_map_free(channel_map *map) {
  for (int r = 0; r < ROLE_COUNT; r++) {
    free(map->files[r]);
    map->files[r] = NULL;
  }
}

static int check_depth(const channel_map *map, const char *path,
                       image_error *error) {
  const int wanted = map->how.depth == DEPTH_POSITION;
  if (map->count[wanted ? ROLE_POSITION : ROLE_DEPTH])
    return 0;
  return image_fail(error,
                    wanted
                        ? "%s: no positions to take depth from; Position, P "
                          "or --map position=LAYER is needed"
                        : "%s: no depth channel; Depth.Z (Blender's Z pass), "
                          "depth.Z or --map depth=CHANNEL is needed",
                    path);
}

int channel_map_check(const channel_map *map, const char *path,
                      image_error *error) {
  if (check_depth(map, path, error) != 0)
    return -1;
  if (!map->count[ROLE_NORMAL] && !map->how.from_depth)
    return image_fail(error,
                      "%s: no normals; Normal.{X,Y,Z} (Blender's Normal "
                      "pass), normal.{X,Y,Z}, --map normal=LAYER or --normals "
                      "from-depth are needed",
                      path);
  return 0;
}

void channel_map_signs(const channel_map *map, dump_space space,
                       float sign[3]) {
  unsigned flips = map->how.flips;
  flips ^= space == SPACE_CAMERA ? 6u : map->mirrored ? 4u : 0u;
  for (int c = 0; c < 3; c++)
    sign[c] = flips >> c & 1 ? -1.0f : 1.0f;
}

void channel_map_configure(const channel_map *map, hbil_config *config) {
  const conventions *how = &map->how;
  config->inputs.projection = map->projection;
  config->inputs.depth_kind = HBIL_DEPTH_PLANAR;
  config->inputs.normal_space =
      how->normals == SPACE_WORLD ? HBIL_SPACE_WORLD : HBIL_SPACE_VIEW;
  if (conventions_depth_is_planar(how) && isfinite(how->sky_depth))
    config->inputs.sky_depth = how->sky_depth;
  config->inputs.direct_scale =
      how->direct == DIRECT_IRRADIANCE ? 1.0f : 3.14159265358979f;
  memcpy(config->inputs.motion_scale, how->motion_scale,
         sizeof how->motion_scale);
}
