/*
 * Pictures of 8 bits that are composed of tiles and text, through OpenImageIO.
 */
#ifndef HBIL_IMAGE_PICTURE_H
#define HBIL_IMAGE_PICTURE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct picture {
  uint32_t width, height;
  unsigned char *rgb; /* width*height*3 bytes, the top row first; owned */
} picture;

typedef struct picture_window {
  uint32_t x, y, width, height;
} picture_window;

/* Which point of a text the x coordinate gives. */
typedef enum picture_align {
  PICTURE_LEFT = 0, /* its beginning */
  PICTURE_CENTRE,   /* its middle */
  PICTURE_RIGHT     /* its end */
} picture_align;

/* R, G and B of a new picture. */
enum { PICTURE_GREY = 32 };

/* 0..1 as a byte; what lies outside becomes 0 or 255, and NaN 0. */
static inline unsigned char picture_byte(float value) {
  if (!(value > 0.0f))
    return 0;
  return (unsigned char)(value < 1.0f ? value * 255.0f + 0.5f : 255.0f);
}

/* The functions below return 0, or -1 if memory runs out. */

int picture_new(uint32_t width, uint32_t height, picture *out);

/* Frees the pixels and zeroes the picture.  A zeroed picture is allowed. */
void picture_free(picture *p);

/* Resizes a tile to the window's size and copies it there. */
int picture_tile(picture *to, const picture_window *at, const picture *tile);

/* Draws white text of `size` pixels height on the base line y.  Also returns -1
 * if there is no font (Debian: fonts-dejavu-core). */
int picture_text(picture *to, int x, int y, int size, picture_align align,
                 const char *text);

#ifdef __cplusplus
}
#endif

#endif
