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

#define FIRST_BENT HBIL_LIGHT_BENT
#define PI 3.14159265f
#define INV_PI 0.318309886f

/* Does anything read this plane? */
static inline bool wanted(int p) {
  return p == HBIL_LIGHT_AO || (p < FIRST_BENT           ? GATHER_RADIANCE
                                : p < HBIL_LIGHT_UNKNOWN ? GATHER_BENT
                                                         : REFUSED_FRAME);
}

static inline void add_tap(realv *value, realv weight,
                           global const float *light, uint plane) {
  for (int p = 0; p < HBIL_GATHERED_PLANES; ++p)
    if (wanted(p))
      value[p] = fma(weight, LOADV(light + (uint)p * plane), value[p]);
}

/* The filtered planes of HBIL_WIDTH pixels of layer (i, j), from its pixel
 * (x, y) on. */
static inline void filter(const hbil_view_args view, const hbil_layer_args in,
                          global const float *split, global const float *light,
                          global const float *estimate, int i, int j, int x,
                          int y, realv *value) {
  const uint center =
      (uint)(4 * j + i) * in.layer + in.origin + (uint)y * in.row + (uint)x;
  for (int p = 0; p < HBIL_GATHERED_PLANES; ++p)
    value[p] = 0.0f;
  const realv w0 = LOADV(split + center);
  const realv gx0 = LOADV(split + center + HBIL_SPLIT_GX * in.plane);
  const realv gy0 = LOADV(split + center + HBIL_SPLIT_GY * in.plane);
  const realv rx = ray_x(view, 4 * x + i, 4);
  const float ry = ray_y(view, 4 * y + j);
  const realv gz0 = w0 - fma(gx0, rx, gy0 * ry);
  const realv n0 = fma(gx0, gx0, fma(gy0, gy0, gz0 * gz0));
#if RAW
  add_tap(value, 1.0f, light + center, in.plane);
#else
  const realv falloff = 1.0f / (HBIL_PLANE_TOLERANCE * w0);
  realv total = 0.0f;
  for (int dy = -2; dy <= 2; ++dy) {
    const int ty = j + dy;
    const float ey = (float)dy * view.inv_fy;
    for (int dx = -2; dx <= 2; ++dx) {
      const int tx = i + dx;
      const float ex = (float)dx * view.inv_fx;
      const int at =
          (int)(((uint)(ty & 3) * 4u + (uint)(tx & 3)) * in.layer + in.origin) +
          (y + (ty >> 2)) * (int)in.row + x + (tx >> 2);
      const realv w1 = LOADV(split + at);
      const realv gx1 = LOADV(split + at + HBIL_SPLIT_GX * in.plane);
      const realv gy1 = LOADV(split + at + HBIL_SPLIT_GY * in.plane);
      const realv gz1 = w1 - fma(gx1, rx + ex, gy1 * (ry + ey));
      const realv off = w1 - w0 - fma(gx0, (realv)ex, gy0 * ey);
      const realv close = fma(-fabs(off), falloff, (realv)1.0f);
      const realv n1 = fma(gx1, gx1, fma(gy1, gy1, gz1 * gz1));
      const realv dot01 =
          max(fma(gx0, gx1, fma(gy0, gy1, gz0 * gz1)), (realv)0.0f);
      realv same = dot01 * dot01 / (n0 * n1);
      same *= same;
      same *= same;
      same *= same;
      const float spatial = ((dx == -2 || dx == 2) ? 0.5f : 1.0f) *
                            ((dy == -2 || dy == 2) ? 0.5f : 1.0f);
      const realv weight = (dx == 0 && dy == 0)
                               ? (realv)1.0f
                               : select((realv)0.0f, spatial * close * same,
                                        (close > 0.0f) & (w1 > 0.0f));
      total += weight;
      add_tap(value, weight, light + at, in.plane);
    }
  }
  total = 1.0f / total;
  for (int p = 0; p < HBIL_GATHERED_PLANES; ++p)
    value[p] *= total;
#endif
#if REFUSED_FRAME
  /* What faces away is lit by what the screen's surfaces send on average. */
  const realv inv_n = -1.0f / sqrt(n0);
  const realv share =
      max(1.0f - value[HBIL_LIGHT_AO] - value[HBIL_LIGHT_UNKNOWN], (realv)0.0f);
  for (int c = 0; c < 3; ++c) {
    const realv shown = value[HBIL_LIGHT_RED + c];
    const realv unseen = unseen_light(estimate, c, gx0 * inv_n, gy0 * inv_n,
                                      gz0 * inv_n, shown * INV_PI, share);
    value[HBIL_LIGHT_RED + c] =
        fma(PI * value[HBIL_LIGHT_UNKNOWN], unseen, shown);
  }
#endif
  /* the sky keeps what the gather gave it: open, dark, no direction */
  const intv sky = w0 <= 0.0f;
  value[HBIL_LIGHT_AO] = select(value[HBIL_LIGHT_AO], (realv)1.0f, sky);
  for (int p = HBIL_LIGHT_RED; p < HBIL_LIGHT_PLANES; ++p)
    value[p] = select(value[p], (realv)0.0f, sky);
#if GATHER_BENT
  realv length2 = 0.0f;
  for (int c = 0; c < 3; ++c)
    length2 = fma(value[FIRST_BENT + c], value[FIRST_BENT + c], length2);
  /* a length is 0..1; below 1e-12 it has no direction left in fp32 */
  const realv scale =
      select((realv)0.0f, 1.0f / sqrt(length2), length2 > 1e-24f);
  for (int c = 0; c < 3; ++c)
    value[FIRST_BENT + c] *= scale;
#endif
}

kernel void recompose(const hbil_view_args view, const hbil_layer_args in,
                      global const float *split, global const float *light,
                      global const float *estimate, global float *resolved,
                      const hbil_plane_args out) {
  const int x0 = (int)get_global_id(0) * HBIL_WIDTH;
  const int row = (int)get_global_id(1);
  if (4 * x0 >= view.width || row >= view.height)
    return;
  realv value[4][HBIL_GATHERED_PLANES];
  for (int i = 0; i < 4; ++i)
    filter(view, in, split, light, estimate, i, row & 3, x0, row >> 2,
           value[i]);
  resolved += (uint)row * out.row + (uint)(4 * x0);
  for (int p = 0; p < HBIL_LIGHT_PLANES; ++p) {
    if (!wanted(p))
      continue;
    const realv column[4] = {value[0][p], value[1][p], value[2][p],
                             value[3][p]};
    realv pixels[4];
    INTERLEAVE(column, pixels);
    for (int i = 0; i < 4; ++i)
      STOREV(pixels[i], resolved + (uint)p * out.plane + i * HBIL_WIDTH);
  }
}
