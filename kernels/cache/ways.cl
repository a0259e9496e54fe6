/*
 * ways: what rays read of the states of voxels, so that they ask once a step,
 * and cross what is all alike in one step.
 *
 * resolve: what a level has not seen has the state of the next coarser level
 * there.  Levels are done one after the other, the coarsest one first.
 * brick: the state of a cube of voxels, if all have the same.
 *
 * Launch: resolve: x = words of a row of voxels, y = rows, z = slices, of one
 * level; brick: x = bricks of a row, y = rows, z = slices, of all levels.
 */
#include "lib/cache_voxels.clh"

kernel void resolve(const hbil_cache_args cache, const int level,
                    global const uint *states, global uint *ways) {
  const uint x = (uint)get_global_id(0), y = (uint)get_global_id(1);
  const uint z = (uint)get_global_id(2), n = (uint)cache.voxels;
  if (x >= n / WORD_VOXELS || y >= n || z >= n)
    return;
  const uint word =
      ((((((uint)level << cache.log2_voxels | z) << cache.log2_voxels) | y)
        << cache.log2_voxels) >>
       4) |
      x;
  uint way = states[word];
  const uint unknown = ~(way | (way >> 1)) & 0x55555555u;
  if (unknown && level + 1 < cache.levels) {
    const int up_y = cell_at(cache, level, 1, (int)y) >> 1;
    const int up_z = cell_at(cache, level, 2, (int)z) >> 1;
    /* neighbours share the coarser voxel, as levels move by whole ones */
    for (uint i = 0; i < WORD_VOXELS; i += 2) {
      const uint pair = (unknown >> (2u * i)) & 5u;
      if (!pair)
        continue;
      const int up_x =
          cell_at(cache, level, 0, (int)(x * WORD_VOXELS + i)) >> 1;
      const uint number =
          (uint)voxel_number(cache, level + 1, up_x, up_y, up_z);
      way |= (state_in_word(ways[number >> 4], number) * pair) << (2u * i);
    }
  }
  ways[word] = way;
}

kernel void brick(const hbil_cache_args cache, global const uint *ways,
                  global uint *bricks) {
  const uint x = (uint)get_global_id(0), y = (uint)get_global_id(1);
  const uint z = (uint)get_global_id(2);
  const uint n = (uint)cache.voxels, across = n / HBIL_BRICK;
  if (x >= across || y >= across || z >= across * (uint)cache.levels)
    return;
  const uint corner =
      ((((z * HBIL_BRICK << cache.log2_voxels) | (y * HBIL_BRICK))
        << cache.log2_voxels) |
       (x * HBIL_BRICK));
  const uint first = state_in_word(ways[corner >> 4], corner);
  uint other = first == HBIL_VOXEL_SURFACE;
  for (uint k = 0; k < HBIL_BRICK; ++k)
    for (uint j = 0; j < HBIL_BRICK; ++j) {
      const uint row =
          corner + (((k << cache.log2_voxels) + j) << cache.log2_voxels);
      other |=
          ((ways[row >> 4] >> (2u * (row & 15u))) & 255u) ^ (first * 0x55u);
    }
  bricks[((z * across) + y) * across + x] = other ? HBIL_BRICK_MIXED : first;
}
