/*
 * An image in host memory: named planes of floats, and what its file's header
 * tells about them.  Files are read and written by other modules.
 */
#ifndef HBIL_IMAGE_H
#define HBIL_IMAGE_H

#include "image/window.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The type of a channel in its file.  In memory, halves are floats. */
typedef enum image_type { IMAGE_FLOAT = 0, IMAGE_HALF, IMAGE_UINT } image_type;

/* One channel: width*height floats, row by row, the top row first. */
typedef struct image_plane {
  char name[256];  /* full channel name, e.g. "ViewLayer.Depth.Z" */
  float *pixels;   /* owned by the image, unless they are lent; NULL if only the
                      header was read */
  image_type type; /* IMAGE_UINT: the pixels are the bits of uint32_t values */
  uint16_t *halves; /* IEEE halves in place of pixels, which are NULL then, for
                       a file that is written; else NULL */
  int is_lent;      /* 1: pixels or halves lie in an image_memory */
} image_plane;

/* The camera matrices that some renderers store in the header, unchanged. */
typedef struct image_matrices {
  int has_camera, has_ndc;
  double world_to_camera[16], world_to_ndc[16];
} image_matrices;

/* Views of a multi-view file, and the characters of a name, at most. */
enum { IMAGE_VIEWS = 16, IMAGE_VIEW_NAME = 64 };

/* A number in the header, under a name of the program's own. */
enum { IMAGE_NUMBERS = 64, IMAGE_NUMBER_NAME = 128 };
typedef struct image_number {
  char name[IMAGE_NUMBER_NAME];
  double value;
} image_number;

typedef struct image {
  uint32_t width, height; /* size of the data window */
  int32_t x, y;           /* top left corner of the data window */
  image_window display;   /* width 0: the same as the data window */
  size_t count;
  image_plane *planes;
  image_matrices matrices;
  char origin[128];  /* the program that wrote the file, if the header says */
  size_t view_count; /* of a multi-view file; 0: it is none */
  char views[IMAGE_VIEWS][IMAGE_VIEW_NAME]; /* the default view first */
  size_t number_count; /* the first ones of the header, IMAGE_NUMBERS at most */
  image_number *numbers; /* owned; NULL: none */
  int gamma;    /* 1: colours are encoded as sRGB; 0: they are linear */
  int integers; /* 1: values are stored as integers, which stand for 0..1 */
  char key[32]; /* identifies what the image was computed from (see
                 * exr_key.h); "" if the file has no such attribute */
  /* Of hbil's layers, in world units: near_irradiance is light of surfaces
   * within the first one and far_irradiance light of what is beyond it; ao,
   * bent_normal and cone_cosine count occluders within the second one.  0: the
   * file doesn't say */
  float near_radius, ao_radius;
} image;

/* Frees the planes and zeroes the image.  A zeroed image and NULL are allowed.
 */
void image_free(image *img);

/* Returns the plane of that name, or NULL. */
image_plane *image_find(const image *img, const char *name);

/* Adds a plane of zeros.  Returns it, or NULL if memory runs out.  Pointers to
 * other planes of the image become invalid; pointers to their pixels do not. */
image_plane *image_add(image *img, const char *name);

/* The same, with pixels of any value, for those who set them all. */
image_plane *image_add_unset(image *img, const char *name);

/* The same, of halves. */
image_plane *image_add_halves(image *img, const char *name);

/* Adds a plane without pixels, for an image of which only the header is read.
 */
image_plane *image_declare(image *img, const char *name);

image_window image_data_window(const image *img);
image_window image_display_window(const image *img);

#ifdef __cplusplus
}
#endif

#endif
