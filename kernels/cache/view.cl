/*
 * view: the caller's planes of a view become a table of texels, which inject
 * reads in any order: every `stride`th pixel of every `stride`th row.
 *
 * Launch: x = texels of a row, y = rows.
 * In: the caller's planes.  Out: HBIL_TEXEL_WORDS words a texel.
 */
#include "lib/cache_args.h"
#include "lib/cache_voxels.clh"
#include "lib/depth.clh"
#include "lib/flags.clh"
#include "lib/surface_inputs.clh"
#include "lib/surface_normal.clh"

FLAG(GATHER_EMISSION)

/* Diffuse reflectance, and the radiance of the first bounce or, in finished
 * views, of all. */
INLINE void surface_light(const hbil_cache_view_args args,
                          const surface_inputs *in, int x, int y,
                          float reflectance[3], float sent[3]) {
  int usable = TRUE_LANES;
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    const float albedo = surface_albedo(args.surface, in, c, x, y, 1, &usable);
    reflectance[c] =
        albedo * surface_diffuse(args.surface, in, c, x, y, 1, &usable);
    const float light =
        direct_light(args.surface, in->direct, c, x, y, 1, &usable);
    sent[c] = args.finished
                  ? light
                  : INV_PI * reflectance[c] * irradiance_of(light, albedo);
    if (GATHER_EMISSION && !args.finished)
      sent[c] += surface_emission(args.surface, in, c, x, y, 1, &usable);
    sent[c] *= args.per_exposure;
  }
}

INLINE uint pack_reflectance(const float reflectance[3]) {
  uint word = 0u;
#pragma unroll
  for (uint c = 0; c < 3; ++c)
    word |= (uint)rint(1023.0f * reflectance[c]) << (10u * c);
  return word;
}

kernel void read_view(const hbil_cache_view_args args, global uint *texels,
                      global const void *depth, global const void *normal,
                      global const void *albedo, global const void *f0,
                      global const void *direct, global const void *emission) {
  const int column = (int)get_global_id(0), row = (int)get_global_id(1);
  if (column >= args.width || row >= args.height)
    return;
  const int x = column * args.stride, y = row * args.stride;
  const float rx = ray_x(args.view, x, 1), ry = ray_y(args.view, y);
  const float z =
      planar_depth(stored_depth(depth, args.depth, args.decode, x, y, 1), rx,
                   ry, args.decode);
  uint4 texel = 0u;
  if (z > 0.0f) {
    const surface_inputs planes = {albedo, f0, direct, emission};
    float n[3], reflectance[3], sent[3];
    view_normal(normal, args.normal, args.normals, x, y, 1, n);
    /* surfaces whose normal can't be used face the eye, as in split */
    if (!is_usable_normal(squared_length(n))) {
      n[0] = -rx;
      n[1] = -ry;
      n[2] = -1.0f;
    }
    const float3 m = rotated(args.to_world, (float3)(n[0], n[1], n[2]));
    surface_light(args, &planes, x, y, reflectance, sent);
    texel = (uint4)(as_uint(z * args.scale), pack_normal(m.x, m.y, m.z),
                    pack_reflectance(reflectance),
                    word_of_light((float3)(sent[0], sent[1], sent[2])));
  }
  vstore4(texel,
          (size_t)args.first + (size_t)row * (size_t)args.width +
              (size_t)column,
          texels);
}
