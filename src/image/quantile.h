/*
 * Quantiles of numbers.
 */
#ifndef HBIL_IMAGE_QUANTILE_H
#define HBIL_IMAGE_QUANTILE_H

#include <stddef.h>

/* Sorts numbers, the smallest first.  None may be NAN. */
void sort_ascending(double *values, size_t count);

/* The number that this share of them, 0..1, doesn't exceed; NAN if there are
 * none.  Sorts them. */
double quantile(double *values, size_t count, double share);

#endif
