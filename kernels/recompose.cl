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
 * Builds: RAW (only undo the split), GATHER_RADIANCE, GATHER_BENT.
 * Launch: x = groups of 4*HBIL_WIDTH pixels of a row, y = rows.
 * In: split planes (guides), light planes.  Out: light planes, full
 * resolution; the bent normal of unit length or 0.
 */

#define PI 3.14159265f
#define INV_PI 0.318309886f

/* Weighted sums of a pixel's neighbourhood. */
typedef struct sums {
  realv total, plane[HBIL_GATHERED_PLANES];
} sums;

/* What the pixel in the middle brings to the weights. */
typedef struct middle {
  realv inv_off;    /* 1 / (0.02 w0) */
  realv w, gx, gy;  /* w0 and the plane's gradient times inv_off */
  realv nx, ny, nz; /* unit normal */
} middle;

static inline void add_planes(sums *s, realv weight, global const float *light,
                              uint plane) {
  realv value[HBIL_GATHERED_PLANES];
  gathered_light(light, plane, value);
  s->total += weight;
  for (int p = 0; p < HBIL_GATHERED_PLANES; ++p)
    if (GATHERED(p))
      s->plane[p] = fma(weight, value[p], s->plane[p]);
}

/* Written out row by row: PoCL's compiler does not unroll it. */
#define ADD_ROW(dy, spatial)                                                   \
  add_row(&s, &m, dy, spatial, view, from, to,                                 \
          split + row_of(in, j + (dy), y), light + row_of(lit, j + (dy), y),   \
          in.plane, lit.plane)

/* Where the layers of row j (0..3, or a few more or less) of the blocks' row y
 * begin. */
static inline uint row_of(const hbil_layer_args l, int j, int y) {
  return (uint)(j & 3) * 4u * l.layer + l.origin + (uint)(y + (j >> 2)) * l.row;
}

/* From there, column i of the blocks' column x. */
static inline int column_of(const hbil_layer_args l, int i, int x) {
  return (i & 3) * (int)l.layer + x + (i >> 2);
}

#if !RAW
/* The neighbour at `split` and `light`, ex along its row; expected: w0 + gy ey,
 * scaled; spatial: its share for its place. */
static inline void add_tap(sums *s, const middle *m, realv expected, float ex,
                           float spatial, global const float *split,
                           global const float *light, uint in_plane,
                           uint plane) {
  const realv off =
      fma(LOADV(split), m->inv_off, -fma(m->gx, (realv)ex, expected));
  const realv close = max(1.0f - fabs(off), (realv)0.0f);
  realv n[3];
  split_normal(split, in_plane, n);
  realv same = fma(m->nx, n[0], fma(m->ny, n[1], m->nz * n[2]));
  same = max(same, (realv)0.0f);
  same *= same;
  same *= same;
  same *= same;
  same *= same;
  add_planes(s, spatial * close * same, light, plane);
}

/* Five neighbours of a row; from, to: where those of each column begin. */
static inline void add_row(sums *s, const middle *m, int dy, float spatial,
                           const hbil_view_args view, const int *from,
                           const int *to, global const float *split,
                           global const float *light, uint in_plane,
                           uint plane) {
  const realv expected = fma(m->gy, (realv)((float)dy * view.inv_fy), m->w);
  const float e = view.inv_fx;
  add_tap(s, m, expected, -2.0f * e, 0.5f * spatial, split + from[0],
          light + to[0], in_plane, plane);
  add_tap(s, m, expected, -e, spatial, split + from[1], light + to[1], in_plane,
          plane);
  if (dy == 0)
    add_planes(s, 1.0f, light + to[2], plane);
  else
    add_tap(s, m, expected, 0.0f, spatial, split + from[2], light + to[2],
            in_plane, plane);
  add_tap(s, m, expected, e, spatial, split + from[3], light + to[3], in_plane,
          plane);
  add_tap(s, m, expected, 2.0f * e, 0.5f * spatial, split + from[4],
          light + to[4], in_plane, plane);
}
#endif

#if REFUSED_FRAME
/* What faces away is lit by what the screen's surfaces send on average. */
static inline void fill_unknown(sums *s, const middle *m,
                                global const float *estimate) {
  const realv unknown = s->plane[HBIL_LIGHT_UNKNOWN];
  const realv share =
      max(1.0f - s->plane[HBIL_LIGHT_AO] - unknown, (realv)0.0f);
  realv frame[3];
  frame_light(estimate, m->nx, m->ny, m->nz, frame);
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
  for (int p = HBIL_LIGHT_BENT; p < HBIL_LIGHT_PLANES; ++p)
    length2 = fma(s->plane[p], s->plane[p], length2);
  /* a length is 0..1; below 1e-12 it has no direction left in fp32 */
  const realv scale =
      select((realv)0.0f, 1.0f / sqrt(length2), length2 > 1e-24f);
  for (int p = HBIL_LIGHT_BENT; p < HBIL_LIGHT_PLANES; ++p)
    s->plane[p] *= scale;
}
#endif

/* The filtered planes of HBIL_WIDTH pixels of layer (i, j), from its pixel
 * (x, y) on. */
static inline sums filter(const hbil_view_args view, const hbil_layer_args in,
                          const hbil_layer_args lit, global const float *split,
                          global const float *light,
                          global const float *estimate, int i, int j, int x,
                          int y) {
  const uint at =
      (uint)(4 * j + i) * in.layer + in.origin + (uint)y * in.row + (uint)x;
  const realv w0 = LOADV(split + at);
  middle m;
  sums s;
  realv n[3];
  split_normal(split + at, in.plane, n);
  m.nx = n[0];
  m.ny = n[1];
  m.nz = n[2];
  for (int p = 0; p < HBIL_GATHERED_PLANES; ++p)
    s.plane[p] = 0.0f;
  s.total = 0.0f;
#if RAW
  add_planes(&s, 1.0f, light + row_of(lit, j, y) + column_of(lit, i, x),
             lit.plane);
#else
  const realv rx = ray_x(view, 4 * x + i, 4);
  const realv n_r =
      fma(m.nx, rx, fma(m.ny, (realv)ray_y(view, 4 * y + j), m.nz));
  m.inv_off = 1.0f / (HBIL_PLANE_TOLERANCE * w0);
  m.w = 1.0f / HBIL_PLANE_TOLERANCE;
  m.gx = m.nx * m.w / n_r;
  m.gy = m.ny * m.w / n_r;
  int from[5], to[5];
  for (int k = 0; k < 5; ++k) {
    from[k] = column_of(in, i + k - 2, x);
    to[k] = column_of(lit, i + k - 2, x);
  }
  ADD_ROW(-2, 0.5f);
  ADD_ROW(-1, 1.0f);
  ADD_ROW(0, 1.0f);
  ADD_ROW(1, 1.0f);
  ADD_ROW(2, 0.5f);
  const realv inv_total = 1.0f / s.total;
  for (int p = 0; p < HBIL_GATHERED_PLANES; ++p)
    s.plane[p] *= inv_total;
#endif
#if REFUSED_FRAME
  fill_unknown(&s, &m, estimate);
#endif
#if GATHER_BENT
  normalize_bent(&s);
#endif
  /* the sky keeps what the gather gave it: open, dark, no direction */
  const intv sky = w0 <= 0.0f;
  s.plane[HBIL_LIGHT_AO] = select(s.plane[HBIL_LIGHT_AO], (realv)1.0f, sky);
  for (int p = HBIL_LIGHT_RED; p < HBIL_LIGHT_PLANES; ++p)
    s.plane[p] = select(s.plane[p], (realv)0.0f, sky);
  return s;
}

kernel void recompose(const hbil_view_args view, const hbil_layer_args in,
                      const hbil_layer_args lit, global const float *split,
                      global const float *light, global const float *estimate,
                      global float *resolved, const hbil_plane_args out) {
  const int x0 = (int)get_global_id(0) * HBIL_WIDTH;
  const int row = (int)get_global_id(1);
  if (4 * x0 >= view.width || row >= view.height)
    return;
  sums value[4];
  for (int i = 0; i < 4; ++i)
    value[i] =
        filter(view, in, lit, split, light, estimate, i, row & 3, x0, row >> 2);
  resolved += (uint)row * out.row + (uint)(4 * x0);
  for (int p = 0; p < HBIL_LIGHT_PLANES; ++p) {
    if (!GATHERED(p))
      continue;
    const realv column[4] = {value[0].plane[p], value[1].plane[p],
                             value[2].plane[p], value[3].plane[p]};
    realv pixels[4];
    INTERLEAVE(column, pixels);
    for (int i = 0; i < 4; ++i)
      STOREV(pixels[i], resolved + (uint)p * out.plane + i * HBIL_WIDTH);
  }
}
