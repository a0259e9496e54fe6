/* Whether the caller's planes share memory.  A gap is the distance in bytes
 * from the first byte of `a` to that of `b`. */
#include "overlap.h"

#include <stdint.h>

/* The position of `at` in a period, 0 .. period - 1. */
static int64_t modulo(int64_t at, int64_t period) {
  const int64_t rest = at % period;
  return rest < 0 ? rest + period : rest;
}

static bool ranges_meet(int64_t gap, size_t a_bytes, size_t b_bytes) {
  return gap < (int64_t)a_bytes && -gap < (int64_t)b_bytes;
}

static bool rows_meet(const plane_shape *a, const plane_shape *b, int64_t gap) {
  if (!ranges_meet(gap, plane_row_extent(a), plane_row_extent(b)))
    return false;
  if (a->pixel != b->pixel)
    return true;
  const int64_t pixel = (int64_t)a->pixel, behind = modulo(gap, pixel);
  return ranges_meet(behind, a->run, b->run) ||
         ranges_meet(behind - pixel, a->run, b->run);
}

static size_t image_extent(const plane_shape *shape) {
  return (shape->rows - 1) * shape->row + plane_row_extent(shape);
}

static bool images_meet(const plane_shape *a, const plane_shape *b,
                        int64_t gap) {
  if (a->rows == 1)
    return rows_meet(a, b, gap);
  if (!ranges_meet(gap, image_extent(a), image_extent(b)))
    return false;
  if (a->row != b->row)
    return true;
  /* No row is longer than the pitch, so one of `a` reaches two of `b`. */
  const int64_t row = (int64_t)a->row, behind = modulo(gap, row);
  return rows_meet(a, b, behind) || rows_meet(a, b, behind - row);
}

bool planes_overlap(const plane_region *a, const plane_region *b) {
  if (a->memory != b->memory)
    return false;
  for (size_t i = 0; i < a->shape.images; ++i)
    for (size_t j = 0; j < b->shape.images; ++j)
      if (images_meet(&a->shape, &b->shape,
                      (int64_t)(b->start + j * b->shape.image) -
                          (int64_t)(a->start + i * a->shape.image)))
        return true;
  return false;
}

bool plane_overlaps_itself(const plane_shape *shape) {
  for (size_t i = 1; i < shape->images; ++i)
    if (images_meet(shape, shape, (int64_t)(i * shape->image)))
      return true;
  return false;
}
