/* What several passes do with planes. */
#ifndef HBIL_EXACT_PLANES_H
#define HBIL_EXACT_PLANES_H

#include "exact/exact.h"

/* Sets a pixel to 0 in all planes. */
void exact_planes_clear(exact_planes *planes, int x, int y);
/* Whether the pixel lies in the picture. */
static inline bool exact_planes_contain(const exact_planes *planes, int x,
                                        int y) {
  return x >= 0 && y >= 0 && x < planes->width && y < planes->height;
}
/* Whether there are planes of that size, and as many as `count` or more. */
bool exact_planes_fit(const exact_planes *planes, cl_uint width, cl_uint height,
                      int count);

#endif
