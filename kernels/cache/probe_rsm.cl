/*
 * probe_rsm: light at the probes from reflective shadow maps (Dachsbacher and
 * Stamminger 2005): surfaces that a light shines on send it on, without regard
 * to what is in the way.
 *
 * A texel with radiance B and area A at the distance r lights a probe from
 * direction d with B A max(-m.d, 0) / r^2, m being its normal.  Texels are
 * chosen at random in a disc about the probe's place in the light's view, at
 * R xi from it, which makes their density 1 / (2 pi R^2 xi); R reaches the
 * farthest corner, so that the mean is the sum over all texels.
 *
 * Launch: x = columns of probes, y = lines.
 * In: split planes, the lights' views.  Out: HBIL_PROBE_FLOATS floats a probe,
 * as from probe_rays; all directions count as known.
 */
#include "lib/cache_rays.clh"
#include "lib/light_view.clh"
#include "lib/probe_place.clh"

/* Adds what a texel sends, `weight` times, to the sums over directions. */
INLINE void add_texel(const hbil_light_view_args light,
                      global const uint *texels, float2 p, float weight,
                      float3 at, float3 n, float4 sum[3]) {
  const int x = (int)floor(p.x), y = (int)floor(p.y);
  if (x < 0 || y < 0 || x >= light.view.width || y >= light.view.height)
    return;
  const uint4 texel = vload4((size_t)(y * light.view.width + x), texels);
  const float z = as_float(texel.x);
  if (!(z > 0.0f))
    return;
  float area;
  const float3 m = normal_of_word(texel.y);
  const float3 to = texel_place(light, x, y, z, m, &area) - at;
  /* no nearer than the texel's own width */
  const float squared = max(dot(to, to), area);
  const float3 d = to * (1.0f / sqrt(squared));
  const float facing = -dot(m, d);
  if (!(dot(n, d) > 0.0f) || !(facing > 0.0f))
    return;
  const float3 sent =
      light_of_word(texel.w) * (weight * area * facing / squared);
  sum[0] += sent.x * (float4)(1.0f, d);
  sum[1] += sent.y * (float4)(1.0f, d);
  sum[2] += sent.z * (float4)(1.0f, d);
}

INLINE void add_light(const hbil_light_view_args light,
                      global const uint *texels, float3 at, float3 n, uint turn,
                      float4 sum[3]) {
  const float2 p = place_in_light(light, at);
  const float2 size = {(float)light.view.width, (float)light.view.height};
  const float reach = length(max(p, size - p)); /* the farthest corner */
  for (int i = 0; i < HBIL_RSM_SAMPLES; ++i) {
    float xi, v;
    ray_places(i, HBIL_RSM_SAMPLES, turn, &xi, &v);
    const float r = reach * xi;
    const float2 to = {cospi(2.0f * v), sinpi(2.0f * v)};
    add_texel(light, texels, p + r * to,
              6.28318531f * reach * r / (float)HBIL_RSM_SAMPLES, at, n, sum);
  }
}

kernel void probe_rsm(const hbil_probes_args args, global const float *split,
                      global const uint *texels, global float *probes,
                      const hbil_light_views_args lights) {
  probe_place probe;
  float4 mean[FUNCTIONS], sum[3] = {0.0f, 0.0f, 0.0f};
  if (!place_of_item(args, split, &probe))
    return;
  for (int i = 0; i < FUNCTIONS; ++i)
    mean[i] = 0.0f;
  if (probe.exists) {
    for (int i = 0; i < lights.count; ++i)
      add_light(lights.light[i],
                texels + HBIL_TEXEL_WORDS * HBIL_LIGHT_MOST_TEXELS * i,
                probe.cache_position, probe.cache_normal,
                mixed(probe.number + mixed((uint)i)), sum);
    mean[KNOWN] = (float4)(1.0f, 0.5f * probe.cache_normal);
    for (int c = 0; c < 3; ++c) /* over the hemisphere's 2 pi */
      mean[RED + c] = 0.159154943f * sum[c];
  }
  store_probe(args, &probe, mean, 0.0f, probes);
}
