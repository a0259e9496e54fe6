/*
 * How far the kernels' fp32 is from double precision, pass by pass.
 */
#ifndef HBIL_TEST_DEVIATION_H
#define HBIL_TEST_DEVIATION_H

#include <stdbool.h>
#include <stddef.h>

#include "test/support/checked_exact.h"

typedef enum deviation_id {
  REPROJECT,
  PUSH_PULL,
  SPLIT_W,
  SPLIT_NORMAL,
  SPLIT_LIGHT,
  GATHER_AO,
  GATHER_LIGHT,
  GATHER_BENT,
  RECOMPOSE_AO,
  RECOMPOSE_LIGHT,
  RECOMPOSE_BENT,
  COMPOSITE_FAR,
  COMPOSITE_CONE,
  COMPOSITE_INDIRECT,
  COMPOSITE_BEAUTY,
  DEVIATIONS
} deviation_id;

/* Differences in units of the plane's largest value; `far_off` of `count` are
 * above FAR_OFF. */
typedef struct deviation {
  double largest, sum, squares;
  size_t count, far_off;
} deviation;
#define FAR_OFF 1e-3

/* Name of the pass and of its result. */
const char *deviation_name(deviation_id id);

/* Adds the differences of `count` planes. */
void add_deviation(deviation *all, deviation_id id, const exact_planes *got,
                   int got_first, const exact_planes *want, int want_first,
                   int count);
/* Adds those of AO and, where the plan has them, of light and bent normals,
 * from deviation `first` on. */
void add_light_deviation(deviation *all, deviation_id first,
                         const exact_planes *got, const exact_planes *want,
                         bool light, bool bent);
/* Fails where a root mean square is above its limit times `slack`, and prints
 * stress_case; with HBIL_TEST_VERBOSE, prints every largest and mean
 * difference in units of 2^-24, a rounding of 1. */
void check_deviations(const deviation *all, double slack);

#endif
