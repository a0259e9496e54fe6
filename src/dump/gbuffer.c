/* A G-buffer: the planes of one frame in host memory, by role. */
#include "dump/gbuffer.h"

#include "image/image.h"

#include <math.h>

void gbuffer_free(gbuffer *g) {
  image_free(&g->planes);
}

float *gbuffer_plane(const gbuffer *g, role r, size_t i) {
  if (i >= g->map.count[r])
    return NULL;
  const image_plane *plane = image_find(&g->planes, g->map.names[r][i]);
  return plane ? plane->pixels : NULL;
}

size_t gbuffer_pixels(const gbuffer *g) {
  return (size_t)g->planes.width * g->planes.height;
}

int gbuffer_is_surface(float depth, float sky_depth) {
  return isfinite(depth) && depth > 0.0f && depth < sky_depth;
}
