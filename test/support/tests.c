/* See tests.h. */
#include "test/support/tests.h"

#include <stdio.h>
#include <stdlib.h>

enum { MOST = 64 };

static struct CMUnitTest tests[MOST];
static int lines[MOST], count;

void tests_add(int line, struct CMUnitTest test) {
  int i = count++;
  if (count > MOST) {
    fprintf(stderr, "test set-up: more than %d tests\n", MOST);
    exit(99);
  }
  for (; i > 0 && lines[i - 1] > line; --i) {
    tests[i] = tests[i - 1];
    lines[i] = lines[i - 1];
  }
  tests[i] = test;
  lines[i] = line;
}

int tests_run_with(CMFixtureFunction begin, CMFixtureFunction end) {
  return _cmocka_run_group_tests("tests", tests, (size_t)count, begin, end);
}

int tests_run(void) {
  return tests_run_with(NULL, NULL);
}
