#include "image/exr_rgb.h"
#include "image/exr_read.h"
#include "image/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Finds PREFIX.R, PREFIX.G and PREFIX.B; `red` is the name of the first. */
static int find_layer(const image *header, const char *red,
                      const char *names[3]) {
  char name[sizeof header->planes->name];
  const size_t last = strlen(red) - 1;
  for (int c = 0; c < 3; c++) {
    snprintf(name, sizeof name, "%s", red);
    name[last] = "RGB"[c];
    const image_plane *plane = image_find(header, name);
    if (!plane)
      return 0;
    names[c] = plane->name;
  }
  return 1;
}

static int choose_channels(const image *header, const char *names[3]) {
  const image_plane *grey = image_find(header, "Y");
  for (size_t i = 0; i < header->count; i++) {
    const char *name = header->planes[i].name;
    const size_t length = strlen(name);
    if (length > 0 && name[length - 1] == 'R' &&
        (length == 1 || name[length - 2] == '.') &&
        find_layer(header, name, names))
      return 1;
  }
  if (!grey && header->count == 1)
    grey = header->planes;
  for (int c = 0; grey && c < 3; c++)
    names[c] = grey->name;
  return grey != NULL;
}

static int interleave(const char *path, const image *planes,
                      const char *const names[3], float **rgb,
                      image_error *error) {
  const size_t pixels = (size_t)planes->width * planes->height;
  *rgb = malloc(3 * sizeof **rgb * pixels);
  if (!*rgb)
    return image_no_memory(error, path);
  for (size_t c = 0; c < 3; c++) {
    const float *from = image_find(planes, names[c])->pixels;
    for (size_t i = 0; i < pixels; i++)
      (*rgb)[3 * i + c] = from[i];
  }
  return 0;
}

int exr_read_rgb(const char *path, float **rgb, uint32_t *width,
                 uint32_t *height, image_error *error) {
  const char *names[3];
  image header, planes;
  if (exr_read_header(path, &header, error) != 0)
    return -1;
  memset(&planes, 0, sizeof planes);
  int failed;
  if ((uint64_t)header.width * header.height > RGB_MAX_PIXELS)
    failed = image_fail(error, "%s: %u x %u pixels; at most %d are needed",
                        path, header.width, header.height, RGB_MAX_PIXELS);
  else if (!choose_channels(&header, names))
    failed = image_fail(error,
                        "%s: no channels R, G and B, nor Y, of which "
                        "a map is made",
                        path);
  else
    failed = exr_read(path, names, 3, &planes, error) != 0 ||
             interleave(path, &planes, names, rgb, error) != 0;
  *width = header.width;
  *height = header.height;
  image_free(&planes);
  image_free(&header);
  return failed ? -1 : 0;
}
