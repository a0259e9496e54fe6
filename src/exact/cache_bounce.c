/*
 * Light that surfaces of the radiance cache send each other.
 *
 * A round sends rays from each voxel, spread by the cosine, in the same
 * directions in every round, and takes their mean.  Rays into what no view has
 * seen get a share of the mean radiance of what the other rays meet, and a
 * little of that of all surfaces, as far as direct light doesn't tell that they
 * end in the sky.
 */
#include "exact/cache.h"
#include "exact/sky_light.h"

/* The largest reflectance that bounces count with. */
#define MOST_REFLECTANCE 0.95

void exact_cache_update_radiance(exact_voxel *voxel) {
  const double *v = voxel->value;
  for (int c = 0; c < 3; ++c) {
    const double reflectance =
        fmin(v[HBIL_VOXEL_REFLECTANCE + c], MOST_REFLECTANCE);
    voxel->radiance[c] = v[HBIL_VOXEL_SENT + c];
    /* finished radiance has all bounces */
    if (v[HBIL_VOXEL_LIGHT_WEIGHT] >= 0.0)
      voxel->radiance[c] += reflectance * v[HBIL_VOXEL_INDIRECT + c];
  }
}

exact_cache_mean exact_cache_mean_of(const exact_cache *cache) {
  exact_cache_mean mean = {{0.0, 0.0, 0.0}, 0.0};
  double surfaces = 0.0, telling = 0.0;
  for (size_t i = 0; i < exact_cache_count(cache); ++i) {
    const exact_place place = exact_cache_place(cache, i);
    const exact_voxel *voxel = exact_cache_at(cache, &place);
    if (place.level < cache->levels - 1 || voxel->state != HBIL_VOXEL_SURFACE)
      continue;
    ++surfaces;
    for (int c = 0; c < 3; ++c)
      mean.radiance[c] += voxel->radiance[c];
    if (voxel->unlit >= 0.0) {
      mean.unlit += voxel->unlit;
      ++telling;
    }
  }
  for (int c = 0; c < 3; ++c)
    mean.radiance[c] /= fmax(1.0, surfaces);
  mean.unlit = telling > 0.0 ? mean.unlit / telling : 1.0;
  return mean;
}

/* Direct light of a voxel over that of a whole hemisphere of the sky that it
 * contains, the largest quotient of the channels. */
static double sky_light_of(const exact_voxel *voxel,
                           const hbil_cache_update *update) {
  double light = 0.0;
  for (int c = 0; c < 3 && update->far_field == HBIL_FAR_FRAME; ++c) {
    const double full = voxel->value[HBIL_VOXEL_REFLECTANCE + c] *
                        (double)update->environment[0][c];
    if (full > 0.0)
      light = fmax(light, voxel->value[HBIL_VOXEL_SENT + c] / full);
  }
  return light;
}

/* What a voxel's rays have brought; shares of the rays. */
typedef struct gathered {
  double surfaces[3], sky[3], open, unknown;
} gathered;

static gathered gather(const exact_cache *cache, const exact_place *place,
                       const hbil_cache_update *update, int rays,
                       uint32_t turn) {
  const exact_voxel *voxel = exact_cache_at(cache, place);
  const double *v = voxel->value;
  const double size = ldexp(1.0, place->level);
  const vec3 n =
      vec_normalize(vec(v[HBIL_VOXEL_NORMAL], v[HBIL_VOXEL_NORMAL + 1],
                        v[HBIL_VOXEL_NORMAL + 2]));
  const vec3 origin =
      vec_add(exact_cache_centre(place),
              v[HBIL_VOXEL_OFFSET] + (double)HBIL_CACHE_LIFT * size, n);
  gathered g = {.open = 0.0};
  for (int i = 0; i < rays; ++i) {
    double a, b;
    exact_ray_place(i, rays, turn, &a, &b);
    const vec3 d = exact_about_normal(n, sqrt(1.0 - a), b);
    const exact_ray_end end =
        exact_cache_follow(cache, origin, d, (double)HBIL_CACHE_START * size);
    g.open += (end.kind != EXACT_RAY_HIT) / (double)rays;
    g.unknown += (end.kind == EXACT_RAY_UNKNOWN) / (double)rays;
    for (int c = 0; c < 3 && end.kind == EXACT_RAY_HIT; ++c)
      g.surfaces[c] += exact_cache_at(cache, &end.place)->radiance[c] / rays;
    for (int c = 0; c < 3 && end.kind == EXACT_RAY_SKY; ++c)
      g.sky[c] +=
          exact_environment(update->far_field, update->environment, c, d) /
          rays;
  }
  return g;
}

static void bounce(const exact_cache *before, const exact_place *place,
                   const hbil_cache_update *update, double unseen_light,
                   int rays, uint32_t turn, const exact_cache_mean *mean,
                   exact_voxel *after) {
  const exact_voxel *voxel = exact_cache_at(before, place);
  const gathered g = gather(before, place, update, rays, turn);
  double lit;
  const double own =
      exact_unlit_part(sky_light_of(voxel, update), g.open, &lit);
  const double unlit = fmin(g.unknown, (own + lit * mean->unlit) * g.open);
  double *v = after->value;
  /* where another light shines, it does not tell */
  after->unlit = g.open > 0.0 && lit == 0.0 ? own : -1.0;
  const double share = (double)HBIL_CACHE_MEAN_SHARE;
  for (int c = 0; c < 3; ++c)
    v[HBIL_VOXEL_INDIRECT + c] =
        g.surfaces[c] + g.sky[c] +
        unlit * unseen_light * (g.surfaces[c] + share * mean->radiance[c]) /
            (1.0 - g.open + share);
}

/* Whether an update does a voxel. */
static bool is_listed(const exact_cache *cache, size_t number,
                      const hbil_cache_update *update, uint32_t phase) {
  const exact_place place = exact_cache_place(cache, number);
  return exact_cache_at(cache, &place)->state == HBIL_VOXEL_SURFACE &&
         number % update->phases == phase;
}

/* Rays of a surface: fewer where the hits wouldn't fit. */
static int rays_of(const exact_cache *cache, const hbil_cache_update *update,
                   uint32_t phase) {
  const size_t count = exact_cache_count(cache);
  size_t listed = 0;
  int rays = HBIL_CACHE_RAYS;
  for (size_t i = 0; i < count; ++i)
    listed += is_listed(cache, i, update, phase);
  while (listed * (size_t)rays > HBIL_CACHE_RAY_HITS * count)
    rays /= 2;
  return rays;
}

void exact_cache_bounce(const exact_cache *before,
                        const hbil_cache_update *update, double unseen_light,
                        uint32_t phase, const exact_cache_mean *mean,
                        exact_cache *after) {
  const int rays = rays_of(before, update, phase);
  for (size_t i = 0; i < exact_cache_count(before); ++i) {
    const exact_place place = exact_cache_place(before, i);
    const exact_voxel *voxel = exact_cache_at(before, &place);
    if (is_listed(before, i, update, phase) &&
        voxel->value[HBIL_VOXEL_LIGHT_WEIGHT] >= 0.0)
      bounce(before, &place, update, unseen_light, rays,
             exact_mixed((uint32_t)i), mean, exact_cache_at(after, &place));
  }
}
