/*
 * Two plans that differ in a skip alone: they must give the same bits.
 */
#ifndef HBIL_TEST_PAIR_H
#define HBIL_TEST_PAIR_H

#include "test/support/fixture.h"

/* Three spans across, the last one not full; two blocks of cells. */
#define WIDTH 301
#define HEIGHT 70
/* Width in world units of the orthographic pictures: a wall at depth 2 fills
 * it. */
#define FLAT_WIDTH 6.0

typedef struct pair {
  setup with, without;
} pair;

typedef void prepare_function(setup *s);

/* Starts a plan with all skips and one without `skip`. */
void pair_start(pair *p, prepare_function *prepare, cl_uint skip);
void pair_free(pair *p);
/* Runs both on the inputs of `with`, asserts that their outputs are the same,
 * and returns what `with` has skipped. */
hbil_statistics pair_compare(pair *p);

/* Uploads and runs a frame. */
void run_frame(setup *s);
hbil_statistics statistics_of(setup *s);
void assert_same_outputs(setup *a, setup *b);

/* Index of a pixel of a picture that is WIDTH wide. */
size_t pixel_at(int x, int y);

/* Packed, without history, all outputs, seen through a lens of 40 degrees. */
void pair_sized_wall(setup *s, uint32_t width, uint32_t height);
void pair_wall(setup *s);
/* A wall at depth 2, seen straight on, that sends light everywhere. */
void pair_fill_wall(setup *s);

#endif
