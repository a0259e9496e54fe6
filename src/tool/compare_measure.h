/* Measures of the difference of two images: of which pixels, of which means,
 * and how much they differ. */
#ifndef HBIL_TOOL_COMPARE_MEASURE_H
#define HBIL_TOOL_COMPARE_MEASURE_H

#include "dump/gbuffer.h"
#include "image/error.h"
#include "image/image.h"
#include "tool/compare_sides.h"

/* ------------------------------------------------------------------------ */
/* Which pixels are compared: the surfaces of a G-buffer                     */

typedef struct compare_mask {
  gbuffer g;  /* without planes, all pixels are compared */
  int albedo; /* 1: black surfaces are not compared either */
} compare_mask;

/* Reads the G-buffer `path`; NULL compares all pixels.  like: an image of the
 * size that it must have.  Returns 0, or -1 with `error` filled;
 * compare_mask_free() frees it in both cases. */
int compare_mask_read(const char *path, int albedo, const image *like,
                      compare_mask *out, image_error *error);
void compare_mask_free(compare_mask *m);

/* The mask of one channel; the planes are the G-buffer's own or NULL. */
typedef struct channel_mask {
  const float *depth, *albedo;
} channel_mask;

/* letter: the last part of the channel's name. */
channel_mask compare_mask_channel(const compare_mask *m, const char *letter);

/* Whether pixel i of the channel is compared. */
int channel_mask_has(const channel_mask *m, size_t i);

/* ------------------------------------------------------------------------ */
/* Means over blocks of pixels                                               */

/* Replaces what is compared by means over blocks of size x size pixels, which
 * begin at the top left; those at the right and at the bottom may be smaller.
 * Pixels that the mask leaves out, or that aren't finite in both images, don't
 * count and aren't changed. */
void compare_take_means(compare_side *a, compare_side *b, const compare_mask *m,
                        unsigned size);

/* ------------------------------------------------------------------------ */
/* Measures                                                                  */

typedef struct compare_result {
  double rmse, relative; /* relative: mean of (a-b)^2 / (b^2 + 0.01) */
  double psnr;           /* dB, against peak; infinity for equal images */
  double largest;        /* largest |a-b| */
  double peak, mean;     /* of b: largest |b|, mean */
  double within;         /* 95 % of the pixels differ by no more */
  size_t values, not_finite;
} compare_result;

/* heat: NULL, or a float for each pixel, which gets the pixel's error.  0, or
 * -1 with `error` filled. */
int compare_measure(const compare_side *a, const compare_side *b,
                    const compare_mask *m, float *heat, compare_result *out,
                    image_error *error);

/* The error that one pixel in a hundred exceeds, as the limit of a heat map: a
 * single bright pixel would hide all others.  0, or -1 if memory runs out. */
int compare_heat_limit(const float *heat, size_t pixels, float *limit);

#endif
