/* The two images of `hbil compare`. */
#define _POSIX_C_SOURCE 200809L
#include "tool/compare_sides.h"

#include "image/error.h"
#include "image/image.h"
#include "image/image_read.h"
#include "image/srgb.h"
#include "tool/compare_layer.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* An existing file is taken as it is, even if its name has a colon. */
static int parse_side(const char *argument, compare_side *out,
                      image_error *error) {
  const char *colon = strrchr(argument, ':');
  out->path = strdup(argument);
  if (!out->path)
    return image_no_memory(error, argument);
  if (colon && colon > argument && access(argument, F_OK) != 0) {
    out->path[colon - argument] = '\0';
    out->layer = colon + 1;
  }
  return image_read_header(out->path, &out->header, error);
}

void compare_side_free(compare_side *s) {
  image_free(&s->header);
  image_free(&s->planes);
  free(s->path);
}

/* Colours in sRGB encoding become linear, as all others are. */
static void make_linear(image *planes) {
  const size_t pixels = (size_t)planes->width * planes->height;
  for (size_t i = 0; i < planes->count; i++)
    if (strcmp(channel_letter(planes->planes[i].name), "A") != 0)
      for (size_t k = 0; k < pixels; k++)
        planes->planes[i].pixels[k] =
            linear_of_srgb(planes->planes[i].pixels[k]);
}

static int read_side(compare_side *s, const char **selected,
                     image_error *error) {
  size_t count;
  if (compare_layer_select(s->path, &s->header, s->layer, selected, &count,
                           error) != 0 ||
      image_read(s->path, selected, count, &s->planes, error) != 0)
    return -1;
  if (s->header.gamma)
    make_linear(&s->planes);
  return 0;
}

const image_plane *compare_partner(const compare_side *a, const compare_side *b,
                                   const char *name) {
  if (a->planes.count == 1 && b->planes.count == 1)
    return &b->planes.planes[0];
  if (!a->layer && !b->layer)
    return image_find(&b->planes, name);
  for (size_t i = 0; i < b->planes.count; i++)
    if (strcmp(channel_letter(b->planes.planes[i].name),
               channel_letter(name)) == 0)
      return &b->planes.planes[i];
  return NULL;
}

static int check_fit(const compare_side *a, const compare_side *b,
                     image_error *error) {
  if (a->planes.width != b->planes.width ||
      a->planes.height != b->planes.height)
    return image_fail(error,
                      "%s: %u x %u pixels, but %s has %u x %u; images of one "
                      "size are needed",
                      a->path, a->planes.width, a->planes.height, b->path,
                      b->planes.width, b->planes.height);
  if (a->planes.count != b->planes.count)
    return image_fail(error,
                      "%s: %zu channels, but %s has %zu; FILE:LAYER with the "
                      "same channels on both sides is needed",
                      a->path, a->planes.count, b->path, b->planes.count);
  for (size_t i = 0; i < a->planes.count; i++)
    if (!compare_partner(a, b, a->planes.planes[i].name))
      return image_fail(error,
                        "%s: channel %s has no partner in %s; layers with the "
                        "same channels are needed",
                        a->path, a->planes.planes[i].name, b->path);
  return 0;
}

static int has_root(const image *header) {
  for (size_t i = 0; i < header->count; i++)
    if (!strchr(header->planes[i].name, '.'))
      return 1;
  return 0;
}

/* A single layer is meant for both files, unless the other one has no such
 * layer, but channels without any. */
static void share_layer(compare_side *a, compare_side *b) {
  compare_side *without = a->layer ? b : a;
  const char *layer = a->layer ? a->layer : b->layer;
  if (!a->layer == !b->layer)
    return;
  without->layer = compare_layer_exists(&without->header, layer) ||
                           !has_root(&without->header)
                       ? layer
                       : "";
}

static int read_planes(compare_side *a, compare_side *b, image_error *error) {
  const char **selected =
      calloc(a->header.count + b->header.count + 1, sizeof *selected);
  if (!selected)
    return image_no_memory(error, a->path);
  share_layer(a, b);
  const int failed =
      read_side(a, selected, error) != 0 || read_side(b, selected, error) != 0;
  free(selected);
  return failed ? -1 : check_fit(a, b, error);
}

int compare_sides_read(const char *first, const char *second, compare_side *a,
                       compare_side *b, image_error *error) {
  memset(a, 0, sizeof *a);
  memset(b, 0, sizeof *b);
  return parse_side(first, a, error) != 0 || parse_side(second, b, error) != 0
             ? -1
             : read_planes(a, b, error);
}
