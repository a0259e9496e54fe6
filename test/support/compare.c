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

double relative_rmse_but_one(const exact_planes *got, const exact_planes *want,
                             int first, int count, double *one) {
  const size_t pixels = (size_t)want->width * (size_t)want->height;
  size_t total, start = range_of(want, first, count, &total);
  double off = 0.0, size = 0.0, farthest = 0.0;
  for (size_t p = start; p < start + pixels; ++p) {
    double pixel = 0.0;
    for (size_t i = p; i < p + total; i += pixels) {
      double d = got->values[i] - want->values[i];
      pixel += d * d;
      size += want->values[i] * want->values[i];
    }
    /* the sum leaves out the farthest so far: the difference of two sums would
     * cancel */
    off += fmin(pixel, farthest);
    farthest = fmax(pixel, farthest);
    if (!isfinite(pixel))
      off = INFINITY;
  }
  *one = size > 0.0 ? sqrt(farthest * (double)pixels / size) : sqrt(farthest);
  return size > 0.0 ? sqrt(off / size) : sqrt(off);
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
