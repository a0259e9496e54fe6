/*
 * move: after a move of the cache's centre, forgets the voxels that came in.
 * Those that stay are where they were in memory.
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
  const uint first = number * WORD_VOXELS, mask = (uint)cache.voxels - 1u;
  const int level = (int)(first >> (3 * cache.log2_voxels));
  const int up = cache.levels - 1 - level;
  const int row = (int)((first >> cache.log2_voxels) & mask);
  const int slice = (int)((first >> (2 * cache.log2_voxels)) & mask);
  uint stays = 0u;
  if (was_inside(cell_at(cache, level, 1, row), args.moved[1], up,
                 cache.voxels) &&
      was_inside(cell_at(cache, level, 2, slice), args.moved[2], up,
                 cache.voxels))
    for (uint i = 0; i < WORD_VOXELS; ++i)
      if (was_inside(cell_at(cache, level, 0, (int)((first & mask) + i)),
                     args.moved[0], up, cache.voxels))
        stays |= 3u << (2u * i);
  states[number] &= stays;
}
