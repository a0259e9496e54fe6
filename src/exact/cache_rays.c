/*
 * Rays through the voxels of the radiance cache.
 *
 * A ray goes from voxel to voxel of the finest level that there is.  Where that
 * has not been seen, the next coarser level is asked.  A surface is hit if the
 * ray crosses its plane from the front, not too near, and within
 * HBIL_CACHE_SLACK of the voxel's middle; otherwise the ray goes on.
 */
#include "exact/cache.h"
#include "exact/passes.h"

int exact_cache_state_for_rays(const exact_cache *cache, exact_place *place) {
  int state = exact_cache_at(cache, place)->state;
  while (state == HBIL_VOXEL_UNKNOWN && place->level + 1 < cache->levels) {
    ++place->level;
    for (int i = 0; i < 3; ++i)
      place->cell[i] = (int)floor(0.5 * place->cell[i]);
    state = exact_cache_at(cache, place)->state;
  }
  return state;
}

bool exact_cache_find(const exact_cache *cache, vec3 at, exact_place *place) {
  for (place->level = 0; place->level < cache->levels; ++place->level) {
    const double size = ldexp(1.0, place->level);
    place->cell[0] = (int)floor(at.x / size);
    place->cell[1] = (int)floor(at.y / size);
    place->cell[2] = (int)floor(at.z / size);
    if (exact_cache_has(cache, place))
      return true;
  }
  return false;
}

double exact_cache_leave(const exact_place *place, vec3 origin,
                         vec3 direction) {
  const double size = ldexp(1.0, place->level);
  const double from[3] = {origin.x, origin.y, origin.z};
  const double d[3] = {direction.x, direction.y, direction.z};
  double t = HUGE_VAL;
  for (int i = 0; i < 3; ++i) {
    const double border = (place->cell[i] + (d[i] > 0.0)) * size;
    if (d[i] != 0.0)
      t = fmin(t, (border - from[i]) / d[i]);
  }
  return t;
}

bool exact_cache_hits(const double *v, const exact_place *place, vec3 origin,
                      vec3 direction, double *distance) {
  const double size = ldexp(1.0, place->level);
  const vec3 n =
      vec_normalize(vec(v[HBIL_VOXEL_NORMAL], v[HBIL_VOXEL_NORMAL + 1],
                        v[HBIL_VOXEL_NORMAL + 2]));
  const vec3 centre = exact_cache_centre(place);
  const double towards = vec_dot(n, direction);
  *distance =
      (v[HBIL_VOXEL_OFFSET] + vec_dot(n, vec_add(centre, -1.0, origin))) /
      towards;
  const vec3 off = vec_add(vec_add(origin, *distance, direction), -1.0, centre);
  const double most = fmax(fabs(off.x), fmax(fabs(off.y), fabs(off.z)));
  return towards < 0.0 && *distance > (double)HBIL_CACHE_NEAREST * size &&
         most <= (double)HBIL_CACHE_SLACK * size;
}

exact_ray_end exact_cache_follow(const exact_cache *cache, vec3 origin,
                                 vec3 direction, double start) {
  exact_ray_end end = {.kind = EXACT_RAY_UNKNOWN};
  exact_place place;
  bool unseen = false;
  int last = HBIL_VOXEL_UNKNOWN;
  double t = start;
  while (exact_cache_find(cache, vec_add(origin, t, direction), &place)) {
    exact_place seen = place;
    last = exact_cache_state_for_rays(cache, &seen);
    if (last == HBIL_VOXEL_SURFACE &&
        exact_cache_hits(exact_cache_at(cache, &seen)->value, &seen, origin,
                         direction, &end.distance)) {
      end.kind = EXACT_RAY_HIT;
      end.place = seen;
      return end;
    }
    if (last == HBIL_VOXEL_UNKNOWN && !unseen)
      end.lost = t;
    unseen = unseen || last == HBIL_VOXEL_UNKNOWN;
    /* behind the border, whatever the rounding */
    t = fmax(t, exact_cache_leave(&place, origin, direction)) + 1e-9;
  }
  if (last == HBIL_VOXEL_SKY && !unseen)
    end.kind = EXACT_RAY_SKY;
  return end;
}

/* --- directions --- */

uint32_t exact_mixed(uint32_t number) {
  /* PCG; Jarzynski and Olano 2020 */
  const uint32_t state = number * 747796405u + 2891336453u;
  const uint32_t word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
  return word >> 22 ^ word;
}

void exact_ray_place(int i, int count, uint32_t turn, double *u, double *v) {
  const double low = (turn & 0xffffu) / 65536.0, high = (turn >> 16) / 65536.0;
  const double golden = i * (0.5 * (sqrt(5.0) - 1.0)) + low;
  *u = (i + high) / count;
  *v = golden - floor(golden);
}

vec3 exact_about_normal(vec3 n, double z, double v) {
  /* an orthonormal basis (Duff and others 2017) */
  const double sign = n.z < (double)HBIL_BASIS_TURNS ? -1.0 : 1.0;
  const double a = -1.0 / (sign + n.z), b = n.x * n.y * a;
  const vec3 s = vec(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
  const vec3 t = vec(b, sign + n.y * n.y * a, -n.y);
  const double r = sqrt(fmax(0.0, 1.0 - z * z));
  return vec_add(vec_add(vec_scale(z, n), r * cos(2.0 * PI * v), s),
                 r * sin(2.0 * PI * v), t);
}

/* --- light --- */

double exact_environment(hbil_far_field far_field,
                         const float environment[9][3], int channel,
                         vec3 direction) {
  const double d[3] = {direction.x, direction.y, direction.z};
  double basis[9], sum = 0.0;
  if (far_field == HBIL_FAR_CONSTANT)
    return (double)environment[0][channel];
  if (far_field != HBIL_FAR_SH)
    return 0.0;
  exact_sh_basis(d, basis);
  for (int i = 0; i < 9; ++i)
    sum += basis[i] * (double)environment[i][channel];
  return fmax(0.0, sum);
}
