/*
 * Glossy light: what the gather has found of a pixel's lobe, and for the rest
 * of the lobe what the radiance cache knows, then the far field.
 *
 * A probe casts rays that are distributed by its own lobe.  The share u of the
 * lobe lies within 1 - cos = 2 u / (1 + 2 k (1 - u)) of its axis.  Rays below
 * the surface count for nothing, and neither do those whose end the frame
 * shows. A pixel takes the probes at the corners of its cell, by their place,
 * and by its own lobe at their axes.
 */
#include "exact/glossy.h"

#include <string.h>

#include "exact/camera.h"
#include "exact/estimate.h"
#include "exact/far_field.h"
#include "exact/input.h"
#include "exact/lobe.h"
#include "exact/passes.h"
#include "exact/planes.h"
#include "exact/cache_methods.h"
#include "exact/sky_light.h"
#include "exact/surface.h"

/* --- probes --- */

static vec3 to_eye(const exact_frame *frame, vec3 place) {
  return exact_is_orthographic(frame->config)
             ? vec(0.0, 0.0, -1.0)
             : vec_scale(-1.0, vec_normalize(place));
}

static void cast(const exact_frame *frame, const exact_cache *cache,
                 const exact_planes *split, const exact_probe *p, uint32_t turn,
                 exact_glossy_probe *out) {
  const exact_stand s = exact_probe_stand(frame, cache, p);
  const vec3 origin = vec_add(s.at, (double)HBIL_CACHE_LIFT * s.size, s.n);
  const double radius = (double)frame->config->model.radius / cache->voxel_size;
  const double cosine = vec_dot(p->normal, to_eye(frame, p->place));
  const double k = exact_lobe(frame->config, cosine);
  const vec3 axis = exact_to_world(&frame->camera, out->axis);
  const double share = 1.0 / HBIL_GLOSSY_RAYS;
  for (int i = 0; i < HBIL_GLOSSY_RAYS; ++i) {
    double u, v;
    exact_ray_place(i, HBIL_GLOSSY_RAYS, turn, &u, &v);
    const vec3 d = exact_about_normal(
        axis, 1.0 - 2.0 * u / (1.0 + 2.0 * k * (1.0 - u)), v);
    if (!(vec_dot(d, s.n) > 0.0))
      continue;
    const exact_ray_end end =
        exact_cache_follow(cache, origin, d, (double)HBIL_CACHE_START * s.size);
    if (end.kind == EXACT_RAY_UNKNOWN)
      out->unknown += share;
    if (end.kind == EXACT_RAY_UNKNOWN ||
        (end.kind == EXACT_RAY_HIT && end.distance < radius &&
         exact_frame_shows(frame, cache, split,
                           vec_add(origin, end.distance, d), d,
                           ldexp((double)HBIL_CACHE_SHOWN, end.place.level))))
      continue;
    out->known += share;
    for (int c = 0; c < 3; ++c)
      out->light[c] +=
          share * (end.kind == EXACT_RAY_HIT
                       ? exact_cache_at(cache, &end.place)->radiance[c]
                       : exact_environment(frame->config->model.far_field,
                                           frame->environment, c, d) /
                             exact_exposure(frame));
  }
}

void exact_make_glossy_probes(const exact_frame *frame,
                              const exact_cache *cache,
                              const exact_planes *split,
                              const exact_probes *probes,
                              exact_glossy_probe *glossy) {
  for (int i = 0; i < probes->count; ++i) {
    const exact_probe *p = probes->probe + i;
    memset(glossy + i, 0, sizeof *glossy);
    if (!p->valid)
      continue;
    glossy[i].axis = exact_reflected(p->normal, to_eye(frame, p->place));
    cast(frame, cache, split, p, exact_mixed((uint32_t)i), glossy + i);
  }
}

/* --- pixels --- */

/* A pixel's mirror. */
typedef struct mirror {
  surface s;
  vec3 axis;
  double k;
} mirror;

static double lobe_value(double k, double cosine) {
  return 1.0 / pow(1.0 + k * (1.0 - cosine), 2.0);
}

/* What the cache knows of a lobe: light and share of what the frame doesn't
 * show. */
static exact_probe_light light_of_probes(const exact_frame *frame,
                                         const exact_glossy_probe *glossy,
                                         const mirror *m, int x, int y) {
  const exact_probes *probes = frame->probes;
  exact_probe_light light = {.share = 0.0};
  double total = 0.0, known = 0.0, unknown = 0.0, sent[3] = {0.0, 0.0, 0.0};
  for (int i = 0; glossy && i < probes->count; ++i) {
    const exact_probe *probe = probes->probe + i;
    const double weight =
        exact_probe_corner(probes, i, x, y) *
        (exact_probe_weight(frame, probe, m->s.at, m->s.normal) *
             lobe_value(m->k, vec_dot(m->axis, glossy[i].axis)) +
         1e-6);
    total += weight;
    known += weight * glossy[i].known;
    unknown += weight * glossy[i].unknown;
    for (int c = 0; c < 3; ++c)
      sent[c] += weight * glossy[i].light[c];
  }
  if (!(known + unknown > 1e-3 * total))
    return light;
  light.share = known / (known + unknown);
  for (int c = 0; c < 3; ++c)
    light.light[c] = exact_exposure(frame) * sent[c] / (known + unknown);
  return light;
}

/* Mean radiance of an environment over a lobe. */
static double environment_light(const exact_frame *frame, int channel,
                                const mirror *m) {
  const vec3 world = exact_to_world(&frame->camera, m->axis);
  const double d[3] = {world.x, world.y, world.z};
  double basis[9], bands[3], sum = 0.0;
  if (frame->config->model.far_field == HBIL_FAR_CONSTANT)
    return (double)frame->environment[0][channel];
  exact_sh_basis(d, basis);
  exact_lobe_bands(exact_lobe(frame->config, 1.0), bands);
  for (int i = 0; i < 9; ++i)
    sum += bands[i == 0  ? 0
                 : i < 4 ? 1
                         : 2] *
           basis[i] * (double)frame->environment[i][channel];
  return fmax(0.0, sum);
}

static void glossy_pixel(const exact_frame *frame, const mirror *m,
                         const exact_planes *resolved,
                         const exact_probe_light *cached, int x, int y,
                         exact_planes *out) {
  const hbil_far_field far = frame->config->model.far_field;
  const int first = EXACT_GLOSSY_PLANES;
  const double ao = fmin(*exact_at(resolved, HBIL_LIGHT_AO, x, y), 1.0);
  const double known =
      clamp(*exact_at(resolved, first + HBIL_GLOSSY_KNOWN, x, y), 0.0, 1.0);
  const double open = 1.0 - known, other = 1.0 - cached->share;
  const double guessed =
      fmin(other, exact_unlit_share(frame, x, y, ao) / fmax(ao, 1e-6));
  for (int c = 0; c < 3; ++c) {
    const double shown = *exact_at(resolved, first + HBIL_GLOSSY_RED + c, x, y);
    double light = open * cached->light[c];
    if (far == HBIL_FAR_FRAME)
      light += open * guessed *
               exact_unseen_radiance(frame, c, m->axis, shown, known, light,
                                     open * cached->share);
    else if (far != HBIL_FAR_NONE)
      light += open * other * environment_light(frame, c, m);
    *exact_at(out, EXACT_GLOSSY + c, x, y) = shown + light;
  }
}

void exact_glossy(const exact_frame *frame, const exact_planes *split,
                  const exact_planes *resolved,
                  const exact_glossy_probe *glossy, exact_planes *out) {
  for (int y = 0; y < out->height; ++y)
    for (int x = 0; x < out->width; ++x) {
      mirror m = {.s = exact_surface_at(frame, split, x, y)};
      for (int c = 0; c < 3; ++c)
        *exact_at(out, EXACT_GLOSSY + c, x, y) = 0.0;
      if (!m.s.is)
        continue;
      const vec3 wo = vec_scale(-1.0, vec_normalize(m.s.ray));
      m.axis = exact_reflected(m.s.normal, wo);
      m.k = exact_lobe(frame->config, vec_dot(m.s.normal, wo));
      const exact_probe_light cached = light_of_probes(frame, glossy, &m, x, y);
      glossy_pixel(frame, &m, resolved, &cached, x, y, out);
    }
}
