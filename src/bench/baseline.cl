/*
 * baseline: the formulas of the paper as they stand there, in one kernel.  Each
 * work-item takes one pixel of the whole image: view-space positions from
 * depth, horizons as cosines, angles by acos, integrals by sin and cos, and no
 * interleaving.
 *
 * Only the sign of the back angle is corrected (doc/method.md).  As in the
 * paper, slices have equal weights, and nothing makes up for what lies between
 * the samples, which are spaced equally as far as the library's reach.
 *
 * Builds: SLICES, SAMPLES (per side), PARALLEL (1: orthographic rays; else 0).
 * Launch: x, y = pixels, rounded up to whole groups.
 * In: planar depth (0: sky), unit view-space normals, radiance.
 * Out: E_near in xyz and AO in w.
 */

#define PI 3.14159265f

typedef struct baseline_args {
  int width, height;
  float fx, fy, cx, cy;
  float facing_fade[2];
} baseline_args;

static float3 position(const baseline_args args, int x, int y, float z) {
  const float2 at = (float2)(((float)x + 0.5f - args.cx) / args.fx,
                             ((float)y + 0.5f - args.cy) / args.fy);
  return PARALLEL ? (float3)(at, z) : (float3)(at, 1.0f) * z;
}

/* Cosine-weighted share of a half-slice from the view direction to theta. */
static float open_share(float theta, float nx, float ny) {
  return 0.5f * (nx * (theta - sin(theta) * cos(theta)) +
                 ny * sin(theta) * sin(theta));
}

/* How far samples go along a screen direction: as a slope of view rays, or in
 * world units where rays are parallel. */
static float reach_along(const baseline_args args, float2 u) {
  const float to_x = (float)args.width / args.fx;
  const float to_y = (float)args.height / args.fy;
  const float edge =
      min(to_x / max(fabs(u.x), 1e-6f), to_y / max(fabs(u.y), 1e-6f));
  return min(max(to_x, to_y), edge);
}

/* One of 16 values in [0,1), a different one for each pixel of a 4x4 block. */
static float dither(int x, int y) {
  const int v = x ^ y;
  return ((float)((v & 1) << 3 | (y & 1) << 2 | (v & 2) | (y & 2) >> 1) +
          0.5f) /
         16.0f;
}

kernel void baseline(const baseline_args args, global const float *depth,
                     global const float4 *normals,
                     global const float4 *radiances, global float4 *result) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  if (x >= args.width || y >= args.height)
    return;
  const int here = y * args.width + x;
  if (depth[here] <= 0.0f) {
    result[here] = (float4)(0.0f, 0.0f, 0.0f, 1.0f);
    return;
  }
  const float3 point = position(args, x, y, depth[here]);
  const float3 wo = PARALLEL ? (float3)(0.0f, 0.0f, -1.0f) : -normalize(point);
  const float3 n = normals[here].xyz;
  const float turn = dither(x, y), shift = dither(3 - y, x);
  const float ny = max(dot(n, wo), 1e-4f);
  float3 light = 0.0f;
  float open = 0.0f;
  for (int slice = 0; slice < SLICES; ++slice) {
    const float phi = ((float)slice + turn) * PI / SLICES;
    for (int side = -1; side <= 1; side += 2) {
      const float2 u = (float2)(cos(phi), sin(phi)) * (float)side;
      const float3 ray = (float3)(u, 0.0f);
      const float3 d = normalize(ray - dot(ray, wo) * wo);
      const float nx = dot(n, d), reach = reach_along(args, u);
      const float tangent = -nx / ny;
      float horizon = tangent / sqrt(1.0f + tangent * tangent);
      float share = open_share(acos(horizon), nx, ny);
      float3 last = radiances[here].xyz;
      for (int k = 0; k < SAMPLES; ++k) {
        const float distance = reach * ((float)k + shift) / SAMPLES;
        const int sx = x + (int)rint(u.x * distance * args.fx);
        const int sy = y + (int)rint(u.y * distance * args.fy);
        if (sx < 0 || sy < 0 || sx >= args.width || sy >= args.height)
          break;
        const int there = sy * args.width + sx;
        if (there == here || depth[there] <= 0.0f)
          continue;
        const float3 wi =
            normalize(position(args, sx, sy, depth[there]) - point);
        const float cosine = dot(wi, wo);
        if (cosine <= horizon)
          continue;
        const float accept = smoothstep(args.facing_fade[0],
                                        args.facing_fade[1],
                                        -dot(normals[there].xyz, wi));
        last = mix(last, radiances[there].xyz, accept);
        const float closed = open_share(acos(min(cosine, 1.0f)), nx, ny);
        light += last * (share - closed);
        share = closed;
        horizon = cosine;
      }
      open += share;
    }
  }
  result[here] = (float4)(light * PI / SLICES, open / SLICES);
}
