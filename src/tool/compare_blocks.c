/* Means over blocks of pixels, in place of the pixels. */
#include "tool/compare_blocks.h"

#include <math.h>

#include "tool/compare_layer.h"

/* A channel of both images. */
typedef struct channel {
  float *a, *b;
  channel_mask mask;
  unsigned width, height;
} channel;

static int counts(const channel *c, size_t i) {
  return channel_mask_has(&c->mask, i) && isfinite(c->a[i]) &&
         isfinite(c->b[i]);
}

static void take_mean(channel *c, unsigned left, unsigned top, unsigned size) {
  const unsigned right = left + size < c->width ? left + size : c->width;
  const unsigned bottom = top + size < c->height ? top + size : c->height;
  double sum_a = 0.0, sum_b = 0.0, count = 0.0;
  for (unsigned y = top; y < bottom; y++)
    for (unsigned x = left; x < right; x++) {
      const size_t i = (size_t)y * c->width + x;
      if (!counts(c, i))
        continue;
      sum_a += (double)c->a[i];
      sum_b += (double)c->b[i];
      count++;
    }
  for (unsigned y = top; y < bottom; y++)
    for (unsigned x = left; x < right; x++) {
      const size_t i = (size_t)y * c->width + x;
      if (!counts(c, i))
        continue;
      c->a[i] = (float)(sum_a / count);
      c->b[i] = (float)(sum_b / count);
    }
}

void compare_take_means(compare_side *a, compare_side *b, const compare_mask *m,
                        unsigned size) {
  for (size_t i = 0; i < a->planes.count; i++) {
    const image_plane *plane = &a->planes.planes[i];
    channel c = {plane->pixels, compare_partner(a, b, plane->name)->pixels,
                 compare_mask_channel(m, channel_letter(plane->name)),
                 a->planes.width, a->planes.height};
    for (unsigned top = 0; top < c.height; top += size)
      for (unsigned left = 0; left < c.width; left += size)
        take_mean(&c, left, top, size);
  }
}
