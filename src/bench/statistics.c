/* Medians of times, and of their ratios. */
#include "bench/statistics.h"

#include "bench/command.h"
#include "image/quantile.h"

bench_spread bench_spread_of(double *values, unsigned count) {
  sort_ascending(values, count);
  return (bench_spread){.median =
                            0.5 * (values[(count - 1) / 2] + values[count / 2]),
                        .low = values[0],
                        .high = values[count - 1]};
}

double bench_median_ratio(const double *numerators, const double *denominators,
                          unsigned count) {
  double ratios[BENCH_MAX_RUNS];
  for (unsigned i = 0; i < count; i++)
    ratios[i] = numerators[i] / denominators[i];
  return bench_spread_of(ratios, count).median;
}
