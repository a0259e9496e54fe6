/*
 * reproject: the light of the last frame as seen from this one (Mayaux 2018,
 * 3.2).
 *
 * The paper projects each pixel of the last frame into this one.  Here each
 * pixel of this frame looks up where its surface was in the last one, so
 * no two sources compete for a pixel, and no cracks open where surfaces come
 * nearer.  The light of the nearest pixel there counts, as it is, if that
 * pixel is at the depth that is expected.
 *
 * Launch: x = vectors of HBIL_WIDTH pixels, y = rows.
 * In: history planes; the depth of this frame; its motion, with
 * REPROJECT_MOTION.  Out: carried planes, whether there are holes,
 * and how many pixels have motion that isn't finite.
 */
#include "lib/depth.clh"
#include "lib/flags.clh"
#include "lib/past_place.clh"
#include "lib/radiance.clh"

FLAG(DISOCCLUSION)

/* Stores carried light with weight 1, holes with weight 0, and the sky, which
 * all pixels right of the image are, with weight -1.  A hole raises
 * HBIL_FLAG_HOLES, which the host has cleared. */
INLINE void store_carried(const realv light[RADIANCE_PLANES], intv found,
                          intv solid, global float *carried, uint plane,
                          global uint *flags) {
#pragma unroll
  for (uint p = 0; p < RADIANCE_PLANES; ++p)
    STOREV(select((realv)0.0f, light[p], found), carried + p * plane);
  const realv none = select((realv)-1.0f, (realv)0.0f, solid);
  STOREV(select(none, (realv)1.0f, found), carried + CARRIED_WEIGHT * plane);
  if (ANY(solid & ~found))
    flags[HBIL_FLAG_HOLES] = 1u; /* all work-items write the same value */
}

#if REPROJECT_MOTION
/* Motion is in pixels of this frame, and the last one may have had others
 * (hbil_plan_follow()).  Frames of one size get the place as it is, without the
 * roundings. */
INLINE void scale_place(past_place *then, const float ratio[2]) {
  if (ratio[0] != 1.0f)
    then->u = fma(then->u + 0.5f, (realv)ratio[0], (realv)-0.5f);
  if (ratio[1] != 1.0f)
    then->v = fma(then->v + 0.5f, (realv)ratio[1], (realv)-0.5f);
}
#endif

/* Reads all planes of the last frame at the pixels that `then` lies in. Returns
 * which of these are in the image. */
INLINE intv recall(global const float *history, const hbil_plane_args planes,
                   const hbil_view_args before, const past_place *then,
                   intv solid, realv value[HISTORY_PLANES]) {
  const pixels at = pixels_of(then, solid, before);
  const intv position = at.y * (int)planes.row + at.x;
  window from;
#pragma unroll
  for (uint p = 0; p < HISTORY_PLANES; ++p)
    value[p] = 0.0f;
  if (find_window(position, at.inside, planes.row, &from)) {
#pragma unroll
    for (uint p = 0; p < HISTORY_PLANES; ++p) {
      global const float *plane = history + p * planes.plane;
      FETCH_WINDOW(plane, &from);
      value[p] = load_window(plane, &from);
    }
  } else if (ANY(at.inside)) {
    const runs from_runs = find_runs(position, at.inside);
#pragma unroll
    for (uint p = 0; p < HISTORY_PLANES; ++p)
      value[p] = load_runs(history + p * planes.plane, &from_runs);
  }
  return at.inside;
}

kernel void reproject(const hbil_reproject_args args,
                      global const float *history, global float *carried,
                      global const void *depth_buffer,
                      global const void *motion_buffer, global uint *flags,
                      volatile global uint *sanitized) {
  const hbil_view_args view = args.view;
  const hbil_plane_args planes = args.planes, past = args.history;
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= view.width || y >= view.height)
    return;
  const int count = view.width - x;
  const realv z = planar_depth(
      stored_depth(depth_buffer, args.depth, args.decode, x, y, count),
      ray_x(view, x, 1), ray_y(view, y), args.decode);
  const intv solid = z > 0.0f;
  const realv spread = spread_at(z);
  const realv p[3] = {plane_x(view, x, 1) * spread, plane_y(view, y) * spread,
                      z};
  realv move[2] = {0.0f, 0.0f};
#if REPROJECT_MOTION
  motion_of(motion_buffer, args.motion, args.motion_scale, x, y, count, solid,
            sanitized, move);
#endif
  past_place then = past_place_of(args.before, args.back, p, move, x, y, 1);
#if REPROJECT_MOTION
  scale_place(&then, args.ratio);
#endif
  realv value[HISTORY_PLANES];
  intv found = recall(history + hbil_history_origin(past), past, args.before,
                      &then, solid, value);
  const realv w = value[HBIL_HISTORY_W];
  found &= w > 0.0f;
#if DISOCCLUSION
  /* |1/w - z| is at most `off`, without the division */
  const realv off =
      args.disocclusion_threshold * depth_unit(args.before, then.z);
  found &= fabs(fma(w, then.z, (realv)-1.0f)) <= w * off;
#endif
  store_carried(value + HBIL_HISTORY_RED, found, solid,
                carried + (uint)y * planes.row + (uint)x, planes.plane, flags);
}
