/*
 * reproject: the light of the last frame, seen from this one.
 *
 * Scatter (paper 3.2).  Every point of the last frame is projected into this
 * one; at each pixel the nearest wins, of equally near ones the smallest
 * source, and one reader per pixel fetches the colour: the same result on every
 * run and device.  The bits of positive depths are in the order of the depths.
 * On CPUs the rows of this frame have owners, who meet the sources in order,
 * need no atomics and fetch the colours, too.  On GPUs two kernels find the
 * smallest: atomic_min on the depths, then on the sources among those that
 * match.
 *
 * Motion: every pixel fetches four pixels of the last frame where its motion
 * vector points, those at the depth it expects.
 *
 * Builds: REPROJECT_MOTION, DEPTH_*, MOTION_*, DISOCCLUSION (finite).
 * Launch: x = vectors of HBIL_WIDTH pixels, y = rows, where nothing else is
 * said.
 * In: history planes (hbil_shared.h).  Out: carried planes, and whether there
 * are holes.
 * All arithmetic is fp32 with the roundings written here.
 */

INLINE realv row_of(const hbil_transform_args t, int row, realv x, realv y,
                    realv z) {
  return fma((realv)t.m[4 * row], x,
             fma((realv)t.m[4 * row + 1], y,
                 fma((realv)t.m[4 * row + 2], z, (realv)t.m[4 * row + 3])));
}

#if HBIL_WIDTH == 1
#define LOAD_UINTV(p) (*(p))
#else
#define LOAD_UINTV(p) HBIL_PASTE(vload, HBIL_WIDTH)(0, (p))
#define LOAD_INTV(p) HBIL_PASTE(vload, HBIL_WIDTH)(0, (p))
#define STORE_UINTV(v, p) STOREV(WORDS_AS_REALV(v), (global float *)(p))
#endif

/* Light that is carried over, weight 1; a hole, 0, raises HBIL_FLAG_HOLES,
 * filled with 0; the sky, -1.  Right of the image all is sky. */
INLINE void store_carried(const realv light[3], intv found, intv solid,
                          global float *carried, uint plane,
                          global uint *flags) {
#pragma unroll
  for (int c = 0; c < 3; ++c)
    STOREV(select((realv)0.0f, light[c], found), carried + c * plane);
  const realv none = select((realv)-1.0f, (realv)0.0f, solid);
  STOREV(select(none, (realv)1.0f, found),
         carried + HBIL_CARRIED_WEIGHT * plane);
  if (ANY(solid & ~found))
    flags[HBIL_FLAG_HOLES] = 1u; /* whoever else writes writes the same */
}

#if !REPROJECT_MOTION

#define NO_SOURCE 0xffffffffu

/* Where the points of HBIL_WIDTH source pixels land, in pixels from the upper
 * left corner, and how far away; false: nowhere, and 0, 0. */
INLINE intv landing_of(const hbil_view_args from, const hbil_view_args to,
                       const hbil_transform_args motion,
                       global const float *history,
                       const hbil_plane_args planes, int x, int y, realv *u,
                       realv *v, realv *depth) {
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

/* The same: places of the targets in the image (-1: nowhere), and the depths
 * there. */
INLINE intv targets_of(const hbil_view_args from, const hbil_view_args to,
                       const hbil_transform_args motion,
                       global const float *history,
                       const hbil_plane_args planes, int x, int y, realv *z) {
  realv u, v;
  const intv inside =
      landing_of(from, to, motion, history, planes, x, y, &u, &v, z);
  return select((intv)-1, TO_INTV(v) * to.width + TO_INTV(u), inside);
}

/* Sources are places in the planes, which are in the order of the pixels.
 * nearest: the least depth that has come to each pixel of this frame, then the
 * sources of all. */

#if HBIL_WIDTH > 1

/*
 * Every band of rows of this frame has an owner, a work-item beside which
 * nobody writes there.  It takes the runs of the last frame of which some point
 * lands in its rows, as scatter_rows has found, and projects those again:
 * cheaper than atomics, of which there would be one for each pixel.
 */

/* First and last row at which the points of a run land; none: no row.  x = runs
 * of a row, y = rows. */
kernel void scatter_rows(const hbil_view_args from, const hbil_view_args to,
                         const hbil_transform_args motion,
                         global const float *history,
                         const hbil_plane_args planes,
                         const hbil_runs_args runs, global int *rows) {
  const int run = (int)get_global_id(0), y = (int)get_global_id(1);
  if (run >= runs.row || y >= from.height)
    return;
  realv first = INFINITY, last = -1.0f;
  for (int i = 0; i < HBIL_RUN; i += HBIL_WIDTH) {
    realv u, v, depth;
    const int x = run * HBIL_RUN + i;
    if (x >= from.width)
      break;
    const intv inside =
        landing_of(from, to, motion, history, planes, x, y, &u, &v, &depth);
    first = min(first, select((realv)INFINITY, v, inside));
    last = max(last, select((realv)-1.0f, v, inside));
  }
  const float lowest = lanes_min(first);
  rows += y * runs.row + run;
  rows[0] = lowest < INFINITY ? (int)lowest : to.height;
  rows[runs.row * from.height] = (int)lanes_max(last);
}

/* Brings in the points of a run that land in the band: those that are nearer,
 * since of equally near ones the first is here. */
INLINE void scatter_run(const hbil_view_args from, const hbil_view_args to,
                        const hbil_transform_args motion,
                        global const float *history,
                        const hbil_plane_args planes, int run, int y,
                        uint begin, uint count, global float *depths,
                        global uint *sources) {
  for (int i = 0; i < HBIL_RUN; i += HBIL_WIDTH) {
    const int x = run * HBIL_RUN + i;
    realv depth;
    if (x >= from.width)
      break;
    const intv to_pixel =
        targets_of(from, to, motion, history, planes, x, y, &depth);
    const uint source = (uint)y * planes.row + (uint)x;
    /* neighbours that land as neighbours, as where the picture hardly moves */
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
      const uint at = (uint)target[l] - begin; /* nowhere is far outside */
      if (at < count && z[l] < depths[at]) {
        depths[at] = z[l];
        sources[at] = source + (uint)l;
      }
    }
  }
}

#else

/* nearest: filled with ones. */
kernel void scatter_depth(const hbil_view_args from, const hbil_view_args to,
                          const hbil_transform_args motion,
                          global const float *history,
                          const hbil_plane_args planes,
                          volatile global uint *nearest) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= from.width || y >= from.height)
    return;
  float z;
  const int target = targets_of(from, to, motion, history, planes, x, y, &z);
  if (target >= 0)
    atomic_min(nearest + target, as_uint(z));
}

kernel void scatter_index(const hbil_view_args from, const hbil_view_args to,
                          const hbil_transform_args motion,
                          global const float *history,
                          const hbil_plane_args planes,
                          volatile global uint *nearest) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= from.width || y >= from.height)
    return;
  const uint pixels = (uint)to.width * (uint)to.height;
  float z;
  const int target = targets_of(from, to, motion, history, planes, x, y, &z);
  if (target >= 0 && nearest[target] == as_uint(z))
    atomic_min(nearest + pixels + target, (uint)y * planes.row + (uint)x);
}

#endif

/* Who has won at the pixels from `at` on, and how far away; NO_SOURCE: nobody,
 * and right of the image, where another band begins. */
INLINE uintv winners(global const uint *nearest, uint pixels, uint at,
                     int count, realv *depth) {
  global const float *depths = (global const float *)nearest + at;
  global const uint *sources = nearest + pixels + at;
#if HBIL_WIDTH > 1
  if (count < HBIL_WIDTH) {
    float far[HBIL_WIDTH];
    uint source[HBIL_WIDTH];
    for (int i = 0; i < HBIL_WIDTH; ++i) {
      far[i] = i < count ? depths[i] : INFINITY;
      source[i] = i < count ? sources[i] : NO_SOURCE;
    }
    *depth = LOADV(far);
    return LOAD_UINTV(source);
  }
#endif
  *depth = LOADV(depths);
  return LOAD_UINTV(sources);
}

/* What a pixel's winner sends, of HBIL_WIDTH pixels. */
#define FETCH_PARAMETERS                                                       \
  const hbil_view_args to, global const float *history, global float *carried, \
      const hbil_plane_args planes, global uint *nearest,                      \
      global const void *depth_buffer,                                         \
      const hbil_external_plane_args depth_image, const float background,      \
      const float disocclusion, global uint *flags
#define FETCH_ARGUMENTS                                                        \
  to, history, carried, planes, nearest, depth_buffer, depth_image,            \
      background, disocclusion, flags
INLINE void fetch(FETCH_PARAMETERS, int x, int y) {
  const int count = to.width - x;
  const realv here =
      planar_depth(load_depth(depth_buffer, depth_image, x, y, 0, count),
                   ray_x(to, x, 1), ray_y(to, y), background);
  realv depth;
  const uintv source =
      winners(nearest, (uint)to.width * (uint)to.height,
              (uint)y * (uint)to.width + (uint)x, count, &depth);
  intv carried_over = (source != NO_SOURCE) & (here > 0.0f);
#if DISOCCLUSION
  carried_over &= fabs(depth - here) <= disocclusion * depth_unit(to, here);
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

/* x = 1, y = bands: finds who wins there, and fetches it while it is in the
 * caches. */
kernel void scatter_bands(FETCH_PARAMETERS, const hbil_view_args from,
                          const hbil_transform_args motion,
                          const hbil_runs_args runs, global const int *rows) {
  const int top = (int)get_global_id(1) * runs.band;
  if (get_global_id(0) > 0 || top >= to.height)
    return;
  const int end = min(top + runs.band, to.height);
  const uint begin = (uint)(top * to.width);
  const uint count = (uint)((end - top) * to.width);
  global float *const depths = (global float *)nearest + begin;
  global uint *const sources = nearest + to.width * to.height + begin;
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
          scatter_run(from, to, motion, history, planes, i, y, begin, count,
                      depths, sources);
    }
  }
  for (int y = top; y < end; ++y)
    for (int x = 0; x < to.width; x += HBIL_WIDTH)
      fetch(FETCH_ARGUMENTS, x, y);
}

#else

kernel void scatter_fetch(FETCH_PARAMETERS) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  if (x < to.width && y < to.height)
    fetch(FETCH_ARGUMENTS, x, y);
}

#endif

#else

/* The mean light of those of the four pixels that are allowed and at the depth
 * that is expected; returns their weight, 0 where there are none.
 *   |1/w - depth| <= off  without its division */
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

/* motion: from this view to the last frame's. */
kernel void follow_motion(const hbil_view_args view,
                          const hbil_transform_args motion,
                          global const float *history, global float *carried,
                          const hbil_plane_args planes,
                          global const void *depth_buffer,
                          const hbil_external_plane_args depth_image,
                          global const void *motion_buffer,
                          const hbil_external_plane_args motion_image,
                          const float scale_x, const float scale_y,
                          const float background, const float disocclusion,
                          global uint *flags, volatile global uint *repaired) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= view.width || y >= view.height)
    return;
  const int count = view.width - x;
  const realv rx = ray_x(view, x, 1);
  const float ry = ray_y(view, y);
  const realv z =
      planar_depth(load_depth(depth_buffer, depth_image, x, y, 0, count), rx,
                   ry, background);
  const realv spread = spread_at(z);
  const realv depth = row_of(motion, 2, plane_x(view, x, 1) * spread,
                             plane_y(view, y) * spread, z);
  const realv off = disocclusion * depth_unit(view, depth);
  const realv mx =
      load_motion(motion_buffer, motion_image, x, y, 0, count) * scale_x;
  const realv my =
      load_motion(motion_buffer, motion_image, x, y, 1, count) * scale_y;
  /* motion that is no number leads nowhere, like one out of the picture */
  const intv sound = (fabs(mx) < INFINITY) & (fabs(my) < INFINITY);
  const intv wanting = (z > 0.0f) & !sound;
  if (ANY(wanting))
    add_repaired(repaired + HBIL_SANITIZED_MOTION, count_lanes(wanting));
  const corners four =
      corners_about((TO_REALV(x + EACH_LANE) + 0.5f) + mx - 0.5f,
                    ((float)y + 0.5f) + my - 0.5f, (z > 0.0f) & (depth > 0.0f),
                    view.width, view.height);
  history += hbil_history_origin(planes);
  const intv place = four.top * (int)planes.row + four.left;
  realv tap[HBIL_HISTORY_PLANES][4], light[3], total;
  window from;
  /* each way with taps of its own: what either may have changed goes through
   * memory */
  if (find_window(place, four.inside, planes.row, &from)) {
#pragma unroll
    for (uint p = 0; p < HBIL_HISTORY_PLANES; ++p) {
      global const float *plane = history + p * planes.plane;
      FETCH_WINDOW(plane, &from, 1, 8 * HBIL_WIDEST);
      load_four_window(plane, &from, tap[p]);
    }
    total = blend(tap, &four, depth, off, light);
  } else {
    const runs from_runs = find_runs(place, four.inside);
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

#endif
