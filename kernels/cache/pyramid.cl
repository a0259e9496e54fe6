/*
 * pyramid: builds lib/pyramid.clh's texels.
 *
 * level_step: of a level, from its voxels or, where the next finer level is,
 * from that one's texels.  A coarse voxel looks at the same few pixels of a
 * view as a fine one, so surfaces have more holes in coarse voxels.
 * next_step: beyond the levels, from the step before.
 *
 * Launch: x, y, z = texels of the step.
 */
#include "lib/pyramid.clh"

/* Part k of a cube is texel (x, y, z) of a step. */
INLINE void set_texel(parts *p, int k, const hbil_cache_args cache,
                      global const float *pyramid, int step, int x, int y,
                      int z) {
  global const float *part =
      pyramid + HBIL_MIP_FLOATS * (size_t)texel_number(cache, step, x, y, z);
#pragma unroll
  for (int i = 0; i < 6; ++i)
    p->along[i][k] = vload4(i, part);
  p->unseen[k] = part[HBIL_MIP_UNSEEN];
  p->sky += part[HBIL_MIP_SKY];
}

INLINE void store_texel(const parts *p, global float *texel) {
  float unseen = 0.0f;
#pragma unroll
  for (int i = 0; i < 6; ++i)
    vstore4(seen_along(p, i), i, texel);
#pragma unroll
  for (int k = 0; k < 8; ++k)
    unseen += p->unseen[k];
  vstore2(0.125f * (float2)(unseen, p->sky), 0, texel + HBIL_MIP_UNSEEN);
}

kernel void level_step(const hbil_cache_args cache, const int level,
                       global const uchar *clearance,
                       global const float *voxels, global const uint *radiance,
                       global float *pyramid) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  const int z = (int)get_global_id(2), middle = cache.voxels / 2;
  if (x >= middle || y >= middle || z >= middle)
    return;
  /* the middle half of a level is the next finer one */
  const int quarter = middle / 2;
  const int low = min(min(x, y), z), high = max(max(x, y), z);
  parts p;
  p.sky = 0.0f;
  if (level > 0 && 2 * low >= quarter && 2 * high + 1 < middle + quarter) {
    for (int k = 0; k < 8; ++k)
      set_texel(&p, k, cache, pyramid, level - 1, 2 * x + (k & 1) - quarter,
                2 * y + ((k >> 1) & 1) - quarter, 2 * z + (k >> 2) - quarter);
  } else {
    p = parts_of_voxels(cache, clearance, voxels, radiance, level,
                        2 * x - middle, 2 * y - middle, 2 * z - middle);
  }
  store_texel(&p, pyramid + HBIL_MIP_FLOATS *
                                (size_t)texel_number(cache, level, x, y, z));
}

kernel void next_step(const hbil_cache_args cache, const int step,
                      global float *pyramid) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  const int z = (int)get_global_id(2), across = texels_across(cache, step);
  if (x >= across || y >= across || z >= across)
    return;
  parts p;
  p.sky = 0.0f;
  for (int k = 0; k < 8; ++k)
    set_texel(&p, k, cache, pyramid, step - 1, 2 * x + (k & 1),
              2 * y + ((k >> 1) & 1), 2 * z + (k >> 2));
  store_texel(&p, pyramid + HBIL_MIP_FLOATS *
                                (size_t)texel_number(cache, step, x, y, z));
}
