/*
 * move: what a cache forgets.
 *
 * forget: after a move of the cache's centre, the voxels that came in.  Those
 * that stay are where they were in memory.
 * forget_box: what the caller says has changed.
 *
 * Launch: x = words of a row of voxels, y = rows, z = slices, of all levels.
 */
#include "lib/cache_voxels.clh"

/* Whether a cell of a level was inside before the move. */
INLINE bool was_inside(int cell, int moved, int up, int voxels) {
  const int before = cell + (moved << up);
  return before >= -voxels / 2 && before < voxels / 2;
}

kernel void forget(const hbil_cache_move_args args, global uint *states) {
  const hbil_cache_args cache = args.cache;
  uint number;
  if (!word_of_item(cache, &number))
    return;
  const word_place at = place_of_word(cache, number);
  const int up = cache.levels - 1 - at.level;
  uint stays = 0u;
  if (was_inside(cell_at(cache, at.level, 1, at.row), args.moved[1], up,
                 cache.voxels) &&
      was_inside(cell_at(cache, at.level, 2, at.slice), args.moved[2], up,
                 cache.voxels))
    for (int i = 0; i < WORD_VOXELS; ++i)
      if (was_inside(cell_at(cache, at.level, 0, at.column + i), args.moved[0],
                     up, cache.voxels))
        stays |= 3u << (2 * i);
  states[number] &= stays;
}

/* What a voxel's surface has of its weight and its light when shares of both
 * are forgotten. */
INLINE void fade(const hbil_cache_forget_args args, global float *voxel) {
  const float left = 1.0f - args.light;
  const float4 light = vload4(0, voxel + HBIL_VOXEL_SENT);
  voxel[HBIL_VOXEL_WEIGHT] *= 1.0f - args.surfaces;
  /* the sign says whether it is finished, so some weight must remain */
  const float weight = max(fabs(light.w) * left, HBIL_LEAST_LIGHT_WEIGHT);
  vstore4((float4)(light.xyz * left,
                   light.w == 0.0f ? 0.0f : copysign(weight, light.w)),
          0, voxel + HBIL_VOXEL_SENT);
  vstore3(vload3(0, voxel + HBIL_VOXEL_INDIRECT) * left, 0,
          voxel + HBIL_VOXEL_INDIRECT);
  if (left < 1.0f && voxel[HBIL_VOXEL_BEFORE] > 0.0f)
    voxel[HBIL_VOXEL_BEFORE] = -1.0f; /* which is no longer its light */
}

/* Whether the box and the cell of a level have more than a face in common,
 * along one axis. */
INLINE bool is_in_box(const hbil_cache_forget_args args, int level, int axis,
                      int place) {
  const int cell = cell_at(args.cache, level, axis, place);
  const float size = (float)(1 << level);
  return (float)cell * size < args.high[axis] &&
         (float)(cell + 1) * size > args.low[axis];
}

kernel void forget_box(const hbil_cache_forget_args args, global uint *states,
                       global float *voxels) {
  uint number;
  if (!word_of_item(args.cache, &number))
    return;
  const word_place at = place_of_word(args.cache, number);
  if (!is_in_box(args, at.level, 1, at.row) ||
      !is_in_box(args, at.level, 2, at.slice))
    return;
  uint inside = 0u;
  for (int i = 0; i < WORD_VOXELS; ++i)
    if (is_in_box(args, at.level, 0, at.column + i))
      inside |= 3u << (2 * i);
  if (args.surfaces >= 1.0f) {
    states[number] &= ~inside;
    return;
  }
  for (uint left = surfaces_of_word(states[number]) & inside; left;
       left &= left - 1u)
    fade(args,
         voxels + HBIL_VOXEL_FLOATS * (size_t)first_surface(number, left));
}
