/* Rays through the bytes of a saved cache. */
#include "exact/saved_cache.h"

#include <string.h>

exact_status exact_saved_open(const void *bytes, size_t size,
                              exact_saved_cache *out) {
  const unsigned char *at = bytes;
  hbil_cache_saved_head head;
  memset(out, 0, sizeof *out);
  if (size < sizeof head)
    return EXACT_BAD_ARGUMENT;
  memcpy(&head, at, sizeof head);
  if (head.voxels < 16 || head.voxels > 256 || head.levels < 1 ||
      head.levels > HBIL_CACHE_MAX_LEVELS)
    return EXACT_BAD_ARGUMENT;
  out->where.voxels = (int)head.voxels;
  out->where.levels = (int)head.levels;
  out->where.voxel_size = head.voxel_size;
  for (int i = 0; i < 3; ++i)
    out->where.middle[i] = (long)head.middle[i];
  const size_t count = exact_cache_count(&out->where);
  out->states = at + sizeof head;
  out->voxels = out->states + count / 4 + count;
  return size == sizeof head + count / 4 + count +
                     HBIL_VOXEL_FLOATS * sizeof(float) * count
             ? EXACT_SUCCESS
             : EXACT_BAD_ARGUMENT;
}

/* As exact_cache_state_for_rays(). */
static int state_at(const exact_saved_cache *saved, exact_place *place) {
  for (;; ++place->level) {
    const size_t number = exact_cache_number(&saved->where, place);
    const int state = saved->states[number / 4] >> 2 * (number % 4) & 3;
    if (state != HBIL_VOXEL_UNKNOWN || place->level + 1 >= saved->where.levels)
      return state;
    for (int i = 0; i < 3; ++i)
      place->cell[i] = (int)floor(0.5 * place->cell[i]);
  }
}

static void read_voxel(const exact_saved_cache *saved, const exact_place *place,
                       exact_voxel *voxel) {
  float v[HBIL_VOXEL_FLOATS];
  memcpy(v, saved->voxels + sizeof v * exact_cache_number(&saved->where, place),
         sizeof v);
  for (int i = 0; i < HBIL_VOXEL_FLOATS; ++i)
    voxel->value[i] = (double)v[i];
}

exact_ray_kind exact_saved_follow(const exact_saved_cache *saved, vec3 origin,
                                  vec3 direction, double near,
                                  double radiance[3]) {
  exact_place place;
  bool unseen = false;
  int last = HBIL_VOXEL_UNKNOWN;
  double t = 0.0, distance;
  memset(radiance, 0, 3 * sizeof *radiance);
  while (
      exact_cache_find(&saved->where, vec_add(origin, t, direction), &place)) {
    exact_place seen = place;
    exact_voxel voxel;
    last = state_at(saved, &seen);
    if (last == HBIL_VOXEL_SURFACE) {
      read_voxel(saved, &seen, &voxel);
      if (exact_cache_hits(voxel.value, &seen, origin, direction, &distance)) {
        exact_cache_update_radiance(&voxel);
        memcpy(radiance, voxel.radiance, sizeof voxel.radiance);
        return EXACT_RAY_HIT;
      }
    }
    unseen = unseen || (t >= near && last == HBIL_VOXEL_UNKNOWN);
    t = fmax(t, exact_cache_leave(&place, origin, direction)) + 1e-9;
  }
  return unseen || last == HBIL_VOXEL_UNKNOWN ? EXACT_RAY_UNKNOWN
                                              : EXACT_RAY_SKY;
}

bool exact_saved_has_surface(const exact_saved_cache *saved, vec3 at) {
  exact_place place;
  return exact_cache_find(&saved->where, at, &place) &&
         state_at(saved, &place) == HBIL_VOXEL_SURFACE;
}
