/*
 * volumes: what the cache's surfaces send into the cells of the volumes, and
 * how much of the light that leaves a cell they stop.
 *
 * A cell stops the share o of the light that leaves it along a half-axis: what
 * is seen of its surfaces along that way (lib/pyramid.clh).  Against that way
 * it gets what a neighbour there would send if that were full of light of the
 * surfaces' radiance B, the intensity 3/2 s^2 B, s being a cell's width: a flux
 * of pi s^2 o B, through the far face and evenly through the four sides.  So
 * light of the same radiance stays as it is beside a surface that sends it.
 *
 * Launch: x, y = cells, z = cells of all levels.
 */
#include "lib/pyramid.clh"
#include "lib/volumes.clh"

/* Of the five faces only the far one makes a slope: 1/(2 pi) of its flux, which
 * is 3/2 of its solid angle (cache/propagate.cl). */
#define SLOPE (1.5f * 0.159154943f * FRONT_FACE)

kernel void volume_sources(const hbil_cache_args cache,
                           global const uchar *clearance,
                           global const float *voxels,
                           global const uint *radiance, global float *sources,
                           global float *opacities) {
  const int middle = cache.voxels / 2;
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  int z;
  const int level = level_of_item(cache, &z);
  if (x >= middle || y >= middle || level >= cache.levels)
    return;
  const uint plane = volume_plane(cache);
  const float size = (float)(2 << level);
  const parts p =
      parts_of_voxels(cache, clearance, voxels, radiance, level, 2 * x - middle,
                      2 * y - middle, 2 * z - middle);
  global float *source = sources + cell_address(cache, 12u, level, x, y, z);
  global float *opacity = opacities + cell_address(cache, 6u, level, x, y, z);
  float3 mean = 0.0f, slope[3] = {0.0f, 0.0f, 0.0f};
#pragma unroll
  for (int i = 0; i < 6; ++i) {
    const seen s = seen_along(&p, i);
    const float3 sent = size * size * s.xyz;
    opacity[(uint)i * plane] = s.w;
    mean += 0.25f * sent;
    slope[i / 2] += (i & 1 ? SLOPE : -SLOPE) * sent;
  }
  const float value[12] = {mean.x, slope[0].x, slope[1].x, slope[2].x,
                           mean.y, slope[0].y, slope[1].y, slope[2].y,
                           mean.z, slope[0].z, slope[1].z, slope[2].z};
#pragma unroll
  for (int i = 0; i < 12; ++i)
    source[(uint)i * plane] = value[i];
}
