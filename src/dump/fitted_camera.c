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

/* The map's camera in the space of read_points(). */
static camera_file given_camera(const channel_map *map) {
  camera_file out = {.orthographic =
                         map->projection == HBIL_PROJECTION_ORTHOGRAPHIC,
                     .fx = map->camera.fx,
                     .fy = map->camera.fy,
                     .cx = map->camera.cx,
                     .cy = map->camera.cy};
  for (int i = 0; i < 16; i++) {
    const double in_view = i % 5 == 0;
    out.camera_to_world[i] =
        (map->how.positions == SPACE_WORLD ? map->camera.world_from_view[i]
                                           : in_view) *
        (i % 4 == 1 || i % 4 == 2 ? -1.0 : 1.0);
    if (map->mirrored && map->how.positions == SPACE_WORLD && i / 4 == 2)
      out.camera_to_world[i] = -out.camera_to_world[i];
  }
  return out;
}

/* What kind of projection the points have that is none of a camera; NULL if
 * some camera shows them so. */
static const char *name_projection(const fit_points *points,
                                   const camera_file *given) {
  const double *m = given->camera_to_world;
  const double eye[3] = {m[3], m[7], m[11]};
  if (camera_fit_error(points, given) < CAMERA_FITS ||
      camera_fit_find(points).found)
    return NULL;
  return camera_fit_name_projection(points, eye);
}

int fitted_camera_check(const char *frame, const channel_map *map,
                        image_error *error) {
  const camera_file given = given_camera(map);
  if (map->count[ROLE_POSITION] < 3)
    return 0;
  fit_points *points = malloc(sizeof *points);
  if (!points)
    return image_no_memory(error, frame);
  const int failed = read_points(frame, map, points, error);
  const char *kind = failed ? NULL : name_projection(points, &given);
  free(points);
  return kind ? image_fail(error,
                           "%s: is %s by its positions; a perspective or an "
                           "orthographic picture is needed, or several that "
                           "show the same",
                           frame, kind)
              : failed;
}
