#include "test/support/compare.h"

#include <stdio.h>

void check_at_most(const char *what, double value, double limit) {
  if (getenv("HBIL_TEST_VERBOSE"))
    fprintf(stderr, "%s: %.3g (limit %.3g)\n", what, value, limit);
  if (!(value <= limit))
    fail_msg("%s: %.9g is above %.9g", what, value, limit);
}

/* Number of values of planes [first, first + count), and where they begin. */
static size_t range_of(const exact_planes *planes, int first, int count,
                       size_t *total) {
  size_t plane = (size_t)planes->width * (size_t)planes->height;
  *total = plane * (size_t)count;
  return plane * (size_t)first;
}

double relative_rmse(const exact_planes *got, const exact_planes *want,
                     int first, int count) {
  size_t total, start = range_of(want, first, count, &total);
  double off = 0.0, size = 0.0;
  for (size_t i = start; i < start + total; ++i) {
    double d = got->values[i] - want->values[i];
    off += d * d;
    size += want->values[i] * want->values[i];
  }
  if (!isfinite(off))
    return INFINITY;
  return size > 0.0 ? sqrt(off / size) : sqrt(off);
}

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Sum of the squared differences; infinite where one is not finite. */
static double squares_but_few(const exact_planes *got, const exact_planes *want,
                              int first, int count, int few) {
  const size_t pixels = (size_t)want->width * (size_t)want->height;
  size_t total, start = range_of(want, first, count, &total);
  double *off = calloc(pixels, sizeof *off), sum = 0.0;
  assert_non_null(off);
  for (size_t i = start; i < start + total; ++i) {
    const double d = got->values[i] - want->values[i];
    off[(i - start) % pixels] += isfinite(d) ? d * d : HUGE_VAL;
  }
  qsort(off, pixels, sizeof *off, ascending);
  for (size_t i = 0; i + (size_t)few < pixels; ++i)
    sum += off[i];
  if (off[pixels - 1] == HUGE_VAL)
    sum = HUGE_VAL;
  free(off);
  return sum;
}

double relative_rmse_but_few(const exact_planes *got, const exact_planes *want,
                             int first, int count, int few) {
  size_t total, start = range_of(want, first, count, &total);
  const double off = squares_but_few(got, want, first, count, few);
  double size = 0.0;
  for (size_t i = start; i < start + total; ++i)
    size += want->values[i] * want->values[i];
  return size > 0.0 ? sqrt(off / size) : sqrt(off);
}

double rms_over_largest(const exact_planes *got, const exact_planes *want,
                        int first, int count, int few) {
  size_t total;
  range_of(want, first, count, &total);
  const double most = largest_value(want, first, count);
  const double rms =
      sqrt(squares_but_few(got, want, first, count, few) / (double)total);
  return most > 0.0 ? rms / most : rms;
}

double largest_error(const exact_planes *got, const exact_planes *want,
                     int first, int count) {
  size_t total, start = range_of(want, first, count, &total);
  double largest = 0.0;
  for (size_t i = start; i < start + total; ++i) {
    double d = fabs(got->values[i] - want->values[i]);
    if (!isfinite(d))
      return INFINITY;
    largest = d > largest ? d : largest;
  }
  return largest;
}

double largest_value(const exact_planes *planes, int first, int count) {
  size_t total, start = range_of(planes, first, count, &total);
  double largest = 0.0;
  for (size_t i = start; i < start + total; ++i)
    largest = fmax(largest, fabs(planes->values[i]));
  return largest;
}

size_t count_values(const exact_planes *planes) {
  return (size_t)planes->width * (size_t)planes->height * (size_t)planes->count;
}

size_t count_different(const exact_planes *got, const exact_planes *want) {
  size_t different = 0;
  assert_int_equal(got->count, want->count);
  for (size_t i = 0; i < count_values(want); ++i)
    different += !(got->values[i] == want->values[i]);
  return different;
}
