/*
 * follow_probes: the light of probes, averaged over frames.
 *
 * Probes stand on the picture.  When the camera moves they slide over the
 * surfaces, other rays leave from them, and these meet other voxels, so what
 * they bring changes by a few per cent in patches, at places where no light has
 * changed.  What lies beyond the near field changes slowly along a surface, so
 * each probe is joined with those that stood on the same surface in the last
 * frame: frame n has the weight 1/n until n is HBIL_PROBE_FRAMES, then
 * 1/HBIL_PROBE_FRAMES.
 *
 * Where the new frame differs by more than HBIL_PROBE_CHANGE, which is more
 * than chance, light or surfaces have changed, and counting starts again.
 *
 * Launch: x = columns of probes, y = lines.  In: the probes of this frame,
 * those that the last frame left.  Out: HBIL_PROBE_FLOATS floats a probe.
 */
#include "lib/cache_voxels.clh"
#include "lib/probe_grid.clh"
#include "lib/probe_likeness.clh"

/* Known and unknown; with red, green, blue; with what is guessed, which has no
 * direction. */
enum { SHARES = 2, FUNCTIONS = 5, VALUES = 6 };

/* What the last frame's probes say of a place: means, and the number of frames
 * that they stand for; 0: nothing. */
typedef struct past_probe {
  float4 f[VALUES];
  float frames;
} past_probe;

/* p, n: place and normal in the last frame's view space. */
INLINE past_probe find_past(const hbil_follow_args args,
                            global const float *probes, float3 p, float3 n) {
  const hbil_view_args view = args.before;
  const hbil_probe_grid_args grid = args.grid;
  past_probe past = {{0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f}, 0.0f};
  if (!ORTHOGRAPHIC && !(p.z > 0.0f))
    return past;
  const float shrink = ORTHOGRAPHIC ? 1.0f : 1.0f / p.z;
  const float inv = 1.0f / (float)grid.spacing;
  const float u = inv * to_subpixel(fma(view.fx, p.x * shrink, view.cx) - 0.5f);
  const float v = inv * to_subpixel(fma(view.fy, p.y * shrink, view.cy) - 0.5f);
  if (!(u > -1.0f && v > -1.0f && u < (float)grid.columns &&
        v < (float)(grid.lines / 2 + 1)))
    return past;
  float total = 0.0f;
  /* four at corners of cells, four inside cells */
  for (int i = 0; i < 8; ++i) {
    const float shift = i < 4 ? 0.0f : 0.5f;
    const float s = u - shift, t = v - shift;
    const int x = (int)floor(s) + (i & 1), y = (int)floor(t) + (i >> 1 & 1);
    const int line = 2 * y + (i < 4 ? 0 : 1);
    const float corner =
        (1.0f - fabs(s - (float)x)) * (1.0f - fabs(t - (float)y));
    if (!has_probe(grid, x, line) || !(corner > 0.0f))
      continue;
    global const float *other =
        probes + HBIL_PROBE_FLOATS * probe_number(grid, x, line);
    const float weight =
        corner * other[HBIL_PROBE_VALID] *
        likeness(view, p, n, vload3(0, other + HBIL_PROBE_POSITION),
                 vload3(0, other + HBIL_PROBE_NORMAL));
    total += weight;
    past.frames = fma(weight, other[HBIL_PROBE_FRAMES_AT], past.frames);
    for (int k = 0; k < VALUES; ++k)
      past.f[k] += weight * vload4(2 + k, other);
  }
  /* with less than this, other surfaces are nearer */
  if (!(total >= HBIL_PROBE_LEAST_LIKENESS)) {
    past.frames = 0.0f;
    return past;
  }
  past.frames /= total;
  for (int k = 0; k < VALUES; ++k)
    past.f[k] /= total;
  return past;
}

/* How much has changed: the largest difference of a share, or of all light over
 * the brighter one. */
INLINE float change(const float4 now[VALUES], const past_probe *past) {
  float light = 0.0f, before = 0.0f, most = 0.0f;
  for (int k = 0; k < SHARES; ++k)
    most = max(most, fabs(now[k].x - past->f[k].x));
  for (int k = SHARES; k < FUNCTIONS; ++k) {
    light += now[k].x;
    before += past->f[k].x;
  }
  const float brighter = max(light, before);
  return brighter > 0.0f ? max(most, fabs(light - before) / brighter) : most;
}

kernel void follow_probes(const hbil_follow_args args,
                          global const float *probes, global const float *past,
                          global float *followed) {
  const int column = (int)get_global_id(0), line = (int)get_global_id(1);
  if (!has_probe(args.grid, column, line))
    return;
  const uint number = probe_number(args.grid, column, line);
  global const float *probe = probes + HBIL_PROBE_FLOATS * number;
  global float *to = followed + HBIL_PROBE_FLOATS * number;
  const float4 place = vload4(0, probe);
  float4 normal = vload4(1, probe), f[VALUES];
  for (int k = 0; k < VALUES; ++k)
    f[k] = vload4(2 + k, probe);
  float frames = 1.0f;
  if (args.has_before && place.w > 0.0f) {
    past_probe then = find_past(args, past, transformed(args.back, place.xyz),
                                rotated(args.back, normal.xyz));
    for (int k = 0; k < FUNCTIONS; ++k)
      then.f[k].yzw = rotated(args.forth, then.f[k].yzw);
    if (then.frames > 0.0f && change(f, &then) <= HBIL_PROBE_CHANGE) {
      frames = min(then.frames + 1.0f, (float)HBIL_PROBE_FRAMES);
      for (int k = 0; k < VALUES; ++k)
        f[k] = then.f[k] + (f[k] - then.f[k]) / frames;
    }
  }
  normal.w = frames;
  vstore4(place, 0, to);
  vstore4(normal, 1, to);
  for (int k = 0; k < VALUES; ++k)
    vstore4(f[k], 2 + k, to);
}
