/* Measures of the difference of two images. */
#ifndef HBIL_TOOL_COMPARE_MEASURE_H
#define HBIL_TOOL_COMPARE_MEASURE_H

#include "tool/compare_mask.h"
#include "tool/compare_sides.h"
#include "image/error.h"

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
