/*
 * reproject: the light of the last frame, seen from this one.
 *
 * Scatter (paper 3.2).  Every point of the last frame is projected into this
 * one; at each pixel the nearest wins, of equally near ones the smallest
 * source, and one reader per pixel fetches the colour: the same result on every
 * run and device.  The bits of positive depths are in the order of the depths,
 * so with 64-bit atomics depth and source are one key, and one kernel finds the
 * smallest.  Without them there are two: atomic_min on the depths, then on the
 * sources among those that match.
 * Motion: every pixel fetches four pixels of the last frame where its motion
 * vector points, those at the depth it expects.
 *
 * Builds: REPROJECT_MOTION, SCATTER_KEYS (64-bit atomics), DEPTH_*, MOTION_*,
 * DISOCCLUSION (finite).
 * Launch: x = vectors of HBIL_WIDTH pixels, y = rows.
 * In: history planes (hbil_shared.h).  Out: carried planes, weight 1 or 0.
 * All arithmetic is fp32 with the roundings written here.
 */

static inline realv row_of(const hbil_transform_args t, int row, realv x,
                           realv y, realv z) {
  return fma((realv)t.m[4 * row], x,
             fma((realv)t.m[4 * row + 1], y,
                 fma((realv)t.m[4 * row + 2], z, (realv)t.m[4 * row + 3])));
}

#if !REPROJECT_MOTION

#define NO_SOURCE 0xffffffffu

/* Where the points of HBIL_WIDTH source pixels go: index of the target pixel
 * (-1: nowhere) and depth there. */
static inline intv target_of(const hbil_view_args from, const hbil_view_args to,
                             const hbil_transform_args motion,
                             global const float *history,
                             const hbil_plane_args planes, int x, int y,
                             realv *depth) {
  realv w = LOADV(history + (uint)y * planes.row + (uint)x);
  realv z = 1.0f / w;
  realv px = ray_x(from, x, 1) * z, py = ray_y(from, y) * z;
  realv qz = row_of(motion, 2, px, py, z);
  realv u = fma((realv)to.fx, row_of(motion, 0, px, py, z) / qz, (realv)to.cx);
  realv v = fma((realv)to.fy, row_of(motion, 1, px, py, z) / qz, (realv)to.cy);
  intv inside = (w > 0.0f) & (qz > 0.0f) & (qz < INFINITY) & (u >= 0.0f) &
                (u < (float)to.width) & (v >= 0.0f) & (v < (float)to.height) &
                (x + EACH_LANE < from.width);
  intv none = -1;
  /* Out-of-range floats must not reach the conversion. */
  u = select((realv)0.0f, u, inside);
  v = select((realv)0.0f, v, inside);
  *depth = qz;
#if HBIL_WIDTH == 1
  return select(none, convert_int(v) * to.width + convert_int(u), inside);
#else
  return select(none,
                HBIL_PASTE(convert_int, HBIL_WIDTH)(v) * to.width +
                    HBIL_PASTE(convert_int, HBIL_WIDTH)(u),
                inside);
#endif
}

#if HBIL_WIDTH == 1
#define STORE_INTV(v, p) (*(p) = (v))
#define LOAD_UINTV(p) (*(p))
#else
#define LOAD_UINTV(p) HBIL_PASTE(vload, HBIL_WIDTH)(0, (p))
#define STORE_INTV(v, p) HBIL_PASTE(vstore, HBIL_WIDTH)((v), 0, (p))
#endif

/* nearest: filled with ones.  Sources are places in the planes, which are in
 * the order of the pixels. */

#if SCATTER_KEYS

#pragma OPENCL EXTENSION cl_khr_int64_extended_atomics : enable

/* Keys: a depth above its source. */
typedef ulong scatter_word;
#define NO_KEY 0xffffffffffffffffUL

kernel void scatter_keys(const hbil_view_args from, const hbil_view_args to,
                         const hbil_transform_args motion,
                         global const float *history,
                         const hbil_plane_args planes,
                         volatile global scatter_word *nearest) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= from.width || y >= from.height)
    return;
  const uint source = (uint)y * planes.row + (uint)x;
  realv depth;
  int target[HBIL_WIDTH];
  float z[HBIL_WIDTH];
  STORE_INTV(target_of(from, to, motion, history, planes, x, y, &depth),
             target);
  STOREV(depth, z);
  for (int i = 0; i < HBIL_WIDTH; ++i)
    if (target[i] >= 0)
      atom_min(nearest + target[i], upsample(as_uint(z[i]), source + (uint)i));
}

/* Who has won at the pixels from `at` on, and how far away; NO_SOURCE: nobody,
 * and right of the image. */
static inline uintv winners(global const scatter_word *nearest, uint pixels,
                            uint at, int count, realv *depth) {
  HBIL_PASTE(ulong, HBIL_WIDTH) key;
  (void)pixels;
  if (count >= HBIL_WIDTH) {
    key = LOAD_UINTV(nearest + at);
  } else {
    scatter_word lane[HBIL_WIDTH];
    for (int i = 0; i < HBIL_WIDTH; ++i)
      lane[i] = i < count ? nearest[at + (uint)i] : NO_KEY;
    key = LOAD_UINTV(lane);
  }
  *depth = AS_REALV(AS_INTV(HBIL_PASTE(convert_uint, HBIL_WIDTH)(key >> 32)));
  return HBIL_PASTE(convert_uint, HBIL_WIDTH)(key & NO_SOURCE);
}

#else

/* First all depths, then all sources. */
typedef uint scatter_word;

kernel void scatter_depth(const hbil_view_args from, const hbil_view_args to,
                          const hbil_transform_args motion,
                          global const float *history,
                          const hbil_plane_args planes,
                          volatile global scatter_word *nearest) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= from.width || y >= from.height)
    return;
  realv depth;
  int target[HBIL_WIDTH];
  float z[HBIL_WIDTH];
  STORE_INTV(target_of(from, to, motion, history, planes, x, y, &depth),
             target);
  STOREV(depth, z);
  for (int i = 0; i < HBIL_WIDTH; ++i)
    if (target[i] >= 0)
      atomic_min(nearest + target[i], as_uint(z[i]));
}

kernel void scatter_index(const hbil_view_args from, const hbil_view_args to,
                          const hbil_transform_args motion,
                          global const float *history,
                          const hbil_plane_args planes,
                          volatile global scatter_word *nearest) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= from.width || y >= from.height)
    return;
  const uint pixels = (uint)to.width * (uint)to.height;
  realv depth;
  int target[HBIL_WIDTH];
  float z[HBIL_WIDTH];
  STORE_INTV(target_of(from, to, motion, history, planes, x, y, &depth),
             target);
  STOREV(depth, z);
  for (int i = 0; i < HBIL_WIDTH; ++i)
    if (target[i] >= 0 && nearest[target[i]] == as_uint(z[i]))
      atomic_min(nearest + pixels + target[i],
                 (uint)y * planes.row + (uint)(x + i));
}

static inline uintv winners(global const scatter_word *nearest, uint pixels,
                            uint at, int count, realv *depth) {
  if (count >= HBIL_WIDTH) {
    *depth = AS_REALV(AS_INTV(LOAD_UINTV(nearest + at)));
    return LOAD_UINTV(nearest + pixels + at);
  }
  uint place[HBIL_WIDTH];
  float z[HBIL_WIDTH];
  for (int i = 0; i < HBIL_WIDTH; ++i) {
    place[i] = i < count ? nearest[pixels + at + (uint)i] : NO_SOURCE;
    z[i] = i < count ? as_float(nearest[at + (uint)i]) : 0.0f;
  }
  *depth = LOADV(z);
  return LOAD_UINTV(place);
}

#endif

kernel void scatter_fetch(const hbil_view_args to, global const float *history,
                          global float *carried, const hbil_plane_args planes,
                          global const scatter_word *nearest,
                          global const void *depth_buffer,
                          const hbil_image_args depth_image,
                          const float background, const float disocclusion) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= to.width || y >= to.height)
    return;
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
  carried_over &= fabs(depth - here) <= disocclusion * here;
#endif
  history += HBIL_HISTORY_RED * planes.plane;
  carried += (uint)y * planes.row + (uint)x;
  uint from[HBIL_WIDTH];
  STORE_INTV(AS_INTV(source), (int *)from);
  /* Where the picture only moves, neighbours have come from neighbours. */
  const bool together = !ANY(source != from[0] + AS_UINTV((intv)EACH_LANE)) &&
                        from[0] != NO_SOURCE;
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    realv light = 0.0f;
    if (together) {
      light = LOADV(history + c * planes.plane + from[0]);
    } else if (ANY(carried_over)) {
      float lane[HBIL_WIDTH];
      for (int i = 0; i < HBIL_WIDTH; ++i)
        lane[i] =
            from[i] != NO_SOURCE ? history[c * planes.plane + from[i]] : 0.0f;
      light = LOADV(lane);
    }
    STOREV(select((realv)0.0f, light, carried_over),
           carried + c * planes.plane);
  }
  STOREV(select((realv)0.0f, (realv)1.0f, carried_over),
         carried + HBIL_CARRIED_WEIGHT * planes.plane);
}

#else

/* One of the four pixels around the place the motion vector points to. */
static inline void add_tap(global const float *history,
                           const hbil_plane_args planes, int width, int height,
                           int x, int y, float weight, float depth,
                           float disocclusion, float *sum, float *total) {
  if (x < 0 || y < 0 || x >= width || y >= height)
    return;
  history += (uint)y * planes.row + (uint)x;
  if (!(history[0] > 0.0f))
    return;
#if DISOCCLUSION
  if (!(fabs(1.0f / history[0] - depth) <= disocclusion * depth))
    return;
#endif
  *total += weight;
  for (int c = 0; c < 3; ++c)
    sum[c] =
        fma(weight, history[(HBIL_HISTORY_RED + c) * planes.plane], sum[c]);
}

/* The same of a whole vector of pixels whose places are neighbours, from
 * `history` on, none outside the picture. */
static inline void add_taps(global const float *history,
                            const hbil_plane_args planes, realv weight,
                            realv depth, float disocclusion, realv sum[3],
                            realv *total) {
  const realv w = LOADV(history);
  intv valid = w > 0.0f;
#if DISOCCLUSION
  valid &= fabs(1.0f / w - depth) <= disocclusion * depth;
#endif
  *total = select(*total, *total + weight, valid);
#pragma unroll
  for (int c = 0; c < 3; ++c)
    sum[c] = select(sum[c],
                    fma(weight,
                        LOADV(history + (HBIL_HISTORY_RED + c) * planes.plane),
                        sum[c]),
                    valid);
}

static inline realv row_start(realv v) {
#if HBIL_WIDTH == 1
  return v;
#else
  return v.s0;
#endif
}

/* motion: from this view to the last frame's. */
kernel void follow_motion(
    const hbil_view_args view, const hbil_transform_args motion,
    global const float *history, global float *carried,
    const hbil_plane_args planes, global const void *depth_buffer,
    const hbil_image_args depth_image, global const void *motion_buffer,
    const hbil_image_args motion_image, const float scale_x,
    const float scale_y, const float background, const float disocclusion) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  if (x >= view.width || y >= view.height)
    return;
  const int count = view.width - x;
  const realv rx = ray_x(view, x, 1);
  const float ry = ray_y(view, y);
  const realv z =
      planar_depth(load_depth(depth_buffer, depth_image, x, y, 0, count), rx,
                   ry, background);
  const realv depth = row_of(motion, 2, rx * z, ry * z, z);
  const realv mx =
      load_motion(motion_buffer, motion_image, x, y, 0, count) * scale_x;
  const realv my =
      load_motion(motion_buffer, motion_image, x, y, 1, count) * scale_y;
  const realv u = (TO_REALV(x + EACH_LANE) + 0.5f) + mx - 0.5f;
  const realv v = ((float)y + 0.5f) + my - 0.5f;
  const intv inside = (z > 0.0f) & (depth > 0.0f) & (u > -1.0f) &
                      (u < (float)view.width) & (v > -1.0f) &
                      (v < (float)view.height);
  const realv left = floor(u), top = floor(v);
  const realv a = u - left, b = v - top;
  const realv weight[4] = {(1.0f - a) * (1.0f - b), a * (1.0f - b),
                           (1.0f - a) * b, a * b};
  realv sum[3] = {0.0f, 0.0f, 0.0f}, total = 0.0f;
  /* Where the picture only moves, and by nearly the same everywhere here, the
   * places are neighbours too. */
  const realv first = row_start(left), row = row_start(top);
  const intv together = inside & (left == first + TO_REALV((intv)EACH_LANE)) &
                        (top == row) & (first >= 0.0f) & (row >= 0.0f) &
                        (first + (float)(HBIL_WIDTH + 1) <= (float)view.width) &
                        (row + 2.0f <= (float)view.height);
  if (!ANY(!together)) {
    float lane[HBIL_WIDTH];
    STOREV(left, lane);
    const int at_x = convert_int(lane[0]);
    STOREV(top, lane);
    history += (uint)convert_int(lane[0]) * planes.row + (uint)at_x;
#pragma unroll
    for (int t = 0; t < 4; ++t)
      add_taps(history + (uint)(t >> 1) * planes.row + (uint)(t & 1), planes,
               weight[t], depth, disocclusion, sum, &total);
  } else {
    float lane_depth[HBIL_WIDTH], lane_sum[3][HBIL_WIDTH], at_x[HBIL_WIDTH];
    float at_y[HBIL_WIDTH], lane_weight[4][HBIL_WIDTH], lane_total[HBIL_WIDTH];
    /* Out-of-range floats must not reach the conversion. */
    STOREV(select((realv)-9.0f, left, inside), at_x);
    STOREV(select((realv)-9.0f, top, inside), at_y);
    STOREV(depth, lane_depth);
#pragma unroll
    for (int t = 0; t < 4; ++t)
      STOREV(weight[t], lane_weight[t]);
    for (int i = 0; i < HBIL_WIDTH; ++i) {
      float one[3] = {0.0f, 0.0f, 0.0f};
      lane_total[i] = 0.0f;
      for (int t = 0; t < 4; ++t)
        add_tap(history, planes, view.width, view.height,
                convert_int(at_x[i]) + (t & 1), convert_int(at_y[i]) + (t >> 1),
                lane_weight[t][i], lane_depth[i], disocclusion, one,
                &lane_total[i]);
      for (int c = 0; c < 3; ++c)
        lane_sum[c][i] = one[c];
    }
#pragma unroll
    for (int c = 0; c < 3; ++c)
      sum[c] = LOADV(lane_sum[c]);
    total = LOADV(lane_total);
  }
  const intv found = total > 0.0f;
  carried += (uint)y * planes.row + (uint)x;
#pragma unroll
  for (int c = 0; c < 3; ++c)
    STOREV(select((realv)0.0f, sum[c] / total, found),
           carried + c * planes.plane);
  STOREV(select((realv)0.0f, (realv)1.0f, found),
         carried + HBIL_CARRIED_WEIGHT * planes.plane);
}

#endif
