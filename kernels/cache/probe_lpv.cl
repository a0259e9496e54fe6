/*
 * probe_lpv: light at the probes from the light propagation volumes
 * (lib/volumes.clh).
 *
 * Cells have the intensity I(w) of all light that passes, so the radiance from
 * direction d is I(-d) / (3/2 s^2), s being a cell's width: light of radiance L
 * from everywhere sends the flux pi L s^2 through a face, and I times 2 pi / 3,
 * the solid angle of a neighbour's five faces.  The volumes don't tell what no
 * view has seen; all directions count as known.
 *
 * Launch: x = columns of probes, y = lines.
 * In: split planes, volumes.  Out: HBIL_PROBE_FLOATS floats a probe, as from
 * probe_rays.
 */
#include "lib/probe_place.clh"
#include "lib/volumes.clh"

/* Mean and slope of each colour at a place, interpolated between cells. */
INLINE void read_volumes(const hbil_cache_args cache,
                         global const float *volumes, int level, float3 at,
                         float4 value[3]) {
  const int across = cache.voxels / 2;
  const uint plane = volume_plane(cache);
  const float3 q =
      at * (0.5f / (float)(1 << level)) + 0.5f * (float)across - 0.5f;
  const float3 low = clamp(floor(q), -1.0f, (float)(across - 1));
  const float3 f = clamp(q - low, 0.0f, 1.0f);
  for (int c = 0; c < 3; ++c)
    value[c] = 0.0f;
  for (int k = 0; k < 8; ++k) {
    const float weight = (k & 1 ? f.x : 1.0f - f.x) *
                         (k & 2 ? f.y : 1.0f - f.y) *
                         (k & 4 ? f.z : 1.0f - f.z);
    global const float *cell =
        volumes +
        cell_address(cache, VOLUME_PLANES, level, (int)low.x + (k & 1),
                     (int)low.y + ((k >> 1) & 1), (int)low.z + (k >> 2));
    for (int c = 0; c < 3; ++c) {
      global const float *colour = cell + (uint)c * VOLUME_COLOUR * plane;
      value[c] += weight * (float4)(colour[0], colour[plane], colour[2 * plane],
                                    colour[3 * plane]);
    }
  }
}

kernel void probe_lpv(const hbil_probes_args args, global const float *split,
                      global const float *volumes, global float *probes) {
  probe_place probe;
  float4 mean[FUNCTIONS];
  if (!place_of_item(args, split, &probe))
    return;
  for (int i = 0; i < FUNCTIONS; ++i)
    mean[i] = 0.0f;
  if (probe.exists) {
    /* over a hemisphere the mean of d is n/2, and that of d d^T is 1/3 */
    const float3 n = probe.cache_normal;
    const int level = min((int)log2(probe.size), args.cache.levels - 1);
    const float size = 2.0f * probe.size; /* of a cell */
    float4 value[3];
    /* half a cell away from the surface, as sources are */
    read_volumes(args.cache, volumes, level,
                 probe.cache_position + 0.5f * size * n, value);
    mean[KNOWN] = (float4)(1.0f, 0.5f * n);
    for (int c = 0; c < 3; ++c) {
      const float4 light = value[c] * (1.0f / (1.5f * size * size));
      mean[RED + c] = (float4)(light.x - 0.5f * dot(light.yzw, n),
                               0.5f * light.x * n - light.yzw * (1.0f / 3.0f));
    }
  }
  store_probe(args, &probe, mean, 0.0f, probes);
}
