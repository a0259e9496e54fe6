/*
 * Cones through the radiance cache, and the pyramid that they read.
 *
 * A cube is seen along an axis as its eight parts are: four columns of two, of
 * which the part in front hides the one behind as far as it is opaque.  Columns
 * that no view has seen don't count.  A surface is seen from its front alone,
 * and from aside as much as it is turned there.
 */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "exact/cache_methods.h"
#include "exact/input.h"

/* --- the pyramid --- */

int exact_pyramid_across(const exact_pyramid *pyramid, int step) {
  const int beyond = step - (pyramid->levels - 1);
  return (pyramid->voxels / 2) >> (beyond > 0 ? beyond : 0);
}

int exact_pyramid_steps(const exact_pyramid *pyramid) {
  int steps = 0;
  while (exact_pyramid_across(pyramid, steps))
    ++steps;
  return steps;
}

/* Cubes of all steps before this one. */
static size_t cubes_before(const exact_pyramid *pyramid, int step) {
  size_t sum = 0;
  for (int m = 0; m < step; ++m) {
    const size_t n = (size_t)exact_pyramid_across(pyramid, m);
    sum += n * n * n;
  }
  return sum;
}

exact_status exact_pyramid_create(exact_pyramid *pyramid,
                                  const exact_cache *cache) {
  pyramid->voxels = cache->voxels;
  pyramid->levels = cache->levels;
  pyramid->mip = calloc(cubes_before(pyramid, exact_pyramid_steps(pyramid)),
                        sizeof *pyramid->mip);
  return pyramid->mip ? EXACT_SUCCESS : EXACT_OUT_OF_MEMORY;
}

void exact_pyramid_free(exact_pyramid *pyramid) {
  free(pyramid->mip);
  pyramid->mip = NULL;
}

exact_mip *exact_pyramid_at(const exact_pyramid *pyramid, int step, int x,
                            int y, int z) {
  const size_t n = (size_t)exact_pyramid_across(pyramid, step);
  return pyramid->mip + cubes_before(pyramid, step) +
         ((size_t)z * n + (size_t)y) * n + (size_t)x;
}

/* Parts by bits: 1 is x, 2 is y, 4 is z. */
static exact_mip mip_of_parts(const exact_mip part[8]) {
  exact_mip mip;
  memset(&mip, 0, sizeof mip);
  for (int k = 0; k < 8; ++k) {
    mip.unseen += part[k].unseen / 8.0;
    mip.sky += part[k].sky / 8.0;
  }
  for (int way = 0; way < 6; ++way) {
    const int bit = 1 << (way / 2);
    int columns = 0; /* of which something has been seen */
    for (int k = 0; k < 8; ++k) {
      /* the first one of a column, on the way */
      if (((k & bit) != 0) != (way % 2 == 1))
        continue;
      const double *front = part[k].along[way];
      const double *back = part[k ^ bit].along[way];
      for (int c = 0; c < 4; ++c)
        mip.along[way][c] += front[c] + (1.0 - front[3]) * back[c];
      columns += part[k].unseen < 1.0 || part[k ^ bit].unseen < 1.0;
    }
    for (int c = 0; c < 4 && columns > 0; ++c)
      mip.along[way][c] /= columns;
  }
  return mip;
}

static exact_mip mip_of_voxel(const exact_cache *cache,
                              const exact_place *place) {
  const exact_voxel *voxel = exact_cache_at(cache, place);
  exact_place found = *place;
  exact_mip mip;
  memset(&mip, 0, sizeof mip);
  const int state = exact_cache_state_for_rays(cache, &found);
  mip.unseen = state == HBIL_VOXEL_UNKNOWN;
  mip.sky = state == HBIL_VOXEL_SKY;
  const double *n = voxel->value + HBIL_VOXEL_NORMAL;
  const double most = fmax(fabs(n[0]), fmax(fabs(n[1]), fabs(n[2])));
  for (int i = 0; i < 6 && voxel->state == HBIL_VOXEL_SURFACE; ++i) {
    const double towards = (i % 2 ? n[i / 2] : -n[i / 2]) / most;
    if (!(towards > 0.0))
      continue;
    for (int c = 0; c < 3; ++c)
      mip.along[i][c] = towards * voxel->radiance[c];
    mip.along[i][3] = towards;
  }
  return mip;
}

exact_mip exact_mip_of_voxels(const exact_cache *cache, int level,
                              const int low[3]) {
  exact_mip part[8];
  for (int k = 0; k < 8; ++k) {
    const exact_place place = {
        level, {low[0] + (k & 1), low[1] + ((k >> 1) & 1), low[2] + (k >> 2)}};
    part[k] = mip_of_voxel(cache, &place);
  }
  return mip_of_parts(part);
}

/* The cube of the step before that is voxel `cell` of a level; NULL: it is
 * outside of that. */
static const exact_mip *finer_mip(const exact_pyramid *pyramid, int step,
                                  const int cell[3]) {
  const int n = exact_pyramid_across(pyramid, step - 1);
  const int at[3] = {cell[0] + n / 2, cell[1] + n / 2, cell[2] + n / 2};
  for (int i = 0; i < 3; ++i)
    if (at[i] < 0 || at[i] >= n)
      return NULL;
  return exact_pyramid_at(pyramid, step - 1, at[0], at[1], at[2]);
}

void exact_pyramid_build(const exact_cache *cache, exact_pyramid *pyramid,
                         int step) {
  const int n = exact_pyramid_across(pyramid, step);
  for (int i = 0; i < n * n * n; ++i) {
    const int at[3] = {i % n, i / n % n, i / n / n};
    exact_mip part[8];
    for (int k = 0; k < 8; ++k) {
      exact_place place = {step, {0, 0, 0}};
      for (int axis = 0; axis < 3; ++axis)
        place.cell[axis] = 2 * at[axis] - n + (k >> axis & 1);
      const exact_mip *finer =
          step > 0 ? finer_mip(pyramid, step, place.cell) : NULL;
      part[k] = finer ? *finer : mip_of_voxel(cache, &place);
    }
    *exact_pyramid_at(pyramid, step, at[0], at[1], at[2]) = mip_of_parts(part);
  }
}

/* --- samples --- */

/* A place, as a cone sees it: the mean radiance of its surfaces, and the share
 * of the cone that they stop on a way as long as its size. */
typedef struct sample {
  double light[3], opacity, unseen, sky;
  double size; /* in voxels of level 0 */
} sample;

static sample sample_voxel(const exact_cache *cache, int level, vec3 p,
                           vec3 d) {
  sample s = {.size = ldexp(1.0, level)};
  exact_place place = {level,
                       {(int)floor(p.x / s.size), (int)floor(p.y / s.size),
                        (int)floor(p.z / s.size)}};
  const int state = exact_cache_state_for_rays(cache, &place);
  s.unseen = state == HBIL_VOXEL_UNKNOWN;
  s.sky = state == HBIL_VOXEL_SKY;
  if (state != HBIL_VOXEL_SURFACE)
    return s;
  const exact_voxel *voxel = exact_cache_at(cache, &place);
  const double *n = voxel->value + HBIL_VOXEL_NORMAL;
  if (vec_dot(vec(n[0], n[1], n[2]), d) < 0.0) {
    memcpy(s.light, voxel->radiance, sizeof voxel->radiance);
    s.opacity = INFINITY; /* however short the way */
  }
  return s;
}

/* Between the middles of those of eight cubes of which something was seen. */
static sample sample_pyramid(const exact_pyramid *pyramid, int step, vec3 p,
                             vec3 d) {
  const int n = exact_pyramid_across(pyramid, step);
  sample s = {.size = ldexp(2.0, step)};
  const double from[3] = {p.x, p.y, p.z}, way[3] = {d.x, d.y, d.z};
  double f[3], seen = 0.0;
  int low[3];
  for (int i = 0; i < 3; ++i) {
    const double at = clamp(from[i] / s.size + 0.5 * n - 0.5, 0.0, n - 1.0);
    low[i] = (int)floor(at);
    f[i] = at - low[i];
  }
  for (int k = 0; k < 8; ++k) {
    double weight = 1.0;
    int at[3];
    for (int i = 0; i < 3; ++i) {
      const int up = k >> i & 1;
      weight *= up ? f[i] : 1.0 - f[i];
      at[i] = low[i] + up < n ? low[i] + up : n - 1;
    }
    const exact_mip *mip = exact_pyramid_at(pyramid, step, at[0], at[1], at[2]);
    /* on a way of length 1 a cone advances by |d| along each axis */
    for (int i = 0; i < 3; ++i) {
      const double *face = mip->along[2 * i + (way[i] < 0.0)];
      for (int c = 0; c < 3; ++c)
        s.light[c] += weight * fabs(way[i]) * face[c];
      s.opacity += weight * fabs(way[i]) * face[3];
    }
    s.unseen += weight * mip->unseen;
    s.sky += weight * mip->sky;
    seen += mip->unseen < 1.0 ? weight : 0.0;
  }
  for (int c = 0; c < 3 && s.opacity > 0.0; ++c)
    s.light[c] /= s.opacity;
  s.opacity /= fmax(seen, (double)HBIL_CONE_LEAST_SEEN);
  return s;
}

/* finest: the finest level there. */
static sample sample_at(const exact_cache *cache, const exact_pyramid *pyramid,
                        vec3 p, vec3 d, double width, int finest) {
  if (width < ldexp(2.0, finest))
    return sample_voxel(cache, finest, p, d);
  /* the coarsest step that cones read has two cubes across */
  const int last = exact_pyramid_steps(pyramid) - 2;
  int step = finest;
  while (step < last && ldexp(4.0, step) <= width)
    ++step;
  return sample_pyramid(pyramid, step, p, d);
}

/* --- cones --- */

static void follow_cone(const exact_frame *frame, const exact_cache *cache,
                        const exact_pyramid *pyramid, const exact_planes *split,
                        vec3 origin, vec3 d, double spread, double start,
                        exact_probe *probe) {
  const double half = cache->voxels / 2;
  const double radius = (double)frame->config->model.radius / cache->voxel_size;
  const double share = 1.0 / HBIL_CONES;
  double through = 1.0, clear = 1.0, sky = 0.0, t = start;
  while (through > 0.01) {
    const vec3 p = vec_add(origin, t, d);
    const double away = fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z)));
    int finest = 0;
    while (finest < cache->levels && !(away < ldexp(half, finest)))
      ++finest;
    if (finest == cache->levels)
      break;
    const sample s = sample_at(cache, pyramid, p, d,
                               (double)HBIL_CONE_DETAIL * spread * t, finest);
    const double step = 0.5 * fmax(spread * t, s.size);
    const double stopped = through * fmin(s.opacity * step / s.size, 1.0);
    if (stopped > 0.0 &&
        !(t < radius && exact_frame_shows(frame, cache, split, p, d,
                                          (double)HBIL_CACHE_SHOWN * s.size))) {
      exact_probe_add(frame, probe->known, share * stopped, d);
      for (int c = 0; c < 3; ++c)
        exact_probe_add(frame, probe->light[c], share * stopped * s.light[c],
                        d);
    }
    through -= stopped;
    if (s.unseen > 0.5)
      clear = 0.0;
    sky = s.sky / fmax(1.0 - s.unseen, fmax(s.sky, (double)FLT_MIN));
    t += step;
  }
  const double open = through * clear * sky;
  exact_probe_add(frame, probe->known, share * open, d);
  exact_probe_add(frame, probe->unknown, share * (through - open), d);
  for (int c = 0; c < 3; ++c)
    exact_probe_add(frame, probe->light[c],
                    share * open *
                        exact_environment(frame->config->model.far_field,
                                          frame->environment, c, d) /
                        exact_exposure(frame),
                    d);
}

void exact_probe_cones(const exact_frame *frame, const exact_cache *cache,
                       const exact_pyramid *pyramid, const exact_planes *split,
                       exact_probes *probes) {
  /* the solid angle of a cone is 2 pi (1 - cosine) */
  const double cosine = 1.0 - 1.0 / HBIL_CONES;
  const double spread = 2.0 * tan(acos(cosine));
  exact_place_probes(frame, split, probes);
  for (int k = 0; k < probes->count; ++k) {
    exact_probe *p = probes->probe + k;
    if (!p->valid)
      continue;
    const exact_stand s = exact_probe_stand(frame, cache, p);
    for (int i = 0; i < HBIL_CONES; ++i) {
      double u, v;
      exact_ray_place(i, HBIL_CONES, exact_mixed((uint32_t)k), &u, &v);
      follow_cone(frame, cache, pyramid, split,
                  vec_add(s.at, (double)HBIL_CACHE_LIFT * s.size, s.n),
                  exact_about_normal(s.n, u, v), spread,
                  (double)HBIL_CONE_START * s.size, p);
    }
  }
}
