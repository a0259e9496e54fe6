/* The two images of `hbil compare`. */
#define _POSIX_C_SOURCE 200809L
#include "tool/compare_sides.h"

#include "image/error.h"
#include "image/exr_read.h"
#include "image/image.h"

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
  return exr_read_header(out->path, &out->header, error);
}

void compare_side_free(compare_side *s) {
  image_free(&s->header);
  image_free(&s->planes);
  free(s->path);
}

/* Whether a name is `wanted`, or that behind a view layer: "DiffInd" stands for
 * "ViewLayer.DiffInd". */
static int ends_in(const char *name, size_t length, const char *wanted) {
  const size_t tail = strlen(wanted);
  return length >= tail && strncmp(name + length - tail, wanted, tail) == 0 &&
         (length == tail || name[length - tail - 1] == '.');
}

static int in_layer(const char *channel, const char *wanted) {
  const char *dot = strrchr(channel, '.');
  return !wanted || ends_in(channel, strlen(channel), wanted) ||
         (dot && ends_in(channel, (size_t)(dot - channel), wanted));
}

const char *channel_letter(const char *channel) {
  const char *dot = strrchr(channel, '.');
  return dot ? dot + 1 : channel;
}

/* The alpha of a layer is coverage and is not compared. */
static int select_channels(const compare_side *s, const char **out) {
  int count = 0;
  for (size_t i = 0; i < s->header.count; i++)
    if (in_layer(s->header.planes[i].name, s->layer) &&
        !(s->layer &&
          strcmp(channel_letter(s->header.planes[i].name), "A") == 0))
      out[count++] = s->header.planes[i].name;
  return count;
}

static int read_side(compare_side *s, const char **selected, int *count,
                     image_error *error) {
  *count = select_channels(s, selected);
  if (*count == 0)
    return image_fail(error,
                      "%s: has no layer %s; the part of its channels' names "
                      "in front of the dot is needed",
                      s->path, s->layer ? s->layer : "at all");
  return exr_read(s->path, selected, (size_t)*count, &s->planes, error);
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
                      "%s: %zu channels, but %s has %zu; layers with the same "
                      "channels are needed",
                      a->path, a->planes.count, b->path, b->planes.count);
  for (size_t i = 0; i < a->planes.count; i++)
    if (!compare_partner(a, b, a->planes.planes[i].name))
      return image_fail(error,
                        "%s: channel %s has no partner in %s; layers with the "
                        "same channels are needed",
                        a->path, a->planes.planes[i].name, b->path);
  return 0;
}

static int read_planes(compare_side *a, compare_side *b, image_error *error) {
  int count;
  const char **selected =
      calloc(a->header.count + b->header.count + 1, sizeof *selected);
  if (!selected)
    return image_no_memory(error, a->path);
  if (!a->layer != !b->layer) { /* a single layer is meant for both */
    a->layer = a->layer ? a->layer : b->layer;
    b->layer = a->layer;
  }
  const int failed = read_side(a, selected, &count, error) != 0 ||
                     read_side(b, selected, &count, error) != 0;
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
