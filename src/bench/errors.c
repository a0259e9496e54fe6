/* How far results are off from the exact integral. */
#include <math.h>
#include <stdlib.h>

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

double bench_ao_mean(const bench_content *content, const float *ao) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < bench_pixels(content); i++)
    if (content->compared[i] && bench_is_surface(content, i)) {
      sum += (double)ao[i];
      count += 1.0;
    }
  return sum / count;
}

double bench_ao_error(const bench_content *content, const float *ao,
                      const float *exact) {
  return surface_error(content, ao, exact, 1, 0);
}

double bench_light_error(const bench_content *content, const float *light,
                         const float *exact) {
  return surface_error(content, light, exact, 3, 1);
}

/* --- the band of structures that an eye sees --- */

/* Standard deviations of the two Gaussians, pixels: between them lie waves of
 * some 8 to 60 pixels. */
static const double fine = 1.5, coarse = 8.0;

/* The window's errors, and 1 where there is a surface, or 0 for both. */
typedef struct patch {
  size_t width, height;
  double *error, *weight;
} patch;

/* One axis of a blur that is cut off at three standard deviations: sums of
 * `count` values that lie `stride` apart, not divided by the weights. */
static void blur_line(const double *from, double *to, size_t count,
                      size_t stride, double sigma) {
  const size_t reach = (size_t)ceil(3.0 * sigma);
  for (size_t i = 0; i < count; i++) {
    const size_t last = i + reach < count ? i + reach : count - 1;
    double sum = 0.0;
    for (size_t k = i > reach ? i - reach : 0; k <= last; k++) {
      const double off = ((double)k - (double)i) / sigma;
      sum += exp(-0.5 * off * off) * from[k * stride];
    }
    to[i * stride] = sum;
  }
}

/* between: as large as the patch. */
static void blur_plane(const patch *p, const double *from, double sigma,
                       double *between, double *to) {
  for (size_t y = 0; y < p->height; y++)
    blur_line(from + y * p->width, between + y * p->width, p->width, 1, sigma);
  for (size_t x = 0; x < p->width; x++)
    blur_line(between + x, to + x, p->height, p->width, sigma);
}

static double band_of(const patch *p, double *memory) {
  const size_t pixels = p->width * p->height;
  double *const between = memory, *const sum = memory + pixels;
  double *const weight = sum + pixels, *const band = weight + pixels;
  double square = 0.0, count = 0.0;
  for (int i = 0; i < 2; i++) {
    const double sigma = i == 0 ? fine : coarse;
    blur_plane(p, p->error, sigma, between, sum);
    blur_plane(p, p->weight, sigma, between, weight);
    for (size_t k = 0; k < pixels; k++)
      if (p->weight[k] > 0.0)
        band[k] = i == 0 ? sum[k] / weight[k] : band[k] - sum[k] / weight[k];
  }
  for (size_t k = 0; k < pixels; k++)
    if (p->weight[k] > 0.0) {
      square += band[k] * band[k];
      count += 1.0;
    }
  return sqrt(square / count);
}

double bench_ao_band(const bench_content *content, const float *ao,
                     const float *exact) {
  const uint32_t *w = content->window;
  const size_t pixels = (size_t)w[2] * w[3];
  double *memory = pixels ? calloc(6 * pixels, sizeof *memory) : NULL;
  const patch p = {w[2], w[3], memory, memory ? memory + pixels : NULL};
  if (!memory)
    return NAN;
  for (size_t y = 0; y < p.height; y++)
    for (size_t x = 0; x < p.width; x++) {
      const size_t at = (w[1] + y) * content->width + w[0] + x;
      if (!bench_is_surface(content, at))
        continue;
      p.error[y * p.width + x] = (double)ao[at] - (double)exact[at];
      p.weight[y * p.width + x] = 1.0;
    }
  const double band = band_of(&p, memory + 2 * pixels);
  free(memory);
  return band;
}
