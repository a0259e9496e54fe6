/* Measures of the difference of two images. */
#include "tool/compare_measure.h"

#include "image/error.h"
#include "image/image.h"
#include "tool/compare_layer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bounds the relative error of dark pixels. */
static const double relative_epsilon = 0.01;

typedef struct sums {
  double square, relative, largest;
  double peak, sum_b; /* of b: largest value, sum */
  size_t values, not_finite;
} sums;

/* heat (or NULL) collects the squared errors of each pixel.  worst has the
 * largest error of each pixel's channels, and is negative where nothing is
 * compared. */
static void add_channel(const image_plane *a, const image_plane *b,
                        const compare_mask *m, size_t pixels, sums *s,
                        float *heat, float *worst) {
  const channel_mask mask = compare_mask_channel(m, channel_letter(a->name));
  for (size_t i = 0; i < pixels; i++) {
    if (!channel_mask_has(&mask, i))
      continue;
    if (!isfinite(a->pixels[i]) || !isfinite(b->pixels[i])) {
      s->not_finite++;
      continue;
    }
    const double value_b = b->pixels[i];
    const double off = a->pixels[i] - value_b;
    s->square += off * off;
    s->relative += off * off / (value_b * value_b + relative_epsilon);
    s->largest = fmax(s->largest, fabs(off));
    s->peak = fmax(s->peak, fabs(value_b));
    s->sum_b += value_b;
    s->values++;
    worst[i] = fmaxf(worst[i], (float)fabs(off));
    if (heat)
      heat[i] += (float)(off * off);
  }
}

static compare_result finish(const sums *s) {
  const double n = s->values ? (double)s->values : 1.0;
  compare_result r = {.rmse = sqrt(s->square / n),
                      .relative = s->relative / n,
                      .largest = s->largest,
                      .peak = s->peak,
                      .mean = s->sum_b / n,
                      .values = s->values,
                      .not_finite = s->not_finite};
  r.psnr = r.rmse > 0.0 ? 20.0 * log10(s->peak / r.rmse) : INFINITY;
  return r;
}

static int ascending(const void *a, const void *b) {
  const float x = *(const float *)a, y = *(const float *)b;
  return (x > y) - (x < y);
}

/* The error that 95 % of the compared pixels don't exceed.  Sorts. */
static double within_95(float *worst, size_t pixels) {
  size_t left_out = 0;
  qsort(worst, pixels, sizeof *worst, ascending);
  while (left_out < pixels && worst[left_out] < 0.0f)
    left_out++;
  const size_t count = pixels - left_out;
  return count ? (double)worst[left_out + (count - 1) * 95 / 100] : 0.0;
}

int compare_measure(const compare_side *a, const compare_side *b,
                    const compare_mask *m, float *heat, compare_result *out,
                    image_error *error) {
  const size_t pixels = (size_t)a->planes.width * a->planes.height;
  float *worst = malloc((pixels + 1) * sizeof *worst);
  sums s = {0};
  if (!worst)
    return image_no_memory(error, a->path);
  for (size_t i = 0; i < pixels; i++) {
    worst[i] = -1.0f;
    if (heat)
      heat[i] = 0.0f;
  }
  for (size_t i = 0; i < a->planes.count; i++)
    add_channel(&a->planes.planes[i],
                compare_partner(a, b, a->planes.planes[i].name), m, pixels, &s,
                heat, worst);
  for (size_t i = 0; heat && i < pixels; i++)
    heat[i] = sqrtf(heat[i]);
  *out = finish(&s);
  out->within = within_95(worst, pixels);
  free(worst);
  return 0;
}

int compare_heat_limit(const float *heat, size_t pixels, float *limit) {
  float *sorted = malloc(pixels * sizeof *sorted);
  if (!sorted)
    return -1;
  memcpy(sorted, heat, pixels * sizeof *sorted);
  qsort(sorted, pixels, sizeof *sorted, ascending);
  *limit = sorted[(pixels - 1) * 99 / 100];
  if (!(*limit > 0.0f))
    *limit = sorted[pixels - 1];
  free(sorted);
  return 0;
}
