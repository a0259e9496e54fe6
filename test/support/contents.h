/*
 * G-buffers from extremes: contents that are hard to compute with, cameras of
 * all kinds, and values that no renderer should write.
 */
#ifndef HBIL_TEST_CONTENTS_H
#define HBIL_TEST_CONTENTS_H

#include "test/support/fixture.h"
#include "test/support/random.h"

typedef enum content {
  ROOM,
  JUMBLE,  /* depths over a factor of 1e7, normals in all directions */
  CHECKER, /* two depths, alternating from pixel to pixel */
  SPIKES,  /* a wall, with single pixels far in front of it and behind it */
  NOISE,
  AWAY, /* half of the normals face away: surfaces seen edge on */
  CONTENTS
} content;

extern const char *const content_names[CONTENTS];
/* Fills the inputs; not for ROOM.  The camera must be set. */
void load_content(setup *s, content kind, uint32_t index, random_state *r);

typedef struct camera_view {
  double fov;          /* vertical, degrees */
  double off_x, off_y; /* principal point from the middle, in pictures */
  double pixel;        /* height of a pixel over its width */
} camera_view;

enum { VIEWS = 7 };
extern const camera_view views[VIEWS];
void set_view(setup *s, const camera_view *v);

/* A plane through (0, 0, 3) that sends radiance 1 and is tilted by so many
 * degrees; sky where it is behind the eye or seen at a grazing angle. */
void load_plane(setup *s, double tilt, double azimuth);

/* Replaces a share of all input values by ones that are odd or not valid. */
void spoil(setup *s, random_state *r, double share);

/* One of an array's values. */
#define ANY_OF(r, values)                                                      \
  ((values)[(size_t)(random_unit(r) *                                          \
                     (double)(sizeof(values) / sizeof *(values)))])

#endif
