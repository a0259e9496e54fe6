/*
 * scatter: the light of the last frame as seen from this one, by the movement
 * of the camera (Mayaux 2018, 3.2).
 *
 * Every point of the last frame is projected into this one.  At each pixel the
 * nearest point wins; among equally near ones, the first in pixel order wins.
 * So the result is the same in every run and on every device.  The bits of
 * positive floats have the same order as the floats.
 *
 * On CPUs (HBIL_WIDTH above 1), each band of rows of this frame belongs to one
 * work-item, which needs no atomics and fetches the colours as well.  On GPUs,
 * two kernels find the nearest point: one by atomic_min on the depths, one by
 * atomic_min on the sources that match.  A third fetches the colours.
 *
 * Launch, unless a kernel says otherwise: x = vectors of HBIL_WIDTH pixels, y
 * = rows.
 * In: history planes.  Out: carried planes, and whether there are holes.
 */
#include "lib/carried_light.clh"

#if HBIL_WIDTH == 1
#define LOAD_UINTV(p) (*(p))
#else
#define LOAD_UINTV(p) HBIL_PASTE(vload, HBIL_WIDTH)(0, (p))
#define LOAD_INTV(p) HBIL_PASTE(vload, HBIL_WIDTH)(0, (p))
#define STORE_UINTV(v, p) STOREV(WORDS_AS_REALV(v), (global float *)(p))
#endif

#define NO_SOURCE 0xffffffffu

/* Where the points of HBIL_WIDTH source pixels land, in pixels from the upper
 * left corner, and their depth.  False, and 0, 0, where they land outside. */
INLINE intv landing_of(const hbil_scatter_args args,
                       global const float *history, int x, int y, realv *u,
                       realv *v, realv *depth) {
  const hbil_view_args from = args.from, to = args.to;
  const hbil_transform_args motion = args.motion;
  const hbil_plane_args planes = args.planes;
  realv w = LOADV(history + hbil_history_origin(planes) + (uint)y * planes.row +
                  (uint)x);
  realv z = 1.0f / w;
  realv px = plane_x(from, x, 1) * spread_at(z);
  realv py = plane_y(from, y) * spread_at(z);
  realv qz = row_of(motion, 2, px, py, z);
  *u = fma((realv)to.fx, row_of(motion, 0, px, py, z) / spread_at(qz),
           (realv)to.cx);
  *v = fma((realv)to.fy, row_of(motion, 1, px, py, z) / spread_at(qz),
           (realv)to.cy);
  intv inside = (w > 0.0f) & (qz > 0.0f) & (qz < INFINITY) & (*u >= 0.0f) &
                (*u < (float)to.width) & (*v >= 0.0f) &
                (*v < (float)to.height) & (x + EACH_LANE < from.width);
  /* Out-of-range floats must not reach a conversion. */
  *u = select((realv)0.0f, *u, inside);
  *v = select((realv)0.0f, *v, inside);
  *depth = qz;
  return inside;
}

/* Indices of the target pixels in rows of `row` (-1: outside), and the depths
 * there. */
INLINE intv targets_of(const hbil_scatter_args args,
                       global const float *history, int x, int y, int row,
                       realv *z) {
  realv u, v;
  const intv inside = landing_of(args, history, x, y, &u, &v, z);
  return select((intv)-1, TO_INTV(v) * row + TO_INTV(u), inside);
}

/* A source is an index into the history planes, whose order is that of the
 * pixels. */

#if HBIL_WIDTH > 1

/*
 * Each band of rows of this frame belongs to one work-item, which alone writes
 * there.  It reads the runs of the last frame that have points in its rows,
 * which scatter_rows has found, and projects them again.  That is cheaper than
 * an atomic operation for each pixel.
 */

/* First and last row at which the points of a run land; an empty range where
 * there are none.  Launch: x = runs of a row, y = rows. */
kernel void scatter_rows(const hbil_scatter_args args,
                         global const float *history, global int *rows) {
  const hbil_view_args from = args.from, to = args.to;
  const hbil_runs_args runs = args.runs;
  const int run = (int)get_global_id(0), y = (int)get_global_id(1);
  if (run >= runs.row || y >= from.height)
    return;
  realv first = INFINITY, last = -1.0f;
  for (int i = 0; i < HBIL_RUN; i += HBIL_WIDTH) {
    realv u, v, depth;
    const int x = run * HBIL_RUN + i;
    if (x >= from.width)
      break;
    const intv inside = landing_of(args, history, x, y, &u, &v, &depth);
    first = min(first, select((realv)INFINITY, v, inside));
    last = max(last, select((realv)-1.0f, v, inside));
  }
  const float lowest = lanes_min(first);
  rows += y * runs.row + run;
  rows[0] = lowest < INFINITY ? (int)lowest : to.height;
  rows[runs.row * from.height] = (int)lanes_max(last);
}

/* Adds the points of a run that land in the band.  Sources come in their order,
 * so with a strict comparison the first of equally near ones remains. */
INLINE void scatter_run(const hbil_scatter_args args,
                        global const float *history, int run, int y, uint begin,
                        uint count, global float *depths,
                        global uint *sources) {
  for (int i = 0; i < HBIL_RUN; i += HBIL_WIDTH) {
    const int x = run * HBIL_RUN + i;
    realv depth;
    if (x >= args.from.width)
      break;
    const intv to_pixel =
        targets_of(args, history, x, y, (int)args.planes.row, &depth);
    const uint source = (uint)y * args.planes.row + (uint)x;
    /* fast path: neighbours land as neighbours where the picture hardly moves
     */
    const uint first = (uint)to_pixel.s0 - begin;
    if (!ANY(to_pixel - EACH_LANE != to_pixel.s0) &&
        first + HBIL_WIDTH <= count && first < count) {
      const realv least = LOADV(depths + first);
      const intv nearer = depth < least;
      STOREV(select(least, depth, nearer), depths + first);
      STORE_UINTV(select(LOAD_UINTV(sources + first),
                         AS_UINTV(EACH_LANE) + source, nearer),
                  sources + first);
      continue;
    }
    int target[HBIL_WIDTH];
    float z[HBIL_WIDTH];
    STORE_INTV(to_pixel, target);
    STOREV(depth, z);
    for (int l = 0; l < HBIL_WIDTH; ++l) {
      const uint at = (uint)target[l] - begin; /* -1 becomes far outside */
      if (at < count && z[l] < depths[at]) {
        depths[at] = z[l];
        sources[at] = source + (uint)l;
      }
    }
  }
}

#else

/* nearest: the least depth that has arrived at each pixel of this frame; behind
 * these the sources of all pixels.  The host has filled it with ones. */
kernel void scatter_depth(const hbil_scatter_args args,
                          global const float *history,
                          volatile global uint *nearest) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= args.from.width || y >= args.from.height)
    return;
  float z;
  const int target = targets_of(args, history, x, y, args.to.width, &z);
  if (target >= 0)
    atomic_min(nearest + target, as_uint(z));
}

kernel void scatter_index(const hbil_scatter_args args,
                          global const float *history,
                          volatile global uint *nearest) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= args.from.width || y >= args.from.height)
    return;
  const uint pixels = (uint)args.to.width * (uint)args.to.height;
  float z;
  const int target = targets_of(args, history, x, y, args.to.width, &z);
  if (target >= 0 && nearest[target] == as_uint(z))
    atomic_min(nearest + pixels + target, (uint)y * args.planes.row + (uint)x);
}

#endif

/* Carries over the light of the nearest points of HBIL_WIDTH pixels: of
 * `source`, or NO_SOURCE, at `depth`. */
INLINE void fetch(const hbil_scatter_args args, global const float *history,
                  global float *carried, uintv source, realv depth,
                  global const void *depth_buffer, global uint *flags, int x,
                  int y) {
  const hbil_view_args to = args.to;
  const hbil_plane_args planes = args.planes;
  const int count = to.width - x;
  const realv here = planar_depth(
      stored_depth(depth_buffer, args.depth, args.decode, x, y, count),
      ray_x(to, x, 1), ray_y(to, y), args.decode);
  intv carried_over = (source != NO_SOURCE) & (here > 0.0f);
#if DISOCCLUSION
  carried_over &=
      fabs(depth - here) <= args.disocclusion_threshold * depth_unit(to, here);
#endif
  history += hbil_history_origin(planes) + HBIL_HISTORY_RED * planes.plane;
  realv light[3];
  window from;
  if (find_window(AS_INTV(source), carried_over, planes.row, &from)) {
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      global const float *plane = history + c * (int)planes.plane;
      FETCH_WINDOW(plane, &from, 0, 6 * HBIL_WIDEST);
      light[c] = load_window(plane, &from);
    }
  } else {
    const runs from_runs = find_runs(AS_INTV(source), carried_over);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      light[c] = load_runs(history + c * (int)planes.plane, &from_runs);
  }
  store_carried(light, carried_over, here > 0.0f,
                carried + (uint)y * planes.row + (uint)x, planes.plane, flags);
}

#if HBIL_WIDTH > 1

/* Finds the nearest sources of a band and fetches their light while it is in
 * the caches.  Until then, the carried planes of red and green hold the depths
 * and the sources, because memory of their own would pass through the caches
 * besides.  Launch: x = 1, y = bands. */
kernel void scatter_bands(const hbil_scatter_args args,
                          global const float *history, global float *carried,
                          global const void *depth_buffer, global uint *flags,
                          global const int *rows) {
  const hbil_view_args from = args.from, to = args.to;
  const hbil_runs_args runs = args.runs;
  const int top = (int)get_global_id(1) * runs.band;
  if (get_global_id(0) > 0 || top >= to.height)
    return;
  const int end = min(top + runs.band, to.height);
  const uint begin = (uint)top * args.planes.row;
  const uint count = (uint)(end - top) * args.planes.row;
  global float *const depths =
      carried + HBIL_CARRIED_RED * args.planes.plane + begin;
  global uint *const sources = (global uint *)(depths + args.planes.plane);
  for (uint i = 0; i < count; ++i) {
    depths[i] = INFINITY;
    sources[i] = NO_SOURCE;
  }
  for (int y = 0; y < from.height; ++y) {
    global const int *first = rows + y * runs.row;
    global const int *last = first + runs.row * from.height;
    for (int run = 0; run < runs.row; run += HBIL_WIDTH) {
      if (!ANY((LOAD_INTV(first + run) < end) & (LOAD_INTV(last + run) >= top)))
        continue;
      for (int i = run; i < run + HBIL_WIDTH; ++i)
        if (first[i] < end && last[i] >= top)
          scatter_run(args, history, i, y, begin, count, depths, sources);
    }
  }
  for (int y = top; y < end; ++y)
    for (int x = 0; x < to.width; x += HBIL_WIDTH) {
      const uint at = (uint)(y - top) * args.planes.row + (uint)x;
      fetch(args, history, carried, LOAD_UINTV(sources + at),
            LOADV(depths + at), depth_buffer, flags, x, y);
    }
}

#else

kernel void scatter_fetch(const hbil_scatter_args args,
                          global const float *history, global float *carried,
                          global uint *nearest, global const void *depth_buffer,
                          global uint *flags) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  if (x >= args.to.width || y >= args.to.height)
    return;
  const int at = y * args.to.width + x;
  fetch(args, history, carried, nearest[args.to.width * args.to.height + at],
        as_float(nearest[at]), depth_buffer, flags, x, y);
}

#endif
