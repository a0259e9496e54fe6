/* How large a place is, by what pictures of it show. */
#ifndef HBIL_TOOL_EXTENT_H
#define HBIL_TOOL_EXTENT_H

#include "dump/gbuffer.h"
#include "hbil/hbil.h"
#include "image/error.h"

/* A picture of the place. */
typedef struct extent_picture {
  const char *path;
  const channel_map *map; /* with its camera */
} extent_picture;

/*
 * Chooses centre and voxel_size of a radiance cache with config->voxels and
 * config->levels: the middle of the frames' cameras, and what some of the
 * frames and all views show.  0, or -1 with `error` filled.
 */
int extent_choose(const extent_picture *frames, size_t count,
                  const extent_picture *views, size_t view_count,
                  hbil_cache_config *config, image_error *error);

/* Distances from a centre. */
typedef struct extent {
  double centre[3];
  double *distances; /* owned */
  size_t count, room;
} extent;

/* Adds surfaces of a frame, some thousand of them.  0, or -1 with `error`
 * filled. */
int extent_add(extent *e, const gbuffer *g, image_error *error);

/* Half the width of a cube about the centre that holds nearly all surfaces; 0:
 * there are none. */
double extent_radius(extent *e);

void extent_free(extent *e);

#endif
