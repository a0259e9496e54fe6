/*
 * volumes: what the cache's surfaces send into the cells of the volumes, and
 * how much of the light that enters a cell they stop.
 *
 * A surface voxel sends its light from half a cell in front of it, so that it
 * doesn't light itself: intensity Phi/pi (1/4 + 1/2 n.w), the order-1 part of
 * Phi/pi max(n.w, 0), with the flux Phi = pi B A.  A plane crosses (|nx| +
 * |ny| + |nz|) / s^2 voxels for each unit of its area, which gives A.
 *
 * Launch: x, y = cells, z = cells of all levels.
 */
#include "lib/pyramid.clh"
#include "lib/volumes.clh"

/* Adds what voxel `number` sends, if that is into cell (x, y, z). */
INLINE void add_voxel(global const float *voxels, global const uint *radiance,
                      uint number, float3 cell, int3 wanted, float area,
                      float4 sum[3]) {
  const float3 mean = vload3(0, voxels + HBIL_VOXEL_FLOATS * (size_t)number);
  const float3 n = mean * (1.0f / sqrt(dot(mean, mean)));
  const int3 to = convert_int3(floor(0.5f * (cell + 0.5f + n)));
  if (to.x != wanted.x || to.y != wanted.y || to.z != wanted.z)
    return;
  const float3 lean = fabs(n);
  const float4 lobe =
      (float4)(0.25f, 0.5f * n) * (area / (lean.x + lean.y + lean.z));
  const float3 sent = light_of_word(radiance[number]);
  sum[0] += sent.x * lobe;
  sum[1] += sent.y * lobe;
  sum[2] += sent.z * lobe;
}

/* Adds what the voxels in and around a cell send into it; low: its lowest
 * voxel.
 */
INLINE void add_voxels(const hbil_cache_args cache, global const uint *states,
                       global const float *voxels, global const uint *radiance,
                       int level, int3 low, float4 sum[3]) {
  const int middle = cache.voxels / 2;
  const float size = (float)(1 << level);
  for (int k = -1; k < 3; ++k)
    for (int j = -1; j < 3; ++j)
      for (int i = -1; i < 3; ++i) {
        const int3 cell = low + (int3)(i, j, k);
        if (cell.x < -middle || cell.y < -middle || cell.z < -middle ||
            cell.x >= middle || cell.y >= middle || cell.z >= middle)
          continue;
        const uint number =
            (uint)voxel_number(cache, level, cell.x, cell.y, cell.z);
        if (state_in_word(states[number >> 4], number) == HBIL_VOXEL_SURFACE)
          add_voxel(voxels, radiance, number, convert_float3(cell), low / 2,
                    size * size, sum);
      }
}

/* Whether surfaces can be among those voxels.  They are 4 across, as a brick
 * is, so the bricks of the eight at their corners are all that they are in. */
INLINE bool has_surfaces(const hbil_cache_args cache, global const uint *bricks,
                         int level, int3 low) {
  const int middle = cache.voxels / 2, k = cache.log2_voxels;
  const uint mask = (uint)cache.voxels - 1u;
  const uint across = (uint)cache.voxels / HBIL_BRICK;
  for (int i = 0; i < 8; ++i) {
    const int3 cell =
        clamp(low + (int3)(i & 1 ? 2 : -1, i & 2 ? 2 : -1, i & 4 ? 2 : -1),
              (int3)(-middle), (int3)(middle - 1));
    const uint number =
        (uint)voxel_number(cache, level, cell.x, cell.y, cell.z);
    const uint mx = number & mask, my = (number >> k) & mask;
    const uint mz = number >> (2 * k); /* with the level */
    if (bricks[((mz / HBIL_BRICK) * across + my / HBIL_BRICK) * across +
               mx / HBIL_BRICK] == HBIL_BRICK_MIXED)
      return true;
  }
  return false;
}

kernel void volume_sources(const hbil_cache_args cache,
                           global const uint *states, global const uint *ways,
                           global const float *voxels,
                           global const uint *radiance, global float *sources,
                           global float *opacities, global const uint *bricks) {
  const int middle = cache.voxels / 2;
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  int z;
  const int level = level_of_item(cache, &z);
  if (x >= middle || y >= middle || level >= cache.levels)
    return;
  const uint plane = volume_plane(cache);
  const int3 low = (int3)(2 * x - middle, 2 * y - middle, 2 * z - middle);
  float4 sum[3] = {0.0f, 0.0f, 0.0f};
  const bool any = has_surfaces(cache, bricks, level, low);
  if (any)
    add_voxels(cache, states, voxels, radiance, level, low, sum);
  global float *source = sources + cell_address(cache, 12u, level, x, y, z);
  for (int c = 0; c < 3; ++c) {
    source[(4 * c) * plane] = sum[c].x;
    source[(4 * c + 1) * plane] = sum[c].y;
    source[(4 * c + 2) * plane] = sum[c].z;
    source[(4 * c + 3) * plane] = sum[c].w;
  }
  global float *opacity = opacities + cell_address(cache, 6u, level, x, y, z);
  for (int i = 0; i < 6; ++i)
    opacity[i * plane] = 0.0f;
  if (!any)
    return;
  const parts p = parts_of_voxels(cache, ways, states, voxels, radiance, level,
                                  low.x, low.y, low.z);
  for (int i = 0; i < 6; ++i)
    opacity[i * plane] = seen_along(&p, i).w;
}
