/* One captured frame: its planes and its camera. */
#define _POSIX_C_SOURCE 200809L
#include "tool/tool.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A pixel has one or the other, or a share of each on an edge. */
static void add_background(gbuffer *g) {
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  for (size_t c = 0; c < g->map.count[ROLE_BACKGROUND]; c++) {
    const image_plane *sum =
        image_find(&g->planes, g->map.names[ROLE_EMISSION][c]);
    const float *add = gbuffer_plane(g, ROLE_BACKGROUND, c);
    for (size_t i = 0; sum && i < pixels; i++)
      sum->pixels[i] += add[i];
  }
}

int gbuffer_read(const char *path, const channel_map *map, unsigned roles,
                 gbuffer *out, image_error *error) {
  const char *names[ROLE_COUNT * ROLE_CHANNELS];
  size_t count = 0;
  out->map = *map;
  for (int r = 0; r < ROLE_COUNT; r++) {
    if (!(roles >> r & 1))
      out->map.count[r] = 0;
    for (size_t c = 0; c < out->map.count[r]; c++)
      names[count++] = out->map.names[r][c];
  }
  if (exr_read(path, names, count, &out->planes, error) != 0)
    return -1;
  add_background(out);
  return 0;
}

void gbuffer_free(gbuffer *g) {
  image_free(&g->planes);
}

const float *gbuffer_plane(const gbuffer *g, role r, size_t i) {
  if (i >= g->map.count[r])
    return NULL;
  const image_plane *plane = image_find(&g->planes, g->map.names[r][i]);
  return plane ? plane->pixels : NULL;
}

char *gbuffer_camera_name(const char *frame) {
  const char *slash = strrchr(frame, '/');
  const char *dot = strrchr(slash ? slash : frame, '.');
  const size_t stem = dot ? (size_t)(dot - frame) : strlen(frame);
  char *name = malloc(stem + sizeof ".json");
  if (name) {
    memcpy(name, frame, stem);
    strcpy(name + stem, ".json");
  }
  return name;
}

int gbuffer_camera(const char *frame, const char *override, camera_file *out,
                   image_error *error) {
  if (override)
    return camera_read(override, out, error);
  char *name = gbuffer_camera_name(frame);
  if (!name)
    return image_no_memory(error, frame);
  const int failed = camera_read(name, out, error);
  free(name);
  return failed;
}

int gbuffer_check_camera(const char *frame, const image *img,
                         const camera_file *camera, image_error *error) {
  if (!camera->width ||
      (camera->width == img->width && camera->height == img->height))
    return 0;
  return image_fail(error,
                    "%s: %u x %u pixels, but its camera is for %u x %u; the "
                    "camera of this frame is needed",
                    frame, img->width, img->height, camera->width,
                    camera->height);
}

int gbuffer_is_surface(float depth, float background) {
  return isfinite(depth) && depth > 0.0f && depth < background;
}

void gbuffer_hbil_camera(const camera_file *file, hbil_camera *out) {
  hbil_camera_from_opengl(out, file->camera_to_world, file->fx, file->fy,
                          file->cx, file->cy);
}
