/* Cameras that are fitted to a frame's positions. */
#include "dump/fitted_camera.h"

#include "dump/camera_fit.h"
#include "dump/read_gbuffer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Positions as a camera sees them: those in camera space become points of view
 * space, which is then the world. */
static int read_points(const char *frame, const channel_map *map,
                       fit_points *out, image_error *error) {
  channel_map plain = *map;
  gbuffer g;
  if (plain.how.positions == SPACE_CAMERA)
    plain.how.flips ^= 6u;
  plain.how.positions = SPACE_WORLD;
  plain.mirrored = 0;
  if (plain.how.depth == DEPTH_POSITION)
    plain.count[ROLE_DEPTH] = 0;
  plain.how.depth = DEPTH_PLANAR;
  if (gbuffer_read(frame, &plain,
                   1u << ROLE_POSITION | 1u << ROLE_DEPTH | 1u << ROLE_COVERAGE,
                   &g, error) != 0)
    return -1;
  camera_fit_points(&g, out);
  gbuffer_free(&g);
  return 0;
}

/* Pixels of the planes become those of the picture. */
static void take(const channel_map *map, const camera_fit *f,
                 frame_camera *out) {
  out->file = f->camera;
  out->file.width = out->file.height = 0;
  out->file.cx += (double)map->window.x - (double)map->display.x;
  out->file.cy += (double)map->window.y - (double)map->display.y;
  out->from = "fitted to the positions";
  out->fitted = 1;
  out->mirrored = f->mirrored;
  out->placed = map->how.positions == SPACE_WORLD;
  if (out->placed)
    return;
  memset(out->file.camera_to_world, 0, sizeof out->file.camera_to_world);
  for (int i = 0; i < 16; i += 5)
    out->file.camera_to_world[i] = 1;
}

int fitted_camera_read(const char *frame, const channel_map *map,
                       frame_camera *out, image_error *error) {
  fit_points *points = NULL;
  int failed = 0;
  out->from = NULL;
  if (map->count[ROLE_POSITION] < 3)
    return 0;
  if (!(points = malloc(sizeof *points)))
    return image_no_memory(error, frame);
  failed = read_points(frame, map, points, error);
  if (!failed) {
    const camera_fit f = camera_fit_find(points);
    if (f.found)
      take(map, &f, out);
  }
  free(points);
  return failed;
}
