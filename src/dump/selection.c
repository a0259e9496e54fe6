/* The n-th smallest of many numbers: Hoare's quickselect. */
#include "dump/selection.h"

/* The median of the first, the middle and the last value of a range, so that
 * sorted numbers are no worse than others.  One value of the range besides it
 * is not less, and one is not greater. */
static double pivot_of(const double *values, size_t first, size_t last) {
  const double a = values[first], b = values[first + (last - first) / 2],
               c = values[last];
  const double low = a < b ? a : b, high = a < b ? b : a;
  return c < low ? low : c > high ? high : c;
}

/* Moves what is greater than the pivot behind what is less, and returns where
 * the front part ends; behind it there is at least one value. */
static size_t divide(double *values, size_t first, size_t last) {
  const double pivot = pivot_of(values, first, last);
  for (;; first++, last--) {
    while (values[first] < pivot)
      first++;
    while (values[last] > pivot)
      last--;
    if (first >= last)
      return last;
    const double lesser = values[last];
    values[last] = values[first];
    values[first] = lesser;
  }
}

double select_nth(double *values, size_t count, size_t n) {
  size_t first = 0, last = count - 1;
  while (first < last) {
    const size_t end = divide(values, first, last);
    if (n <= end)
      last = end;
    else
      first = end + 1;
  }
  return values[first];
}
