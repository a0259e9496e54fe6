/*
 * probe_glossy: the light that the frame doesn't show itself in the lobe of a
 * rough mirror (lib/lobe.clh), at the places of the probes: rays through the
 * radiance cache, distributed by the lobe.
 *
 * Rays whose first surface this frame shows are left out, as in probe_rays.cl.
 *
 * Launch: x = columns of probes, y = lines.
 * In: split planes, the cache.  Out: HBIL_GLOSSY_PROBE_FLOATS floats a probe.
 */
#include "lib/cache_rays.clh"
#include "lib/lobe.clh"
#include "lib/probe_place.clh"
#include "lib/shown_rays.clh"

/* A probe's lobe: the reflected direction in view space and in cache space, and
 * k. */
typedef struct probe_lobe {
  float3 axis, r;
  float k;
} probe_lobe;

INLINE probe_lobe lobe_of_probe(const hbil_probes_args args,
                                const probe_place *probe) {
  probe_lobe l;
  const float3 wo =
      ORTHOGRAPHIC ? (float3)(0.0f, 0.0f, -1.0f) : -normalize(probe->position);
  const float cosine = max(dot(probe->normal, wo), 1e-4f);
  l.axis = 2.0f * cosine * probe->normal - wo;
  l.r = rotated(args.to_cache, l.axis) * (1.0f / args.scale);
  l.k = args.lobe * min(1.0f / cosine, HBIL_LOBE_STEEPEST);
  return l;
}

INLINE void trace(const hbil_probes_args args, global const float *split,
                  const cache_map *map, global const uint *radiance,
                  const probe_place *probe, const probe_lobe *lobe,
                  probe_finds *sum) {
  const uintv turn = mixed((uintv)probe->number);
  const float3 n = probe->cache_normal;
  for (int i = 0; i < HBIL_GLOSSY_RAYS; i += HBIL_WIDTH) {
    realv u, v;
    ray_places(i + EACH_LANE, HBIL_GLOSSY_RAYS, turn, &u, &v);
    /* The share u of the lobe lies about its axis as far as this. */
    const realv cosine =
        1.0f - 2.0f * u / fma(2.0f * lobe->k, 1.0f - u, (realv)1.0f);
    const points d = about_normal(all_at(lobe->r), cosine, v);
    const intv wanted =
        (i + EACH_LANE < HBIL_GLOSSY_RAYS) &
        (fma(d.x, (realv)n.x, fma(d.y, (realv)n.y, d.z * n.z)) > 0.0f);
    const probe_finds found =
        finds_of_rays(args, split, map, radiance, probe, d, wanted);
    sum->known += found.known;
    sum->unknown += found.unknown;
#pragma unroll
    for (int c = 0; c < 3; ++c)
      sum->light[c] += found.light[c];
  }
}

kernel void probe_glossy(const hbil_probes_args args, global const float *split,
                         global const uchar *clearance,
                         global const float *voxels,
                         global const uint *radiance, global float *probes) {
  const cache_map map = {args.cache, clearance, voxels};
  probe_place probe;
  probe_lobe lobe = {0.0f, 0.0f, 0.0f};
  probe_finds sum = {0.0f, 0.0f, {0.0f, 0.0f, 0.0f}};
  if (!place_of_item(args, split, &probe))
    return;
  if (probe.exists) {
    lobe = lobe_of_probe(args, &probe);
    trace(args, split, &map, radiance, &probe, &lobe, &sum);
  }
  const float mean = 1.0f / HBIL_GLOSSY_RAYS;
  global float *to = probes + HBIL_GLOSSY_PROBE_FLOATS * probe.number;
  vstore4((float4)(probe.position, probe.exists ? 1.0f : 0.0f), 0, to);
  vstore4((float4)(probe.normal, 0.0f), 1, to);
  vstore4((float4)(lobe.axis, mean * lanes_sum(sum.known)), 2, to);
  vstore4(
      (float4)(mean * lanes_sum(sum.unknown), mean * lanes_sum(sum.light[0]),
               mean * lanes_sum(sum.light[1]), mean * lanes_sum(sum.light[2])),
      3, to);
}
