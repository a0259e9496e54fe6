/*
 * gather: the horizon search.  AO, E_near and the bent normal of every pixel,
 * layer by layer.
 *
 * All pixels of a layer share the sample offsets, so a vector of neighbouring
 * pixels loads vectors of neighbouring samples.  Along a half-slice the highest
 * horizon is the largest excess of inverse depth over the pixel's tangent
 * plane, per unit of ray slope:
 *   excess = (w1 - w0 - grad.e) / |e| ,  cot(theta) = cot(theta_t) + a z0
 * excess (HACKING.md derives it); only where that maximum grows is there
 * anything to compute.  Integrals of a half-slice, theta from the view
 * direction: A = nx/2 (theta - sin cos) + ny/2 sin^2        cosine-weighted b =
 * D/2 (theta - sin cos) + wo/2 sin^2         direction Each slice weighs J =
 * |wo_z| / (1 - (u.wo)^2), since slices equally spaced on the screen are not
 * equally spaced about wo; sums are divided by the sum of J A(theta_t), which
 * makes the white furnace exact for any number of slices.
 *
 * HBAO counts every direction alike and an occluder by its distance: A is then
 * 1 - cos(theta) and blocked intervals are weighted by W(r).
 *
 * Builds: SLICES, SAMPLES, LIMITED (a radius), HBAO, LEVELS, GATHER_RADIANCE,
 * GATHER_BENT, REFUSED_BLACK (refused light is black here), REFUSED_FRAME (the
 * same, and the refused share is written for recompose to fill), FINITE
 * (occluders have a thickness: sectors instead of a horizon).
 * Launch: x = vectors of HBIL_WIDTH pixels of a layer row, y = layer rows, z =
 * layers.  In: split planes, steps.  Out: light planes, same layout.
 */

#define PI 3.14159265f
#define HALF_PI 1.57079633f

/* theta - sin(theta) cos(theta) and sin^2(theta) of h = cot(theta).
 * The smaller of sine and cosine gives theta by an arc sine: an odd polynomial
 * on [0, sqrt(1/2)], relative error 1.1e-7 (fitted). */
static inline void horizon_terms(realv h, realv *g, realv *sin2) {
  /* a square that fp32 can hold; beyond it theta is 0 to the last digit */
  const realv a = min(fabs(h), (realv)1e18f);
  const realv s = 1.0f / sqrt(fma(a, a, (realv)1.0f));
  const realv c = a * s;
  const intv steep = a > 1.0f;
  const realv t = select(c, s, steep);
  const realv q = t * t;
  realv p = fma(q, (realv)0.103156536f, (realv)-0.0583750432f);
  p = fma(q, p, (realv)0.0628147176f);
  p = fma(q, p, (realv)0.0383250187f);
  p = fma(q, p, (realv)0.0755701933f);
  p = fma(q, p, (realv)0.166647642f);
  p = fma(t * q, p, t);
  const realv up = fma(-s, c, select(HALF_PI - p, p, steep));
  *g = select(up, PI - up, h < 0.0f);
  *sin2 = s * s;
}

/* A: the measure of the directions from wo to the angle of h = cot(theta), of
 * which the terms above are given. */
static inline realv measure(realv h, realv g, realv sin2, realv nx, realv ny) {
#if HBAO
  /* a square that fp32 can hold; beyond it the cosine is 1 anyway */
  return 1.0f - clamp(h, -1e18f, 1e18f) * sqrt(sin2);
#else
  return 0.5f * fma(nx, g, ny * sin2);
#endif
}

#if LIMITED
/* Largest inverse depth of the tile that holds layer pixel x. */
static inline float tile_nearest(global const float *row, int x) {
  float lane[HBIL_TILE], nearest;
  row += x / HBIL_TILE * HBIL_TILE;
  for (int i = 0; i < HBIL_TILE; i += HBIL_WIDTH)
    STOREV(LOADV(row + i), lane + i);
  nearest = lane[0];
  for (int i = 1; i < HBIL_TILE; ++i)
    nearest = max(nearest, lane[i]);
  return nearest;
}
#endif

/* What a pixel brings to all its slices. */
typedef struct center {
  realv w, nx, ny, nz; /* inverse depth, unit normal */
  realv gx, gy;        /* the tangent plane's gradient of inverse depth */
  realv rx;            /* ray */
  float ry;
  realv z, r, inv_r;      /* depth, length of the ray, its inverse */
  realv red, green, blue; /* own radiance */
} center;

/* State of a half-slice. */
typedef struct march {
  realv excess;     /* the highest so far; FINITE: the least to count */
  realv a, g, sin2; /* integrals up to the present horizon; FINITE: over
                       what is still open */
#if HBAO
  realv blocked; /* sum of W dA */
#endif
#if FINITE
  uintv covered;         /* sectors of equal A that are blocked */
  realv sectors, sector; /* sectors per A, A of a sector */
#endif
  realv red, green, blue; /* sum of L dA */
  realv last_red, last_green, last_blue;
  realv unknown; /* sum of dA of refused samples */
} march;

#if FINITE
/*
 * A sample that ends at its back covers the angles from its front to there,
 * both one line in inverse depth: theta in [theta_1, theta_b].  Sectors are
 * equal in A; their borders are dithered from layer to layer by `dither`.
 * Returns the A of newly covered sectors and takes it from what is open.
 */
static inline realv cover(march *m, intv rises, realv cot_front, realv cot_back,
                          realv nx, realv ny, float dither) {
  const uintv one = 1u;
  realv g1, g2, sin1, sin2;
  horizon_terms(cot_front, &g1, &sin1);
  horizon_terms(cot_back, &g2, &sin2);
  const realv a1 = measure(cot_front, g1, sin1, nx, ny);
  const realv a2 = measure(cot_back, g2, sin2, nx, ny);
  const uintv first = AS_UINTV(TO_INTV(fma(a1, m->sectors, (realv)dither)));
  const uintv last = AS_UINTV(TO_INTV(fma(a2, m->sectors, (realv)dither)));
  const uintv fresh = ((one << last) - (one << first)) & ~m->covered &
                      AS_UINTV(LANE_MASK(rises));
  m->covered |= fresh;
  const realv share = TO_REALV(AS_INTV(popcount(fresh))) * m->sector;
  /* The interval's mean direction stands for its fresh part; below 1e-5 of A
   * the differences have no digits left in fp32. */
  const realv part = share / max(a2 - a1, (realv)1e-5f);
  m->a = max(m->a - share, (realv)0.0f);
  m->g = fma(part, g1 - g2, m->g);
  m->sin2 = fma(part, sin1 - sin2, m->sin2);
  return share;
}

/* A sample's back is nearer to infinity by this share of its inverse depth: for
 * a depth greater by the factor 1 + d it is d / (1 + d).  FINITE: bit 0, d is
 * the relative thickness; bit 1, it is the thickness along the sample's ray. */
static inline realv back_share(const center *c, realv w1, const hbil_step step,
                               const hbil_gather_args args) {
  realv d = args.relative_thickness;
#if FINITE & 2
  const realv rx = c->rx + step.ex, ry = c->ry + step.ey;
  const realv ray2 = fma(rx, rx, fma(ry, ry, (realv)1.0f));
  d = min(d, args.thickness * w1 / sqrt(ray2));
#endif
  return d / (1.0f + d);
}
#endif

/* The samples that raise the horizon: lanes `rises`, sample of inverse depth
 * w1 at `step`, found at `sample` in the planes. */
static inline void raise(const center *c, march *m, intv rises, realv excess,
                         realv w1, const hbil_step step,
                         global const float *sample, uint plane,
                         const hbil_gather_args args, realv cot_tangent,
                         realv slope, realv nx, realv ny, float dither) {
#if LIMITED || (GATHER_RADIANCE && !FACING_ALL)
  /* (sample point - point) w1, from P = r z */
  const realv vz = (c->w - w1) * c->z;
  const realv vx = fma(c->rx, vz, (realv)step.ex);
  const realv vy = fma((realv)c->ry, vz, (realv)step.ey);
  const realv v2 = fma(vx, vx, fma(vy, vy, vz * vz));
#endif
#if LIMITED
  const realv limit = args.radius * w1;
  rises &= v2 <= limit * limit;
  if (!ANY(rises))
    return;
#endif
#if FINITE
  const realv excess_back =
      max(fma(w1 * step.inv_e, -back_share(c, w1, step, args), excess),
          (realv)0.0f);
  const realv share =
      cover(m, rises, fma(slope, excess, cot_tangent),
            fma(slope, excess_back, cot_tangent), nx, ny, dither);
  /* what covers nothing new is not seen */
  rises = share > 0.0f;
  if (!ANY(rises))
    return;
#else
  realv g, sin2;
  const realv cot_horizon = fma(slope, excess, cot_tangent);
  horizon_terms(cot_horizon, &g, &sin2);
  const realv a = measure(cot_horizon, g, sin2, nx, ny);
  const realv share = select((realv)0.0f, m->a - a, rises);
  m->a = select(m->a, a, rises);
  m->g = select(m->g, g, rises);
  m->sin2 = select(m->sin2, sin2, rises);
  m->excess = select(m->excess, excess, rises);
#endif
#if HBAO && LIMITED
  /* lanes of "nothing there" overflow: no share of infinity */
  const realv weight =
      max(fma(sqrt(v2) / w1, (realv)-args.falloff, (realv)1.0f), (realv)0.0f);
  m->blocked = fma(share, select((realv)0.0f, weight, rises), m->blocked);
#elif HBAO
  m->blocked += share;
#endif
#if GATHER_RADIANCE
#if !FACING_ALL
  /* Cosine of the sample's normal with the way back to the center. */
  global const float *normal = sample + HBIL_SPLIT_NORMAL * plane;
  const realv away =
      fma(vx, LOADV(normal),
          fma(vy, LOADV(normal + plane), vz * LOADV(normal + 2u * plane)));
  const realv cosine = -away / sqrt(v2);
#if FACING_STEP
  const realv accept =
      select((realv)0.0f, (realv)1.0f, (cosine >= args.facing[0]) & rises);
#else
  const realv t = clamp((cosine - args.facing[0]) * args.facing[1], 0.0f, 1.0f);
  const realv accept =
      select((realv)0.0f, t * t * fma((realv)-2.0f, t, (realv)3.0f), rises);
#endif
#endif
  /* Lanes that don't rise have no share, and accept nothing. */
  realv red = LOADV(sample + HBIL_SPLIT_RED * plane);
  realv green = LOADV(sample + (HBIL_SPLIT_RED + 1) * plane);
  realv blue = LOADV(sample + (HBIL_SPLIT_RED + 2) * plane);
#if REFUSED_FRAME
  m->unknown = fma(share, 1.0f - accept, m->unknown);
#endif
#if REFUSED_BLACK
  red *= accept;
  green *= accept;
  blue *= accept;
#elif REFUSED_LAST
  m->last_red = red = fma(accept, red - m->last_red, m->last_red);
  m->last_green = green = fma(accept, green - m->last_green, m->last_green);
  m->last_blue = blue = fma(accept, blue - m->last_blue, m->last_blue);
#endif
  m->red = fma(share, red, m->red);
  m->green = fma(share, green, m->green);
  m->blue = fma(share, blue, m->blue);
#endif
}

kernel void gather(const hbil_gather_args args, global const float *split,
                   global const hbil_step *steps, global float *light) {
  const hbil_layer_args in = args.split;
  const int x = (int)get_global_id(0) * HBIL_WIDTH;
  const int y = (int)get_global_id(1), layer = (int)get_global_id(2);
  if (x >= in.width || y >= in.height)
    return;
  const uint at = (uint)layer * in.layer + in.origin + (uint)y * in.row;
  global const float *here = split + at + (uint)x;
  global const float *from = split + (uint)y * in.row + (uint)x;
  light += (uint)layer * args.light.layer + args.light.origin +
           (uint)y * args.light.row + (uint)x;

  center c;
  c.w = LOADV(here);
  const intv solid = c.w > 0.0f;
  realv ao = 1.0f, red = 0.0f, green = 0.0f, blue = 0.0f;
  realv unknown = 0.0f;
  realv bent_x = 0.0f, bent_y = 0.0f, bent_z = 0.0f;
  if (ANY(solid)) {
#if LIMITED
    steps +=
        (uint)(hbil_level(args.reach, args.radius * tile_nearest(split + at, x),
                          LEVELS) *
               HBIL_LAYERS) *
        (2u * SLICES * SAMPLES);
#endif
    steps += (uint)layer * (2u * SLICES * SAMPLES);
    c.nx = LOADV(here + HBIL_SPLIT_NORMAL * in.plane);
    c.ny = LOADV(here + (HBIL_SPLIT_NORMAL + 1) * in.plane);
    c.nz = LOADV(here + (HBIL_SPLIT_NORMAL + 2) * in.plane);
#if GATHER_RADIANCE && REFUSED_LAST
    c.red = LOADV(here + HBIL_SPLIT_RED * in.plane);
    c.green = LOADV(here + (HBIL_SPLIT_RED + 1) * in.plane);
    c.blue = LOADV(here + (HBIL_SPLIT_RED + 2) * in.plane);
#endif
    c.rx = ray_x(args.view, 4 * x + (layer & 3), 4);
    c.ry = ray_y(args.view, 4 * y + (layer >> 2));
    c.z = 1.0f / c.w;
    c.r = sqrt(fma(c.rx, c.rx, (realv)fma(c.ry, c.ry, 1.0f)));
    c.inv_r = 1.0f / c.r;
    /* Inverse depth on the plane through P is (n.r') / (n.P). */
    const realv n_r = select(
        (realv)-1.0f, fma(c.nx, c.rx, fma(c.ny, (realv)c.ry, c.nz)), solid);
    const realv n_p = c.w / n_r;
    c.gx = c.nx * n_p;
    c.gy = c.ny * n_p;
    const realv ny = -n_r * c.inv_r;
    const realv inv_ny = 1.0f / ny;

    /* A normal rounded to `flat` shifts the plane's gradient by this much at
     * most: below it, samples of the pixel's own plane would rise. */
    const realv least_excess = args.flat * c.w * c.inv_r * inv_ny * inv_ny;

    /* Sums over half-slices: J A at the horizon and at the tangent plane, the
     * same of b, b in the slice's u and along wo. */
    realv open = 0.0f, whole = 0.0f;
    realv open_x = 0.0f, open_y = 0.0f, open_wo = 0.0f;
    realv whole_x = 0.0f, whole_y = 0.0f, whole_wo = 0.0f;

    const float dither = ((float)hbil_shift_slot(layer) + 0.5f) / 16.0f;
    for (int slice = 0; slice < SLICES; ++slice) {
      float ux, uy;
      hbil_pattern_args pattern;
      pattern.slices = SLICES;
      pattern.turn = args.turn;
      hbil_slice_direction(layer, slice, pattern, &ux, &uy);
      const realv u_wo = -(ux * c.rx + uy * c.ry) * c.inv_r;
      const realv ud2 = fma(-u_wo, u_wo, (realv)1.0f);
      const realv inv_ud = 1.0f / sqrt(ud2);
      const realv jacobian = c.inv_r * inv_ud * inv_ud;
      const realv slope = c.r * c.z * inv_ud;
      const realv n_u = fma(c.nx, (realv)ux, c.ny * uy);
      const realv side_nx = fma(-u_wo, ny, n_u) * inv_ud;
      const realv side_cot = -side_nx * inv_ny;
      realv slice_red = 0.0f, slice_green = 0.0f, slice_blue = 0.0f;
      realv slice_unknown = 0.0f;

      for (int side = 0; side < 2; ++side) {
        const float sign = side ? -1.0f : 1.0f;
        const realv nx = sign * side_nx, cot_tangent = sign * side_cot;
        march m;
        horizon_terms(cot_tangent, &m.g, &m.sin2);
        m.a = measure(cot_tangent, m.g, m.sin2, nx, ny);
        m.excess = least_excess;
        const realv start = m.a;
#if HBAO
        m.blocked = 0.0f;
#endif
#if FINITE
        m.covered = 0u;
        m.sectors = HBIL_SECTORS / max(m.a, (realv)1e-6f);
        m.sector = m.a * (1.0f / HBIL_SECTORS);
#endif
#if GATHER_RADIANCE
        m.red = m.green = m.blue = m.unknown = 0.0f;
#if REFUSED_LAST
        m.last_red = c.red;
        m.last_green = c.green;
        m.last_blue = c.blue;
#endif
#endif
        whole = fma(jacobian, start, whole);
#if GATHER_BENT
        const realv tangent_d = 0.5f * sign * m.g * inv_ud;
        whole_x = fma(jacobian * tangent_d, (realv)ux, whole_x);
        whole_y = fma(jacobian * tangent_d, (realv)uy, whole_y);
        whole_wo =
            fma(jacobian, fma(-tangent_d, u_wo, 0.5f * m.sin2), whole_wo);
#endif

        for (int k = 0; k < SAMPLES; ++k) {
          const hbil_step step = steps[k];
          const int sx = x + step.dx, sy = y + step.dy;
          /* Offsets only grow: past the border nothing follows. */
          if ((uint)sy >= (uint)in.height || sx <= -HBIL_WIDTH ||
              sx >= in.width)
            break;
          global const float *sample = from + step.offset;
          const realv w1 = LOADV(sample);
          const realv excess =
              fma(fma(w1, (realv)args.keep, -c.w), (realv)step.inv_e,
                  -fma(c.gx, (realv)step.ux, c.gy * step.uy));
          const intv rises = excess > m.excess;
          if (ANY(rises))
            raise(&c, &m, rises, excess, w1, step, sample, in.plane, args,
                  cot_tangent, slope, nx, ny, dither);
        }
        steps += SAMPLES;

#if HBAO
        m.a = start - m.blocked;
#endif
        open = fma(jacobian, m.a, open);
#if GATHER_BENT
        const realv open_d = 0.5f * sign * m.g * inv_ud;
        open_x = fma(jacobian * open_d, (realv)ux, open_x);
        open_y = fma(jacobian * open_d, (realv)uy, open_y);
        open_wo = fma(jacobian, fma(-open_d, u_wo, 0.5f * m.sin2), open_wo);
#endif
#if GATHER_RADIANCE
        slice_red += m.red;
        slice_green += m.green;
        slice_blue += m.blue;
        slice_unknown += m.unknown;
#endif
      }
      red = fma(jacobian, slice_red, red);
      green = fma(jacobian, slice_green, green);
      blue = fma(jacobian, slice_blue, blue);
      unknown = fma(jacobian, slice_unknown, unknown);
    }

    /* whole is S at least in the mean; it falls to the size of a half-slice's
     * own rounding only where nothing can be seen (1e-6 of a slice). */
    const realv inv_whole = 1.0f / max(whole, 1e-6f);
    ao = select((realv)1.0f, clamp(open * inv_whole, 0.0f, 1.0f), solid);
    red = select((realv)0.0f, PI * red * inv_whole, solid);
    green = select((realv)0.0f, PI * green * inv_whole, solid);
    blue = select((realv)0.0f, PI * blue * inv_whole, solid);
    unknown = select((realv)0.0f, unknown * inv_whole, solid);
#if GATHER_BENT
    /* Few slices miss the full hemisphere's S n by whole_*; adding what is
     * missing in the measure of what is open makes a bare plane's bent normal
     * exactly n and leaves a closed point alone. */
    const float n_scale = SLICES;
    const realv wo_sum = fma(-ao, whole_wo, open_wo) * c.inv_r;
    bent_x = open_x + ao * fma((realv)n_scale, c.nx, -whole_x) - wo_sum * c.rx;
    bent_y = open_y + ao * fma((realv)n_scale, c.ny, -whole_y) - wo_sum * c.ry;
    bent_z = ao * n_scale * c.nz - wo_sum;
    const float scale = 1.0f / SLICES;
    bent_x = select((realv)0.0f, bent_x * scale, solid);
    bent_y = select((realv)0.0f, bent_y * scale, solid);
    bent_z = select((realv)0.0f, bent_z * scale, solid);
#endif
  }
  STOREV(ao, light);
#if GATHER_RADIANCE
  STOREV(red, light + HBIL_LIGHT_RED * args.light.plane);
  STOREV(green, light + (HBIL_LIGHT_RED + 1) * args.light.plane);
  STOREV(blue, light + (HBIL_LIGHT_RED + 2) * args.light.plane);
#endif
#if REFUSED_FRAME
  STOREV(unknown, light + HBIL_LIGHT_UNKNOWN * args.light.plane);
#endif
#if GATHER_BENT
  STOREV(bent_x, light + HBIL_LIGHT_BENT * args.light.plane);
  STOREV(bent_y, light + (HBIL_LIGHT_BENT + 1) * args.light.plane);
  STOREV(bent_z, light + (HBIL_LIGHT_BENT + 2) * args.light.plane);
#endif
}
