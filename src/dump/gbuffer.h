/* A G-buffer: the planes of one frame in host memory, by role. */
#ifndef HBIL_DUMP_GBUFFER_H
#define HBIL_DUMP_GBUFFER_H

#include "dump/channel_map.h"
#include "image/image.h"

typedef struct gbuffer {
  channel_map map; /* describes `planes`; owns no file names */
  image planes;
  /* what gbuffer_plane() returns, once gbuffer_index() has looked it up */
  float *indexed[ROLE_COUNT][ROLE_CHANNELS];
} gbuffer;

/* Frees the planes.  It may be called twice and on a zeroed G-buffer. */
void gbuffer_free(gbuffer *g);

/* Channel i of a role, width*height floats; NULL if there is none. */
float *gbuffer_plane(const gbuffer *g, role r, size_t i);

/* Looks all planes up by their names, so that gbuffer_plane(), which is called
 * for single pixels, need not.  To be called when all planes are there; their
 * pixels stay where they are. */
void gbuffer_index(gbuffer *g);

size_t gbuffer_pixels(const gbuffer *g);

/* The planes as hbil_config_suggest() takes them; they point into g. */
hbil_host_planes gbuffer_host_planes(const gbuffer *g);

/* Whether the library takes a depth for that of a surface, not of the sky. */
int gbuffer_is_surface(float depth, float sky_depth);

#endif
