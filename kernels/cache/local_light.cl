/*
 * local_light: sums up lib/local_light.clh's areas.
 *
 * area_light: those of the levels, from their surfaces.  join_areas: those
 * beyond the levels, from those of the last level.  Both do nothing if neither
 * radiance nor surfaces have changed since the last time.
 *
 * An area has six sums of (red, green, blue, 1), over the surfaces that face
 * along +x -x +y -y +z -z, by the cosine.
 *
 * Launch: area_light: x, y = areas of a level across, z = those of all levels;
 * join_areas: x = areas beyond the levels.
 */
#include "lib/local_light.clh"

/* since: the round before this update; see last_change in bounce.cl. */
INLINE bool areas_change(const hbil_cache_round_args since,
                         global const uint *last_change) {
  return since.fresh || (int)(*last_change - since.number) > 0;
}

/* The surfaces among the HBIL_AREA_VOXELS voxels of a row from cell x on: the
 * higher of two bits each.  row: the number of the row's first voxel in memory;
 * at: that of the cell in it. */
INLINE uint surfaces_of_row(const hbil_cache_args cache,
                            global const uint *states, uint row, uint at) {
  const uint next = (at + WORD_VOXELS) & (uint)(cache.voxels - 1);
  const uint off = at % WORD_VOXELS;
  uint bits = states[(row + at) / WORD_VOXELS] >> (2u * off);
  if (off > WORD_VOXELS - HBIL_AREA_VOXELS)
    bits |= states[(row + next) / WORD_VOXELS] << (2u * (WORD_VOXELS - off));
  return surfaces_of_word(bits) & ((1u << (2 * HBIL_AREA_VOXELS)) - 1u);
}

INLINE void add_surface(float4 sum[6], global const float *voxel, uint word) {
  const float3 n = vload3(0, voxel + HBIL_VOXEL_NORMAL);
  const float3 unit = n * (1.0f / sqrt(max(dot(n, n), FLT_MIN)));
  const float4 sent = (float4)(light_of_word(word), 1.0f);
  sum[0] += max(unit.x, 0.0f) * sent;
  sum[1] += max(-unit.x, 0.0f) * sent;
  sum[2] += max(unit.y, 0.0f) * sent;
  sum[3] += max(-unit.y, 0.0f) * sent;
  sum[4] += max(unit.z, 0.0f) * sent;
  sum[5] += max(-unit.z, 0.0f) * sent;
}

kernel void area_light(const hbil_cache_args cache, global const uint *states,
                       global const float *voxels, global const uint *radiance,
                       const hbil_cache_round_args since,
                       global const uint *last_change, global float *areas) {
  const int across = areas_across(cache, 0), middle = cache.voxels / 2;
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  const int level = (int)get_global_id(2) / max(across, 1);
  const int z = (int)get_global_id(2) % max(across, 1);
  float4 sum[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  if (x >= across || y >= across || level >= cache.levels ||
      !areas_change(since, last_change))
    return;
  const uint mask = (uint)(cache.voxels - 1);
  for (int k = 0; k < HBIL_AREA_VOXELS * HBIL_AREA_VOXELS; ++k) {
    const uint first = (uint)voxel_number(
        cache, level, HBIL_AREA_VOXELS * x - middle,
        HBIL_AREA_VOXELS * y - middle + k % HBIL_AREA_VOXELS,
        HBIL_AREA_VOXELS * z - middle + k / HBIL_AREA_VOXELS);
    const uint at = first & mask, row = first - at;
    for (uint left = surfaces_of_row(cache, states, row, at); left;
         left &= left - 1u) {
      const uint number = row + ((at + (31u - clz(left & -left)) / 2u) & mask);
      add_surface(sum, voxels + HBIL_VOXEL_FLOATS * (size_t)number,
                  radiance[number]);
    }
  }
  global float *to =
      areas + HBIL_AREA_FLOATS * (first_area(cache, level) +
                                  (uint)((z * across + y) * across + x));
  for (int i = 0; i < 6; ++i)
    vstore4(sum[i], i, to);
}

kernel void join_areas(const hbil_cache_args cache,
                       const hbil_cache_round_args since,
                       global const uint *last_change, global float *areas) {
  const int last = cache.levels - 1, fine = areas_across(cache, last);
  const uint number = first_area(cache, cache.levels) + (uint)get_global_id(0);
  int step = cache.levels;
  uint first = first_area(cache, step);
  float4 sum[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  if (get_global_id(1) > 0 || !areas_change(since, last_change))
    return;
  for (; areas_across(cache, step) > 0; ++step) {
    const uint across = (uint)areas_across(cache, step);
    if (number < first + across * across * across)
      break;
    first += across * across * across;
  }
  const int across = areas_across(cache, step), place = (int)(number - first);
  if (across < 1)
    return;
  const int size = fine / across;
  global const float *from = areas + HBIL_AREA_FLOATS * first_area(cache, last);
  for (int k = 0; k < size * size * size; ++k) {
    const int x = place % across * size + k % size;
    const int y = place / across % across * size + k / size % size;
    const int z = place / across / across * size + k / size / size;
    global const float *part =
        from + HBIL_AREA_FLOATS * (uint)((z * fine + y) * fine + x);
    for (int i = 0; i < 6; ++i)
      sum[i] += vload4(i, part);
  }
  for (int i = 0; i < 6; ++i)
    vstore4(sum[i], i, areas + HBIL_AREA_FLOATS * number);
}
