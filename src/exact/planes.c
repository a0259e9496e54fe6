/* Planes of doubles. */
#include "exact/planes.h"

#include <stdint.h>
#include <stdlib.h>

const char *exact_status_text(exact_status status) {
  switch (status) {
  case EXACT_SUCCESS:
    return "success";
  case EXACT_OUT_OF_MEMORY:
    return "out of memory";
  case EXACT_BAD_ARGUMENT:
    return "bad argument";
  }
  return "unknown status";
}

exact_status exact_planes_create(exact_planes *planes, int width, int height,
                                 int count) {
  const exact_planes none = {0, 0, 0, NULL};
  *planes = none;
  if (width < 1 || height < 1 || count < 1)
    return EXACT_BAD_ARGUMENT;
  /* two ints have a product that fits in 64 bits */
  const uint64_t pixels = (uint64_t)width * (uint64_t)height;
  if (pixels > SIZE_MAX / sizeof(double) / (uint64_t)count)
    return EXACT_OUT_OF_MEMORY;
  planes->values = calloc((size_t)pixels * (size_t)count, sizeof(double));
  if (!planes->values)
    return EXACT_OUT_OF_MEMORY;
  planes->width = width;
  planes->height = height;
  planes->count = count;
  return EXACT_SUCCESS;
}

void exact_planes_free(exact_planes *planes) {
  free(planes->values);
  planes->values = NULL;
}

void exact_planes_clear(exact_planes *planes, int x, int y) {
  for (int p = 0; p < planes->count; ++p)
    *exact_at(planes, p, x, y) = 0.0;
}

bool exact_planes_fit(const exact_planes *planes, cl_uint width, cl_uint height,
                      int count) {
  return planes->values && planes->width >= 1 && planes->height >= 1 &&
         (cl_uint)planes->width == width && (cl_uint)planes->height == height &&
         planes->count >= count;
}
