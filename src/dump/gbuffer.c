/* A G-buffer: the planes of one frame in host memory, by role. */
#include "dump/gbuffer.h"

#include "image/image.h"

#include <math.h>
#include <string.h>

void gbuffer_free(gbuffer *g) {
  image_free(&g->planes);
  memset(g->indexed, 0, sizeof g->indexed);
}

static float *find_plane(const gbuffer *g, role r, size_t i) {
  const image_plane *plane = image_find(&g->planes, g->map.names[r][i]);
  return plane ? plane->pixels : NULL;
}

float *gbuffer_plane(const gbuffer *g, role r, size_t i) {
  if (i >= g->map.count[r])
    return NULL;
  float *const indexed = g->indexed[r][i];
  return indexed ? indexed : find_plane(g, r, i);
}

void gbuffer_index(gbuffer *g) {
  for (int r = 0; r < ROLE_COUNT; r++)
    for (size_t i = 0; i < ROLE_CHANNELS; i++)
      g->indexed[r][i] = i < g->map.count[r] ? find_plane(g, (role)r, i) : NULL;
}

size_t gbuffer_pixels(const gbuffer *g) {
  return (size_t)g->planes.width * g->planes.height;
}

static hbil_host_plane host_plane(const gbuffer *g, role r) {
  hbil_host_plane plane = {.pixel_pitch = sizeof(float)};
  for (size_t c = 0; c < role_channels(r); c++)
    plane.channel[c] = gbuffer_plane(g, r, c);
  return plane;
}

hbil_host_planes gbuffer_host_planes(const gbuffer *g) {
  return (hbil_host_planes){.depth = host_plane(g, ROLE_DEPTH),
                            .normal = host_plane(g, ROLE_NORMAL),
                            .direct = host_plane(g, ROLE_DIRECT),
                            .emission = host_plane(g, ROLE_EMISSION)};
}

int gbuffer_is_surface(float depth, float sky_depth) {
  return isfinite(depth) && depth > 0.0f && depth < sky_depth;
}
