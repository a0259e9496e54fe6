/*
 * bounce: light that surfaces of the cache send each other.
 *
 * mean_part, mean_sum: the mean radiance of the coarsest level's surfaces,
 * which stands for what no view has seen where rays meet nothing else.
 * bounce: what arrives at voxels along their rays (cache/ray_hits.cl).
 * update_radiance: the radiance that each voxel sends, which rays read.  It is
 * apart from bounce, so that all voxels of a round see the light of the round
 * before, in any order of work-items.
 * last_change: the number of the last round that changed a word of radiance or
 * what is known of unlit directions.  Both are rounded, so light comes to rest.
 * Behind a round without changes all work is left out, with the same bits.
 *
 * Launch: update_radiance: x = words of a row of voxels, y = rows, z = slices,
 * of all levels; mean_part: x = HBIL_CACHE_PARTS; mean_sum: one work-item;
 * bounce: any x.
 */
#include "lib/ray_hits.clh"
#include "lib/sky_light.clh"

/* The largest reflectance that bounces count with, so that light in a closed
 * white place stays finite: the series of all bounces is at most 20. */
#define MOST_REFLECTANCE 0.95f

/* --- rounds --------------------------------------------------------------- */

/* Whether a round may change anything. */
INLINE bool round_has_work(const hbil_cache_round_args round,
                           global const uint *last_change) {
  return round.fresh || round.number - *last_change <= 1u;
}

/* --- means ---------------------------------------------------------------- */

/* A voxel's sum: what it sends, 1, the unlit part of its open directions, and 1
 * if it tells that. */
INLINE float8 telling_of(global const uint *radiance,
                         global const uchar *unlit_codes, uint number) {
  const uchar code = unlit_codes[number];
  return (float8)(light_of_word(radiance[number]), 1.0f,
                  code > 0 ? (float)(code - 1) * (1.0f / 254.0f) : 0.0f,
                  code > 0 ? 1.0f : 0.0f, 0.0f, 0.0f);
}

kernel void mean_part(const hbil_cache_args cache, global const uint *states,
                      global const uint *radiance,
                      global const uchar *unlit_codes, global float *means,
                      const hbil_cache_round_args round,
                      global const uint *last_change) {
  const uint part = (uint)get_global_id(0);
  uint first, end;
  if (!coarsest_words_of_item(cache, &first, &end) ||
      !round_has_work(round, last_change))
    return;
  float8 sum = 0.0f;
  for (uint i = first; i < end; ++i)
    for (uint left = surfaces_of_word(states[i]); left; left &= left - 1u)
      sum += telling_of(radiance, unlit_codes, first_surface(i, left));
  vstore8(sum, part + 1, means);
}

kernel void mean_sum(global float *means, const hbil_cache_round_args round,
                     global const uint *last_change) {
  if (get_global_id(0) > 0 || get_global_id(1) > 0 ||
      !round_has_work(round, last_change))
    return;
  float8 sum = 0.0f;
  for (int i = 1; i <= HBIL_CACHE_PARTS; ++i)
    sum += vload8(i, means);
  /* where no voxel tells, all is unlit */
  vstore4((float4)(sum.s012 * (1.0f / max(sum.s3, 1.0f)),
                   sum.s5 > 0.0f ? sum.s4 / sum.s5 : 1.0f),
          0, means);
}

/* --- bounces -------------------------------------------------------------- */

/* Direct light of a voxel over that of a whole hemisphere of the sky that it
 * contains, the largest quotient of the three channels (lib/sky_light.clh): so
 * much of the hemisphere ends in the sky, and is no guess. */
INLINE float sky_light_of(const hbil_cache_bounce_args args,
                          global const float *voxel) {
  float largest = 0.0f;
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    const float share = voxel[HBIL_VOXEL_REFLECTANCE + c];
    if (args.sky[c] > 0.0f && share > 0.0f)
      largest =
          max(largest, voxel[HBIL_VOXEL_SENT + c] / (share * args.sky[c]));
  }
  return largest;
}

/* What a voxel's rays have brought: light of surfaces and of the sky, and
 * shares of the rays. */
typedef struct gathered_rays {
  float surfaces[3], sky[3];
  float open, unknown;
} gathered_rays;

INLINE gathered_rays gather_rays(const hbil_cache_bounce_args args,
                                 global const float *voxel,
                                 global const uint *radiance,
                                 global const uint *hits, uint number,
                                 int rays) {
  const float3 plane = vload3(0, voxel + HBIL_VOXEL_NORMAL);
  const float3 n = plane * (1.0f / sqrt(dot(plane, plane)));
  realv surfaces[3] = {0.0f, 0.0f, 0.0f}, sky[3] = {0.0f, 0.0f, 0.0f};
  realv open = 0.0f, unknown = 0.0f;
  for (int i = 0; i < rays; i += HBIL_WIDTH) {
    const intv is_ray = i + EACH_LANE < rays;
    /* may read beyond this surface's hits: the next one's, or the spare words
     * at the end */
    const uintv hit = LOADV(hits + i);
    ray_ends ends = {.hit = is_ray & (hit < HIT_SKY),
                     .sky = is_ray & (hit == HIT_SKY),
                     .voxel = AS_INTV(hit)};
    points d = {0.0f, 0.0f, 0.0f};
    realv light[3];
    if (ANY(ends.sky))
      d = surface_ray_directions(i + EACH_LANE, rays, number, all_at(n));
    light_of_rays(&ends, radiance, args.environment, d, light);
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      surfaces[c] += select((realv)0.0f, light[c], ends.hit);
      sky[c] += select(light[c], (realv)0.0f, ends.hit);
    }
    open += select((realv)0.0f, (realv)1.0f, is_ray & !ends.hit);
    unknown += select((realv)0.0f, (realv)1.0f, is_ray & !ends.hit & !ends.sky);
  }
  const float inv = 1.0f / (float)rays;
  gathered_rays g = {.open = lanes_sum(open) * inv,
                     .unknown = lanes_sum(unknown) * inv};
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    g.surfaces[c] = lanes_sum(surfaces[c]) * inv;
    g.sky[c] = lanes_sum(sky[c]) * inv;
  }
  return g;
}

INLINE float first_lane(realv v) {
  float lane[HBIL_WIDTH];
  STOREV(v, lane);
  return lane[0];
}

/* Returns whether what others may learn from it has changed. */
INLINE bool bounce_voxel(const hbil_cache_bounce_args args, global float *voxel,
                         const gathered_rays g, global const float *means,
                         global uchar *unlit_code) {
  realv lit_by_other;
  const float own = first_lane(unlit_part((realv)sky_light_of(args, voxel),
                                          (realv)g.open, &lit_by_other));
  const float lit = first_lane(lit_by_other);
  const float unlit = min(fma(lit, means[3], own) * g.open, g.unknown);
  /* what others may learn from it; 0: nothing */
  const uchar code =
      g.open > 0.0f && lit == 0.0f ? (uchar)(1.5f + 254.0f * own) : (uchar)0;
  const bool changes = code != *unlit_code;
  *unlit_code = code;
  /* what no view has seen sends like what the other rays have met */
  const float guessed =
      unlit * args.unseen_light / (1.0f - g.open + HBIL_CACHE_MEAN_SHARE);
#pragma unroll
  for (int c = 0; c < 3; ++c)
    voxel[HBIL_VOXEL_INDIRECT + c] =
        g.surfaces[c] + g.sky[c] +
        guessed * fma(HBIL_CACHE_MEAN_SHARE, means[c], g.surfaces[c]);
  return changes;
}

kernel void bounce(const hbil_cache_bounce_args args, global const uint *list,
                   global const uint *hits, global float *voxels,
                   global const uint *radiance, global const float *means,
                   global uchar *unlit_codes, const hbil_cache_round_args round,
                   global uint *last_change) {
  uint place;
  bool changes = false;
  if (get_global_id(1) > 0 || args.cache.voxels < 1 ||
      !round_has_work(round, last_change))
    return;
  const int rays = rays_of_each(args.cache, list[0]);
  const uint end = part_of_item(list[0], 1u, &place);
  for (; place < end; ++place) {
    const uint number = list[HBIL_LIST_HEAD + place];
    global float *voxel = voxels + HBIL_VOXEL_FLOATS * (size_t)number;
    /* finished radiance has all bounces */
    if (voxel[HBIL_VOXEL_LIGHT_WEIGHT] < 0.0f)
      continue;
    const gathered_rays g = gather_rays(
        args, voxel, radiance, hits + (size_t)place * (uint)rays, number, rays);
    changes |= bounce_voxel(args, voxel, g, means, unlit_codes + number);
  }
  if (changes)
    atomic_xchg(last_change, round.number);
}

/* --- what voxels send ----------------------------------------------------- */

kernel void update_radiance(const hbil_cache_args cache,
                            global const uint *states,
                            global const float *voxels, global uint *radiance,
                            const hbil_cache_round_args round,
                            global uint *last_change) {
  uint word;
  bool changes = false;
  if (!word_of_item(cache, &word) || !round_has_work(round, last_change))
    return;
  for (uint left = surfaces_of_word(states[word]); left; left &= left - 1u) {
    const uint number = first_surface(word, left);
    global const float *voxel = voxels + HBIL_VOXEL_FLOATS * (size_t)number;
    const float4 light = vload4(0, voxel + HBIL_VOXEL_SENT);
    const float4 reflectance =
        min(vload4(0, voxel + HBIL_VOXEL_REFLECTANCE), MOST_REFLECTANCE);
    const float4 indirect = vload4(0, voxel + HBIL_VOXEL_INDIRECT);
    const float4 sent =
        light.w < 0.0f ? light : fma(reflectance, indirect, light);
    const uint now = word_of_light(sent.xyz);
    changes |= now != radiance[number];
    radiance[number] = now;
  }
  if (changes)
    atomic_xchg(last_change, round.number);
}
