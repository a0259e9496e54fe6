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

void channel_map_encode(channel_map *map, role r, const image *header) {
  map->gamma[r] = header->gamma;
  map->floats[r] = !header->integers;
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

/* The library's limit, which holds for all that is done with a frame. */
static int check_size(const channel_map *map, const char *path,
                      image_error *error) {
  const image_window *w = &map->data;
  return w->width <= HBIL_MAX_SIZE && w->height <= HBIL_MAX_SIZE
             ? 0
             : image_fail(error,
                          "%s: %u x %u pixels; a picture of at most %d x %d is "
                          "needed",
                          path, w->width, w->height, HBIL_MAX_SIZE,
                          HBIL_MAX_SIZE);
}

int channel_map_check(const channel_map *map, const char *path,
                      image_error *error) {
  if (map->unnamed && !map->count[ROLE_DEPTH] && !map->count[ROLE_POSITION])
    return image_fail(
        error,
        "%s: its channels have no names (ch00, ch01, ...), as Mitsuba's "
        "mi.util.write_bitmap() writes them; Bitmap.write(), or --map "
        "depth=ch03,normal=ch07,ch08,ch09,... in the order of the "
        "integrator's AOVs, is needed",
        path);
  if (check_depth(map, path, error) != 0 || check_size(map, path, error) != 0)
    return -1;
  if (!map->count[ROLE_NORMAL] && !map->how.from_depth)
    return image_fail(error,
                      "%s: no normals; Normal.{X,Y,Z} (Blender's Normal "
                      "pass), normal.{X,Y,Z}, --map normal=LAYER or --normals "
                      "from-depth are needed",
                      path);
  return 0;
}

int channel_map_follows(const channel_map *map, const char *path,
                        const channel_map *first, const char *first_path,
                        image_error *error) {
  const image_window *size = &first->display, *own = &map->display;
  for (int r = 0; r < ROLE_COUNT; r++)
    if (first->count[r] && !map->count[r] && r != ROLE_POSITION &&
        r != ROLE_INDIRECT && r != ROLE_COVERAGE && r != ROLE_PICTURE &&
        r != ROLE_ALPHA)
      return image_fail(error,
                        "%s: has no %s, which %s has; the same channels in "
                        "every frame are needed",
                        path, role_name((role)r), first_path);
  if (own->width != size->width || own->height != size->height)
    return image_fail(error,
                      "%s: %u x %u pixels, but %s has %u x %u; frames of one "
                      "size are needed",
                      path, own->width, own->height, first_path, size->width,
                      size->height);
  return 0;
}

void channel_map_read_alike(channel_map *map, const channel_map *first) {
  const double near = map->how.near, far = map->how.far;
  map->how = first->how;
  map->how.near = near;
  map->how.far = far;
}

void channel_map_signs(const channel_map *map, dump_space space,
                       float sign[3]) {
  unsigned flips = map->how.flips;
  flips ^= space == SPACE_CAMERA ? 6u : map->mirrored ? 4u : 0u;
  for (int c = 0; c < 3; c++)
    sign[c] = flips >> c & 1 ? -1.0f : 1.0f;
}

int channel_map_depth_is_hardware(const channel_map *map) {
  return map->how.depth == DEPTH_DEVICE || map->how.depth == DEPTH_REVERSED;
}

void channel_map_hardware_depth(const channel_map *map, double out[2]) {
  const double near = map->how.near, far = map->how.far;
  const int parallel = map->projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  /* of depths that are 0 at the near plane and 1 at the far plane */
  const double stretch = isinf(far) ? 1 : far / (far - near);
  const double a = parallel ? -near / (far - near) : stretch;
  const double b = parallel ? 1 / (far - near) : -near * stretch;
  const int reversed = map->how.depth == DEPTH_REVERSED;
  out[0] = out[1] = 0;
  if (!channel_map_depth_is_hardware(map))
    return;
  out[0] = reversed ? 1 - a : a;
  out[1] = reversed ? -b : b;
}

/* The library's sky_depth, in camera units. */
static float sky_depth(const channel_map *map) {
  const conventions *how = &map->how;
  double ab[2];
  if (how->depth == DEPTH_POSITION || !isfinite(how->sky_depth) ||
      conventions_begin_at_near(how))
    return INFINITY;
  if (!channel_map_depth_is_hardware(map))
    return how->sky_depth * (float)how->unit;
  if (how->sky_depth > 1.0f) /* no value of a depth buffer */
    return INFINITY;
  channel_map_hardware_depth(map, ab);
  const double above = (double)how->sky_depth - ab[0];
  const double z = map->projection == HBIL_PROJECTION_ORTHOGRAPHIC
                       ? above / ab[1]
                       : ab[1] / above;
  /* The sky is often at this very value, which the kernels may round to a depth
   * that is a little smaller. */
  return z > 0 && isfinite(z) ? (float)(z * (1 - 1e-6)) : INFINITY;
}

void channel_map_configure(const channel_map *map, hbil_config *config) {
  const conventions *how = &map->how;
  config->inputs.projection = map->projection;
  config->inputs.depth_kind = how->depth == DEPTH_RAY ? HBIL_DEPTH_RAY
                              : channel_map_depth_is_hardware(map)
                                  ? HBIL_DEPTH_HARDWARE
                                  : HBIL_DEPTH_PLANAR;
  config->inputs.depth_scale =
      how->depth == DEPTH_POSITION || channel_map_depth_is_hardware(map)
          ? 1.0f
          : (how->backwards ? -1.0f : 1.0f) * (float)how->unit;
  config->inputs.sky_depth = sky_depth(map);
  config->inputs.normal_space =
      how->normals == SPACE_WORLD ? HBIL_SPACE_WORLD : HBIL_SPACE_VIEW;
  channel_map_signs(map, how->normals, config->inputs.normal_scale);
  config->inputs.direct_scale =
      how->direct == DIRECT_IRRADIANCE ? 1.0f : 3.14159265358979f;
  memcpy(config->inputs.motion_scale, how->motion_scale,
         sizeof how->motion_scale);
}
