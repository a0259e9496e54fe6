/* Medians of times, and of their ratios. */
#ifndef HBIL_BENCH_STATISTICS_H
#define HBIL_BENCH_STATISTICS_H

#include <stddef.h>

/* Runs before the first that is counted. */
enum { BENCH_WARM_UP = 2 };

typedef struct bench_spread {
  double median, low, high;
} bench_spread;

/* count: at least 1.  Sorts values. */
bench_spread bench_spread_of(double *values, unsigned count);

/* The median of numerators[i] / denominators[i].  Both were measured in the
 * same turn, so whatever slows the machine for a while slows both.
 * count: 1..BENCH_MAX_RUNS. */
double bench_median_ratio(const double *numerators, const double *denominators,
                          unsigned count);

#endif
