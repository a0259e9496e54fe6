/* How large a place is, by what pictures of it show. */
#ifndef HBIL_TOOL_EXTENT_H
#define HBIL_TOOL_EXTENT_H

#include "dump/channel_map.h"
#include "hbil/hbil.h"
#include "image/error.h"

/* A picture of the place. */
typedef struct extent_picture {
  const char *path;
  const channel_map *map; /* with its camera */
} extent_picture;

/* The places of the picture's surfaces in the world, some thousand of them,
 * which the caller frees.  0, or -1 with `error` filled and *out NULL. */
int extent_places(const extent_picture *p, double (**out)[3], size_t *count,
                  image_error *error);

/*
 * Chooses centre and voxel_size of a radiance cache with config->voxels and
 * config->levels: the middle of the frames' cameras, and what some of the
 * frames and all views show.  0, or -1 with `error` filled.
 */
int extent_choose(const extent_picture *frames, size_t count,
                  const extent_picture *views, size_t view_count,
                  hbil_cache_config *config, image_error *error);

#endif
