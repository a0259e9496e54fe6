/*
 * links: where light comes from to surfaces of the cache.
 *
 * list_parts, list_surfaces: the surfaces of an update, in rising order.
 * trace: rays from each of them; a link says what a ray ends at.  All bounces
 * of an update follow the same links, so that rays are traced once for all of
 * them.
 *
 * Launch: list_parts, list_surfaces: x = HBIL_CACHE_PARTS.  trace: any x.
 */
#include "lib/cache_links.clh"

/* --- the surfaces of an update -------------------------------------------- */

/* The surfaces of a word that the update does, as surfaces_of_word(). */
INLINE uint listed_of_word(const hbil_cache_list_args args,
                           global const uint *states, uint word) {
  uint listed = surfaces_of_word(states[word]);
  if (args.share > 1)
    for (uint left = listed; left; left &= left - 1u)
      if (first_surface(word, left) % (uint)args.share != (uint)args.phase)
        listed &= ~(left & -left);
  return listed;
}

/* The words of states that a part has, from *word on, before the one returned;
 * none for work-items that are no part. */
INLINE uint words_of_part(const hbil_cache_args cache, uint *word) {
  const uint part = (uint)get_global_id(0);
  const uint words = ((uint)cache.levels << (3 * cache.log2_voxels)) /
                     WORD_VOXELS / HBIL_CACHE_PARTS;
  const bool is = part < HBIL_CACHE_PARTS && get_global_id(1) == 0;
  *word = is ? part * words : 0u;
  return is ? *word + words : 0u;
}

kernel void list_parts(const hbil_cache_list_args args,
                       global const uint *states, global uint *list) {
  uint word, count = 0;
  const uint end = words_of_part(args.cache, &word);
  if (word == end)
    return;
  for (; word < end; ++word)
    count += popcount(listed_of_word(args, states, word));
  list[1 + get_global_id(0)] = count;
}

kernel void list_surfaces(const hbil_cache_list_args args,
                          global const uint *states, global uint *list) {
  uint word;
  const uint end = words_of_part(args.cache, &word);
  const uint part = (uint)get_global_id(0);
  if (word == end)
    return;
  global uint *next = list + HBIL_LIST_HEAD;
  for (uint i = 0; i < part; ++i)
    next += list[1 + i];
  for (; word < end; ++word)
    for (uint left = listed_of_word(args, states, word); left;
         left &= left - 1u)
      *next++ = first_surface(word, left);
  if (part == HBIL_CACHE_PARTS - 1)
    list[0] = (uint)(next - (list + HBIL_LIST_HEAD));
}

/* --- rays ----------------------------------------------------------------- */

INLINE void trace_surface(const cache_map *map, uint number, int rays,
                          global uint *links) {
  const hbil_cache_args cache = map->cache;
  const uint mask = (uint)cache.voxels - 1u;
  const int level = (int)(number >> (3 * cache.log2_voxels));
  const float size = (float)(1 << level);
  const float4 plane =
      vload4(0, map->voxels + HBIL_VOXEL_FLOATS * (size_t)number);
  const float3 n = plane.xyz * (1.0f / sqrt(dot(plane.xyz, plane.xyz)));
  /* scalars of a vector function: any lane */
  float cell[3][HBIL_WIDTH];
#pragma unroll
  for (int i = 0; i < 3; ++i)
    STOREV(TO_REALV(cell_at(
               cache, level, i,
               (intv)(int)((number >> (i * cache.log2_voxels)) & mask))),
           cell[i]);
  const float3 centre =
      ((float3)(cell[0][0], cell[1][0], cell[2][0]) + 0.5f) * size;
  const float3 origin = centre + n * fma(HBIL_CACHE_LIFT, size, plane.w);
  for (int i = 0; i < rays; i += HBIL_WIDTH) {
    uint link[HBIL_WIDTH];
    const ray_ends ends =
        follow_rays(map, origin, link_directions(i, rays, number, n),
                    (realv)(HBIL_CACHE_START * size), i + EACH_LANE < rays);
    const uintv open =
        select((uintv)LINK_UNKNOWN, (uintv)LINK_SKY, AS_UINTV(ends.sky));
    STORE_INTV(AS_INTV(select(open, AS_UINTV(ends.voxel), AS_UINTV(ends.hit))),
               link);
    for (int k = 0; k < min(HBIL_WIDTH, rays - i); ++k)
      links[i + k] = link[k];
  }
}

kernel void trace(const hbil_cache_args cache, global const uchar *ways,
                  global const float *voxels, global const uint *list,
                  global uint *links) {
  const cache_map map = {cache, ways, voxels};
  uint place;
  if (get_global_id(1) > 0 || cache.voxels < 1)
    return;
  const int rays = links_each(cache, list[0]);
  const uint end = places_of_item(list[0], &place);
  for (; place < end; ++place) {
    const uint number = list[HBIL_LIST_HEAD + place];
    /* finished radiance has all bounces */
    if (voxels[HBIL_VOXEL_FLOATS * (size_t)number + HBIL_VOXEL_LIGHT_WEIGHT] >=
        0.0f)
      trace_surface(&map, number, rays, links + (size_t)place * (uint)rays);
  }
}
