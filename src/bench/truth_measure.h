/* How far an answer's indirect light is from the truth. */
#ifndef HBIL_BENCH_TRUTH_MEASURE_H
#define HBIL_BENCH_TRUTH_MEASURE_H

#include <stddef.h>

#include "image/error.h"
#include "tool/compare_measure.h"
#include "tool/compare_sides.h"

typedef struct truth_figures {
  double rmse;   /* that of hbil compare --mask */
  double mean;   /* of the answer, over the same values */
  double chroma; /* see below; NAN where no pixel counts */
  size_t not_finite;
} truth_figures;

/*
 * Measures an answer of the truth's size.  chroma: the chromaticity of a pixel
 * is the vector (R, G, B) / (R + G + B), where what is negative counts as 0, or
 * a third each for black.  The error is the root of the mean of the squared
 * distances between the answer's and the truth's, weighted by the truth's
 * luminance.  Pixels count of which the mask has all three channels and whose
 * luminance in the truth is above a thousandth of its mean.  Returns 0, or -1
 * with `error` filled.
 */
int truth_measure(const compare_side *answer, const compare_side *truth,
                  const compare_mask *mask, truth_figures *out,
                  image_error *error);

/* The same for one colour everywhere. */
int truth_measure_constant(const double rgb[3], const compare_side *truth,
                           const compare_mask *mask, truth_figures *out,
                           image_error *error);

/* The truth's mean colour where the mask has each channel. */
void truth_mean_colour(const compare_side *truth, const compare_mask *mask,
                       double rgb[3]);

#endif
