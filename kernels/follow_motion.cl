/*
 * follow_motion: the light of the last frame, seen from this one, by motion
 * vectors.
 *
 * Every pixel fetches the four pixels of the last frame that its motion vector
 * points to, those at the depth that it expects.
 *
 * Launch: x = vectors of HBIL_WIDTH pixels, y = rows.
 * In: history planes.  Out: carried planes, and whether there are holes.
 */
#include "lib/carried_light.clh"

LOADER(motion, MOTION_TYPE, MOTION_STRIDE)

/* The mean light of those of the four pixels that are in the image and at the
 * expected depth; returns their weight, 0 where there are none.  The test is
 * |1/w - depth| <= off without its division. */
INLINE realv blend(realv tap[HBIL_HISTORY_PLANES][4], const corners *four,
                   realv depth, realv off, realv light[3]) {
  realv total = 0.0f;
#pragma unroll
  for (int c = 0; c < 3; ++c)
    light[c] = 0.0f;
#pragma unroll
  for (int t = 0; t < 4; ++t) {
    const realv w = tap[HBIL_HISTORY_W][t];
#if DISOCCLUSION
    const intv counts =
        four->allowed[t] & (fabs(fma(w, depth, (realv)-1.0f)) <= w * off);
#else
    const intv counts = four->allowed[t] & (w > 0.0f);
#endif
    total = select(total, total + four->weight[t], counts);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      light[c] = select(
          light[c],
          fma(four->weight[t], tap[HBIL_HISTORY_RED + c][t], light[c]), counts);
  }
  const realv inv_total = 1.0f / total;
#pragma unroll
  for (int c = 0; c < 3; ++c)
    light[c] *= inv_total;
  return total;
}

kernel void follow_motion(const hbil_follow_motion_args args,
                          global const float *history, global float *carried,
                          global const void *depth_buffer,
                          global const void *motion_buffer, global uint *flags,
                          volatile global uint *sanitized) {
  const hbil_view_args view = args.view;
  const hbil_plane_args planes = args.planes;
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= view.width || y >= view.height)
    return;
  const int count = view.width - x;
  const realv rx = ray_x(view, x, 1);
  const float ry = ray_y(view, y);
  const realv z = planar_depth(
      stored_depth(depth_buffer, args.depth, args.decode, x, y, count), rx, ry,
      args.decode);
  const realv spread = spread_at(z);
  const realv depth = row_of(args.back, 2, plane_x(view, x, 1) * spread,
                             plane_y(view, y) * spread, z);
  const realv off = args.disocclusion_threshold * depth_unit(view, depth);
  const realv mx = load_motion(motion_buffer, args.motion, x, y, 0, count) *
                   args.motion_scale[0];
  const realv my = load_motion(motion_buffer, args.motion, x, y, 1, count) *
                   args.motion_scale[1];
  /* motion that is not finite leads nowhere, like one out of the picture */
  const intv finite = (fabs(mx) < INFINITY) & (fabs(my) < INFINITY);
  const intv unusable = (z > 0.0f) & !finite;
  if (ANY(unusable))
    add_sanitized(sanitized + HBIL_SANITIZED_MOTION, count_lanes(unusable));
  const corners four =
      corners_about((TO_REALV(x + EACH_LANE) + 0.5f) + mx - 0.5f,
                    ((float)y + 0.5f) + my - 0.5f, (z > 0.0f) & (depth > 0.0f),
                    view.width, view.height);
  history += hbil_history_origin(planes);
  const intv position = four.top * (int)planes.row + four.left;
  realv tap[HBIL_HISTORY_PLANES][4], light[3], total;
  window from;
  /* Each branch has its own taps, because a value that both may change would go
   * through memory. */
  if (find_window(position, four.inside, planes.row, &from)) {
#pragma unroll
    for (uint p = 0; p < HBIL_HISTORY_PLANES; ++p) {
      global const float *plane = history + p * planes.plane;
      FETCH_WINDOW(plane, &from, 1, 8 * HBIL_WIDEST);
      load_four_window(plane, &from, tap[p]);
    }
    total = blend(tap, &four, depth, off, light);
  } else {
    const runs from_runs = find_runs(position, four.inside);
#pragma unroll
    for (uint p = 0; p < HBIL_HISTORY_PLANES; ++p)
      load_four_runs(history + p * planes.plane, &from_runs, planes.row,
                     tap[p]);
    total = blend(tap, &four, depth, off, light);
  }
  const intv found = total > 0.0f;
  store_carried(light, found, z > 0.0f,
                carried + (uint)y * planes.row + (uint)x, planes.plane, flags);
}
