/*
 * Rays through the bytes that hbil_cache_save() gives, as a picture of what a
 * cache knows needs them.  The bytes are read where they are, since an
 * exact_cache takes three times their memory.
 */
#ifndef HBIL_EXACT_SAVED_CACHE_H
#define HBIL_EXACT_SAVED_CACHE_H

#include "exact/cache.h"

typedef struct exact_saved_cache {
  exact_cache where; /* it has no voxels */
  const unsigned char *states;
  const unsigned char *voxels; /* floats of any alignment */
} exact_saved_cache;

/* bytes: the caller's, which must stay.  EXACT_BAD_ARGUMENT if there are too
 * few or too many of them. */
exact_status exact_saved_open(const void *bytes, size_t size,
                              exact_saved_cache *out);

/* What a ray of unit direction meets, in cache space, and the radiance that it
 * sends; 0 unless a surface is hit.  Unlike rays of light, it ends in no sky
 * but in what views looked through.  Places nearer than `near` need not have
 * been seen. */
exact_ray_kind exact_saved_follow(const exact_saved_cache *saved, vec3 origin,
                                  vec3 direction, double near,
                                  double radiance[3]);

/* Whether a place, in cache space, lies in a voxel with a surface. */
bool exact_saved_has_surface(const exact_saved_cache *saved, vec3 at);

#endif
