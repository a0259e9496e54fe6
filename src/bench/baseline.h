/* The paper's method as one plain kernel: what the library is compared to. */
#ifndef HBIL_BENCH_BASELINE_H
#define HBIL_BENCH_BASELINE_H

#include "bench/content.h"
#include "bench/opencl.h"

enum { BENCH_BASELINE_SLICES = 2, BENCH_BASELINE_STEPS = 8 };

typedef struct bench_baseline {
  bench_spread milliseconds;
  double ao_error, light_error; /* without any filter */
} bench_baseline;

/* exact_ao, exact_light: the exact integral of the paper's model. */
int bench_baseline_measure(const bench_device *d, const bench_content *content,
                           unsigned runs, const float *exact_ao,
                           const float *exact_light, bench_baseline *out,
                           image_error *error);

#endif
