/* The planes of a frame's own file, held from one reading of it to the next. */
#include "dump/held_planes.h"

#include "image/clock.h"
#include "image/image_read.h"

#include <string.h>

void held_planes_free(held_planes *h) {
  image_free(&h->planes);
  h->is_read = 0;
  h->is_over = 1;
}

/* Reads all that the map names.  If that fails, because of a channel that
 * nobody may want, each reader reads its own. */
static void fill(held_planes *h, const char *path, const channel_map *map) {
  const char *names[ROLE_COUNT * ROLE_CHANNELS];
  size_t count = 0;
  for (int r = 0; r < ROLE_COUNT; r++)
    for (size_t c = 0; !map->files[r] && c < map->count[r]; c++)
      names[count++] = map->names[r][c];
  const double start = seconds_now();
  h->is_read = image_read(path, names, count, &h->planes, NULL) == 0;
  h->seconds += seconds_now() - start;
  h->is_over = !h->is_read;
}

static int has_all(const image *planes, const char *const *names,
                   size_t count) {
  for (size_t i = 0; i < count; i++)
    if (!image_find(planes, names[i]))
      return 0;
  return 1;
}

/* An image with the same header, and copies of the named planes. */
static int copy(const image *from, const char *const *names, size_t count,
                image *out) {
  const size_t bytes = sizeof(float) * from->width * from->height;
  *out = *from;
  out->planes = NULL;
  out->count = 0;
  for (size_t i = 0; i < count; i++) {
    const image_plane *source = image_find(from, names[i]);
    if (image_find(out, names[i]))
      continue;
    image_plane *plane = image_add(out, names[i]);
    if (!plane) {
      image_free(out);
      return -1;
    }
    plane->type = source->type;
    memcpy(plane->pixels, source->pixels, bytes);
  }
  return 0;
}

int held_planes_read(const char *path, const channel_map *map,
                     const char *const *names, size_t count, image *out,
                     image_error *error) {
  held_planes *h = map->held;
  if (h && !h->is_over && !h->is_read && !h->is_last)
    fill(h, path, map);
  if (!h || !h->is_read || !has_all(&h->planes, names, count))
    return image_read(path, names, count, out, error);
  if (!h->is_last)
    return copy(&h->planes, names, count, out) != 0
               ? image_no_memory(error, path)
               : 0;
  *out = h->planes;
  memset(&h->planes, 0, sizeof h->planes);
  held_planes_free(h);
  return 0;
}
