/* The n-th smallest of many numbers, without sorting them all. */
#ifndef HBIL_DUMP_SELECTION_H
#define HBIL_DUMP_SELECTION_H

#include <stddef.h>

/* What values[n] would be if the values were sorted; n < count, and none is
 * NaN.  Changes their order. */
double select_nth(double *values, size_t count, size_t n);

#endif
