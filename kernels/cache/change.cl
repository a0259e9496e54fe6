/*
 * change: light that no view sees any more follows the light that views see.
 *
 * Voxels that views have shown since the last update hold what light they sent
 * before (inject.cl, HBIL_VOXEL_BEFORE).  The cache's extent is divided into
 * regions.  Where what is seen of a region and around it agrees that there is
 * less light, surfaces that no view has seen are dimmed by as much: a lamp that
 * goes out behind the camera, or dusk.  Nothing is brightened: a patch of
 * sun that comes in at a door tells nothing of other places.
 *
 * change_part: sums over parts of the coarsest level, for each region.
 * change_region: the sums of each region.
 * change_ratio: what each region makes of all, the near ones first.
 * follow_change: dims what has not been seen, and the means that the newest
 * view of what has been seen joined; forgets who was seen.
 *
 * Launch: change_part: x = HBIL_CACHE_PARTS; change_region, change_ratio: x =
 * HBIL_CACHE_REGIONS; follow_change: x = words of a row of voxels, y = rows, z
 * = slices, of all levels.
 */
#include "lib/cache_voxels.clh"

/* Of a region: 0 and 1: the light of what is seen, now and before; 2: how much
 * it has changed by without signs; 3: the number of voxels; 4 and 5: the light
 * before, and the number, of those that have next to none now, which are in none
 * of the others. */
typedef float8 change_sums;

/* The region of a voxel. */
INLINE int region_of(const hbil_cache_args c, uint number) {
  const int mask = c.voxels - 1, k = c.log2_voxels;
  const int level = (int)(number >> (3 * k)), up = c.levels - 1 - level;
  int region = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const int place = (int)(number >> (axis * k)) & mask;
    region = region * HBIL_CACHE_REGIONS_ACROSS +
             region_along(c, cell_at(c, level, axis, place) >> up);
  }
  return region;
}

/* How bright a voxel was before the views since the last update, how bright they
 * show it, and their share of its mean. */
typedef struct seen_change {
  bool is_known;
  float before, now, share;
} seen_change;

INLINE seen_change change_of_voxel(global const float *voxel) {
  const float held = voxel[HBIL_VOXEL_BEFORE];
  const uint newest = as_uint(held) & HBIL_VOXEL_MOMENT_VIEWS;
  const float views = fabs(voxel[HBIL_VOXEL_LIGHT_WEIGHT]);
  seen_change s = {
      held > 0.0f && views >= 1.0f,
      as_float(as_uint(held) & ~HBIL_VOXEL_MOMENT_VIEWS), 0.0f,
      min((float)newest, views) / max(views, 1.0f)};
  if (s.is_known) {
    const float3 sent = vload3(0, voxel + HBIL_VOXEL_SENT);
    const float mean = sent.x + sent.y + sent.z;
    s.now = max(s.before + (mean - s.before) / s.share, 0.0f);
  }
  return s;
}

INLINE change_sums sums_of_voxel(global const float *voxel) {
  const seen_change s = change_of_voxel(voxel);
  if (!s.is_known)
    return 0.0f;
  const float most = HBIL_CACHE_MOST_CHANGE;
  if (s.now * most < s.before)
    return (float8)(0.0f, 0.0f, 0.0f, 0.0f, s.before, 1.0f, 0.0f, 0.0f);
  /* as much as can be gone may have come, so that both cancel */
  const float before = max(s.before, s.now / most);
  return (float8)(s.now, before, fabs(s.now - before), 1.0f, 0.0f, 0.0f, 0.0f,
                  0.0f);
}

kernel void change_part(const hbil_cache_args cache, global const uint *states,
                        global const float *voxels, global float *changes) {
  const uint part = (uint)get_global_id(0);
  uint first, end;
  if (!coarsest_words_of_item(cache, &first, &end))
    return;
  global float *sums =
      changes + HBIL_CHANGE_SUMS * HBIL_CACHE_REGIONS * (1 + part);
  for (int r = 0; r < HBIL_CACHE_REGIONS; ++r)
    vstore8((float8)(0.0f), r, sums);
  for (uint i = first; i < end; ++i)
    for (uint left = surfaces_of_word(states[i]); left; left &= left - 1u) {
      const uint number = first_surface(i, left);
      const change_sums s =
          sums_of_voxel(voxels + HBIL_VOXEL_FLOATS * (size_t)number);
      if (s.s3 + s.s5 > 0.0f) {
        const int region = region_of(cache, number);
        vstore8(vload8(region, sums) + s, region, sums);
      }
    }
}

kernel void change_region(global float *changes) {
  const int region = (int)get_global_id(0);
  if (region >= HBIL_CACHE_REGIONS || get_global_id(1) > 0)
    return;
  change_sums sum = 0.0f;
  for (int part = 1; part <= HBIL_CACHE_PARTS; ++part)
    sum += vload8(HBIL_CACHE_REGIONS * part + region, changes);
  vstore8(sum, region, changes);
}

kernel void change_ratio(global const float *changes, global float *ratios) {
  const int own = (int)get_global_id(0), n = HBIL_CACHE_REGIONS_ACROSS;
  if (own >= HBIL_CACHE_REGIONS || get_global_id(1) > 0)
    return;
  change_sums sum = 0.0f;
  for (int r = 0; r < HBIL_CACHE_REGIONS; ++r) {
    const int dx = own % n - r % n, dy = own / n % n - r / n % n;
    const int dz = own / (n * n) - r / (n * n);
    const float weight = 1.0f / (float)(1 + dx * dx + dy * dy + dz * dz);
    sum += weight * vload8(r, changes);
  }
  const bool is_gone = sum.s4 > sum.s1;
  const float gone = is_gone ? sum.s4 : 0.0f;
  const float count = sum.s3 + (is_gone ? sum.s5 : 0.0f);
  const float now = sum.s0, before = sum.s1 + gone, apart = sum.s2 + gone;
  const float ratio = now / max(before, FLT_MIN);
  const bool less = count >= HBIL_CHANGE_VOXELS &&
                    ratio < 1.0f - HBIL_CHANGE_LEAST &&
                    before - now > HBIL_CHANGE_AGREEMENT * apart;
  ratios[own] = less ? max(ratio, 1.0f / HBIL_CACHE_MOST_CHANGE) : 1.0f;
}

kernel void follow_change(const hbil_cache_args cache,
                          global const uint *states, global const float *ratios,
                          global float *voxels) {
  uint word;
  if (!word_of_item(cache, &word))
    return;
  for (uint left = surfaces_of_word(states[word]); left; left &= left - 1u) {
    const uint number = first_surface(word, left);
    global float *voxel = voxels + HBIL_VOXEL_FLOATS * (size_t)number;
    const bool is_seen = voxel[HBIL_VOXEL_BEFORE] != 0.0f;
    const float ratio = ratios[region_of(cache, number)];
    const seen_change s = change_of_voxel(voxel);
    if (is_seen)
      voxel[HBIL_VOXEL_BEFORE] = 0.0f;
    if (!(ratio < 1.0f))
      continue;
    const float4 light = vload4(0, voxel + HBIL_VOXEL_SENT);
    if (!is_seen) /* a guess, which the next view replaces by half */
      vstore4((float4)(ratio * light.xyz, clamp(light.w, -1.0f, 1.0f)), 0,
              voxel + HBIL_VOXEL_SENT);
    else if (s.is_known && s.now < s.before && s.share < 1.0f)
      /* as if its mean before had fallen */
      vstore3(light.xyz * (mix(ratio * s.before, s.now, s.share) /
                           mix(s.before, s.now, s.share)),
              0, voxel + HBIL_VOXEL_SENT);
  }
}
