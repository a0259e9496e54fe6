/* Planes of floats, the message of a failure, and files written whole. */
#define _POSIX_C_SOURCE 200809L
#include "image/image.h"
#include "image/temporary.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int image_fail(image_error *error, const char *format, ...) {
  if (error) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
  }
  return -1;
}

int image_no_memory(image_error *error, const char *path) {
  return image_fail(error,
                    "%s: not enough memory; a smaller image or a machine with "
                    "more memory is needed",
                    path);
}

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

/* The process id keeps two runs that write the same file apart. */
char *temporary_name(const char *path, image_error *error) {
  const size_t size = strlen(path) + 32;
  char *name = malloc(size);
  if (!name) {
    image_no_memory(error, path);
    return NULL;
  }
  snprintf(name, size, "%s.tmp%ld", path, (long)getpid());
  return name;
}

void temporary_discard(char *name) {
  if (name)
    unlink(name);
  free(name);
}

int temporary_commit(char *name, const char *path, image_error *error) {
  if (rename(name, path) != 0) {
    image_fail(error, "%s: cannot be written: %s", path, strerror(errno));
    temporary_discard(name);
    return -1;
  }
  free(name);
  return 0;
}
