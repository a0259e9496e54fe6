/*
 * Seeded random numbers: the same on every machine.
 */
#ifndef HBIL_TEST_RANDOM_H
#define HBIL_TEST_RANDOM_H

#include <stdint.h>

typedef struct random_state {
  uint64_t state; /* the seed, at first */
} random_state;

/* Uniform in [0, 1). */
double random_unit(random_state *r);

#endif
