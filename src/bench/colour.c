/* Layers of three channels. */
#define _POSIX_C_SOURCE 200809L
#include "bench/colour.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/exr_read.h"

static const char *const letters[3] = {"R", "G", "B"};

/* Whether a channel is that letter of a layer. */
static int is_of(const char *channel, const char *layer, const char *letter) {
  char tail[64];
  snprintf(tail, sizeof tail, "%s%s%s", layer, *layer ? "." : "", letter);
  const size_t whole = strlen(channel), part = strlen(tail);
  if (whole < part || strcmp(channel + whole - part, tail) != 0)
    return 0;
  return whole == part || (*layer && channel[whole - part - 1] == '.');
}

static int find_in(const image *header, const char *layer,
                   const char *names[3]) {
  int found = 0;
  for (int c = 0; c < 3; c++) {
    names[c] = NULL;
    for (size_t i = 0; i < header->count && !names[c]; i++)
      if (is_of(header->planes[i].name, layer, letters[c]))
        names[c] = header->planes[i].name;
    found += names[c] != NULL;
  }
  return found == 3;
}

int bench_colour_find(const image *header, const char *const *layers,
                      const char *names[3]) {
  for (int i = 0; layers[i]; i++)
    if (find_in(header, layers[i], names))
      return 1;
  return 0;
}

/* exr_read() returns the planes in the order that was asked for. */
static void name_planes(image *planes) {
  for (int c = 0; c < 3; c++)
    snprintf(planes->planes[c].name, sizeof planes->planes[c].name, "%s",
             letters[c]);
}

int bench_colour_read(const char *path, const char *const *layers,
                      compare_side *out, image_error *error) {
  const char *names[3];
  memset(out, 0, sizeof *out);
  out->path = strdup(path);
  if (!out->path)
    return image_no_memory(error, path);
  if (exr_read_header(path, &out->header, error) != 0)
    return -1;
  if (!bench_colour_find(&out->header, layers, names))
    return image_fail(error,
                      "%s: no indirect light; channels %s.{R,G,B} are needed",
                      path, layers[0]);
  if (exr_read(path, names, 3, &out->planes, error) != 0)
    return -1;
  name_planes(&out->planes);
  return 0;
}

int bench_colour_fill(const image *size, const double rgb[3], compare_side *out,
                      image_error *error) {
  const size_t pixels = (size_t)size->width * size->height;
  memset(out, 0, sizeof *out);
  out->planes.width = size->width;
  out->planes.height = size->height;
  out->path = strdup("a constant colour");
  if (!out->path)
    return image_no_memory(error, "a constant colour");
  for (int c = 0; c < 3; c++) {
    image_plane *plane = image_add(&out->planes, letters[c]);
    if (!plane)
      return image_no_memory(error, out->path);
    for (size_t i = 0; i < pixels; i++)
      plane->pixels[i] = (float)rgb[c];
  }
  return 0;
}
