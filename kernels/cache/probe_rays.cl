/*
 * probe_rays: the light that the frame doesn't show itself, at places all over
 * the picture: rays from a pixel's surface through the radiance cache.
 *
 * Rays whose first surface this frame shows are left out, because the near
 * field has their light.  Of the others a probe has three order-1 functions of
 * the direction (doc/method.md, section 13): the share with known light, that
 * light, and the share with unknown light; and means of what areas of the cache
 * tell of the latter; 0 unless the far field is HBIL_FAR_FRAME.
 *
 * Launch: x = columns of probes, y = lines.
 * In: split planes, the cache.  Out: HBIL_PROBE_FLOATS floats a probe.
 */
#include "lib/cache_rays.clh"
#include "lib/local_light.clh"
#include "lib/probe_likeness.clh"
#include "lib/probe_place.clh"
#include "lib/shown_rays.clh"

/* 1: areas tell what is unknown, which FAR 3 alone needs (lib/far_light.clh) */
FLAG(AREAS)

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

/* Rays of a probe: twice or four times as many where few of the eight corner
 * probes around it stand on the same surface, so that the filter has little to
 * average over.  For a probe inside a cell, these eight and the one that they
 * surround, at the cell's first corner. */
INLINE int rays_of_probe(const hbil_probes_args args, global const float *split,
                         const probe_place *probe) {
  const int line = (int)get_global_id(1);
  int alike = 0;
  for (int i = 0; i < 9; ++i) {
    const int column = (int)get_global_id(0) + i % 3 - 1;
    const int row = line / 2 + i / 3 - 1;
    const bool itself = i == 4 && !is_inside_cell(line);
    if (itself || !has_probe(args.grid, column, 2 * row))
      continue;
    int x, y;
    pixel_of_corner(args, column, row, &x, &y);
    const pixel p = read_pixel(args.split, split, x, y);
    alike += p.w > SKY && likeness(args.view, probe->position, probe->normal,
                                   point_at(args.view, x, y, p.w), p.n) > 0.5f;
  }
  return HBIL_PROBE_RAYS * (alike < 3 ? 4 : alike < 5 ? 2 : 1);
}

/* Nine neighbouring probes share a sequence of directions: this one has every
 * ninth of them. */
INLINE points ray_directions(intv i, int rays, const probe_place *probe) {
  const int tile = HBIL_PROBE_TILE;
  const int first =
      (int)get_global_id(0) % tile + (int)get_global_id(1) / 2 % tile * tile;
  realv u, v;
  /* from the middles of strata: none is level */
  ray_places(i * (tile * tile) + first, rays * (tile * tile),
             (uintv)0x80000000u, &u, &v);
  return about_normal(all_at(probe->cache_normal), u, v);
}

/* Adds what areas tell of rays whose light is unknown. */
INLINE void add_guesses(const hbil_cache_args cache, global const float *areas,
                        const probe_place *probe, const probe_finds *found,
                        points d, float4 *guess) {
  float x[HBIL_WIDTH], y[HBIL_WIDTH], z[HBIL_WIDTH], lost[HBIL_WIDTH];
  const realv away =
      select((realv)0.0f, found->lost, found->unknown > (realv)0.0f);
  if (!AREAS || !ANY(away > 0.0f))
    return;
  STOREV(d.x, x);
  STOREV(d.y, y);
  STOREV(d.z, z);
  STOREV(away, lost);
  for (int i = 0; i < HBIL_WIDTH; ++i) {
    const float3 direction = (float3)(x[i], y[i], z[i]);
    if (lost[i] > 0.0f)
      *guess += local_light(cache, areas,
                            ray_origin(probe) + direction * lost[i], direction);
  }
}

/* How much areas tell of a probe: of its rays, how many are unknown, and how
 * many go to the sky. */
INLINE float weight_of_areas(float rays, float unknown, float sky) {
  const float hole = 2.0f - unknown * (2.0f / HBIL_AREA_HOLE) / rays;
  const float under =
      1.0f - sky * (1.0f / HBIL_AREA_SKY) / max(rays - unknown, 1.0f);
  return clamp(hole, 0.0f, 1.0f) * max(under, 0.0f);
}

/* Returns how many rays there were.  guess: means over these. */
INLINE int trace(const hbil_probes_args args, global const float *split,
                 const cache_map *map, global const uint *radiance,
                 global const float *areas, const probe_place *probe,
                 rays_sum sum[FUNCTIONS], float4 *guess) {
  const int rays = rays_of_probe(args, split, probe);
  realv sky = 0.0f;
  for (int i = 0; i < rays; i += HBIL_WIDTH) {
    const points d = ray_directions(i + EACH_LANE, rays, probe);
    const probe_finds found = finds_of_rays(args, split, map, radiance, probe,
                                            d, i + EACH_LANE < rays);
    add_rays(&sum[KNOWN], found.known, d);
    add_rays(&sum[UNKNOWN], found.unknown, d);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      add_rays(&sum[RED + c], found.light[c], d);
    sky += found.sky;
    add_guesses(map->cache, areas, probe, &found, d, guess);
  }
  *guess *= weight_of_areas((float)rays, lanes_sum(sum[UNKNOWN].even),
                            lanes_sum(sky)) /
            (float)rays;
  return rays;
}

kernel void probe_rays(const hbil_probes_args args, global const float *split,
                       global const uchar *clearance,
                       global const float *voxels, global const uint *radiance,
                       global const float *areas, global float *probes) {
  const cache_map map = {args.cache, clearance, voxels};
  probe_place probe;
  rays_sum sum[FUNCTIONS];
  float4 mean[FUNCTIONS], guess = 0.0f;
  if (!place_of_item(args, split, &probe))
    return;
  for (int i = 0; i < FUNCTIONS; ++i)
    sum[i].even = sum[i].x = sum[i].y = sum[i].z = 0.0f;
  int rays = 1;
  if (probe.exists)
    rays = trace(args, split, &map, radiance, areas, &probe, sum, &guess);
  for (int i = 0; i < FUNCTIONS; ++i)
    mean[i] = mean_of_rays(&sum[i], rays);
  store_probe(args, &probe, mean, guess, probes);
}
