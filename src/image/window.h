/*
 * Rectangles of pixels in the coordinates that OpenEXR uses: y points down,
 * and the corner may be negative.
 */
#ifndef HBIL_IMAGE_WINDOW_H
#define HBIL_IMAGE_WINDOW_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct image_window {
  int32_t x, y; /* the top left pixel */
  uint32_t width, height;
} image_window;

/* The smallest window that contains both. */
image_window image_window_union(image_window a, image_window b);

/* The intersection; 0 x 0 pixels if the two don't overlap. */
image_window image_window_common(image_window a, image_window b);

/* Copies the pixels that both windows contain from one plane to another and
 * sets the other pixels of `out` to zero.  Each plane holds one float per pixel
 * of its window, row by row. */
void image_place(const float *pixels, image_window from, float *out,
                 image_window to);

#ifdef __cplusplus
}
#endif

#endif
