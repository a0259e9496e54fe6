/*
 * probe_rays: the light that the frame doesn't show itself, at places all over
 * the picture: rays from a pixel's surface through the radiance cache.
 *
 * Rays whose first surface this frame shows are left out, because the near
 * field has their light.  Of the others a probe has three order-1 functions of
 * the direction (doc/method.md, section 13): the share with known light, that
 * light, and the share with unknown light.
 *
 * Launch: x = columns of probes, y = rows.
 * In: split planes, the cache.  Out: HBIL_PROBE_FLOATS floats a probe.
 */
#include "lib/cache_rays.clh"
#include "lib/probe_place.clh"
#include "lib/shown_rays.clh"

/* Sums over vectors of rays: an order-1 function. */
typedef struct rays_sum {
  realv even, x, y, z;
} rays_sum;

INLINE void add_rays(rays_sum *sum, realv value, points d) {
  sum->even += value;
  sum->x = fma(value, d.x, sum->x);
  sum->y = fma(value, d.y, sum->y);
  sum->z = fma(value, d.z, sum->z);
}

/* The mean over `count` rays. */
INLINE float4 mean_of_rays(const rays_sum *sum, int count) {
  return (float4)(lanes_sum(sum->even), lanes_sum(sum->x), lanes_sum(sum->y),
                  lanes_sum(sum->z)) *
         (1.0f / (float)count);
}

INLINE void trace(const hbil_probes_args args, global const float *split,
                  const cache_map *map, global const uint *radiance,
                  const probe_place *probe, rays_sum sum[FUNCTIONS]) {
  const uintv turn = mixed((uintv)probe->number);
  const points n = all_at(probe->n);
  for (int i = 0; i < args.rays; i += HBIL_WIDTH) {
    const intv is = i + EACH_LANE < args.rays;
    realv u, v;
    ray_places(i + EACH_LANE, args.rays, turn, &u, &v);
    const points d = about_normal(n, u, v);
    const probe_finds found =
        finds_of_rays(args, split, map, radiance, probe, d, is);
    add_rays(&sum[KNOWN], found.known, d);
    add_rays(&sum[UNKNOWN], found.unknown, d);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      add_rays(&sum[RED + c], found.light[c], d);
  }
}

kernel void probe_rays(const hbil_probes_args args, global const float *split,
                       global const uchar *ways, global const float *voxels,
                       global const uint *radiance, global float *probes) {
  const cache_map map = {args.cache, ways, voxels};
  probe_place probe;
  rays_sum sum[FUNCTIONS];
  float4 mean[FUNCTIONS];
  if (!place_of_item(args, split, &probe))
    return;
  for (int i = 0; i < FUNCTIONS; ++i)
    sum[i].even = sum[i].x = sum[i].y = sum[i].z = 0.0f;
  if (probe.is)
    trace(args, split, &map, radiance, &probe, sum);
  for (int i = 0; i < FUNCTIONS; ++i)
    mean[i] = mean_of_rays(&sum[i], max(args.rays, 1));
  store_probe(args, &probe, mean, probes);
}
