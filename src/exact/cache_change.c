/*
 * Light that no view sees any more follows the light that views see, region by
 * region of the cache's extent.
 */
#include "exact/cache.h"

/* Of a region: the light of what is seen, now and before, how much it has
 * changed by without signs, and the number of voxels; gone, gone_voxels: the
 * light before, and the number, of those that have next to none now, which are
 * in none of the others. */
typedef struct change_sums {
  double now, before, apart, voxels, gone, gone_voxels;
} change_sums;

/* The region of a place in cache space, or the nearest one. */
static int region_at(const exact_cache *cache, const double at[3]) {
  const double end = cache->voxels / 2;
  int region = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const double cell = floor(ldexp(at[axis], 1 - cache->levels));
    region = region * HBIL_CACHE_REGIONS_ACROSS +
             (int)(fmin(fmax(cell, -end), end - 1.0) + end) *
                 HBIL_CACHE_REGIONS_ACROSS / cache->voxels;
  }
  return region;
}

static int region_of(const exact_cache *cache, const exact_place *place) {
  double corner[3];
  for (int axis = 0; axis < 3; ++axis)
    corner[axis] = ldexp((double)place->cell[axis], place->level);
  return region_at(cache, corner);
}

double exact_cache_fallen(const exact_cache *cache,
                          const float ratios[HBIL_CACHE_REGIONS], vec3 at) {
  return (double)ratios[region_at(cache, (double[3]){at.x, at.y, at.z})];
}

/* How bright a voxel was before the views since the last update, how bright
 * they show it, and their share of its mean. */
typedef struct seen_change {
  double before, now, share;
} seen_change;

static bool change_of(const double *v, seen_change *s) {
  const double views = fabs(v[HBIL_VOXEL_LIGHT_WEIGHT]);
  if (!(v[HBIL_VOXEL_BEFORE] > 0.0 && views >= 1.0))
    return false;
  const unsigned newest = exact_voxel_before(v[HBIL_VOXEL_BEFORE], &s->before);
  const double sent =
      v[HBIL_VOXEL_SENT] + v[HBIL_VOXEL_SENT + 1] + v[HBIL_VOXEL_SENT + 2];
  s->share = fmin(newest, views) / views;
  s->now = fmax(s->before + (sent - s->before) / s->share, 0.0);
  return true;
}

static void add_voxel(const exact_voxel *voxel, change_sums *sums) {
  const double most = (double)HBIL_CACHE_MOST_CHANGE;
  seen_change s;
  if (!change_of(voxel->value, &s))
    return;
  if (s.now * most < s.before) {
    sums->gone += s.before;
    ++sums->gone_voxels;
    return;
  }
  const double before = fmax(s.before, s.now / most);
  sums->now += s.now;
  sums->before += before;
  sums->apart += fabs(s.now - before);
  ++sums->voxels;
}

static double ratio_of(const change_sums *sums, int own) {
  const int n = HBIL_CACHE_REGIONS_ACROSS;
  change_sums all = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  for (int r = 0; r < HBIL_CACHE_REGIONS; ++r) {
    const int dx = own % n - r % n, dy = own / n % n - r / n % n;
    const int dz = own / (n * n) - r / (n * n);
    const double weight = 1.0 / (1 + dx * dx + dy * dy + dz * dz);
    all.now += weight * sums[r].now;
    all.before += weight * sums[r].before;
    all.apart += weight * sums[r].apart;
    all.voxels += weight * sums[r].voxels;
    all.gone += weight * sums[r].gone;
    all.gone_voxels += weight * sums[r].gone_voxels;
  }
  if (all.gone > all.before) {
    all.before += all.gone;
    all.apart += all.gone;
    all.voxels += all.gone_voxels;
  }
  const bool less =
      all.voxels >= (double)HBIL_CHANGE_VOXELS &&
      all.now < (1.0 - (double)HBIL_CHANGE_LEAST) * all.before &&
      all.before - all.now > (double)HBIL_CHANGE_AGREEMENT * all.apart;
  return less ? fmax(all.now / all.before, 1.0 / (double)HBIL_CACHE_MOST_CHANGE)
              : 1.0;
}

void exact_cache_follow_change(exact_cache *cache) {
  change_sums sums[HBIL_CACHE_REGIONS] = {{0.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
  for (size_t i = 0; i < exact_cache_count(cache); ++i) {
    const exact_place place = exact_cache_place(cache, i);
    const exact_voxel *voxel = exact_cache_at(cache, &place);
    if (place.level == cache->levels - 1 && voxel->state == HBIL_VOXEL_SURFACE)
      add_voxel(voxel, sums + region_of(cache, &place));
  }
  for (size_t i = 0; i < exact_cache_count(cache); ++i) {
    const exact_place place = exact_cache_place(cache, i);
    exact_voxel *voxel = exact_cache_at(cache, &place);
    double *v = voxel->value;
    if (voxel->state != HBIL_VOXEL_SURFACE)
      continue;
    seen_change s;
    const bool is_seen = v[HBIL_VOXEL_BEFORE] != 0.0;
    const bool is_known = change_of(v, &s);
    const double ratio = ratio_of(sums, region_of(cache, &place));
    v[HBIL_VOXEL_BEFORE] = 0.0;
    if (ratio == 1.0)
      continue;
    double left = ratio;
    if (!is_seen)
      v[HBIL_VOXEL_LIGHT_WEIGHT] =
          fmax(-1.0, fmin(1.0, v[HBIL_VOXEL_LIGHT_WEIGHT]));
    else if (is_known && s.now < s.before && s.share < 1.0)
      /* as if the mean before had fallen */
      left = (ratio * s.before + (s.now - ratio * s.before) * s.share) /
             (s.before + (s.now - s.before) * s.share);
    else
      continue;
    for (int c = 0; c < 3; ++c)
      v[HBIL_VOXEL_SENT + c] *= left;
  }
}

/* Whether a voxel has more than a face in common with the box. */
static bool is_in_box(const exact_place *place, vec3 low, vec3 high) {
  const double from[3] = {low.x, low.y, low.z};
  const double to[3] = {high.x, high.y, high.z};
  bool inside = true;
  for (int i = 0; i < 3; ++i)
    inside &= ldexp(place->cell[i], place->level) < to[i] &&
              ldexp(place->cell[i] + 1, place->level) > from[i];
  return inside;
}

void exact_cache_forget(exact_cache *cache, const hbil_cache_change *change) {
  const vec3 low = exact_cache_from_world(
      cache, vec(change->low[0], change->low[1], change->low[2]));
  const vec3 high = exact_cache_from_world(
      cache, vec(change->high[0], change->high[1], change->high[2]));
  for (size_t i = 0; i < exact_cache_count(cache); ++i) {
    const exact_place place = exact_cache_place(cache, i);
    exact_voxel *voxel = exact_cache_at(cache, &place);
    double *v = voxel->value;
    if (!is_in_box(&place, low, high))
      continue;
    if (change->surfaces >= 1.0f)
      voxel->state = HBIL_VOXEL_UNKNOWN;
    if (voxel->state != HBIL_VOXEL_SURFACE)
      continue;
    v[HBIL_VOXEL_WEIGHT] *= 1.0 - (double)change->surfaces;
    const double weight = v[HBIL_VOXEL_LIGHT_WEIGHT];
    if (change->light > 0.0f && v[HBIL_VOXEL_BEFORE] > 0.0)
      v[HBIL_VOXEL_BEFORE] = -1.0;
    for (int k = HBIL_VOXEL_SENT; k < HBIL_VOXEL_BEFORE; ++k)
      v[k] *= 1.0 - (double)change->light;
    if (weight != 0.0) /* whose sign must remain */
      v[HBIL_VOXEL_LIGHT_WEIGHT] =
          copysign(fmax(fabs(v[HBIL_VOXEL_LIGHT_WEIGHT]),
                        (double)HBIL_LEAST_LIGHT_WEIGHT),
                   weight);
  }
}
