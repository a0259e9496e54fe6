/*
 * cmocka, and the tests of a program: all that its source defines with TEST()
 * are run, in the order in which they stand there.
 */
#ifndef HBIL_TEST_TESTS_H
#define HBIL_TEST_TESTS_H

/* cmocka.h needs the first four. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* Begins a test, a function with the parameter void **state. */
#define TEST(name) TEST_WITH(name, NULL, NULL)
/* The same with what is done before it and after it. */
#define TEST_WITH(name, begin, end)                                            \
  TEST_ADD(name, #name, begin, end)                                            \
  static void name(void **state __attribute__((unused)))

/* Adds a test before main() runs.  label: its name in the log. */
#define TEST_ADD(name, label, begin, end)                                      \
  static void name(void **state);                                              \
  __attribute__((constructor)) static void name##_is_added(void) {             \
    tests_add(__LINE__,                                                        \
              (struct CMUnitTest){(label), (name), (begin), (end), NULL});     \
  }
/* The order in which they are added is the compiler's, so lines count. */
void tests_add(int line, struct CMUnitTest test);

/* Runs the tests: the value for main() to return.  A program without a main()
 * gets that of main.c, which opens a device for them. */
int tests_run(void);
/* The same with what is done before all of them and after all. */
int tests_run_with(CMFixtureFunction begin, CMFixtureFunction end);

#endif
