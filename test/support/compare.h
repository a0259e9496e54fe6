/*
 * Measures of how far planes of numbers are apart.
 */
#ifndef HBIL_TEST_COMPARE_H
#define HBIL_TEST_COMPARE_H

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "test/support/checked_exact.h"
#include "test/support/tests.h"

/* Fails when `value` is above the limit or not a number; with HBIL_TEST_VERBOSE
 * in the environment, prints it. */
void check_at_most(const char *what, double value, double limit);

/* The measures below look at planes [first, first + count). */

/* Root of the mean squared difference, relative to the root mean square of
 * `want`; infinite when `got` holds a value that is not finite. */
double relative_rmse(const exact_planes *got, const exact_planes *want,
                     int first, int count);
/* The same without the `few` pixels that are farthest off; where a value is not
 * finite the result is infinite. */
double relative_rmse_but_few(const exact_planes *got, const exact_planes *want,
                             int first, int count, int few);
/* The root of the mean squared difference relative to the largest value, also
 * without these. */
double rms_over_largest(const exact_planes *got, const exact_planes *want,
                        int first, int count, int few);
/* Largest difference; infinite when one is not finite. */
double largest_error(const exact_planes *got, const exact_planes *want,
                     int first, int count);
/* Largest absolute value. */
double largest_value(const exact_planes *planes, int first, int count);
/* Number of values in all planes that differ. */
size_t count_different(const exact_planes *got, const exact_planes *want);
/* Number of values in all planes together. */
size_t count_values(const exact_planes *planes);

#endif
