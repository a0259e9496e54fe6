/*
 * recompose: layers -> full resolution.
 *
 * Each pixel of a 4x4 block has gathered along its own directions.  A joint
 * bilateral filter over the 5x5 pixels around it (lib/neighbours.clh) combines
 * them, guided by depth and normal (lib/filter_weight.clh).
 *
 * With a single slice per pixel, slices weigh J A(theta_t), as they do within
 * a pixel: AO and light are quotients of sums over the neighbourhood.  Means
 * of quotients would favour slices that cover little of the hemisphere.  Their
 * weights are in WEIGHT_PLANE; it is 0 with more slices.
 *
 * The spread of the neighbours' light tells how far their mean may be off
 * (hbil_config.error_estimate).  ERROR_PLANE is the plane where the errors
 * begin.  UNKNOWN_PLANE is the plane of the share that back-facing samples
 * block, or 0 if no output has it.
 *
 * With OUT_GLOSSY the sums over lobes of all neighbours are divided by their
 * whole lobes' (gather/glossy.clh).  GLOSSY_PLANE and GLOSSY_RESOLVED are where
 * they begin in the gathered and in the resolved planes.
 *
 * Launch: x = groups of 4 pixels of a row, y = rows.  If HBIL_WIDTH is more
 * than 1: x = groups of 4*SPAN pixels, y = HBIL_RECOMPOSE_ROWS rows.
 * In: split planes, gathered light planes.  Out: light planes, full
 * resolution; the bent normal has length 1 or 0.
 */

#include "lib/filter_weight.clh"
#include "lib/flags.clh"
#include "lib/interleave.clh"
#include "lib/unpacked_rows.clh"
#include "lib/unseen_light.clh"

FLAG(UNFILTERED)
FLAG(OUT_ERROR)

#if OUT_ERROR && (!defined(ERROR_PLANE) || ERROR_PLANE < 1)
#error ERROR_PLANE must be the first plane behind the light
#endif
#if !defined(UNKNOWN_PLANE) || (UNKNOWN_PLANE && !FALLBACK_FRAME_MEAN)
#error UNKNOWN_PLANE must be 0 without FALLBACK_FRAME_MEAN
#endif

/* The rows of a work-item. */
#define ROWS (HBIL_WIDTH == 1 ? 1 : HBIL_RECOMPOSE_ROWS)

/* Weighted sums of a pixel's neighbourhood, and what it takes to finish them:
 * its own inverse depth and normal. */
typedef struct sums {
  realv total, plane[HBIL_GATHERED_PLANES];
  realv w, n[3];
#if OUT_ERROR
  realv square_ao, square_near; /* of AO, of the channels of E_near */
  realv square_bright;          /* of those above BRIGHT, in units of it */
#endif
#if OUT_GLOSSY
  realv glossy[HBIL_GATHERED_GLOSSY_PLANES];
#endif
} sums;

#if OUT_ERROR
/* The square of light can overflow, or underflow, although the light itself
 * does neither (HBIL_BRIGHTEST).  So there are two sums, and the light of one
 * of them is scaled down by this power of two. */
#define BRIGHT 0x1p50f

INLINE void add_squares(sums *s, const float *t, realv weight) {
  const realv ao = TAP(t, TAP_LIGHT + HBIL_LIGHT_AO);
  s->square_ao = fma(weight * ao, ao, s->square_ao);
#if GATHER_RADIANCE
#pragma unroll
  for (int p = HBIL_LIGHT_RED; p < HBIL_LIGHT_BENT; ++p) {
    const realv light = TAP(t, TAP_LIGHT + p), zero = 0.0f;
    const intv is_bright = light > BRIGHT;
    const realv dim = select(light, zero, is_bright);
    const realv bright = select(zero, light * (1.0f / BRIGHT), is_bright);
    s->square_near = fma(weight * dim, dim, s->square_near);
    s->square_bright = fma(weight * bright, bright, s->square_bright);
  }
#endif
}

/* The sums must have become means before.  The variance is a difference of
 * squares, so anything below 2^-12 of the mean is rounding. */
INLINE void errors_of(const sums *s, const hbil_error_args errors, realv *ao,
                      realv *near_irradiance) {
  const realv inv_total = 1.0f / s->total, zero = 0.0f;
  const realv open = s->plane[HBIL_LIGHT_AO];
  *ao = errors.ao * sqrt(max(fma(-open, open, s->square_ao * inv_total), zero));
  /* in units of BRIGHT if anything in the neighbourhood is that bright */
  const intv is_bright = s->square_bright > 0.0f;
  const realv unit = select((realv)1.0f, (realv)BRIGHT, is_bright);
  const realv units = select((realv)1.0f, (realv)(1.0f / BRIGHT), is_bright);
  realv square =
      fma(s->square_near * units, units, s->square_bright) * inv_total;
#if GATHER_RADIANCE
#pragma unroll
  for (int p = HBIL_LIGHT_RED; p < HBIL_LIGHT_BENT; ++p) {
    const realv mean = s->plane[p] * units;
    square = fma(-mean, mean, square);
  }
#endif
  *near_irradiance =
      errors.near_irradiance * sqrt(max(square * (1.0f / 3.0f), zero)) * unit;
  const intv sky = s->w <= SKY;
  *ao = select(*ao, zero, sky);
  *near_irradiance = select(*near_irradiance, zero, sky);
}
#endif

/* Adds a neighbour's light.  Bent normals are not divided by the slice's
 * weight, so they contain it already. */
INLINE void add_light(sums *s, const float *t, realv weight) {
#define ADD_PLANE(p)                                                           \
  s->plane[p] = fma(weight, TAP(t, TAP_LIGHT + p), s->plane[p]);
#if OUT_GLOSSY
#pragma unroll
  for (int p = 0; p < HBIL_GATHERED_GLOSSY_PLANES; ++p)
    s->glossy[p] = fma(weight, TAP(t, TAP_GLOSSY + p), s->glossy[p]);
#endif
#if WEIGHT_PLANE
  IF_BENT(ADD_PLANE)
  weight *= TAP(t, TAP_WEIGHT);
  s->total += weight;
  ADD_PLANE(HBIL_LIGHT_AO)
  IF_RADIANCE(ADD_PLANE)
  IF_UNKNOWN(ADD_PLANE)
#else
  s->total += weight;
  EACH_GATHERED(ADD_PLANE)
#endif
#if OUT_ERROR
  add_squares(s, t, weight);
#endif
}

/* Adds a neighbour t.  plane: plane_beside() there; least: the least weight of
 * a surface. */
INLINE void add_tap(sums *s, const middle *m, const float *t, realv plane,
                    float share, float least) {
  const realv w = TAP(t, TAP_W);
  const realv n[3] = {TAP(t, TAP_NORMAL), TAP(t, TAP_NORMAL + 1),
                      TAP(t, TAP_NORMAL + 2)};
  realv weight = filter_weight(m, w, n, plane);
  if (least > 0.0f)
    weight = max(weight, select((realv)0.0f, (realv)least, w > SKY));
  add_light(s, t, weight * share);
}

#if FALLBACK_FRAME_MEAN
/* Light for the share that back-facing samples block: an estimate of what the
 * visible surfaces send. */
INLINE void fill_unknown(sums *s, global const float *estimate) {
  const realv unknown = s->plane[HBIL_LIGHT_UNKNOWN];
  const realv share =
      max(1.0f - s->plane[HBIL_LIGHT_AO] - unknown, (realv)0.0f);
  realv frame[3];
  frame_light(estimate, s->n[0], s->n[1], s->n[2], frame);
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    const realv shown = s->plane[HBIL_LIGHT_RED + c];
    s->plane[HBIL_LIGHT_RED + c] =
        fma(PI * unknown,
            unseen_light(estimate, c, frame[c], shown * INV_PI, share,
                         (realv)0.0f, (realv)0.0f),
            shown);
  }
}
#endif

#if GATHER_BENT
INLINE void normalize_bent(sums *s) {
  realv length2 = 0.0f;
#pragma unroll
  for (int p = HBIL_LIGHT_BENT; p < HBIL_LIGHT_PLANES; ++p)
    length2 = fma(s->plane[p], s->plane[p], length2);
  /* the length is 0..3; below 1e-12 fp32 has no direction left */
  const realv scale =
      select((realv)0.0f, 1.0f / sqrt(length2), length2 > 1e-24f);
#pragma unroll
  for (int p = HBIL_LIGHT_BENT; p < HBIL_LIGHT_PLANES; ++p)
    s->plane[p] *= scale;
}
#endif

/* Turns sums into means. */
INLINE void mean(sums *s) {
#if OUT_GLOSSY
  /* a whole lobe is 1e-7 and more, except at the sky */
  const realv inv_whole =
      1.0f / max(s->glossy[HBIL_GLOSSY_WHOLE], (realv)FLT_MIN);
#pragma unroll
  for (int p = 0; p < HBIL_GLOSSY_PLANES; ++p)
    s->glossy[p] *= inv_whole;
#endif
#if !UNFILTERED
  const realv inv_total = 1.0f / s->total;
#define DIVIDE_PLANE(p) s->plane[p] *= inv_total;
  EACH_GATHERED(DIVIDE_PLANE)
#endif
}

/* Fills in unknown light, normalizes the bent normal, and clears the sky. */
INLINE void finish(sums *s, global const float *estimate) {
#if FALLBACK_FRAME_MEAN
  fill_unknown(s, estimate);
#endif
#if GATHER_BENT
  normalize_bent(s);
#endif
  /* the sky is open, sends no light and has no direction */
  const intv sky = s->w <= SKY;
#define CLEAR_PLANE(p)                                                         \
  s->plane[p] = select(s->plane[p], (realv)((p) == HBIL_LIGHT_AO), sky);
  EACH_RESOLVED(CLEAR_PLANE)
#if OUT_GLOSSY
#pragma unroll
  for (int p = 0; p < HBIL_GLOSSY_PLANES; ++p)
    s->glossy[p] = select(s->glossy[p], (realv)0.0f, sky);
#endif
#if UNKNOWN_PLANE
  CLEAR_PLANE(HBIL_LIGHT_UNKNOWN)
#endif
}

/* Sums for the pixels (4 x + column, 4 y + row) and every fourth to their
 * right.  rows: the unpacked rows around them.  odd_x: 1 in odd columns at
 * half resolution, otherwise 0.  Callers pass a constant, so the compiler
 * removes the columns that aren't gathered.  The loop over rows is not
 * unrolled: unrolling made it 2 to 5 % faster, and compiling took 1 to 2 s
 * longer. */
#if HBIL_WIDTH == 1
#define NEIGHBOUR(i, j)                                                        \
  (load_tap(from, column + (i), row + (j), x, y, loaded), loaded)
#else
#define NEIGHBOUR(i, j) (rows[(j) + FILTER_DOWN] + beside[(i) + FILTER_ACROSS])
#endif
INLINE sums filter(const hbil_view_args view, const tap_source *from,
                   const float *const *rows, int column, int row, int x, int y,
                   int odd_x) {
  const int odd_y = row & (GATHERED_ROWS - 1);
  const bool is_gathered = IS_GATHERED(odd_x, odd_y);
#if HBIL_WIDTH == 1
  float loaded[TAP_PLANES];
#else
  int beside[2 * FILTER_ACROSS + 1];
#pragma unroll
  for (int i = -FILTER_ACROSS; i <= FILTER_ACROSS; ++i)
    beside[i + FILTER_ACROSS] = tap_offset(column + i);
#endif
  sums s;
  const float *const self = NEIGHBOUR(0, 0);
  s.w = TAP(self, TAP_W);
#pragma unroll
  for (int c = 0; c < 3; ++c)
    s.n[c] = TAP(self, TAP_NORMAL + c);
#define START_PLANE(p) s.plane[p] = 0.0f;
  EACH_GATHERED(START_PLANE)
#if OUT_ERROR
  s.square_ao = s.square_near = s.square_bright = 0.0f;
#endif
#if OUT_GLOSSY
#pragma unroll
  for (int p = 0; p < HBIL_GATHERED_GLOSSY_PLANES; ++p)
    s.glossy[p] = 0.0f;
#endif
  /* the pixel itself always has weight 1 */
  s.total = is_gathered ? 0.0f : HBIL_ALONE_WEIGHT;
  s.plane[HBIL_LIGHT_AO] = s.total;
  if (is_gathered)
    add_light(&s, self, (realv)1.0f);
#if !UNFILTERED
  const middle m = middle_of(view, from->split_args, from->split, s.w, s.n,
                             column, row, x, y);
  /* FILTER_DOWN is even, so the first row is gathered */
#pragma unroll 1
  for (int j = odd_y - FILTER_DOWN; j <= FILTER_DOWN; j += GATHERED_ROWS) {
    const realv plane = plane_below(&m, j);
#pragma unroll
    for (int i = -FILTER_ACROSS; i <= FILTER_ACROSS; ++i) {
      const float share = i == 0 && j == 0 ? 0.0f : neighbour_share(i, j);
      if (IS_GATHERED(odd_x + i, 0) && share > 0.0f)
        add_tap(&s, &m, NEIGHBOUR(i, j), plane_beside(&m, plane, i), share,
                least_weight(is_gathered, i, j));
    }
  }
#endif
  return s;
}

/* The same, with the constant that belongs to the column. */
INLINE sums filter_at(const hbil_view_args view, const tap_source *from,
                      const float *const *rows, int column, int row, int x,
                      int y) {
#if GATHERED < HBIL_LAYERS
  if (column & 1)
    return filter(view, from, rows, column, row, x, y, 1);
#endif
  return filter(view, from, rows, column, row, x, y, 0);
}

/* Pixels of four layers, in the order of the image. */
INLINE void store_columns(const realv *column, global float *to) {
  realv pixels[4];
  INTERLEAVE(column, pixels);
#pragma unroll
  for (int i = 0; i < 4; ++i)
    STREAMV(pixels[i], to + i * HBIL_WIDTH);
}

INLINE void store_plane(const sums *value, int p, global float *to) {
  const realv column[4] = {value[0].plane[p], value[1].plane[p],
                           value[2].plane[p], value[3].plane[p]};
  store_columns(column, to);
}

/* 4*HBIL_WIDTH pixels of row 4 y + row.  The loop over columns is not unrolled,
 * because that would need four times the registers. */
INLINE void resolve(const hbil_view_args view, const tap_source *from,
                    global const float *estimate, const float *const *rows,
                    int row, int x, int y, global float *resolved,
                    const hbil_plane_args out, const hbil_error_args errors) {
  sums value[4];
  for (int i = 0; i < 4; ++i)
    value[i] = filter_at(view, from, rows, i, row, x, y);
#if OUT_ERROR
  realv ao[4], near_irradiance[4];
#endif
  for (int i = 0; i < 4; ++i) {
    mean(&value[i]);
#if OUT_ERROR
    errors_of(&value[i], errors, &ao[i], &near_irradiance[i]);
#endif
    finish(&value[i], estimate);
  }
  global float *to = resolved + (uint)(4 * y + row) * out.row + (uint)(4 * x);
#if OUT_ERROR
  store_columns(ao, to + ERROR_PLANE * out.plane);
#if GATHER_RADIANCE
  store_columns(near_irradiance, to + (ERROR_PLANE + 1) * out.plane);
#endif
#endif
#if OUT_GLOSSY
  for (int p = 0; p < HBIL_GLOSSY_PLANES; ++p) {
    const realv lobes[4] = {value[0].glossy[p], value[1].glossy[p],
                            value[2].glossy[p], value[3].glossy[p]};
    store_columns(lobes, to + (uint)(GLOSSY_RESOLVED + p) * out.plane);
  }
#endif
#if UNKNOWN_PLANE
  store_plane(value, HBIL_LIGHT_UNKNOWN, to + UNKNOWN_PLANE * out.plane);
#endif
#define STORE_PLANE(p) store_plane(value, p, to + (p)*out.plane);
  EACH_RESOLVED(STORE_PLANE)
}

kernel void recompose(const hbil_recompose_args args, global const float *split,
                      global const float *light, global const float *estimate,
                      global float *resolved, global const uint *flags) {
  const hbil_view_args view = args.view;
  const tap_source from = {split, light, args.split, args.light};
  const hbil_plane_args out = args.planes;
  const hbil_error_args errors = args.errors;
  const int x = (int)get_global_id(0) * SPAN_VECTORS * HBIL_WIDTH;
  const int top = (int)get_global_id(1) * ROWS, y = top >> 2;
  if (4 * x >= view.width || top >= view.height ||
      (args.is_static && !flags[HBIL_FLAG_CHANGED]))
    return;
#if HBIL_WIDTH == 1
  resolve(view, &from, estimate, 0, top & 3, x, y, resolved, out, errors);
#else
  realv memory[TAP_ROWS * TAP_ROW / HBIL_WIDTH];
  float *rows[TAP_ROWS];
  for (int k = 0; k < TAP_ROWS; ++k) {
    rows[k] = (float *)memory + k * TAP_ROW;
    if (k > 0)
      unpack_row(&from, k - FILTER_DOWN - 1, x, y, rows[k]);
  }
  const int last = min(ROWS, view.height - top) - 1;
  const int right = min(SPAN_VECTORS * HBIL_WIDTH, (view.width + 3) / 4 - x);
  for (int row = 0; row <= last; ++row) {
    float *const oldest = rows[0];
#pragma unroll
    for (int k = 0; k < TAP_ROWS - 1; ++k)
      rows[k] = rows[k + 1];
    rows[TAP_ROWS - 1] = oldest;
    unpack_row(&from, row + FILTER_DOWN, x, y, oldest);
    if (row < last)
      fetch_row(&from, row + FILTER_DOWN + 1, x, y);
    for (int v = 0; v < right; v += HBIL_WIDTH) {
      const float *around[TAP_ROWS];
#pragma unroll
      for (int k = 0; k < TAP_ROWS; ++k)
        around[k] = rows[k] + v;
      resolve(view, &from, estimate, around, row & 3, x + v, y + (row >> 2),
              resolved, out, errors);
    }
  }
#endif
}
