/* Voxels: where they are, and moves. */
#include "exact/cache.h"

#include <stdlib.h>
#include <string.h>

static double coarsest(double voxel_size, int levels) {
  return ldexp(voxel_size, levels - 1);
}

exact_status exact_cache_create(exact_cache *cache,
                                const hbil_cache_config *config) {
  memset(cache, 0, sizeof *cache);
  cache->voxels = (int)config->voxels;
  cache->levels = (int)config->levels;
  cache->voxel_size = config->voxel_size;
  for (int i = 0; i < 3; ++i)
    cache->middle[i] =
        lrint(config->centre[i] / coarsest(config->voxel_size, cache->levels));
  cache->all = calloc(exact_cache_count(cache), sizeof *cache->all);
  return cache->all ? EXACT_SUCCESS : EXACT_OUT_OF_MEMORY;
}

void exact_cache_free(exact_cache *cache) {
  free(cache->all);
  cache->all = NULL;
}

size_t exact_cache_count(const exact_cache *cache) {
  const size_t n = (size_t)cache->voxels;
  return n * n * n * (size_t)cache->levels;
}

exact_voxel *exact_cache_at(const exact_cache *cache,
                            const exact_place *place) {
  const size_t n = (size_t)cache->voxels;
  size_t at = (size_t)place->level;
  for (int i = 2; i >= 0; --i)
    at = at * n + (size_t)(place->cell[i] + cache->voxels / 2);
  return cache->all + at;
}

/* How many cells of a level the middle is from the world's origin, modulo the
 * cells of a level. */
static int wrapped_middle(const exact_cache *cache, int level, int axis) {
  const long n = cache->voxels;
  const long whole = (cache->middle[axis] % n + n) % n;
  return (int)(whole * (1L << (cache->levels - 1 - level)) % n);
}

size_t exact_cache_number(const exact_cache *cache, const exact_place *place) {
  const int n = cache->voxels;
  size_t number = (size_t)place->level;
  for (int i = 2; i >= 0; --i) {
    const int cell = place->cell[i] + wrapped_middle(cache, place->level, i);
    number = number * (size_t)n + (size_t)((cell + n) % n);
  }
  return number;
}

exact_place exact_cache_place(const exact_cache *cache, size_t number) {
  const int n = cache->voxels;
  const size_t each = (size_t)n * (size_t)n * (size_t)n;
  exact_place place = {.level = (int)(number / each)};
  for (int i = 0; i < 3; ++i, number /= (size_t)n) {
    const int at = (int)(number % (size_t)n);
    const int cell = (at - wrapped_middle(cache, place.level, i) + n) % n;
    place.cell[i] = cell < n / 2 ? cell : cell - n;
  }
  return place;
}

bool exact_cache_has(const exact_cache *cache, const exact_place *place) {
  const int half = cache->voxels / 2;
  for (int i = 0; i < 3; ++i)
    if (place->cell[i] < -half || place->cell[i] >= half)
      return false;
  return true;
}

vec3 exact_cache_centre(const exact_place *place) {
  const double size = ldexp(1.0, place->level);
  return vec((place->cell[0] + 0.5) * size, (place->cell[1] + 0.5) * size,
             (place->cell[2] + 0.5) * size);
}

static vec3 middle_in_world(const exact_cache *cache) {
  const double unit = coarsest(cache->voxel_size, cache->levels);
  return vec((double)cache->middle[0] * unit, (double)cache->middle[1] * unit,
             (double)cache->middle[2] * unit);
}

vec3 exact_cache_from_world(const exact_cache *cache, vec3 world) {
  return vec_scale(1.0 / cache->voxel_size,
                   vec_add(world, -1.0, middle_in_world(cache)));
}

vec3 exact_cache_to_world(const exact_cache *cache, vec3 at) {
  return vec_add(middle_in_world(cache), cache->voxel_size, at);
}

exact_status exact_cache_move(exact_cache *cache, const double centre[3]) {
  exact_cache before = *cache;
  const double unit = coarsest(cache->voxel_size, cache->levels);
  cache->all = calloc(exact_cache_count(cache), sizeof *cache->all);
  if (!cache->all) {
    cache->all = before.all;
    return EXACT_OUT_OF_MEMORY;
  }
  for (int i = 0; i < 3; ++i)
    cache->middle[i] = lrint(centre[i] / unit);
  for (size_t k = 0; k < exact_cache_count(cache); ++k) {
    const exact_place place = exact_cache_place(cache, k);
    exact_place old = place;
    for (int i = 0; i < 3; ++i) {
      const long moved = cache->middle[i] - before.middle[i];
      old.cell[i] += (int)(moved * (1L << (cache->levels - 1 - place.level)));
    }
    if (exact_cache_has(&before, &old))
      *exact_cache_at(cache, &place) = *exact_cache_at(&before, &old);
  }
  free(before.all);
  return EXACT_SUCCESS;
}
