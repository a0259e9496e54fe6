/*
 * Plans with the temporal filter, and the history that the filter stores.
 */
#ifndef HBIL_TEST_HISTORY_H
#define HBIL_TEST_HISTORY_H

#include "test/support/stages.h"

/* Without padding between the rows: the end of a row is beside the beginning of
 * the next. */
#define WIDTH 128
#define HEIGHT 54
#define PIXELS (WIDTH * HEIGHT)
/* The longest history of most of these plans, in frames. */
#define MOST 4

/* AO, E_near and bent normals of the room, without history of light, so that a
 * frame doesn't depend on those before it; unfiltered, since the 4 x 4 filter
 * takes longest to compile. */
void averaging_init(setup *s, int width, int height, cl_uint frames);
/* Loads and uploads a frame of the scene. */
void averaging_load(setup *s, uint32_t scene, cl_uint index);
void same_bits(const exact_planes *got, const exact_planes *want);

/* All passes that run before the filter. */
#define PASSES_BEFORE_FILTER 5
extern enqueue_function *const passes_before_filter[PASSES_BEFORE_FILTER];

/* Planes of HBIL_STAGE_TEMPORAL_HISTORY; from HISTORY_LIGHT on, those of
 * RESOLVED. */
enum { HISTORY_W, HISTORY_NORMAL, HISTORY_FRAMES, HISTORY_LIGHT };

/* A copy of the history's words; the caller frees `bytes`. */
typedef struct history {
  hbil_buffer at;
  unsigned char *bytes;
} history;

history history_read(setup *s);
/* Where a plane's value of a pixel begins, in bytes. */
size_t history_offset(const history *h, int plane, int x, int y);
double history_value(const history *h, int plane, int x, int y);
void history_normal(const history *h, int x, int y, double n[3]);

#endif
