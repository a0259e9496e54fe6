/*
 * pyramid: builds lib/pyramid.clh's texels.
 *
 * first_step: from the voxels of the coarsest level.
 * next_step: from the step before.
 *
 * Launch: x, y, z = texels of the step.
 */
#include "lib/pyramid.clh"

INLINE void store_texel(const parts *p, global float *texel) {
#pragma unroll
  for (int i = 0; i < 6; ++i)
    vstore4(seen_along(p, i), i, texel);
  vstore2(0.125f * (float2)(p->unseen, p->sky), 0, texel + HBIL_MIP_UNSEEN);
}

kernel void first_step(const hbil_cache_args cache, global const uint *states,
                       global const uint *ways, global const float *voxels,
                       global const uint *radiance, global float *pyramid) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  const int z = (int)get_global_id(2), middle = cache.voxels / 2;
  if (x >= middle || y >= middle || z >= middle)
    return;
  const parts p =
      parts_of_voxels(cache, ways, states, voxels, radiance, cache.levels - 1,
                      2 * x - middle, 2 * y - middle, 2 * z - middle);
  store_texel(&p, pyramid + HBIL_MIP_FLOATS *
                                (size_t)texel_number(cache, 0, x, y, z));
}

kernel void next_step(const hbil_cache_args cache, const int step,
                      global float *pyramid) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  const int z = (int)get_global_id(2), across = cache.voxels >> (step + 1);
  if (x >= across || y >= across || z >= across)
    return;
  parts p;
  p.unseen = p.sky = 0.0f;
  for (int k = 0; k < 8; ++k) {
    global const float *part =
        pyramid + HBIL_MIP_FLOATS * (size_t)texel_number(cache, step - 1,
                                                         2 * x + (k & 1),
                                                         2 * y + ((k >> 1) & 1),
                                                         2 * z + (k >> 2));
    for (int i = 0; i < 6; ++i)
      p.along[i][k] = vload4(i, part);
    p.unseen += part[HBIL_MIP_UNSEEN];
    p.sky += part[HBIL_MIP_SKY];
  }
  store_texel(&p, pyramid + HBIL_MIP_FLOATS *
                                (size_t)texel_number(cache, step, x, y, z));
}
