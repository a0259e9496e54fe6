/* The n-th smallest of many numbers is the one that sorting finds. */
#include "dump/selection.h"
#include "test/support/tests.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
TEST(random_numbers) {
  static const unsigned kinds[] = {1, 2, 3, 10, 100000};
  unsigned seed = 1;
  double values[MOST];
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

TEST(ordered_numbers) {
  double up[MOST], down[MOST], ridge[MOST];
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
  return tests_run();
}
