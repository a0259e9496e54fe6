/*
 * Random settings, formats, inputs and cameras from extremes, from a seed.
 */
#ifndef HBIL_TEST_DRAW_H
#define HBIL_TEST_DRAW_H

#include "test/support/contents.h"

/* How hard a case is to compute with, which decides what its results may be
 * off by. */
typedef enum hardness {
  SCENES, /* a ray-traced scene in world units */
  HARD,   /* contents and cameras from extremes, in plain units; no sectors */
  WILD    /* any unit, any thickness, and values that are not valid */
} hardness;

typedef struct drawn {
  uint64_t seed;
  hardness kind;
  content what;
  camera_view view;
  double scale;   /* of depths */
  double spoiled; /* share of the input values that are not valid */
  random_state r; /* for the contents */
} drawn;

/* Draws a case: the setup has its settings, and is not started. */
void draw_case(setup *s, drawn *d, uint64_t seed);
/* The same with the best of some seeds: the one whose settings make the most
 * pairs of values that no case before had.  Build defines depend on what is
 * counted.  index: of the case, from 0 on. */
void draw_covering_case(setup *s, drawn *d, uint64_t seed, uint64_t index);
/* Writes all that was drawn to stress_case. */
void draw_tell(const setup *s, const drawn *d);
/* Replaces camera and inputs by those of a frame, and uploads. */
void draw_frame(setup *s, drawn *d, uint32_t index);

/* An integer below `count`. */
cl_uint random_below(random_state *r, int count);

#endif
