/* The n-th smallest of many numbers is the one that sorting finds. */
#include "dump/selection.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <setjmp.h>

#include <cmocka.h>

enum { MOST = 300 };

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Compares every n with the sorted numbers. */
static void check(const double *values, size_t count) {
  double sorted[MOST], mixed[MOST];
  memcpy(sorted, values, count * sizeof *values);
  qsort(sorted, count, sizeof *sorted, ascending);
  for (size_t n = 0; n < count; n++) {
    memcpy(mixed, values, count * sizeof *values);
    if (select_nth(mixed, count, n) != sorted[n])
      fail_msg("number %zu of %zu", n, count);
    qsort(mixed, count, sizeof *mixed, ascending);
    assert_memory_equal(mixed, sorted, count * sizeof *sorted);
  }
}

/* Random numbers, of which few are different if `kinds` is small. */
static void random_numbers(void **state) {
  static const unsigned kinds[] = {1, 2, 3, 10, 100000};
  unsigned seed = 1;
  double values[MOST];
  (void)state;
  for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
    for (size_t count = 1; count <= 40; count++) {
      for (size_t i = 0; i < count; i++) {
        seed = seed * 1664525u + 1013904223u;
        const unsigned kind = (seed >> 8) % kinds[k];
        values[i] = kind == 1 ? INFINITY : (double)kind - 1.0;
      }
      check(values, count);
    }
}

static void ordered_numbers(void **state) {
  double up[MOST], down[MOST], ridge[MOST];
  (void)state;
  for (int i = 0; i < MOST; i++) {
    up[i] = i;
    down[i] = MOST - i;
    ridge[i] = i < MOST / 2 ? i : MOST - i;
  }
  check(up, MOST);
  check(down, MOST);
  check(ridge, MOST);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(random_numbers),
      cmocka_unit_test(ordered_numbers),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
