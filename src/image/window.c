/* Imath::Box and OIIO::ROI have the same operations, but in int, which damaged
 * or extreme windows overflow. */
#include "image/window.h"

#include <stddef.h>
#include <string.h>

static int64_t minimum(int64_t a, int64_t b) {
  return a < b ? a : b;
}

static int64_t maximum(int64_t a, int64_t b) {
  return a > b ? a : b;
}

/* The right and bottom edges lie behind the last pixel. */
typedef struct edges {
  int64_t left, top, right, bottom;
} edges;

static edges edges_of(image_window w) {
  return (edges){w.x, w.y, (int64_t)w.x + w.width, (int64_t)w.y + w.height};
}

static image_window window_of(edges e) {
  if (e.right <= e.left || e.bottom <= e.top)
    return (image_window){0, 0, 0, 0};
  return (image_window){(int32_t)e.left, (int32_t)e.top,
                        (uint32_t)(e.right - e.left),
                        (uint32_t)(e.bottom - e.top)};
}

image_window image_window_union(image_window a, image_window b) {
  const edges p = edges_of(a), q = edges_of(b);
  return window_of((edges){minimum(p.left, q.left), minimum(p.top, q.top),
                           maximum(p.right, q.right),
                           maximum(p.bottom, q.bottom)});
}

image_window image_window_common(image_window a, image_window b) {
  const edges p = edges_of(a), q = edges_of(b);
  return window_of((edges){maximum(p.left, q.left), maximum(p.top, q.top),
                           minimum(p.right, q.right),
                           minimum(p.bottom, q.bottom)});
}

void image_place(const float *pixels, image_window from, float *out,
                 image_window to) {
  const image_window both = image_window_common(from, to);
  if (both.width != to.width || both.height != to.height)
    memset(out, 0, sizeof *out * to.width * to.height);
  for (uint32_t y = 0; y < both.height; y++) {
    const size_t from_x = (size_t)((int64_t)both.x - from.x);
    const size_t from_y = (size_t)((int64_t)both.y - from.y) + y;
    const size_t to_x = (size_t)((int64_t)both.x - to.x);
    const size_t to_y = (size_t)((int64_t)both.y - to.y) + y;
    memcpy(out + to_y * to.width + to_x, pixels + from_y * from.width + from_x,
           both.width * sizeof *out);
  }
}
