/* Reads the G-buffer of a frame from its files. */
#include "dump/read_gbuffer.h"

#include "dump/convert.h"
#include "dump/held_planes.h"
#include "image/error.h"
#include "image/image.h"
#include "image/image_memory.h"
#include "image/image_read.h"
#include "image/window.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A pixel shows a surface or the background, or on an edge a share of both. */
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

/* The roles to read for the roles that are wanted.  Depth may be computed from
 * positions, and irradiance needs the albedo that it is divided by.  Emission
 * may be in direct light, where depth tells the sky. */
static unsigned needed(const channel_map *map, unsigned roles) {
  const unsigned light_and_lamps = 1u << ROLE_DIRECT | 1u << ROLE_EMISSION;
  if (map->how.shows_sources && roles & light_and_lamps)
    roles =
        (roles | 1u << ROLE_DIRECT | 1u << ROLE_DEPTH) & ~(1u << ROLE_EMISSION);
  if (map->how.depth == DEPTH_POSITION && roles >> ROLE_DEPTH & 1)
    roles = (roles | 1u << ROLE_POSITION) & ~(1u << ROLE_DEPTH);
  const unsigned light = 1u << ROLE_DIRECT | 1u << ROLE_INDIRECT;
  const unsigned multiplied = light | 1u << ROLE_DEPTH | 1u << ROLE_NORMAL |
                              1u << ROLE_POSITION | 1u << ROLE_ALBEDO;
  if (map->how.direct == DIRECT_RADIANCE && roles & light)
    roles |= 1u << ROLE_ALBEDO;
  if (map->how.premultiplied && roles & multiplied)
    roles |= 1u << ROLE_COVERAGE;
  return roles;
}

static int same_text(const char *a, const char *b) {
  return a == b || (a && b && strcmp(a, b) == 0);
}

/* Moves a plane that was read to the G-buffer, or copies it if the window
 * differs. */
static int take_plane(gbuffer *g, image *from, image_window at,
                      const char *name, const char *as) {
  const image_window to = g->map.window;
  image_plane *source = image_find(from, name);
  const int fits = memcmp(&at, &to, sizeof at) == 0;
  image_plane *plane =
      fits ? image_declare(&g->planes, as) : image_add(&g->planes, as);
  if (!plane)
    return -1;
  if (!fits)
    image_place(source->pixels, at, plane->pixels, to);
  else {
    plane->pixels = source->pixels;
    plane->is_lent = source->is_lent;
    source->pixels = NULL;
  }
  return 0;
}

/* A channel of two roles: the first role has the plane, the second one gets a
 * copy of it. */
static int copy_plane(gbuffer *g, const char *name, const char *as) {
  image_plane *plane = image_add(&g->planes, as);
  if (!plane)
    return -1;
  const image_plane *given = image_find(&g->planes, name);
  memcpy(plane->pixels, given->pixels,
         sizeof(float) * g->planes.width * g->planes.height);
  return 0;
}

/* The plane of an earlier role, or an earlier component, that already has this
 * channel of this file; NULL if there is none. */
static const char *find_taken(const gbuffer *g, const channel_map *map,
                              unsigned roles, int r, size_t c) {
  for (int q = 0; q <= r; q++)
    for (size_t d = 0; d < (q < r ? map->count[q] : c); d++)
      if (roles >> q & 1 && same_text(map->files[q], map->files[r]) &&
          strcmp(map->names[q][d], map->names[r][c]) == 0)
        return g->map.names[q][d];
  return NULL;
}

/* The planes of all roles that are in this file. */
static int take_planes(gbuffer *g, const channel_map *map, unsigned roles,
                       const char *file, image *from) {
  const image_window shown = image_display_window(from);
  image_window at = image_data_window(from);
  at.x += map->display.x - shown.x;
  at.y += map->display.y - shown.y;
  for (int r = 0; r < ROLE_COUNT; r++)
    for (size_t c = 0; c < map->count[r]; c++) {
      char *as = g->map.names[r][c];
      const char *name = map->names[r][c];
      if (!(roles >> r & 1) || !same_text(map->files[r], file))
        continue;
      const char *taken = find_taken(g, map, roles, r, c);
      snprintf(as, sizeof g->map.names[r][c], "%s.%zu", role_name((role)r), c);
      if ((taken ? copy_plane(g, taken, as)
                 : take_plane(g, from, at, name, as)) != 0)
        return -1;
    }
  return 0;
}

static int read_file(const char *frame, const char *file, unsigned roles,
                     const channel_map *map, gbuffer *out, image_error *error) {
  const char *names[ROLE_COUNT * ROLE_CHANNELS];
  const char *path = file ? file : frame;
  size_t count = 0;
  image planes;
  for (int r = 0; r < ROLE_COUNT; r++)
    for (size_t c = 0; roles >> r & 1 && c < map->count[r]; c++)
      if (same_text(map->files[r], file))
        names[count++] = map->names[r][c];
  if (count == 0)
    return 0;
  if ((file ? image_read(path, names, count, &planes, error)
            : held_planes_read(path, map, names, count, &planes, error)) != 0)
    return -1;
  const int failed = take_planes(out, map, roles, file, &planes)
                         ? image_no_memory(error, path)
                         : 0;
  image_free(&planes);
  return failed;
}

/* Reads each file once: that of the frame, then those of single passes. */
static int read_files(const char *path, unsigned roles, const channel_map *map,
                      gbuffer *out, image_error *error) {
  if (read_file(path, NULL, roles, map, out, error) != 0)
    return -1;
  for (int r = 0; r < ROLE_COUNT; r++) {
    int before = !map->files[r];
    for (int q = 0; q < r && !before; q++)
      before = same_text(map->files[q], map->files[r]);
    if (!before && read_file(path, map->files[r], roles, map, out, error) != 0)
      return -1;
  }
  return 0;
}

/* All frames' light is in one unit. */
static void remove_exposure(gbuffer *g) {
  static const role light[] = {ROLE_DIRECT, ROLE_EMISSION, ROLE_INDIRECT,
                               ROLE_PICTURE};
  const size_t pixels = gbuffer_pixels(g);
  const float factor = (float)(1.0 / g->map.exposure);
  if (!(g->map.exposure > 0.0))
    return;
  for (size_t r = 0; r < sizeof light / sizeof *light; r++)
    for (size_t c = 0; c < g->map.count[light[r]]; c++) {
      float *plane = gbuffer_plane(g, light[r], c);
      for (size_t i = 0; plane && i < pixels; i++)
        plane[i] *= factor;
    }
}

size_t gbuffer_read_bytes(const channel_map *map, unsigned roles) {
  const unsigned read = needed(map, roles);
  const image_window *window = &map->window, *data = &map->data;
  const size_t plane =
      image_memory_plane(sizeof(float) * window->width * window->height);
  const size_t cut =
      memcmp(window, data, sizeof *window) == 0
          ? 0
          : image_memory_plane(sizeof(float) * data->width * data->height);
  size_t bytes = map->how.depth == DEPTH_POSITION ? plane : 0;
  for (int r = 0; r < ROLE_COUNT; r++)
    if (read >> r & 1)
      bytes += map->count[r] * (plane + cut);
  return bytes;
}

int gbuffer_read(const char *path, const channel_map *map, unsigned roles,
                 gbuffer *out, image_error *error) {
  const unsigned read = needed(map, roles);
  memset(&out->planes, 0, sizeof out->planes);
  memset(out->indexed, 0, sizeof out->indexed);
  out->map = *map;
  out->planes.x = map->window.x;
  out->planes.y = map->window.y;
  out->planes.width = map->window.width;
  out->planes.height = map->window.height;
  memset(out->map.files, 0, sizeof out->map.files);
  out->map.held = NULL;
  for (int r = 0; r < ROLE_COUNT; r++)
    if (!(read >> r & 1))
      out->map.count[r] = 0;
  if (read_files(path, read, map, out, error) != 0 ||
      convert_planes(path, out, error) != 0) {
    gbuffer_free(out);
    return -1;
  }
  gbuffer_index(out);
  add_background(out);
  remove_exposure(out);
  return 0;
}

int gbuffer_read_as_stored(const char *path, const channel_map *map,
                           unsigned roles, gbuffer *out, image_error *error) {
  channel_map stored = *map;
  stored.how = conventions_as_stored();
  stored.mirrored = 0;
  stored.exposure = 0.0;
  memset(stored.gamma, 0, sizeof stored.gamma);
  if (map->how.depth == DEPTH_POSITION)
    stored.count[ROLE_DEPTH] = 0;
  if (map->how.shows_sources)
    stored.count[ROLE_EMISSION] = 0;
  return gbuffer_read(path, &stored, roles, out, error);
}
