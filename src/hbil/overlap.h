/* Whether the caller's planes share memory. */
#ifndef HBIL_OVERLAP_H
#define HBIL_OVERLAP_H

#include <stdbool.h>

#include "planes.h"

/* The bytes of a plane.  All of them are in `memory`, a buffer that is no
 * sub-buffer. */
typedef struct plane_region {
  cl_mem memory;
  size_t start; /* of its first byte there */
  plane_shape shape;
} plane_region;

/* False if the planes have no byte in common.  Planes that lie between each
 * other's rows or pixels are only told apart if they have the same distance
 * from row to row, or from pixel to pixel; otherwise the answer is true.  Both
 * have the same number of rows and of pixels, and no row is longer than its
 * pitch. */
bool planes_overlap(const plane_region *a, const plane_region *b);

/* Whether channels of a planar format have bytes in common. */
bool plane_overlaps_itself(const plane_shape *shape);

#endif
