/* Quantiles of numbers. */
#include "image/quantile.h"

#include <math.h>
#include <stdlib.h>

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

void sort_ascending(double *values, size_t count) {
  if (count)
    qsort(values, count, sizeof *values, ascending);
}

double quantile(double *values, size_t count, double share) {
  if (!count)
    return NAN;
  sort_ascending(values, count);
  return values[(size_t)(share * (double)(count - 1))];
}
