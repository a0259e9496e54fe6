/* Medians of times, and shares of other values. */
#include "bench/statistics.h"

#include <math.h>
#include <stdlib.h>

#include "bench/command.h"

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

bench_spread bench_spread_of(double *values, unsigned count) {
  qsort(values, count, sizeof *values, ascending);
  return (bench_spread){.median =
                            0.5 * (values[(count - 1) / 2] + values[count / 2]),
                        .low = values[0],
                        .high = values[count - 1]};
}

double bench_quantile(double *values, size_t count, double share) {
  if (!count)
    return NAN;
  qsort(values, count, sizeof *values, ascending);
  return values[(size_t)(share * (double)(count - 1))];
}

double bench_median_ratio(const double *numerators, const double *denominators,
                          unsigned count) {
  double ratios[BENCH_MAX_RUNS];
  for (unsigned i = 0; i < count; i++)
    ratios[i] = numerators[i] / denominators[i];
  return bench_spread_of(ratios, count).median;
}
