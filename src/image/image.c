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

/* ------------------------------------------------------------------------ */
/* Windows                                                                   */

image_window image_data_window(const image *img) {
  return (image_window){img->x, img->y, img->width, img->height};
}

image_window image_display_window(const image *img) {
  return img->display.width ? img->display : image_data_window(img);
}

static int64_t lower(int64_t a, int64_t b) {
  return a < b ? a : b;
}

static int64_t upper(int64_t a, int64_t b) {
  return a > b ? a : b;
}

/* Corners of a window: left, top, right, bottom. */
static void corners(image_window w, int64_t out[4]) {
  out[0] = w.x;
  out[1] = w.y;
  out[2] = (int64_t)w.x + w.width;
  out[3] = (int64_t)w.y + w.height;
}

static image_window between(int64_t left, int64_t top, int64_t right,
                            int64_t bottom) {
  if (right <= left || bottom <= top)
    return (image_window){0, 0, 0, 0};
  return (image_window){(int32_t)left, (int32_t)top, (uint32_t)(right - left),
                        (uint32_t)(bottom - top)};
}

image_window image_window_union(image_window a, image_window b) {
  int64_t p[4], q[4];
  corners(a, p);
  corners(b, q);
  return between(lower(p[0], q[0]), lower(p[1], q[1]), upper(p[2], q[2]),
                 upper(p[3], q[3]));
}

image_window image_window_common(image_window a, image_window b) {
  int64_t p[4], q[4];
  corners(a, p);
  corners(b, q);
  return between(upper(p[0], q[0]), upper(p[1], q[1]), lower(p[2], q[2]),
                 lower(p[3], q[3]));
}

void image_place(const float *pixels, image_window from, float *out,
                 image_window to) {
  const image_window both = image_window_common(from, to);
  if (both.width != to.width || both.height != to.height)
    memset(out, 0, sizeof *out * to.width * to.height);
  for (uint32_t y = 0; y < both.height; y++) {
    const size_t left = (size_t)((int64_t)both.x - from.x);
    const size_t top = (size_t)((int64_t)both.y - from.y) + y;
    const size_t x = (size_t)((int64_t)both.x - to.x);
    const size_t row = (size_t)((int64_t)both.y - to.y) + y;
    memcpy(out + row * to.width + x, pixels + top * from.width + left,
           both.width * sizeof *out);
  }
}

/* ------------------------------------------------------------------------ */
/* Any file                                                                  */

int image_read_header(const char *path, image *out, image_error *error) {
  return formats_recognise(path) ? formats_read_header(path, out, error)
                                 : exr_read_header(path, out, error);
}

int image_read(const char *path, const char *const *names, size_t count,
               image *out, image_error *error) {
  return formats_recognise(path) ? formats_read(path, names, count, out, error)
                                 : exr_read(path, names, count, out, error);
}

/* ------------------------------------------------------------------------ */
/* Files written whole                                                       */

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
