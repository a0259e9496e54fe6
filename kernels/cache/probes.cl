/*
 * probes: the light that the frame doesn't show itself, at places all over the
 * picture: rays from a pixel's surface through the radiance cache.
 *
 * Rays whose first surface this frame shows are left out, because the near
 * field has their light.  Of the others a probe has three order-1 functions of
 * the direction (doc/method.md, section 13): the share with known light, that
 * light, and the share with unknown light.
 *
 * filter_probes: each probe's functions become means with those around it, on
 * surfaces alike, so that a probe has the rays of up to nine.
 *
 * Launch: x = columns of probes, y = rows.
 * In: split planes, the cache; filter_probes: probes.  Out: HBIL_PROBE_FLOATS
 * floats a probe.
 */
#include "lib/cache_rays.clh"
#include "lib/camera.clh"
#include "lib/layers.clh"
#include "lib/split_planes.clh"

/* What a pixel shows: its w and the normal in view space. */
typedef struct pixel {
  float w;
  float3 n;
} pixel;

INLINE pixel read_pixel(const hbil_layer_args in, global const float *split,
                        int x, int y) {
  pixel p;
  global const float *at =
      split + layer_address(in, x & 3, y & 3, x >> 2, y >> 2);
  p.w = *at;
#if PACKED
  p.n = normal_of_word(as_uint(at[HBIL_PACKED_NORMAL * in.plane]));
#else
  p.n = (float3)(at[HBIL_SPLIT_NORMAL * in.plane],
                 at[(HBIL_SPLIT_NORMAL + 1) * in.plane],
                 at[(HBIL_SPLIT_NORMAL + 2) * in.plane]);
#endif
  return p;
}

/* The pixel of a probe: the one at its place or, where that shows no surface,
 * one of its neighbours. */
INLINE bool find_surface(const hbil_probes_args args, global const float *split,
                         int *x, int *y, pixel *p) {
  const int away = args.grid.spacing / 3;
  const int x0 = *x, y0 = *y;
  for (int i = 0; i < 9; ++i) {
    const int k = (i + 4) % 9; /* the middle first */
    *x = clamp(x0 + (k % 3 - 1) * away, 0, args.view.width - 1);
    *y = clamp(y0 + (k / 3 - 1) * away, 0, args.view.height - 1);
    *p = read_pixel(args.split, split, *x, *y);
    if (p->w > SKY)
      return true;
  }
  return false;
}

INLINE float3 point_at(const hbil_view_args view, int x, int y, float w) {
  const float z = ORTHOGRAPHIC ? -w : 1.0f / w;
  const float spread = ORTHOGRAPHIC ? 1.0f : z;
  return (float3)(((float)x + 0.5f - view.cx) * view.inv_fx * spread,
                  plane_y(view, y) * spread, z);
}

/* Whether the frame shows the place that a ray of direction d, in view space,
 * ends at: q, in view space. */
INLINE bool is_shown(const hbil_probes_args args, global const float *split,
                     float3 q, float3 d, float tolerance) {
  const hbil_view_args view = args.view;
  if (!ORTHOGRAPHIC && !(q.z > 0.0f))
    return false;
  const float shrink = ORTHOGRAPHIC ? 1.0f : 1.0f / q.z;
  const float px = fma(view.fx, q.x * shrink, view.cx);
  const float py = fma(view.fy, q.y * shrink, view.cy);
  if (!(px >= 0.0f && py >= 0.0f && px < (float)view.width &&
        py < (float)view.height))
    return false;
  const pixel p = read_pixel(args.split, split, (int)px, (int)py);
  return p.w > SKY &&
         fabs((ORTHOGRAPHIC ? -p.w : 1.0f / p.w) - q.z) <= tolerance &&
         dot(p.n, d) < 0.0f;
}

/* The rays among `near` whose ends the frame shows. */
INLINE intv shown_rays(const hbil_probes_args args, global const float *split,
                       const ray_ends *ends, float3 origin, points d,
                       intv near) {
  float x[HBIL_WIDTH], y[HBIL_WIDTH], z[HBIL_WIDTH], t[HBIL_WIDTH];
  float size[HBIL_WIDTH], is[HBIL_WIDTH];
  if (!ANY(near))
    return 0;
  STOREV(d.x, x);
  STOREV(d.y, y);
  STOREV(d.z, z);
  STOREV(ends->distance, t);
  STOREV(ends->size, size);
  STOREV(select((realv)0.0f, (realv)1.0f, near), is);
  for (int i = 0; i < HBIL_WIDTH; ++i) {
    const float3 way = (float3)(x[i], y[i], z[i]);
    if (is[i] != 0.0f &&
        !is_shown(args, split, transformed(args.to_view, origin + way * t[i]),
                  rotated(args.to_view, way),
                  HBIL_CACHE_SHOWN * size[i] / args.scale))
      is[i] = 0.0f;
  }
  return LOADV(is) != 0.0f;
}

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

/* Stores a function's values: the mean, and three times the mean with the
 * direction, in view space. */
INLINE void store_sum(const rays_sum *sum, const hbil_probes_args args,
                      global float *to) {
  const float share = 1.0f / (float)max(args.rays, 1);
  const float3 d =
      rotated(args.to_view, (float3)(lanes_sum(sum->x), lanes_sum(sum->y),
                                     lanes_sum(sum->z)));
  vstore4((float4)(lanes_sum(sum->even), 3.0f * args.scale * d) * share, 0, to);
}

/* The five functions of a probe. */
enum { KNOWN, UNKNOWN, RED, SUMS = RED + 3 };

INLINE void trace(const hbil_probes_args args, global const float *split,
                  const cache_map *map, global const uint *radiance,
                  float3 place, float3 normal, uint turn, rays_sum sum[SUMS]) {
  const float3 n = rotated(args.to_cache, normal) * (1.0f / args.scale);
  const float3 at = transformed(args.to_cache, place), away = fabs(at);
  /* the finest level that has the place decides where rays begin */
  float size = 1.0f;
  for (int l = 1; l < args.cache.levels; ++l)
    if (!(max(away.x, max(away.y, away.z)) <
          (float)(args.cache.voxels / 2) * size))
      size += size;
  const float3 origin = at + n * (HBIL_CACHE_LIFT * size);
  for (int i = 0; i < args.rays; i += HBIL_WIDTH) {
    const intv is = i + EACH_LANE < args.rays;
    realv u, v, light[3];
    ray_places(i, args.rays, turn, &u, &v);
    const points d = about_normal(n, u, v);
    const ray_ends ends =
        follow_rays(map, origin, d, (realv)(HBIL_CACHE_START * size), is);
    const intv near = ends.hit & (ends.distance < args.radius);
    const intv known = (ends.hit | ends.sky) &
                       !shown_rays(args, split, &ends, origin, d, near);
    light_of_rays(&ends, radiance, args.environment, d, light);
    add_rays(&sum[KNOWN], select((realv)0.0f, (realv)1.0f, known), d);
    add_rays(&sum[UNKNOWN],
             select((realv)0.0f, (realv)1.0f, is & !ends.hit & !ends.sky), d);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      add_rays(&sum[RED + c], select((realv)0.0f, light[c], known), d);
  }
}

kernel void make_probes(const hbil_probes_args args, global const float *split,
                        global const uint *states, global const uint *ways,
                        global const uint *bricks, global const float *voxels,
                        global const uint *radiance, global float *probes) {
  const cache_map map = {args.cache, states, ways, bricks, voxels};
  const int column = (int)get_global_id(0), row = (int)get_global_id(1);
  if (column >= args.grid.columns || row >= args.grid.rows)
    return;
  const uint number = (uint)row * (uint)args.grid.columns + (uint)column;
  global float *probe = probes + HBIL_PROBE_FLOATS * number;
  int x = min(column * args.grid.spacing, args.view.width - 1);
  int y = min(row * args.grid.spacing, args.view.height - 1);
  pixel p;
  float3 place = 0.0f;
  rays_sum sum[SUMS];
  for (int i = 0; i < SUMS; ++i)
    sum[i].even = sum[i].x = sum[i].y = sum[i].z = 0.0f;
  const bool is = find_surface(args, split, &x, &y, &p);
  if (is) {
    place = point_at(args.view, x, y, p.w);
    trace(args, split, &map, radiance, place, p.n, mixed(number), sum);
  }
  vstore4((float4)(place, is ? 1.0f : 0.0f), 0, probe);
  vstore4((float4)(is ? p.n : (float3)(0.0f), 0.0f), 1, probe);
  store_sum(&sum[KNOWN], args, probe + HBIL_PROBE_KNOWN);
  store_sum(&sum[UNKNOWN], args, probe + HBIL_PROBE_UNKNOWN);
  for (int c = 0; c < 3; ++c)
    store_sum(&sum[RED + c], args, probe + HBIL_PROBE_LIGHT + 4 * c);
}

/* How much a probe is like another: its place is near the other's plane, and it
 * faces the same way. */
INLINE float likeness(const hbil_view_args view, global const float *probe,
                      global const float *other) {
  const float3 p = vload3(0, probe + HBIL_PROBE_POSITION);
  const float3 n = vload3(0, probe + HBIL_PROBE_NORMAL);
  const float3 m = vload3(0, other + HBIL_PROBE_NORMAL);
  const float unit =
      ORTHOGRAPHIC ? (float)view.width * view.inv_fx : max(p.z, FLT_MIN);
  const float off = dot(vload3(0, other + HBIL_PROBE_POSITION) - p, n) /
                    (HBIL_PROBE_TOLERANCE * unit);
  const float near = 1.0f / fma(off, off, 1.0f);
  float facing = max(dot(n, m), 0.0f);
  facing *= facing;
  facing *= facing;
  return other[HBIL_PROBE_VALID] * facing * facing * near * near;
}

kernel void filter_probes(const hbil_probes_args args,
                          global const float *probes, global float *filtered) {
  const hbil_probe_grid_args grid = args.grid;
  const int column = (int)get_global_id(0), row = (int)get_global_id(1);
  if (column >= grid.columns || row >= grid.rows)
    return;
  const int number = row * grid.columns + column;
  global const float *probe = probes + HBIL_PROBE_FLOATS * number;
  global float *to = filtered + HBIL_PROBE_FLOATS * number;
  const float4 place = vload4(0, probe), normal = vload4(1, probe);
  float4 sum[5] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  float total = 0.0f;
  for (int j = max(row - 1, 0); j <= min(row + 1, grid.rows - 1); ++j)
    for (int i = max(column - 1, 0); i <= min(column + 1, grid.columns - 1);
         ++i) {
      global const float *other =
          probes + HBIL_PROBE_FLOATS * (j * grid.columns + i);
      const float weight =
          i == column && j == row ? place.w : likeness(args.view, probe, other);
      total += weight;
      for (int k = 0; k < 5; ++k)
        sum[k] += weight * vload4(2 + k, other);
    }
  const float share = total > 0.0f ? 1.0f / total : 0.0f;
  vstore4(place, 0, to);
  vstore4(normal, 1, to);
  for (int k = 0; k < 5; ++k)
    vstore4(share * sum[k], 2 + k, to);
}
