/*
 * split: G-buffer -> 4x4 interleaved layers of inverse depth, view-space unit
 * normal that faces the eye, and the radiance that the pixel sends.
 *
 * relight: the radiance alone, for static frames.
 *
 * Launch: x = groups of 4*HBIL_WIDTH pixels of a row, y = rows.
 * In: the caller's inputs, carried light (relight: history).  Out: split
 * planes; for each group, bounds and whether the outputs show its light
 * (`used_groups`); counts of sanitized pixels (relight: whether anything has
 * changed).
 */
#include "lib/bounds.clh"
#include "lib/depth.clh"
#include "lib/fallen_light.clh"
#include "lib/flags.clh"
#include "lib/interleave.clh"
#include "lib/layers.clh"
#include "lib/split_planes.clh"
#include "lib/surface_inputs.clh"
#include "lib/surface_normal.clh"

FLAG(FEEDBACK_RADIANCE)
FLAG(GATHER_EMISSION)
FLAG(PROBES)
FLAG(SKIP_UNUSED)

/* --- normals -------------------------------------------------------------- */

/* Normals that face away by this cosine or more are counted: 12 degrees, beyond
 * what smooth shading and normal maps do to surfaces that the eye sees. */
#define AWAY_COSINE 0.2f

/* Turns n towards the eye until it faces it by at least HBIL_MIN_COSINE, and
 * makes its length 1, unless pack_normal() will do that.  (rx, ry, 1) is the
 * ray.  A normal that cannot be used becomes -ray; its lane is cleared in
 * `usable`.  Returns the lanes that face away by AWAY_COSINE. */
INLINE intv face_the_eye(realv n[3], realv rx, float ry, intv *usable) {
  intv away = 0;
  const realv ray2 = fma(rx, rx, (realv)fma(ry, ry, 1.0f));
  const realv length2 = squared_length(n);
  const intv has_direction = is_usable_normal(length2);
  *usable &= has_direction;
  /* `towards` is the cosine times both lengths, which needs no root.  The roots
   * and quotients below would take a tenth of this kernel's time, and nearly
   * every normal faces the eye without them.  The limit is 1 % above
   * HBIL_MIN_COSINE, so that roundings don't matter. */
  const realv towards = -fma(n[0], rx, fma(n[1], (realv)ry, n[2]));
  const float least = 1.01f * HBIL_MIN_COSINE;
  const intv faces = has_direction & (towards > 0.0f) &
                     (towards * towards > least * least * ray2 * length2);
#if PACKED
  const realv scale = 1.0f, eye_scale = 1.0f;
#else
  const realv scale = 1.0f / sqrt(length2), eye_scale = 1.0f / sqrt(ray2);
#endif
  const intv others = !faces;
  if (ANY(others)) {
    const realv inv_r = 1.0f / sqrt(ray2), inv_length = 1.0f / sqrt(length2);
    const realv eye[3] = {-rx, (realv)-ry, -1.0f};
    realv cosine = 0.0f, turned[3], turned2 = 0.0f;
#pragma unroll
    for (int c = 0; c < 3; ++c)
      cosine = fma(n[c] * inv_length, eye[c] * inv_r, cosine);
    away = has_direction & (cosine < -AWAY_COSINE);
    const realv missing = max(HBIL_MIN_COSINE - cosine, (realv)0.0f);
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      turned[c] = fma(missing, eye[c] * inv_r, n[c] * inv_length);
      turned2 = fma(turned[c], turned[c], turned2);
    }
#pragma unroll
    for (int c = 0; c < 3; ++c)
      n[c] = select(
          select(eye[c] * eye_scale, turned[c] / sqrt(turned2), has_direction),
          n[c] * scale, faces);
  } else {
#pragma unroll
    for (int c = 0; c < 3; ++c)
      n[c] *= scale;
  }
  return away;
}

/* --- the radiance that a pixel sends -------------------------------------- */

/* The caller's planes, and what was carried over from the last frame: its light
 * (lib/radiance.clh), or null where there is none, and its weights. */
typedef struct inputs {
  surface_inputs surface;
  global const void *depth, *normal; /* relight: no normal */
  global const float *history, *weight;
  /* what the light of the last frame has fallen to; null: it hasn't */
  hbil_fall_args fall;
  global const float *ratios;
} inputs;

/* Diffuse reflectance over pi of channel c, (1-F0) albedo/pi.  usable: of each
 * input. */
INLINE realv reflectance_of(const hbil_split_args args, const inputs *in, int c,
                            int x, int y, int count, intv *usable) {
  return INV_PI *
         surface_albedo(args.surface, &in->surface, c, x, y, count,
                        usable + HBIL_SURFACE_ALBEDO) *
         surface_diffuse(args.surface, &in->surface, c, x, y, count,
                         usable + HBIL_SURFACE_F0);
}

/* Planar depth of pixels from (x, y) on; the sky's is 0. */
INLINE realv depth_of(const hbil_split_args args, const inputs *in, int x,
                      int y, int count) {
  return planar_depth(
      stored_depth(in->depth, args.depth, args.decode, x, y, count),
      ray_x(args.view, x, 1), ray_y(args.view, y), args.decode);
}

#if GATHER_RADIANCE
/* Radiance that pixels from (x, y) on send.  Pixels of the sky get any value.
 */
INLINE void radiance_of(const hbil_split_args args, const inputs *in, int x,
                        int y, int count, realv light[3], intv *usable) {
  const uint here = (uint)y * args.planes.row + (uint)x;
  realv carried[3] = {0.0f, 0.0f, 0.0f};
  if (in->history) {
    READ_AHEAD(in->history + here);
    load_radiance(in->history + here, args.planes.plane, carried);
    realv share = args.exposure;
#if PROBES
    if (in->ratios)
      share *= fallen_light(in->fall, in->ratios, args.view, x, y, 1,
                            depth_of(args, in, x, y, count));
#endif
#pragma unroll
    for (int c = 0; c < 3; ++c)
      carried[c] *= share;
  }
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    const realv reflectance = reflectance_of(args, in, c, x, y, count, usable);
    const realv irradiance =
        irradiance_of(direct_light(args.surface, in->surface.direct, c, x, y,
                                   count, usable + HBIL_SURFACE_DIRECT),
                      surface_albedo(args.surface, &in->surface, c, x, y, count,
                                     usable + HBIL_SURFACE_ALBEDO));
    realv emitted = 0.0f;
    if (GATHER_EMISSION)
      emitted = surface_emission(args.surface, &in->surface, c, x, y, count,
                                 usable + HBIL_SURFACE_EMISSION);
#if FEEDBACK_RADIANCE
    light[c] = fma(reflectance, irradiance, emitted);
    if (in->history)
      light[c] = select(light[c], carried[c], READV(in->weight + here) > 0.0f);
#else
    light[c] = fma(reflectance, irradiance + carried[c], emitted);
#endif
  }
}

/* Puts it into part `part` of the planes of radiance; 0 at the sky. */
INLINE void collect_radiance(const hbil_split_args args, const inputs *in,
                             int x, int y, intv solid, intv *usable,
                             realv planes[][4], int part) {
  realv light[3];
  radiance_of(args, in, x, y, args.view.width - x, light, usable);
#pragma unroll
  for (int c = 0; c < 3; ++c)
    light[c] = select((realv)0.0f, light[c], solid);
  pack_split_radiance(light, planes, part);
}
#endif

/* --- counts of sanitized pixels ------------------------------------------- */

/* Counts the inputs that could not be used, in the work-item's 4 HBIL_WIDTH
 * pixels.  It reads them again, because there is rarely anything to count. */
INLINE void count_sanitized(const hbil_split_args args, const inputs *in,
                            int x0, int y, volatile global uint *sanitized) {
  const hbil_view_args view = args.view;
  uint depths = 0u, normals = 0u, surface[HBIL_SURFACE_INPUTS] = {0u};
  for (int x = x0; x < min(x0 + 4 * HBIL_WIDTH, view.width); x += HBIL_WIDTH) {
    const int count = view.width - x;
    const realv depth =
        stored_depth(in->depth, args.depth, args.decode, x, y, count);
    const intv solid = planar_depth(depth, ray_x(view, x, 1), ray_y(view, y),
                                    args.decode) > 0.0f;
    realv n[3];
    view_normal(in->normal, args.normal, args.to_view, x, y, count, n);
    depths += count_lanes(!is_usable_depth(depth, args.decode));
    normals += count_lanes(solid & !is_usable_normal(squared_length(n)));
#if GATHER_RADIANCE
    realv light[3];
    intv usable[HBIL_SURFACE_INPUTS];
    for (int i = 0; i < HBIL_SURFACE_INPUTS; ++i)
      usable[i] = TRUE_LANES;
    inputs without_history = *in;
    without_history.history = 0;
    radiance_of(args, &without_history, x, y, count, light, usable);
    for (int i = 0; i < HBIL_SURFACE_INPUTS; ++i)
      surface[i] += count_lanes(
          (i == HBIL_SURFACE_EMISSION ? TRUE_LANES : solid) & !usable[i]);
#endif
  }
  add_sanitized(sanitized + HBIL_SANITIZED_DEPTH, depths);
  add_sanitized(sanitized + HBIL_SANITIZED_NORMAL, normals);
  for (int i = 0; i < HBIL_SURFACE_INPUTS; ++i)
    add_sanitized(sanitized + HBIL_SANITIZED_SURFACE + i, surface[i]);
}

/* --- the kernels ---------------------------------------------------------- */

kernel void split(const hbil_split_args args, const hbil_fall_args fall,
                  global const float *ratios, global float *layers,
                  global const float *carried, global const void *depth,
                  global const void *normal, global const void *albedo,
                  global const void *f0, global const void *direct,
                  global const void *emission, global uint *used_groups,
                  volatile global uint *sanitized, global uint *bounds) {
  const hbil_view_args view = args.view;
  const int x0 = (int)get_global_id(0) * (4 * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  if (x0 >= view.width || y >= view.height)
    return;
  const inputs in = {
      {albedo, f0, direct, emission},
      depth,
      normal,
      args.has_history ? carried + HBIL_CARRIED_RED * args.planes.plane : 0,
      carried + CARRIED_WEIGHT * args.planes.plane,
      fall,
      PROBES && light_falls(fall, ratios) ? ratios : 0};
  intv used = 0, unusable = 0;
  uint away = 0u;
  realv value[SPLIT_PLANES][4];
  const float ry = ray_y(view, y);
  /* Rolled up it takes 5 % less time, and half as long to compile. */
#pragma unroll 1
  for (int part = 0; part < 4; ++part) {
    const int x = x0 + part * HBIL_WIDTH, count = view.width - x;
    const realv rx = ray_x(view, x, 1);
    const realv stored =
        stored_depth(depth, args.depth, args.decode, x, y, count);
    const realv z = planar_depth(stored, rx, ry, args.decode);
    const intv solid = z > 0.0f;
    const realv w = w_of_depth(stored, z, args.decode);
    /* The normal shares the mask of albedo.  Emission that cannot be used
     * counts at the sky, too; the others count only on surfaces. */
    intv usable[HBIL_SURFACE_INPUTS] = {TRUE_LANES, TRUE_LANES, TRUE_LANES,
                                        TRUE_LANES};
    realv n[3];
    view_normal(normal, args.normal, args.to_view, x, y, count, n);
    const intv is_away = solid & face_the_eye(n, rx, ry, usable);
    if (ANY(is_away))
      away += count_lanes(is_away);
    value[HBIL_SPLIT_W][part] = select((realv)HBIL_NOTHING, w, solid);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      n[c] = select((realv)0.0f, n[c], solid);
    pack_split_normal(n, value + HBIL_SPLIT_NORMAL, part);
#if GATHER_RADIANCE
    collect_radiance(args, &in, x, y, solid, usable, value + RADIANCE_PLANE,
                     part);
#endif
#if SKIP_UNUSED
#pragma unroll
    for (int c = 0; c < 3; ++c)
      used |=
          solid & (reflectance_of(args, &in, c, x, y, count, usable) > 0.0f);
#endif
    unusable |=
        !is_usable_depth(stored, args.decode) | !usable[HBIL_SURFACE_EMISSION] |
        (solid & !(usable[HBIL_SURFACE_ALBEDO] & usable[HBIL_SURFACE_F0] &
                   usable[HBIL_SURFACE_DIRECT]));
  }
  add_sanitized(sanitized + HBIL_SANITIZED_AWAY, away);
  if (ANY(unusable))
    count_sanitized(args, &in, x0, y, sanitized);
#if SKIP_UNUSED
  used_groups[(uint)y *
                  (uint)((view.width + 4 * HBIL_WIDTH - 1) / (4 * HBIL_WIDTH)) +
              (uint)get_global_id(0)] = ANY(used);
#endif
#if HAS_BOUNDS
  bounds = group_bounds(args.groups, bounds, y);
  bounds[0] = nearest_of_group(value[HBIL_SPLIT_W]);
#if GATHER_RADIANCE
  bounds[1] = light_of_group(value[HBIL_SPLIT_W], value + RADIANCE_PLANE);
#else
  bounds[1] = 0u;
#endif
#endif
  /* Lanes right of the picture loaded depth 0: they are sky, and so are the
   * right-hand ends of the layers' rows. */
  global float *out =
      layers + layer_address(args.layers, 0, y & 3, x0 >> 2, y >> 2);
  const int planes_out = GATHER_RADIANCE ? SPLIT_PLANES : RADIANCE_PLANE;
  for (int p = 0; p < planes_out; ++p) {
    realv column[4];
    DEINTERLEAVE(value[p], column);
#pragma unroll
    for (int i = 0; i < 4; ++i)
      STREAMV(column[i],
              out + p * args.layers.plane + (uint)i * args.layers.layer);
  }
}

#if GATHER_RADIANCE
/*
 * The radiance of a frame in which only the light differs from the last one;
 * `history` has this view.  Raises HBIL_FLAG_CHANGED, which the host has
 * cleared, if anything differs from the layers.
 */
kernel void relight(const hbil_split_args args, const hbil_fall_args fall,
                    global const float *ratios, global float *layers,
                    global const float *history, global const void *depth,
                    global const void *albedo, global const void *f0,
                    global const void *direct, global const void *emission,
                    global uint *flags, global uint *bounds) {
  const hbil_view_args view = args.view;
  const int x0 = (int)get_global_id(0) * (4 * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  if (x0 >= view.width || y >= view.height)
    return;
  history += hbil_history_origin(args.planes);
  /* A surface's inverse depth is above 0, as a weight must be. */
  const inputs in = {
      {albedo, f0, direct, emission},
      depth,
      0,
      args.has_history ? history + HBIL_HISTORY_RED * args.planes.plane : 0,
      history + HBIL_HISTORY_W * args.planes.plane,
      fall,
      PROBES && light_falls(fall, ratios) ? ratios : 0};
  realv value[RADIANCE_PLANES][4], w[4];
#pragma unroll 1
  for (int part = 0; part < 4; ++part) {
    const int x = x0 + part * HBIL_WIDTH;
    const intv solid = depth_of(args, &in, x, y, view.width - x) > 0.0f;
    /* split has counted what isn't usable */
    intv usable[HBIL_SURFACE_INPUTS] = {0};
    collect_radiance(args, &in, x, y, solid, usable, value, part);
    w[part] = select((realv)HBIL_NOTHING, (realv)1.0f, solid);
  }
#if HAS_BOUNDS
  group_bounds(args.groups, bounds, y)[1] = light_of_group(w, value);
#endif
  global float *out = layers +
                      layer_address(args.layers, 0, y & 3, x0 >> 2, y >> 2) +
                      RADIANCE_PLANE * args.layers.plane;
  realv column[RADIANCE_PLANES][4];
  for (int p = 0; p < RADIANCE_PLANES; ++p) {
    DEINTERLEAVE(value[p], column[p]);
  }
  intv changed = 0;
#pragma unroll
  for (int i = 0; i < 4; ++i, out += args.layers.layer) {
    realv before[RADIANCE_PLANES], now[RADIANCE_PLANES];
    for (int p = 0; p < RADIANCE_PLANES; ++p) {
      before[p] = LOADV(out + p * args.layers.plane);
      now[p] = column[p][i];
    }
    if (args.steady)
      ignore_small_falls(before, now);
    for (int p = 0; p < RADIANCE_PLANES; ++p) {
      changed |= AS_INTV(before[p]) != AS_INTV(now[p]);
      STOREV(now[p], out + p * args.layers.plane);
    }
  }
  if (ANY(changed))
    flags[HBIL_FLAG_CHANGED] = 1u; /* all work-items write the same value */
}
#endif
