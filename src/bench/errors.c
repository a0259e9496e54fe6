/* How far results are off from the exact integral. */
#include <math.h>

#include "bench/content.h"

/* RMSE over the compared surfaces; relative: divided by the mean of b.  A value
 * that is not finite makes the result so. */
static double surface_error(const bench_content *content, const float *a,
                            const float *b, size_t channels, int relative) {
  const size_t pixels = bench_pixels(content);
  double square = 0.0, sum = 0.0, count = 0.0;
  for (size_t i = 0; i < pixels; i++) {
    if (!content->compared[i] || !bench_is_surface(content, i))
      continue;
    for (size_t c = 0; c < channels; c++) {
      const size_t at = c * pixels + i;
      const double off = (double)a[at] - (double)b[at];
      square += off * off;
      sum += (double)b[at];
      count += 1.0;
    }
  }
  const double rmse = sqrt(square / count);
  return relative ? rmse / (sum / count) : rmse;
}

double bench_ao_error(const bench_content *content, const float *ao,
                      const float *exact) {
  return surface_error(content, ao, exact, 1, 0);
}

double bench_light_error(const bench_content *content, const float *light,
                         const float *exact) {
  return surface_error(content, light, exact, 3, 1);
}
