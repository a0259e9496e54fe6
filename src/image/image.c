#include "image/image.h"
#include "image/image_memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void image_free(image *img) {
  if (!img)
    return;
  for (size_t i = 0; i < img->count; i++)
    if (!img->planes[i].is_lent) {
      free(img->planes[i].pixels);
      free(img->planes[i].halves);
    }
  free(img->planes);
  free(img->numbers);
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

/* Adds a plane with memory that is lent, or else malloc'd. */
static image_plane *add(image *img, const char *name, size_t element,
                        void **memory) {
  const size_t bytes = (size_t)img->width * img->height * element;
  void *lent = image_memory_take(bytes);
  *memory = lent ? lent : malloc(bytes + 1);
  image_plane *plane = *memory ? image_declare(img, name) : NULL;
  if (!plane && !lent)
    free(*memory);
  if (plane)
    plane->is_lent = lent != NULL;
  return plane;
}

image_plane *image_add_unset(image *img, const char *name) {
  void *memory;
  image_plane *plane = add(img, name, sizeof *plane->pixels, &memory);
  if (plane)
    plane->pixels = memory;
  return plane;
}

image_plane *image_add(image *img, const char *name) {
  image_plane *plane = image_add_unset(img, name);
  if (plane)
    memset(plane->pixels, 0, sizeof *plane->pixels * img->width * img->height);
  return plane;
}

image_plane *image_add_halves(image *img, const char *name) {
  void *memory;
  image_plane *plane = add(img, name, sizeof *plane->halves, &memory);
  if (plane) {
    plane->halves = memory;
    plane->type = IMAGE_HALF;
  }
  return plane;
}

image_window image_data_window(const image *img) {
  return (image_window){img->x, img->y, img->width, img->height};
}

image_window image_display_window(const image *img) {
  return img->display.width ? img->display : image_data_window(img);
}
