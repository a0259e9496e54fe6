/* Which pixels `hbil compare` compares. */
#include "tool/compare_mask.h"

#include "dump/frame_camera.h"
#include "dump/read_channel_map.h"
#include "dump/read_gbuffer.h"
#include "dump/surface_points.h"
#include "image/camera_json.h"
#include "image/error.h"
#include "image/image.h"
#include "image/image_read.h"
#include "image/window.h"

#include <string.h>

/* Surfaces with less albedo count as black. */
static const float least_albedo = 0.02f;

/* Maps the channels.  If the depth must be converted, the camera is needed. */
static int map_mask(const char *path, channel_map *map, image_error *error) {
  image header;
  source_options guess;
  frame_camera seen;
  camera_file camera;
  source_options_init(&guess);
  if (image_read_header(path, &header, error) != 0)
    return -1;
  int failed = channel_map_read(path, &header, &guess, map, error);
  if (!failed)
    map->window = image_window_common(map->data, map->display);
  if (!failed && map->count[ROLE_DEPTH] &&
      !conventions_depth_is_planar(&map->how))
    failed = frame_camera_read(path, &header, map, NULL, &guess, &seen, NULL,
                               error) != 0 ||
             frame_camera_aim(path, &seen, map, &camera, error) != 0;
  image_free(&header);
  return failed;
}

int compare_mask_read(const char *path, int albedo, const image *like,
                      compare_mask *out, image_error *error) {
  channel_map map;
  memset(out, 0, sizeof *out);
  if (!path)
    return 0;
  if (map_mask(path, &map, error) != 0)
    return -1;
  out->albedo = albedo;
  if (!map.count[ROLE_DEPTH] || (albedo && !map.count[ROLE_ALBEDO]))
    return image_fail(
        error, "%s: cannot be a mask: no %s; a G-buffer is needed", path,
        role_name(map.count[ROLE_DEPTH] ? ROLE_ALBEDO : ROLE_DEPTH));
  if (gbuffer_read(path, &map, 1u << ROLE_DEPTH | 1u << ROLE_ALBEDO, &out->g,
                   error) != 0)
    return -1;
  surface_depths_make_planar(&out->g);
  if (out->g.planes.width != like->width ||
      out->g.planes.height != like->height)
    return image_fail(error,
                      "%s: %u x %u pixels, but the images have %u x %u; a mask "
                      "of their size is needed",
                      path, out->g.planes.width, out->g.planes.height,
                      like->width, like->height);
  return 0;
}

void compare_mask_free(compare_mask *m) {
  gbuffer_free(&m->g);
}

channel_mask compare_mask_channel(const compare_mask *m, const char *letter) {
  const char *place = strlen(letter) == 1 ? strchr("RGB", *letter) : NULL;
  channel_mask out = {
      .depth = gbuffer_plane(&m->g, ROLE_DEPTH, 0),
  };
  if (m->albedo && place)
    out.albedo = gbuffer_plane(&m->g, ROLE_ALBEDO, (size_t)(place - "RGB"));
  return out;
}

int channel_mask_has(const channel_mask *m, size_t i) {
  return (!m->depth || m->depth[i] > 0.0f) &&
         (!m->albedo || m->albedo[i] > least_albedo);
}
