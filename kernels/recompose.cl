/*
 * recompose: layers -> full resolution.  Each pixel of a 4x4 block has looked
 * along its own directions; a joint bilateral filter over the 5x5 pixels around
 * brings them together, guided by depth and normal (guide.clh).
 *
 * Each of the 16 layers weighs the same: nine of them are around the pixel
 * once, those of the outer ring are there twice and count half.  The layer at
 * the corners is there four times; two opposite ones will do, as they leave the
 * centre where it is.
 *
 * Where there may be a single slice a pixel, slices weigh J A(theta_t) as
 * within a pixel: AO and light are quotients of sums over the neighbourhood,
 * not means of quotients, which favour what a slice of little weight happens to
 * see (WEIGHT_PLANE).
 *
 * How much the neighbours' light differs says how far their mean may be off
 * (hbil_config.error).
 *
 * Builds: ORTHOGRAPHIC, RAW (only undo the split), GATHER_RADIANCE,
 * GATHER_BENT, FALLBACK_FRAME_MEAN, STORAGE, OUT_ERROR, ERROR_PLANE (where
 * errors follow the light), WEIGHT_PLANE (where weights of slices are, or 0),
 * ADAPTIVE (the rung is chosen that errors are of). Launch: x = groups of 4
 * pixels of a row, y = rows; where HBIL_WIDTH is more than 1, x = groups of
 * 4*HBIL_SPAN pixels, y = HBIL_RECOMPOSE_ROWS rows. In: split planes (guides),
 * light planes.  Out: light planes, full resolution; the bent normal of unit
 * length or 0.
 */

#define PI 3.14159265f
#define INV_PI 0.318309886f

/* On CPUs a work-item takes a tile of layer pixels, all layers, and goes down
 * many rows.  It keeps the five rows around the present one unpacked, so that
 * hardly a pixel is unpacked twice. */
#if HBIL_WIDTH == 1
#define VECTORS 1
#define ROWS 1
#define TAP_SPAN 1
#else
#define VECTORS (HBIL_SPAN / HBIL_WIDTH)
#define ROWS HBIL_RECOMPOSE_ROWS
/* a tile and a pixel more on either side, in whole vectors */
#define TAP_SPAN ((VECTORS + 1) * HBIL_WIDTH)
#endif

/* Pixels as the filters around them see them: planes, TAP_SPAN apart. */
enum {
  TAP_W = 0,
  TAP_NORMAL = 1, /* x, 2: y, 3: z */
  TAP_LIGHT = 4,
#if FALLBACK_FRAME_MEAN
  TAP_WEIGHT = TAP_LIGHT + HBIL_LIGHT_UNKNOWN + 1,
#else
  TAP_WEIGHT = TAP_LIGHT + HBIL_LIGHT_PLANES,
#endif
#if WEIGHT_PLANE
  TAP_PLANES = TAP_WEIGHT + 1
#else
  TAP_PLANES = TAP_WEIGHT
#endif
};
#define TAP(t, p) LOADV((t) + (p)*TAP_SPAN)
#define TAP_LAYER (TAP_PLANES * TAP_SPAN)
#define TAP_ROW (HBIL_SIDE * TAP_LAYER)

/* Weighted sums of a pixel's neighbourhood, and what it takes to finish them:
 * its own inverse depth and normal. */
typedef struct sums {
  realv total, plane[HBIL_GATHERED_PLANES];
  realv w, n[3];
#if OUT_ERROR
  realv square_ao, square_near; /* of AO, of the channels of E_near */
#endif
} sums;

INLINE void load_tap(const hbil_layer_args in, const hbil_layer_args lit,
                     global const float *split, global const float *light,
                     int i, int j, int x, int y, float *t) {
  realv normal[3], value[HBIL_GATHERED_PLANES];
  split += place(in, i, j, x, y);
  STOREV(LOADV(split), t + TAP_W * TAP_SPAN);
  split_normal(split, in.plane, normal);
#pragma unroll
  for (int c = 0; c < 3; ++c)
    STOREV(normal[c], t + (TAP_NORMAL + c) * TAP_SPAN);
  gathered_light(light + place(lit, i, j, x, y), lit.plane, value);
#define KEEP_PLANE(p) STOREV(value[p], t + (TAP_LIGHT + p) * TAP_SPAN);
  EACH_GATHERED(KEEP_PLANE)
#if WEIGHT_PLANE
  STOREV(value[HBIL_LIGHT_WEIGHT], t + TAP_WEIGHT * TAP_SPAN);
#endif
}

#if HBIL_WIDTH > 1
/* Unpacks row 4 y + j of the tile at x. */
INLINE void keep_row(const hbil_layer_args in, const hbil_layer_args lit,
                     global const float *split, global const float *light,
                     int j, int x, int y, float *row) {
  for (int i = 0; i < HBIL_SIDE; ++i)
    for (int v = 0; v < TAP_SPAN; v += HBIL_WIDTH)
      load_tap(in, lit, split, light, i, j, x - 1 + v, y,
               row + i * TAP_LAYER + v);
}

/* Asks for the lines of a tile in `planes` planes. */
INLINE void fetch_tile(global const float *at, uint plane, uint planes) {
  for (uint p = 0; p < planes; ++p)
    for (uint line = 0; line < TAP_SPAN; line += 16)
      FETCH_LINE(at + p * plane + line);
}

/* Asks for what keep_row() will read. */
INLINE void fetch_row(const hbil_layer_args in, const hbil_layer_args lit,
                      global const float *split, global const float *light,
                      int j, int x, int y) {
  for (int i = 0; i < HBIL_SIDE; ++i) {
    fetch_tile(split + place(in, i, j, x, y), in.plane, RADIANCE_PLANE);
    fetch_tile(light + place(lit, i, j, x, y), lit.plane,
               lit.layer / lit.plane);
  }
}
#endif

#if OUT_ERROR
INLINE void add_squares(sums *s, const float *t, realv weight) {
  const realv ao = TAP(t, TAP_LIGHT + HBIL_LIGHT_AO);
  s->square_ao = fma(weight * ao, ao, s->square_ao);
#if GATHER_RADIANCE
#pragma unroll
  for (int p = HBIL_LIGHT_RED; p < HBIL_LIGHT_BENT; ++p) {
    const realv light = TAP(t, TAP_LIGHT + p);
    s->square_near = fma(weight * light, light, s->square_near);
  }
#endif
}

/* Once sums are means.  A difference of squares: what is below 2^-12 of the
 * mean is rounding. */
INLINE void errors_of(const sums *s, const hbil_rung rung, realv *ao,
                      realv *near_irradiance) {
  const realv inv_total = 1.0f / s->total, zero = 0.0f;
  const realv open = s->plane[HBIL_LIGHT_AO];
  *ao = rung.error_ao *
        sqrt(max(fma(-open, open, s->square_ao * inv_total), zero));
  realv square = s->square_near * inv_total;
#if GATHER_RADIANCE
#pragma unroll
  for (int p = HBIL_LIGHT_RED; p < HBIL_LIGHT_BENT; ++p)
    square = fma(-s->plane[p], s->plane[p], square);
#endif
  *near_irradiance = rung.error_near * sqrt(max(square * (1.0f / 3.0f), zero));
  const intv sky = s->w <= SKY;
  *ao = select(*ao, zero, sky);
  *near_irradiance = select(*near_irradiance, zero, sky);
}
#endif

/* Adds a neighbour's light.  Bent normals are no quotients: what a slice weighs
 * is in them. */
INLINE void add_light(sums *s, const float *t, realv weight) {
#define ADD_PLANE(p)                                                           \
  s->plane[p] = fma(weight, TAP(t, TAP_LIGHT + p), s->plane[p]);
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

/* The pixel i to the right and j below. */
INLINE void add_tap(sums *s, const middle *m, const float *t, int i, int j,
                    float share) {
  const realv n[3] = {TAP(t, TAP_NORMAL), TAP(t, TAP_NORMAL + 1),
                      TAP(t, TAP_NORMAL + 2)};
  add_light(s, t, guide_weight(m, TAP(t, TAP_W), n, i, j) * share);
}

#if FALLBACK_FRAME_MEAN
/* What faces away is lit by what the screen's surfaces send on average. */
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
        fma(PI * unknown, unseen_light(frame[c], shown * INV_PI, share), shown);
  }
}
#endif

#if GATHER_BENT
INLINE void normalize_bent(sums *s) {
  realv length2 = 0.0f;
#pragma unroll
  for (int p = HBIL_LIGHT_BENT; p < HBIL_LIGHT_PLANES; ++p)
    length2 = fma(s->plane[p], s->plane[p], length2);
  /* a length is 0..3; below 1e-12 it has no direction left in fp32 */
  const realv scale =
      select((realv)0.0f, 1.0f / sqrt(length2), length2 > 1e-24f);
#pragma unroll
  for (int p = HBIL_LIGHT_BENT; p < HBIL_LIGHT_PLANES; ++p)
    s->plane[p] *= scale;
}
#endif

/* What the neighbourhood has come together to. */
INLINE void mean(sums *s) {
#if !RAW
  const realv inv_total = 1.0f / s->total;
#define DIVIDE_PLANE(p) s->plane[p] *= inv_total;
  EACH_GATHERED(DIVIDE_PLANE)
#endif
}

/* What is left to do then. */
INLINE void finish(sums *s, global const float *estimate) {
#if FALLBACK_FRAME_MEAN
  fill_unknown(s, estimate);
#endif
#if GATHER_BENT
  normalize_bent(s);
#endif
  /* the sky keeps what the gather gave it: open, dark, no direction */
  const intv sky = s->w <= SKY;
#define CLEAR_PLANE(p)                                                         \
  s->plane[p] = select(s->plane[p], (realv)((p) == HBIL_LIGHT_AO), sky);
  EACH_RESOLVED(CLEAR_PLANE)
}

/* do_this(i, j, share) for the neighbours that are looked at. */
#define EACH_NEIGHBOUR(do_this)                                                \
  do_this(-2, -2, 0.5f) do_this(-1, -2, 0.5f) do_this(0, -2, 0.5f)             \
      do_this(1, -2, 0.5f) do_this(-2, -1, 0.5f) do_this(-1, -1, 1.0f)         \
          do_this(0, -1, 1.0f) do_this(1, -1, 1.0f) do_this(2, -1, 0.5f)       \
              do_this(-2, 0, 0.5f) do_this(-1, 0, 1.0f) do_this(1, 0, 1.0f)    \
                  do_this(2, 0, 0.5f) do_this(-2, 1, 0.5f)                     \
                      do_this(-1, 1, 1.0f) do_this(0, 1, 1.0f)                 \
                          do_this(1, 1, 1.0f) do_this(2, 1, 0.5f)              \
                              do_this(-1, 2, 0.5f) do_this(0, 2, 0.5f)         \
                                  do_this(1, 2, 0.5f) do_this(2, 2, 0.5f)

/* Sums for the pixels (4 x + column, 4 y + row) and every fourth to their
 * right.  rows: the five rows around, kept from pixel x - 1 on. */
#if HBIL_WIDTH == 1
#define NEIGHBOUR(i, j)                                                        \
  (load_tap(in, lit, split, light, column + (i), row + (j), x, y, loaded),     \
   loaded)
#else
#define NEIGHBOUR(i, j)                                                        \
  (rows[(j) + 2] + ((column + (i)) & 3) * TAP_LAYER + 1 + ((column + (i)) >> 2))
#endif
INLINE sums filter(const hbil_view_args view, const hbil_layer_args in,
                   const hbil_layer_args lit, global const float *split,
                   global const float *light, const float *const *rows,
                   int column, int row, int x, int y) {
#if HBIL_WIDTH == 1
  float loaded[TAP_PLANES];
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
  s.square_ao = s.square_near = 0.0f;
#endif
  s.total = 0.0f;
  /* the pixel itself counts 1, whatever becomes of the others */
  add_light(&s, self, (realv)1.0f);
#if !RAW
  const middle m = middle_of(view, s.w, s.n, 4 * x + column, 4 * y + row);
#define ADD_NEIGHBOUR(i, j, share)                                             \
  add_tap(&s, &m, NEIGHBOUR(i, j), i, j, share);
  EACH_NEIGHBOUR(ADD_NEIGHBOUR)
#endif
  return s;
}

/* Four layers' pixels, as they lie in the image. */
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

/* 4*HBIL_WIDTH pixels of row 4 y + row.  The columns stay a loop: side by side
 * they want four times the registers. */
INLINE void resolve(const hbil_view_args view, const hbil_layer_args in,
                    const hbil_layer_args lit, global const float *split,
                    global const float *light, global const float *estimate,
                    const float *const *rows, int row, int x, int y,
                    global float *resolved, const hbil_plane_args out,
                    const hbil_rung rung) {
  sums value[4];
  for (int i = 0; i < 4; ++i)
    value[i] = filter(view, in, lit, split, light, rows, i, row, x, y);
#if OUT_ERROR
  realv ao[4], near_irradiance[4];
#endif
  for (int i = 0; i < 4; ++i) {
    mean(&value[i]);
#if OUT_ERROR
    errors_of(&value[i], rung, &ao[i], &near_irradiance[i]);
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
#define STORE_PLANE(p) store_plane(value, p, to + (p)*out.plane);
  EACH_RESOLVED(STORE_PLANE)
}

kernel void recompose(const hbil_view_args view, const hbil_layer_args in,
                      const hbil_layer_args lit, global const float *split,
                      global const float *light, global const float *estimate,
                      global float *resolved, const hbil_plane_args out,
                      global const uint *flags, const int still,
                      global const hbil_rung *ladder, const int rungs,
                      global const uint *tried) {
  const int x = (int)get_global_id(0) * VECTORS * HBIL_WIDTH;
  const int top = (int)get_global_id(1) * ROWS, y = top >> 2;
  if (4 * x >= view.width || top >= view.height ||
      (still && !flags[HBIL_FLAG_CHANGED]))
    return;
#if ADAPTIVE
  const hbil_rung rung = ladder[good_rung(tried, rungs - 1)];
#else
  const hbil_rung rung = ladder[0];
#endif
#if HBIL_WIDTH == 1
  resolve(view, in, lit, split, light, estimate, 0, top & 3, x, y, resolved,
          out, rung);
#else
  /* begins a pixel before a vector, so that most loads are aligned */
  realv memory[5 * TAP_ROW / HBIL_WIDTH + 1];
  float *rows[5];
  for (int k = 0; k < 5; ++k) {
    rows[k] = (float *)memory + HBIL_WIDTH - 1 + k * TAP_ROW;
    if (k > 0)
      keep_row(in, lit, split, light, k - 3, x, y, rows[k]);
  }
  const int last = min(ROWS, view.height - top) - 1;
  const int right = min(VECTORS * HBIL_WIDTH, (view.width + 3) / 4 - x);
  for (int row = 0; row <= last; ++row) {
    float *const oldest = rows[0];
#pragma unroll
    for (int k = 0; k < 4; ++k)
      rows[k] = rows[k + 1];
    rows[4] = oldest;
    keep_row(in, lit, split, light, row + 2, x, y, oldest);
    if (row < last)
      fetch_row(in, lit, split, light, row + 3, x, y);
    for (int v = 0; v < right; v += HBIL_WIDTH) {
      const float *const around[5] = {rows[0] + v, rows[1] + v, rows[2] + v,
                                      rows[3] + v, rows[4] + v};
      resolve(view, in, lit, split, light, estimate, around, row & 3, x + v,
              y + (row >> 2), resolved, out, rung);
    }
  }
#endif
}
