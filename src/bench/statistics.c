/* Medians and errors. */
#include "bench/bench.h"

#include <math.h>
#include <stdlib.h>

static const float least_albedo = 0.02f;

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

/* Over the surfaces that are compared; divides by the mean of b if relative.  A
 * value that is not finite makes the sum so. */
static double surface_error(const bench_content *content, const float *a,
                            const float *b, int channels, int relative) {
  const size_t pixels = bench_pixels(content);
  double square = 0.0, sum = 0.0, count = 0.0;
  for (size_t i = 0; i < pixels; i++) {
    if (!content->compared[i] || !bench_is_surface(content, i))
      continue;
    for (int c = 0; c < channels; c++) {
      const size_t at = (size_t)c * pixels + i;
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
                      const float *reference) {
  return surface_error(content, ao, reference, 1, 0);
}

double bench_light_error(const bench_content *content, const float *light,
                         const float *reference) {
  return surface_error(content, light, reference, 3, 1);
}

/* The largest error of the channels of each surface that is compared; their
 * mean, and how many pixels. */
static size_t pixel_errors(const bench_content *content, const float *a,
                           const float *b, int channels, double *out,
                           double *mean) {
  const size_t pixels = bench_pixels(content);
  size_t count = 0;
  double sum = 0.0;
  for (size_t i = 0; i < pixels; i++) {
    if (!content->compared[i] || !bench_is_surface(content, i))
      continue;
    double most = 0.0;
    for (int c = 0; c < channels; c++) {
      const size_t at = (size_t)c * pixels + i;
      most = fmax(most, fabs((double)a[at] - (double)b[at]));
      sum += (double)b[at];
    }
    out[count++] = most;
  }
  *mean = sum / (double)(count * (size_t)channels);
  return count;
}

static int beyond_95(const bench_content *content, const float *a,
                     const float *b, int channels, double *out,
                     image_error *error) {
  double mean = 0.0;
  double *errors = malloc((content->compared_count + 1) * sizeof *errors);
  if (!errors)
    return image_no_memory(error, "errors");
  const size_t count = pixel_errors(content, a, b, channels, errors, &mean);
  *out = NAN;
  if (count > 0) {
    qsort(errors, count, sizeof *errors, ascending);
    *out = errors[(count - 1) * 95 / 100] / (channels > 1 ? mean : 1.0);
  }
  free(errors);
  return 0;
}

int bench_ao_95(const bench_content *content, const float *ao,
                const float *reference, double *out, image_error *error) {
  return beyond_95(content, ao, reference, 1, out, error);
}

int bench_light_95(const bench_content *content, const float *light,
                   const float *reference, double *out, image_error *error) {
  return beyond_95(content, light, reference, 3, out, error);
}

/* --- against the truth --- */

static int counts(const bench_content *content, size_t pixel, int channel) {
  const float *albedo = content->frame[0].plane[BENCH_ALBEDO];
  const size_t at = (size_t)channel * bench_pixels(content) + pixel;
  return bench_is_surface(content, pixel) && isfinite(content->truth[at]) &&
         (!albedo || albedo[at] > least_albedo);
}

/* Sum of squared errors of indirect, or of value where that is NULL. */
static double channel_square(const bench_content *content, int channel,
                             const float *indirect, double value,
                             double *count) {
  const size_t pixels = bench_pixels(content);
  double square = 0.0;
  for (size_t i = 0; i < pixels; i++) {
    const size_t at = (size_t)channel * pixels + i;
    if (!counts(content, i, channel))
      continue;
    const double off =
        (indirect ? (double)indirect[at] : value) - (double)content->truth[at];
    square += off * off;
    *count += 1.0;
  }
  return square;
}

static double channel_mean(const bench_content *content, int channel) {
  const size_t pixels = bench_pixels(content);
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < pixels; i++)
    if (counts(content, i, channel)) {
      sum += (double)content->truth[(size_t)channel * pixels + i];
      count += 1.0;
    }
  return sum / count;
}

double bench_model_error(const bench_content *content, const float *indirect) {
  double square = 0.0, count = 0.0;
  for (int c = 0; c < 3; c++)
    square += channel_square(content, c, indirect, 0.0, &count);
  return sqrt(square / count);
}

double bench_mean_error(const bench_content *content) {
  double square = 0.0, count = 0.0;
  for (int c = 0; c < 3; c++)
    square +=
        channel_square(content, c, NULL, channel_mean(content, c), &count);
  return sqrt(square / count);
}
