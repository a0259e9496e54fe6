/*
 * Reflective shadow maps: light that surfaces send which a light's view shows,
 * whatever is in the way.
 */
#include <string.h>

#include "exact/camera.h"
#include "exact/cache_methods.h"

/* The least cosine between a texel's normal and the light's ray that its area
 * is computed with (kernels/lib/light_view.clh). */
#define LEAST_LEAN 0.1

/* What a texel is of, in cache space. */
typedef struct texel_surface {
  vec3 at;
  double area;
} texel_surface;

/* The surface has 1 / cosine times the area of the texel's cross-section at its
 * depth, the cosine being that between the ray and the normal. */
static texel_surface surface_of(const exact_cache *cache,
                                const exact_cache_view *light, double x,
                                double y, const exact_texel *texel) {
  const hbil_camera *c = &light->camera;
  const double *m = c->world_from_view;
  const double z = texel->depth * cache->voxel_size;
  const vec3 across = vec((x * light->stride + 0.5 - c->cx) / c->fx,
                          (y * light->stride + 0.5 - c->cy) / c->fy, 0.0);
  const double spread = light->orthographic ? 1.0 : z;
  const vec3 p = vec(across.x * spread, across.y * spread, z);
  const vec3 ray =
      light->orthographic ? vec(0, 0, 1) : vec(across.x, across.y, 1);
  const vec3 world = vec_add(exact_to_world(c, p), 1.0, vec(m[3], m[7], m[11]));
  const double section =
      spread * spread * light->stride * light->stride /
      (c->fx * c->fy * cache->voxel_size * cache->voxel_size);
  const double lean = fabs(vec_dot(exact_to_world(c, ray), texel->normal));
  return (texel_surface){exact_cache_from_world(cache, world),
                         section / fmax(lean, LEAST_LEAN * vec_length(ray))};
}

static void add_texel(const exact_cache *cache, const exact_cache_view *light,
                      int x, int y, double weight, vec3 at, vec3 n,
                      double sum[3][4]) {
  if (x < 0 || y < 0 || x >= light->width || y >= light->height)
    return;
  const exact_texel *texel =
      light->texel + (size_t)y * (size_t)light->width + x;
  if (!(texel->depth > 0.0))
    return;
  const texel_surface s = surface_of(cache, light, x, y, texel);
  const vec3 to = vec_add(s.at, -1.0, at);
  /* no nearer than the texel is wide */
  const double squared = fmax(vec_dot(to, to), s.area);
  const vec3 d = vec_scale(1.0 / sqrt(squared), to);
  const double facing = -vec_dot(texel->normal, d);
  if (!(vec_dot(n, d) > 0.0) || !(facing > 0.0))
    return;
  for (int c = 0; c < 3; ++c) {
    const double v = weight * texel->sent[c] * s.area * facing / squared;
    sum[c][0] += v;
    sum[c][1] += v * d.x;
    sum[c][2] += v * d.y;
    sum[c][3] += v * d.z;
  }
}

void exact_light_sum(const exact_cache *cache, const exact_cache_view *light,
                     vec3 at, vec3 n, double sum[3][4]) {
  for (int y = 0; y < light->height; ++y)
    for (int x = 0; x < light->width; ++x)
      add_texel(cache, light, x, y, 1.0, at, n, sum);
}

/* Where a place of cache space is in the view, in texels; the middle, if it is
 * behind a light that has a place. */
static void place_in(const exact_cache *cache, const exact_cache_view *light,
                     vec3 at, double p[2]) {
  const hbil_camera *c = &light->camera;
  const double *m = c->world_from_view;
  const vec3 q = exact_to_view(c, vec_add(exact_cache_to_world(cache, at), -1.0,
                                          vec(m[3], m[7], m[11])));
  const double shrink = light->orthographic ? 1.0 : q.z > 0.0 ? 1.0 / q.z : 0.0;
  const double stride = light->stride;
  p[0] = (c->fx * q.x * shrink + c->cx - 0.5) / stride + 0.5;
  p[1] = (c->fy * q.y * shrink + c->cy - 0.5) / stride + 0.5;
  p[0] = clamp(p[0], 0.0, light->width);
  p[1] = clamp(p[1], 0.0, light->height);
}

/* Samples at the distance R xi: their density is 1 / (2 pi R R xi). */
void exact_light_samples(const exact_cache *cache,
                         const exact_cache_view *light, vec3 at, vec3 n,
                         uint32_t turn, double sum[3][4]) {
  double p[2];
  place_in(cache, light, at, p);
  const double reach =
      hypot(fmax(p[0], light->width - p[0]), fmax(p[1], light->height - p[1]));
  for (int i = 0; i < HBIL_RSM_SAMPLES; ++i) {
    double xi, v;
    exact_ray_place(i, HBIL_RSM_SAMPLES, turn, &xi, &v);
    add_texel(cache, light, (int)floor(p[0] + reach * xi * cos(2.0 * PI * v)),
              (int)floor(p[1] + reach * xi * sin(2.0 * PI * v)),
              2.0 * PI * reach * reach * xi / HBIL_RSM_SAMPLES, at, n, sum);
  }
}

void exact_probe_lights(const exact_frame *frame, const exact_cache *cache,
                        const exact_cache_view *lights, int count, bool all,
                        const exact_planes *split, exact_probes *probes) {
  exact_place_probes(frame, split, probes);
  for (int k = 0; k < probes->count; ++k) {
    exact_probe *p = probes->probe + k;
    if (!p->valid)
      continue;
    const exact_stand s = exact_probe_stand(frame, cache, p);
    double sum[3][4] = {{0.0}};
    for (int i = 0; i < count; ++i)
      if (all)
        exact_light_sum(cache, lights + i, s.at, s.n, sum);
      else
        exact_light_samples(cache, lights + i, s.at, s.n,
                            exact_mixed((uint32_t)k + exact_mixed((uint32_t)i)),
                            sum);
    p->known[0] = 1.0;
    p->known[1] = 1.5 * p->normal.x;
    p->known[2] = 1.5 * p->normal.y;
    p->known[3] = 1.5 * p->normal.z;
    for (int c = 0; c < 3; ++c) {
      /* means over 2 pi */
      exact_probe_add(frame, p->light[c], 1.0,
                      vec(sum[c][1] / (2.0 * PI), sum[c][2] / (2.0 * PI),
                          sum[c][3] / (2.0 * PI)));
      p->light[c][0] = sum[c][0] / (2.0 * PI);
    }
  }
}
