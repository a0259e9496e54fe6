/*
 * probe_cones: light that the frame doesn't show itself, by cones through the
 * radiance cache (Crassin and others 2011, "Interactive Indirect Illumination
 * Using Voxel Cone Tracing").
 *
 * A cone is sampled at distances that grow with its width, in voxels while it
 * is narrow and in lib/pyramid.clh's texels when it is wider.  A texel's
 * opacity along an axis is what stops on the way across it, so a sample stops
 * as much of that as its step is of the way.  Surfaces that this frame shows
 * within the near field's radius stop light without giving any, as the near
 * field has their light.
 *
 * Launch: x = columns of probes, y = lines.
 * In: split planes, the cache, the pyramid.  Out: HBIL_PROBE_FLOATS floats a
 * probe, as from probe_rays.
 */
#include "lib/cache_rays.clh"
#include "lib/probe_place.clh"
#include "lib/pyramid.clh"

/* A voxel's surface stops all in half a passage, the shortest step. */
#define VOXEL_OPACITY 2.0f

/* A place in the cache: the mean radiance of what a cone sees of it, the share
 * of the cone that a passage of the width of it stops, and the shares of it
 * that no view has seen, and that have the sky behind. */
typedef struct sample {
  float3 light;
  float opacity;
  float unseen, sky;
  float size; /* of the voxel or texel, in voxels of level 0 */
} sample;

/* The number of the voxel of a level at p. */
INLINE uint number_at(const cache_map *map, int level, float3 p) {
  const float3 cell = floor(p * (1.0f / (float)(1 << level)));
  return (uint)voxel_number(map->cache, level, (int)cell.x, (int)cell.y,
                            (int)cell.z);
}

/* What the finest level from `level` on tells of p; the sample has the size of
 * a voxel of `level`. */
INLINE sample sample_voxel(const cache_map *map, global const uint *radiance,
                           int level, float3 p, float3 d) {
  const uint code = map->clearance[number_at(map, level, p)];
  const uint state = CODE_STATE(code);
  sample s = {0.0f, 0.0f, state == HBIL_VOXEL_UNKNOWN ? 1.0f : 0.0f,
              state == HBIL_VOXEL_SKY ? 1.0f : 0.0f, (float)(1 << level)};
  if (state != HBIL_VOXEL_SURFACE)
    return s;
  const uint number = number_at(map, level + (int)CODE_LEVELS_ABOVE(code), p);
  if (dot(vload3(0, map->voxels + HBIL_VOXEL_FLOATS * (size_t)number), d) <
      0.0f) {
    s.light = light_of_word(radiance[number]);
    s.opacity = VOXEL_OPACITY;
  }
  return s;
}

/* A step of the pyramid at p, interpolated between those of eight texels of
 * which something has been seen. */
INLINE sample sample_pyramid(const hbil_cache_args cache,
                             global const float *pyramid, int step, float3 p,
                             float3 d) {
  const int across = texels_across(cache, step);
  sample s = {0.0f, 0.0f, 0.0f, 0.0f, (float)(2 << step)};
  const float3 at = clamp(p / s.size + 0.5f * (float)across - 0.5f, 0.0f,
                          (float)(across - 1));
  const float3 low = floor(at), f = at - low, part = fabs(d);
  const int x = (int)low.x, y = (int)low.y, z = (int)low.z;
  const int ix = d.x < 0.0f, iy = 2 + (d.y < 0.0f), iz = 4 + (d.z < 0.0f);
  float seen_weight = 0.0f;
  seen sum = 0.0f;
  for (int k = 0; k < 8; ++k) {
    const float weight = (k & 1 ? f.x : 1.0f - f.x) *
                         (k & 2 ? f.y : 1.0f - f.y) *
                         (k & 4 ? f.z : 1.0f - f.z);
    global const float *texel =
        pyramid + HBIL_MIP_FLOATS *
                      (size_t)texel_number(cache, step,
                                           min(x + (k & 1), across - 1),
                                           min(y + ((k >> 1) & 1), across - 1),
                                           min(z + (k >> 2), across - 1));
    sum += weight * (part.x * vload4(ix, texel) + part.y * vload4(iy, texel) +
                     part.z * vload4(iz, texel));
    s.unseen += weight * texel[HBIL_MIP_UNSEEN];
    s.sky += weight * texel[HBIL_MIP_SKY];
    seen_weight += texel[HBIL_MIP_UNSEEN] < 1.0f ? weight : 0.0f;
  }
  s.light = sum.xyz * (1.0f / max(sum.w, FLT_MIN));
  s.opacity = sum.w * (1.0f / max(seen_weight, HBIL_CONE_LEAST_SEEN));
  return s;
}

/* What a cone brings: the shares of it that end at known light, and at what is
 * unknown, and that light. */
typedef struct cone {
  float known, unknown;
  float3 light;
} cone;

INLINE sample sample_at(const cache_map *map, global const uint *radiance,
                        global const float *pyramid, float3 p, float3 d,
                        float width, float finest) {
  const hbil_cache_args cache = map->cache;
  int level = 0;
  while ((float)(1 << level) < finest)
    ++level;
  if (width < 2.0f * finest)
    return sample_voxel(map, radiance, level, p, d);
  int step = level;
  while (texels_across(cache, step + 1) > 1 && (float)(4 << step) <= width)
    ++step;
  return sample_pyramid(cache, pyramid, step, p, d);
}

INLINE cone follow_cone(const hbil_probes_args args, global const float *split,
                        const cache_map *map, global const uint *radiance,
                        global const float *pyramid, float3 origin, float3 d,
                        float spread, float start) {
  const float border =
      (float)(args.cache.voxels / 2) * (float)(1 << (args.cache.levels - 1));
  cone c = {0.0f, 0.0f, (float3)(0.0f)};
  float through = 1.0f, clear = 1.0f, sky = 0.0f, t = start;
  while (through > 0.01f) {
    const float3 p = origin + d * t, away = fabs(p);
    const float far_off = max(away.x, max(away.y, away.z));
    if (!(far_off < border))
      break;
    float finest = 1.0f;
    while (far_off >= (float)(args.cache.voxels / 2) * finest)
      finest += finest;
    const sample s = sample_at(map, radiance, pyramid, p, d,
                               HBIL_CONE_DETAIL * spread * t, finest);
    const float step = 0.5f * max(spread * t, s.size);
    const float stopped = through * min(s.opacity * step / s.size, 1.0f);
    if (stopped > 0.0f && !(t < args.radius &&
                            is_shown(args, split, transformed(args.to_view, p),
                                     rotated(args.to_view, d),
                                     HBIL_CACHE_SHOWN * s.size / args.scale))) {
      c.known += stopped;
      c.light += stopped * s.light;
    }
    through -= stopped;
    if (s.unseen > 0.5f)
      clear = 0.0f;
    /* of what has been seen */
    sky = s.sky / max(1.0f - s.unseen, max(s.sky, FLT_MIN));
    t += step;
  }
  const float open = through * clear * sky;
  const hbil_environment_args e = args.environment;
  const points direction = {d.x, d.y, d.z};
  c.known += open;
  c.unknown = through - open;
  c.light += open * (float3)(sky_channel(e.channel[0], direction),
                             sky_channel(e.channel[1], direction),
                             sky_channel(e.channel[2], direction));
  return c;
}

kernel void probe_cones(const hbil_probes_args args, global const float *split,
                        global const uchar *clearance,
                        global const float *voxels, global const uint *radiance,
                        global const float *pyramid, global float *probes) {
  const cache_map map = {args.cache, clearance, voxels};
  probe_place probe;
  float4 mean[FUNCTIONS];
  if (!place_of_item(args, split, &probe))
    return;
  for (int i = 0; i < FUNCTIONS; ++i)
    mean[i] = 0.0f;
  /* cones of equal solid angle, that fill the hemisphere */
  const int count = HBIL_CONES;
  const float cosine = 1.0f - 1.0f / (float)count;
  const float spread = 2.0f * sqrt(1.0f - cosine * cosine) / cosine;
  const float3 origin = probe.cache_position +
                        probe.cache_normal * (HBIL_CACHE_LIFT * probe.size);
  for (int i = 0; i < count && probe.exists; ++i) {
    float u, v;
    ray_places(i, count, mixed(probe.number), &u, &v);
    const points direction = about_normal(all_at(probe.cache_normal), u, v);
    const float3 d = (float3)(direction.x, direction.y, direction.z);
    const cone c = follow_cone(args, split, &map, radiance, pyramid, origin, d,
                               spread, HBIL_CONE_START * probe.size);
    const float4 share = (float4)(1.0f, d) * (1.0f / (float)count);
    mean[KNOWN] += c.known * share;
    mean[UNKNOWN] += c.unknown * share;
    mean[RED] += c.light.x * share;
    mean[RED + 1] += c.light.y * share;
    mean[RED + 2] += c.light.z * share;
  }
  store_probe(args, &probe, mean, 0.0f, probes);
}
