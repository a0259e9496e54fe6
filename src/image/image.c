#include "image/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void image_free(image *img) {
  if (!img)
    return;
  for (size_t i = 0; i < img->count; i++)
    free(img->planes[i].pixels);
  free(img->planes);
  memset(img, 0, sizeof *img);
}

image_plane *image_find(const image *img, const char *name) {
  for (size_t i = 0; i < img->count; i++)
    if (strcmp(img->planes[i].name, name) == 0)
      return &img->planes[i];
  return NULL;
}

image_plane *image_declare(image *img, const char *name) {
  image_plane *planes = realloc(img->planes, (img->count + 1) * sizeof *planes);
  if (!planes)
    return NULL;
  img->planes = planes;
  image_plane *plane = &planes[img->count];
  memset(plane, 0, sizeof *plane);
  snprintf(plane->name, sizeof plane->name, "%s", name);
  img->count++;
  return plane;
}

image_plane *image_add(image *img, const char *name) {
  const size_t pixels = (size_t)img->width * img->height;
  float *zeros = calloc(pixels ? pixels : 1, sizeof *zeros);
  image_plane *plane = zeros ? image_declare(img, name) : NULL;
  if (!plane) {
    free(zeros);
    return NULL;
  }
  plane->pixels = zeros;
  return plane;
}

image_window image_data_window(const image *img) {
  return (image_window){img->x, img->y, img->width, img->height};
}

image_window image_display_window(const image *img) {
  return img->display.width ? img->display : image_data_window(img);
}
