/*
 * recompose: layers -> full resolution.  Each pixel of a 4x4 block has looked
 * along its own directions; a joint bilateral filter over the 5x5 pixels around
 * (outer ones count half, so that each of the 16 layers weighs the same) brings
 * them together, guided by depth and normal:
 *   weight = max(0, 1 - |w1 - (w0 + grad.e)| / (0.02 w0)) * max(0, n0.n1)^16
 * The first factor measures the distance from the pixel's tangent plane, not
 * from its depth, so tilted planes are not cut.  The second is what keeps an
 * edge between two walls.
 *
 * Builds: RAW (only undo the split), GATHER_RADIANCE, GATHER_BENT,
 * REFUSED_FRAME, PACKED.
 * Launch: x = groups of 4*HBIL_WIDTH pixels of a row, y = rows, four at a time
 * where HBIL_WIDTH is more than 1.
 * In: split planes (guides), light planes.  Out: light planes, full
 * resolution; the bent normal of unit length or 0.
 */

#define PI 3.14159265f
#define INV_PI 0.318309886f

/* A work-item takes four columns of pixels, all layers of a row, and on CPUs
 * four rows: the pixels around them are then unpacked once for all sixteen. */
#if HBIL_WIDTH == 1
#define ROWS 1
#else
#define ROWS HBIL_SIDE
#define TAP_COLUMNS (HBIL_SIDE + 4)
#define TAP_ROWS (ROWS + 4)
#endif

/* Weighted sums of a pixel's neighbourhood. */
typedef struct sums {
  realv total, plane[HBIL_GATHERED_PLANES];
} sums;

/* A pixel as the filters around it see it. */
typedef struct tap {
  realv w, n[3], plane[HBIL_GATHERED_PLANES];
} tap;

/* What the pixel in the middle brings to the weights. */
typedef struct middle {
  realv inv_off;    /* 1 / (0.02 w0) */
  realv w, gx, gy;  /* w0 and the plane's gradient times inv_off */
  realv nx, ny, nz; /* unit normal */
} middle;

/* Where a layered set of planes has the pixels (4 x + i, 4 y + j) and every
 * fourth to their right; i and j from -2 to 5. */
static inline uint place(const hbil_layer_args l, int i, int j, int x, int y) {
  const uint layer = (uint)(4 * (j & 3) + (i & 3));
  return layer * l.layer + l.origin + (uint)(y + (j >> 2)) * l.row +
         (uint)(x + (i >> 2));
}

static inline void load_tap(const hbil_layer_args in, const hbil_layer_args lit,
                            global const float *split,
                            global const float *light, int i, int j, int x,
                            int y, tap *t) {
  split += place(in, i, j, x, y);
  t->w = LOADV(split);
  split_normal(split, in.plane, t->n);
  gathered_light(light + place(lit, i, j, x, y), lit.plane, t->plane);
}

static inline middle middle_of(const hbil_view_args view, const tap *t, int x,
                               int y) {
  middle m;
  const realv rx = ray_x(view, x, 4);
  m.nx = t->n[0];
  m.ny = t->n[1];
  m.nz = t->n[2];
  const realv n_r = fma(m.nx, rx, fma(m.ny, (realv)ray_y(view, y), m.nz));
  m.inv_off = 1.0f / (HBIL_PLANE_TOLERANCE * t->w);
  m.w = 1.0f / HBIL_PLANE_TOLERANCE;
  m.gx = m.nx * m.w / n_r;
  m.gy = m.ny * m.w / n_r;
  return m;
}

/* expected: inverse depth of the plane in the tap's row, ex: the tap's place
 * along it; spatial: its share for its place. */
static inline void add_tap(sums *s, const middle *m, const tap *t,
                           realv expected, float ex, float spatial) {
  const realv off = fma(t->w, m->inv_off, -fma(m->gx, (realv)ex, expected));
  const realv close = max(spatial - spatial * fabs(off), (realv)0.0f);
  realv same = fma(m->nx, t->n[0], fma(m->ny, t->n[1], m->nz * t->n[2]));
  same = max(same, (realv)0.0f);
  same *= same;
  same *= same;
  same *= same;
  same *= same;
  const realv weight = close * same;
  s->total += weight;
#define ADD_PLANE(p) s->plane[p] = fma(weight, t->plane[p], s->plane[p]);
  EACH_GATHERED(ADD_PLANE)
}

#if REFUSED_FRAME
/* What faces away is lit by what the screen's surfaces send on average. */
static inline void fill_unknown(sums *s, const middle *m,
                                global const float *estimate) {
  const realv unknown = s->plane[HBIL_LIGHT_UNKNOWN];
  const realv share =
      max(1.0f - s->plane[HBIL_LIGHT_AO] - unknown, (realv)0.0f);
  realv frame[3];
  frame_light(estimate, m->nx, m->ny, m->nz, frame);
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    const realv shown = s->plane[HBIL_LIGHT_RED + c];
    s->plane[HBIL_LIGHT_RED + c] =
        fma(PI * unknown, unseen_light(frame[c], shown * INV_PI, share), shown);
  }
}
#endif

#if GATHER_BENT
static inline void normalize_bent(sums *s) {
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

/* What is left to do once the neighbourhood has come together. */
static inline void finish(sums *s, const middle *m, realv w,
                          global const float *estimate) {
#if !RAW
  const realv inv_total = 1.0f / s->total;
#define DIVIDE_PLANE(p) s->plane[p] *= inv_total;
  EACH_GATHERED(DIVIDE_PLANE)
#endif
#if REFUSED_FRAME
  fill_unknown(s, m, estimate);
#endif
#if GATHER_BENT
  normalize_bent(s);
#endif
  /* the sky keeps what the gather gave it: open, dark, no direction */
  const intv sky = w <= 0.0f;
#define CLEAR_PLANE(p)                                                         \
  s->plane[p] = select(s->plane[p], (realv)((p) == HBIL_LIGHT_AO), sky);
  EACH_RESOLVED(CLEAR_PLANE)
}

/* The filtered planes of HBIL_WIDTH pixels of one layer.  TAP(i, j): the pixel
 * i to the right and j below, both from -2 to 2. */
#if HBIL_WIDTH == 1
#define TAP(i, j)                                                              \
  (load_tap(in, lit, split, light, column + (i), row + (j), x, y, &loaded),    \
   &loaded)
#else
#define TAP(i, j) (&taps[(row + (j) + 2) * TAP_COLUMNS + column + (i) + 2])
#endif
static inline sums filter(const hbil_view_args view, const hbil_layer_args in,
                          const hbil_layer_args lit, global const float *split,
                          global const float *light,
                          global const float *estimate, const tap *taps,
                          int column, int row, int x, int y) {
#if HBIL_WIDTH == 1
  tap loaded;
#endif
  sums s;
  const realv w = TAP(0, 0)->w;
  const middle m = middle_of(view, TAP(0, 0), 4 * x + column, 4 * y + row);
#if RAW
#define TAKE_PLANE(p) s.plane[p] = TAP(0, 0)->plane[p];
  EACH_GATHERED(TAKE_PLANE)
#else
  /* the pixel itself counts 1, whatever becomes of the others */
  s.total = 1.0f;
#define START_PLANE(p) s.plane[p] = TAP(0, 0)->plane[p];
  EACH_GATHERED(START_PLANE)
  for (int dy = -2; dy <= 2; ++dy) {
    const realv expected = fma(m.gy, (realv)((float)dy * view.inv_fy), m.w);
    const float spatial = dy == -2 || dy == 2 ? 0.5f : 1.0f;
    const float e = view.inv_fx;
    add_tap(&s, &m, TAP(-2, dy), expected, -2.0f * e, 0.5f * spatial);
    add_tap(&s, &m, TAP(-1, dy), expected, -e, spatial);
    if (dy != 0)
      add_tap(&s, &m, TAP(0, dy), expected, 0.0f, spatial);
    add_tap(&s, &m, TAP(1, dy), expected, e, spatial);
    add_tap(&s, &m, TAP(2, dy), expected, 2.0f * e, 0.5f * spatial);
  }
#endif
  finish(&s, &m, w, estimate);
  return s;
}

/* One plane of four layers' pixels, as they lie in the image. */
static inline void store_plane(const sums *value, int p, global float *to) {
  const realv column[4] = {value[0].plane[p], value[1].plane[p],
                           value[2].plane[p], value[3].plane[p]};
  realv pixels[4];
  INTERLEAVE(column, pixels);
#pragma unroll
  for (int i = 0; i < 4; ++i)
    STOREV(pixels[i], to + i * HBIL_WIDTH);
}

kernel void recompose(const hbil_view_args view, const hbil_layer_args in,
                      const hbil_layer_args lit, global const float *split,
                      global const float *light, global const float *estimate,
                      global float *resolved, const hbil_plane_args out,
                      global const uint *flags, const int still) {
  const int x = (int)get_global_id(0) * HBIL_WIDTH;
  const int top = (int)get_global_id(1) * ROWS, y = top >> 2;
  if (4 * x >= view.width || top >= view.height ||
      (still && !flags[HBIL_FLAG_CHANGED]))
    return;
#if HBIL_WIDTH == 1
  const tap *taps = 0;
#else
  tap taps[TAP_ROWS * TAP_COLUMNS];
  for (int j = 0; j < TAP_ROWS; ++j)
    for (int i = 0; i < TAP_COLUMNS; ++i)
      load_tap(in, lit, split, light, i - 2, j - 2, x, y,
               &taps[j * TAP_COLUMNS + i]);
#endif
  for (int row = top & 3; row < (top & 3) + ROWS && 4 * y + row < view.height;
       ++row) {
    sums value[4];
#pragma unroll
    for (int i = 0; i < 4; ++i)
      value[i] =
          filter(view, in, lit, split, light, estimate, taps, i, row, x, y);
    global float *to = resolved + (uint)(4 * y + row) * out.row + (uint)(4 * x);
#define STORE_PLANE(p) store_plane(value, p, to + (p)*out.plane);
    EACH_RESOLVED(STORE_PLANE)
  }
}
