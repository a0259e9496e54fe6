/*
 * gather: the horizon search.  AO, E_near and the bent normal of every pixel,
 * layer by layer.
 *
 * All pixels of a layer share the sample offsets, so a vector of neighbouring
 * pixels loads vectors of neighbouring samples.  Along a half-slice the highest
 * horizon is the largest excess of inverse depth over the pixel's tangent
 * plane, per unit of ray slope (HACKING.md derives it),
 *
 *   excess = (w1 - w0 - grad.e) / |e|
 *
 *   cot(theta) = cot(theta_t) + a z0 excess
 *
 * and only where that maximum grows is there anything to compute.  Integrals of
 * a half-slice, theta from the view direction, cosine-weighted and of
 * direction:
 *
 *   A = nx/2 (theta - sin cos) + ny/2 sin^2
 *
 *   b = D/2 (theta - sin cos) + wo/2 sin^2
 *
 * Each slice weighs J = |wo_z| / (1 - (u.wo)^2), since slices equally spaced on
 * the screen are not equally spaced about wo; sums are divided by the sum of
 * J A(theta_t), which makes the white furnace exact for any number of slices.
 *
 * HBAO counts every direction alike and an occluder by its distance: A is then
 * 1 - cos(theta) and blocked intervals are weighted by W(r).
 *
 * Builds: ORTHOGRAPHIC, LIMITED (a radius), HBAO, LEVELS, GATHER_RADIANCE,
 * GATHER_BENT, FALLBACK_LAST_ACCEPTED (refused light is the last accepted; else
 * it is black here), FALLBACK_FRAME_MEAN (the refused share is written for
 * recompose to fill), FACING_ALL (no light is refused), FACING_STEP (the
 * threshold is sharp), FINITE (occluders have a thickness: sectors instead of a
 * horizon), EXTRAPOLATE, ADAPTIVE (the number of samples is chosen, judge.cl),
 * KEEP_FACTORS (what samples' light counts for is kept, horizon_cache.clh: of
 * the rows that there is memory for), WEIGHT_PLANE (there may be a single
 * slice: what slices weigh is stored, too), STORAGE (common.clh), SKIP_*
 * (spared_of(), look()).
 *
 * Launch: x = spans of HBIL_SPAN pixels of a layer row (single pixels where
 * HBIL_WIDTH is 1), y = layer rows, z = layers; to measure with a rung, x =
 * spans of the tiles that are measured, y = 1.
 * In: split planes, steps.  Out: light planes, same layout.
 */

/* Samples of a half-slice that are looked at before those that rise are: their
 * loads are on the way together, and no branch waits for one of them.  A single
 * pixel has no use for it. */
#if HBIL_WIDTH == 1
#define BLOCK 1
#else
#define BLOCK 32
#endif

/* Entry i of a list of hits, uchars: of a sample of the block and a vector of
 * the span, sample * SPAN_VECTORS + vector. */
#define HIT(list, i) (BLOCK * SPAN_VECTORS == 1 ? 0u : (uint)(list)[i])
#if BLOCK * SPAN_VECTORS > 256
#error an entry of a list of hits is a uchar
#endif

/* Whether what each sample adds must be known, or the highest is enough; and
 * whether it may be enough after all, where samples send no light. */
#define SHARES (GATHER_RADIANCE || HBAO || FINITE)
#define MAY_BE_DARK (GATHER_RADIANCE && SKIP_DARK && !FINITE && !HBAO)

/* 1 / sqrt(x): an estimate and a step of Newton's, whose products and sums are
 * fused; the same wherever it stands. */
INLINE realv inv_sqrt(realv x) {
#if defined(__clang_major__) && __clang_major__ >= 12
#pragma clang fp contract(fast)
#endif
  return 1.0f / sqrt(x);
}

#if KEEP_FACTORS
/* what is dark now may be lit when they are used */
#undef SKIP_DARK
#define SKIP_DARK 0
#endif

#define PI 3.14159265f
#define HALF_PI 1.57079633f

/* theta - sin(theta) cos(theta) and sin^2(theta) of h = cot(theta).
 * The smaller of sine and cosine gives theta by an arc sine: an odd polynomial
 * on [0, sqrt(1/2)], relative error 1.1e-7 (fitted), in pairs of terms: a
 * sample waits for it (Estrin 1960). */
INLINE void horizon_terms(realv h, realv *g, realv *sin2) {
  /* a square that fp32 can hold; beyond it theta is 0 to the last digit */
  const realv a = min(fabs(h), (realv)1e18f);
  const realv s = inv_sqrt(fma(a, a, (realv)1.0f));
  const realv c = a * s;
  const intv steep = a > 1.0f;
  const realv t = select(c, s, steep);
  const realv q = t * t;
  const realv q2 = q * q;
  realv p = fma(q, (realv)0.103156536f, (realv)-0.0583750432f);
  p = fma(q2, p, fma(q, (realv)0.0628147176f, (realv)0.0383250187f));
  p = fma(q2, p, fma(q, (realv)0.0755701933f, (realv)0.166647642f));
  p = fma(t * q, p, t);
  const realv up = fma(-s, c, select(HALF_PI - p, p, steep));
  *g = select(up, PI - up, h < 0.0f);
  *sin2 = s * s;
}

/* A: the measure of the directions from wo to the angle of h = cot(theta), of
 * which the terms above are given. */
INLINE realv measure(realv h, realv g, realv sin2, realv nx, realv ny) {
#if HBAO
  /* a square that fp32 can hold; beyond it the cosine is 1 anyway */
  return 1.0f - clamp(h, -1e18f, 1e18f) * sqrt(sin2);
#else
  return 0.5f * fma(nx, g, ny * sin2);
#endif
}

/* How much light there is in a span's reach. */
enum { LIGHT_NONE, LIGHT_SOME, LIGHT_ALL };
/* And in which quadrants of it, see hbil_quadrants(). */
typedef struct lights {
  int how_much;
  uint quadrants;
} lights;

/* What a pixel brings to all its slices. */
typedef struct center {
  realv w, nx, ny, nz;      /* inverse depth, unit normal */
  realv gx, gy;             /* the tangent plane's gradient of inverse depth */
  realv cosine, inv_cosine; /* of the normal with wo */
  realv least_excess;
  realv rx; /* ray */
  float ry;
  realv z, r, inv_r; /* depth, length of the ray, its inverse */
  realv own[3];      /* radiance */
} center;

/* Asks for what is needed soon.  Normals and light of a sample that rises, here
 * and in the next span, and the samples' w, of the span after the next and of
 * the next row, which take the same steps; the line more that each of them
 * straddles is asked for by its neighbours.
 * OpenCL's own prefetch() does nothing in PoCL. */
INLINE void fetch_early(global const float *sample, uint plane, uint row) {
#if defined(__AVX__) && HBIL_WIDTH > 1
  const int span = SPAN_VECTORS * HBIL_WIDTH;
  for (int i = 0; i < span; i += 16) {
    FETCH_LINE(sample + 2 * span + i);
    FETCH_LINE(sample + row + i);
  }
#if GATHER_RADIANCE && PACKED
  const uint first = FACING_ALL ? RADIANCE_PLANE : HBIL_PACKED_NORMAL;
  for (int i = 0; i < 2 * span; i += 16) {
#pragma unroll
    for (uint p = first; p < SPLIT_PLANES; ++p)
      FETCH_LINE(sample + p * plane + i);
  }
#endif
#endif
}

/* State of a half-slice. */
typedef struct march {
  realv excess;     /* the highest so far; FINITE: the least to count */
  realv a, g, sin2; /* integrals up to the present horizon; FINITE: over
                       what is still open */
#if HBAO
  realv blocked; /* sum of W dA */
#endif
#if FINITE
  uintv covered; /* sectors of equal A that are blocked */
#if EXTRAPOLATE
  uintv even, odd; /* by every other sample alone */
#endif
  realv sectors, sector; /* sectors per A, A of a sector */
#endif
#if GATHER_RADIANCE
  shine light; /* sum of L dA */
#endif
  realv unknown; /* sum of dA of refused samples */
} march;

#if FINITE
/* In PoCL popcount() of a vector becomes a loop over lanes. */
INLINE realv count_bits(uintv bits) {
#if HBIL_WIDTH == 1
  return TO_REALV(AS_INTV(popcount(bits)));
#else
  bits -= (bits >> 1) & 0x55555555u;
  bits = (bits & 0x33333333u) + ((bits >> 2) & 0x33333333u);
  bits = (bits + (bits >> 4)) & 0x0f0f0f0fu;
  return TO_REALV(AS_INTV((bits * 0x01010101u) >> 24));
#endif
}

/*
 * A sample that ends at its back covers the angles from its front to there,
 * both one line in inverse depth: theta in [theta_1, theta_b].  Sectors are
 * equal in A; their borders are dithered from layer to layer by `dither`.
 * Returns the A of newly covered sectors and takes it from what is open.
 */
INLINE realv cover(march *m, intv rises, realv cot_front, realv cot_back,
                   realv nx, realv ny, float dither, int halves) {
  const uintv one = 1u;
  realv g1, g2, sin1, sin2;
  horizon_terms(cot_front, &g1, &sin1);
  horizon_terms(cot_back, &g2, &sin2);
  const realv a1 = measure(cot_front, g1, sin1, nx, ny);
  const realv a2 = measure(cot_back, g2, sin2, nx, ny);
  const uintv first = AS_UINTV(TO_INTV(fma(a1, m->sectors, (realv)dither)));
  const uintv last = AS_UINTV(TO_INTV(fma(a2, m->sectors, (realv)dither)));
  const uintv hidden =
      ((one << last) - (one << first)) & AS_UINTV(LANE_MASK(rises));
  const uintv fresh = hidden & ~m->covered;
#if EXTRAPOLATE
  if (halves & HBIL_HALF_EVEN)
    m->even |= hidden;
  if (halves & HBIL_HALF_ODD)
    m->odd |= hidden;
#endif
  m->covered |= fresh;
  const realv share = count_bits(fresh) * m->sector;
  m->a = max(m->a - share, (realv)0.0f);
#if GATHER_BENT
  /* The interval's mean direction stands for its fresh part; below 1e-5 of A
   * the differences have no digits left in fp32. */
  const realv part = share / max(a2 - a1, (realv)1e-5f);
  m->g = fma(part, g1 - g2, m->g);
  m->sin2 = fma(part, sin1 - sin2, m->sin2);
#endif
  return share;
}

/* A sample's back is nearer to infinity by this share of its inverse depth: for
 * a depth greater by the factor 1 + d it is d / (1 + d).  FINITE: bit 0, d is
 * the relative thickness; bit 1, it is the thickness along the sample's ray.
 * Orthographic: by this much, for what a depth is a share of is the same
 * everywhere. */
INLINE realv back_share(const center *c, realv w1, global const hbil_step *step,
                        const hbil_gather_args args) {
#if ORTHOGRAPHIC
  return args.thickness;
#else
  realv d = args.relative_thickness;
#if FINITE & 2
  const realv rx = c->rx + step->ex, ry = c->ry + step->ey;
  const realv ray2 = fma(rx, rx, fma(ry, ry, (realv)1.0f));
  d = min(d, args.thickness * w1 / sqrt(ray2));
#endif
  return d / (1.0f + d);
#endif
}
#endif

/* What lengths are multiplied with where depths are inverted. */
INLINE realv unit_of(realv w) {
  return ORTHOGRAPHIC ? (realv)1.0f : w;
}

#if LIMITED || (GATHER_RADIANCE && !FACING_ALL)
/* (sample point - point) w1, from P = r z; returns its length squared.
 * Orthographic: without w1. */
INLINE realv way_to(const center *c, realv w1, global const hbil_step *step,
                    realv v[3]) {
  v[2] = (c->w - w1) * c->z;
  v[0] = fma(c->rx, v[2], (realv)step->ex);
  v[1] = fma((realv)c->ry, v[2], (realv)step->ey);
  return fma(v[0], v[0], fma(v[1], v[1], v[2] * v[2]));
}
#endif

#if LIMITED
/* The excess of a sample within the radius; beyond it there is nothing. */
INLINE realv within(const center *c, realv w1, global const hbil_step *step,
                    float radius, realv excess) {
  realv v[3];
  const realv limit = radius * unit_of(w1);
  return select((realv)HBIL_NOTHING, excess,
                way_to(c, w1, step, v) <= limit * limit);
}
#endif

#if GATHER_RADIANCE
/* Whether a sample that rises changes the sum of light.  What faces away can
 * stand for light that is unknown, whatever it sends itself. */
INLINE bool brings_light(const march *m, global const float *sample, uint plane,
                         intv rises) {
#if FALLBACK_FRAME_MEAN
  return true;
#else
  intv light = shining(sample, plane);
#if FALLBACK_LAST_ACCEPTED
  light |= shone(&m->light);
#endif
  return ANY(light & rises);
#endif
}
#endif

/* A pixel's part in one slice. */
typedef struct cut {
  realv u_wo, inv_ud, jacobian, slope, nx, cot;
  realv g, sin2; /* of the tangent plane on the side of u */
  realv open, whole, open_g, open_sin2; /* sums over both sides; g is negative
                                           along -u */
  realv red, green, blue, unknown;
} cut;

/* One side of it. */
typedef struct side_of {
  realv nx, cot_tangent, start_g, start;
} side_of;

/* A sample that raises the horizon in some lane, or the highest of several (for
 * which `step` and `sample` are not read: FINITE and HBAO need all): how much
 * of A it takes; below 0 where it isn't seen.  A lane that doesn't rise comes
 * to the same A again, bit by bit; its g and sin2 hold once some sample has
 * risen in it.  One that does may take nothing, to a rounding, and is the last
 * that was accepted all the same. */
INLINE realv raise(const center *c, const cut *s, const side_of *h, march *m,
                   realv excess, global const hbil_step *step,
                   global const float *sample, const hbil_gather_args args,
                   float dither) {
#if FINITE || (HBAO && LIMITED)
  const realv w1 = LOADV(sample);
#endif
#if FINITE
  const realv excess_back = max(
      fma(unit_of(w1) * step->inv_e, -back_share(c, w1, step, args), excess),
      (realv)0.0f);
  const realv share =
      cover(m, excess > m->excess, fma(s->slope, excess, h->cot_tangent),
            fma(s->slope, excess_back, h->cot_tangent), h->nx, c->cosine,
            dither, step->halves);
  /* what covers nothing new is not seen */
  const intv seen = share > 0.0f;
#else
  const intv seen = excess > m->excess;
  const realv highest = max(m->excess, excess);
  const realv cot = fma(s->slope, highest, h->cot_tangent);
  realv g, sin2;
  horizon_terms(cot, &g, &sin2);
  const realv a = select(m->a, measure(cot, g, sin2, h->nx, c->cosine),
                         highest > c->least_excess);
  const realv share = max(m->a - a, (realv)0.0f);
  m->excess = highest;
  m->a = a;
#if GATHER_BENT
  m->g = g;
  m->sin2 = sin2;
#endif
#endif
#if HBAO && LIMITED
  /* lanes of "nothing there" overflow: no share of infinity */
  realv v[3];
  const realv weight = max(fma(sqrt(way_to(c, w1, step, v)) / unit_of(w1),
                               (realv)-args.falloff, (realv)1.0f),
                           (realv)0.0f);
  m->blocked =
      fma(share, select((realv)0.0f, weight, share > 0.0f), m->blocked);
#elif HBAO
  m->blocked += share;
#endif
  return select((realv)-1.0f, share, seen);
}

#if GATHER_RADIANCE
/* How much of its light a sample sends where it has taken `share` of A. */
INLINE realv accepted(const center *c, realv share,
                      global const hbil_step *step, global const float *sample,
                      uint plane, const hbil_gather_args args) {
#if FACING_ALL
  return (realv)1.0f;
#else
  const intv seen = share >= 0.0f;
  /* Cosine of the sample's normal with the way back to the center. */
  realv v[3], normal[3];
  const realv v2 = way_to(c, LOADV(sample), step, v);
#if PACKED
  unpack_direction(LOAD_WORDS(sample + HBIL_PACKED_NORMAL * plane), normal);
  const realv length2 =
      v2 * fma(normal[0], normal[0],
               fma(normal[1], normal[1], normal[2] * normal[2]));
#else
  split_normal(sample, plane, normal);
  const realv length2 = v2;
#endif
  const realv away =
      fma(v[0], normal[0], fma(v[1], normal[1], v[2] * normal[2]));
  const realv cosine = -away * inv_sqrt(length2);
#if FACING_STEP
  return select((realv)0.0f, (realv)1.0f, (cosine >= args.facing[0]) & seen);
#else
  const realv t = clamp((cosine - args.facing[0]) * args.facing[1], 0.0f, 1.0f);
  return select((realv)0.0f, t * t * fma((realv)-2.0f, t, (realv)3.0f), seen);
#endif
#endif
}

/* The light of a sample that has taken `share` of A where it is seen. */
INLINE void add_light(const center *c, march *m, realv share,
                      global const hbil_step *step, global const float *sample,
                      uint plane, const hbil_gather_args args, int light_here,
                      factors *kept) {
  if (light_here == LIGHT_SOME &&
      !brings_light(m, sample, plane, share >= 0.0f))
    return;
  const realv accept = accepted(c, share, step, sample, plane, args);
#if KEEP_FACTORS
  const bool counts =
      ANY(FALLBACK_LAST_ACCEPTED ? share >= 0.0f : share * accept > 0.0f);
#endif
  /* what isn't seen has no share, and is not accepted */
  share = max(share, (realv)0.0f);
#if FALLBACK_FRAME_MEAN
  m->unknown = fma(share, 1.0f - accept, m->unknown);
#endif
#if !FALLBACK_LAST_ACCEPTED
  share *= accept;
#endif
  add_radiance(&m->light, share, accept, sample, plane);
#if KEEP_FACTORS
  if (counts)
    keep_sample(kept, step->offset, share, accept);
#endif
}
#endif

#if MAY_BE_DARK && !FALLBACK_FRAME_MEAN
/* Of a vector whose hits in a block bring no light the highest alone matters:
 * raises it, takes them off the list and returns how many are left on it. */
INLINE uint leave_dark(const center *c, const cut *s, const side_of *h,
                       march *m, const realv *top, uchar *hit, uint hits,
                       global const hbil_step *steps, global const float *from,
                       uint plane, const hbil_gather_args args) {
  uint lit = 0u, dark = 0u, left = 0u;
#if FALLBACK_LAST_ACCEPTED
  for (uint v = 0u; v < SPAN_VECTORS; ++v)
    if (ANY(shone(&m[v].light)))
      lit |= 1u << v;
#endif
  for (uint i = 0u; i < hits; ++i) {
    const uint entry = HIT(hit, i), v = entry % SPAN_VECTORS;
    if (!(lit >> v & 1u) &&
        ANY(shining(from + v * HBIL_WIDTH + steps[entry / SPAN_VECTORS].offset,
                    plane)))
      lit |= 1u << v;
  }
  for (uint i = 0u; i < hits; ++i) {
    const uint entry = HIT(hit, i), v = entry % SPAN_VECTORS;
    if (lit >> v & 1u)
      hit[left++] = (uchar)entry;
    else
      dark |= 1u << v;
  }
  for (uint v = 0u; v < SPAN_VECTORS; ++v)
    if (dark >> v & 1u)
      raise(&c[v], &s[v], &h[v], &m[v], top[v], steps, from, args, 0.0f);
  return left;
}
#endif

/* Whether nothing can be met from this sample on: offsets only grow, past the
 * border and beyond what is in reach. */
INLINE bool is_beyond(const hbil_gather_args args, global const hbil_step *step,
                      int x, int y, float reach) {
  const hbil_layer_args in = args.split;
  const uint columns = (uint)in.width + (SPAN_VECTORS * HBIL_WIDTH - 1);
#if LIMITED && SKIP_RADIUS
  if (step->inv_e * reach < 1.0f)
    return true;
#endif
  return (uint)(y + step->dy) >= (uint)in.height ||
         (uint)(x + step->dx + (SPAN_VECTORS * HBIL_WIDTH - 1)) >= columns;
}

/* How far a sample stands above the tangent plane. */
INLINE realv excess_of(const hbil_gather_args args, const center *c,
                       global const hbil_step *step,
                       global const float *sample) {
  const realv w1 = LOADV(sample);
  const realv inv_e = step->inv_e, keep = args.keep;
  const realv e_x = step->ux, e_y = step->uy;
  /* the difference first: it loses no digits (Sterbenz) where w1 is near w,
   * and products of both would */
  const realv e =
      fma(fma(w1, keep, -c->w), inv_e, -fma(c->gx, e_x, c->gy * e_y));
#if LIMITED
  return within(c, w1, step, args.radius, e);
#else
  return e;
#endif
}

/* Looks at `count` samples, or those before the border and the end of the
 * reach: their excesses; which of them rise in some lane of a vector, `hits`
 * places of `hit`; the highest.  Returns how many there are. */
INLINE int look(const hbil_gather_args args, const center *c,
                global const hbil_step *steps, int count,
                global const float *from, uint plane, int x, int y, float reach,
                realv (*excess)[SPAN_VECTORS], uchar *hit, uint *hits,
                realv *top) {
  int k = 0;
  *hits = 0u;
  for (; k < count && !is_beyond(args, steps + k, x, y, reach); ++k) {
    global const hbil_step *step = steps + k;
    global const float *sample = from + step->offset;
    fetch_early(sample, plane, args.split.row);
#pragma unroll
    for (int v = 0; v < SPAN_VECTORS; ++v) {
      const realv e = excess_of(args, &c[v], step, sample + v * HBIL_WIDTH);
#if SHARES || EXTRAPOLATE
      excess[k][v] = e;
#endif
#if SHARES
      hit[*hits] = (uchar)(k * SPAN_VECTORS + v);
      *hits += ANY(e > top[v]);
#endif
#if !FINITE
      top[v] = max(top[v], e);
#endif
    }
  }
  return k;
}

#if MAY_BE_DARK
/* Of a half-slice that brings no light the highest sample alone matters: raises
 * all vectors to it.  even, odd: the highest of every other sample. */
INLINE void raise_to_highest(const hbil_gather_args args, const center *c,
                             const cut *s, const side_of *h, march *m,
                             global const hbil_step *steps, int count,
                             global const float *from, int x, int y,
                             float reach, realv *top, realv *even, realv *odd) {
  for (int k = 0; k < count && !is_beyond(args, steps + k, x, y, reach); ++k) {
    global const hbil_step *step = steps + k;
    global const float *sample = from + step->offset;
    fetch_early(sample, 0u, args.split.row); /* without light or normals */
#pragma unroll
    for (int v = 0; v < SPAN_VECTORS; ++v) {
      const realv e = excess_of(args, &c[v], step, sample + v * HBIL_WIDTH);
#if EXTRAPOLATE
      if (step->halves & HBIL_HALF_EVEN)
        even[v] = max(even[v], e);
      if (step->halves & HBIL_HALF_ODD)
        odd[v] = max(odd[v], e);
#endif
      top[v] = max(top[v], e);
    }
  }
  for (int v = 0; v < SPAN_VECTORS; ++v)
    if (ANY(top[v] > m[v].excess))
      raise(&c[v], &s[v], &h[v], &m[v], top[v], steps, from, args, 0.0f);
}
#endif

/* Sums of a pixel over its half-slices: J A at the horizon and at the tangent
 * plane, the same of b, b in the slice's u and along wo; J times light. */
typedef struct total {
  realv open, whole;
  realv open_x, open_y, open_wo;
  realv whole_x, whole_y, whole_wo;
  realv red, green, blue, unknown;
} total;

INLINE center center_of(const hbil_gather_args args, global const float *here,
                        int x, int y, int layer) {
  const hbil_layer_args in = args.split;
  center c;
  c.w = LOADV(here);
  realv n[3];
  split_normal(here, in.plane, n);
  c.nx = n[0];
  c.ny = n[1];
  c.nz = n[2];
  c.own[0] = c.own[1] = c.own[2] = 0.0f; /* of spans that look for none */
  c.rx = ray_x(args.view, 4 * x + (layer & 3), 4);
  c.ry = ray_y(args.view, 4 * y + (layer >> 2));
  c.z = 1.0f / unit_of(c.w);
  c.r = sqrt(fma(c.rx, c.rx, (realv)fma(c.ry, c.ry, 1.0f)));
  c.inv_r = 1.0f / c.r;
  /* Inverse depth on the plane through P is (n.r') / (n.P); orthographic,
   * -z changes by n.e / n_z. */
  const realv n_r = select(
      (realv)-1.0f, fma(c.nx, c.rx, fma(c.ny, (realv)c.ry, c.nz)), c.w > SKY);
  const realv n_p = unit_of(c.w) / n_r;
  c.gx = c.nx * n_p;
  c.gy = c.ny * n_p;
  c.cosine = -n_r * c.inv_r;
  c.inv_cosine = 1.0f / c.cosine;
  /* A normal rounded to `flat` shifts the plane's gradient by this much at
   * most: below it, samples of the pixel's own plane would rise.  Above the
   * sky nothing does: no excess is as large. */
  c.least_excess =
      select((realv)1e38f,
             args.flat * unit_of(c.w) * c.inv_r * c.inv_cosine * c.inv_cosine,
             c.w > SKY);
  return c;
}

/* What a span of pixels has in common. */
typedef struct span {
  float nearest; /* largest inverse depth */
  /* the centre, and how far pixels are from it at most, in ray slope */
  float x, y, half_width;
  /* how far anything lies that can matter, in ray slope; unlimited: 1e30 */
  float reach;
  /* the tangent planes: inverse depth at the centre, at least; gradient; least
   * excess */
  float w, gx[2], gy[2], least_excess;
  /* more than roundings can have added to a plane's inverse depth */
  float rounding;
} span;

#if LIMITED
/* Of the tile that holds layer pixel x, the largest inverse depth. */
INLINE float nearest_of(const center *c, global const float *row, int x) {
  row += x / HBIL_SPAN * HBIL_SPAN;
  realv nearest = LOADV(row);
  for (int i = HBIL_WIDTH; i < HBIL_SPAN; i += HBIL_WIDTH)
    nearest = max(nearest, LOADV(row + i));
  return lanes_max(nearest);
}
#else
INLINE float nearest_of(const center *c, global const float *row, int x) {
  realv nearest = c[0].w;
  for (int v = 1; v < SPAN_VECTORS; ++v)
    nearest = max(nearest, c[v].w);
  return lanes_max(nearest);
}
#endif

/* Where vector v of the span lies in the picture's plane. */
INLINE realv place_of(const hbil_gather_args args, int x, int layer, int v) {
  return plane_x(args.view, 4 * (x + v * HBIL_WIDTH) + (layer & 3), 4);
}

INLINE span span_of(const hbil_gather_args args, float nearest, int x, int y,
                    int layer) {
  span s;
  const float first = lanes_min(place_of(args, x, layer, 0));
  const float last = lanes_max(place_of(args, x, layer, SPAN_VECTORS - 1));
  s.nearest = nearest;
  s.x = 0.5f * (first + last);
  s.y = plane_y(args.view, 4 * y + (layer >> 2));
  s.half_width = last - s.x;
#if LIMITED
  /* A point on the ray r0 + e is at least z0 |r0 x e| / |r0 + e| away, and that
   * is at least z0 |e| / |longest ray|; orthographic, |e|.  A thousandth for
   * roundings. */
  s.reach =
      1.001f * args.radius * (ORTHOGRAPHIC ? 1.0f : nearest * args.longest);
#else
  s.reach = 1e30f;
#endif
  return s;
}

#if SKIP_OPEN
/* A plane is w_p + g.(q - r_p) at the ray q: from the span's centre on the
 * lowest of all is bounded by its value there and the ranges of g.  Four
 * roundings of 2^-24 make the value there, and each product with g has one,
 * over twice the image's width at most; no gradient, none of them. */
INLINE void bound_planes(const hbil_gather_args args, const center *c, span *s,
                         int x, int layer) {
  const float most = HBIL_NOTHING;
  realv w = -most, least = -most, size = 0.0f;
  realv gx[2] = {-most, most}, gy[2] = {-most, most};
  for (int v = 0; v < SPAN_VECTORS; ++v) {
    const intv solid = c[v].w > SKY;
    const realv at = fma(c[v].gx, s->x - place_of(args, x, layer, v), c[v].w);
#if ORTHOGRAPHIC
    size = max(size, select((realv)0.0f, fabs(c[v].w), solid));
#endif
    w = min(w, select((realv)-most, at, solid));
    least = min(least, select((realv)-most, c[v].least_excess, solid));
    gx[0] = min(gx[0], select((realv)-most, c[v].gx, solid));
    gx[1] = max(gx[1], select((realv)most, c[v].gx, solid));
    gy[0] = min(gy[0], select((realv)-most, c[v].gy, solid));
    gy[1] = max(gy[1], select((realv)most, c[v].gy, solid));
  }
  s->w = lanes_min(w);
  s->least_excess = lanes_min(least);
  s->gx[0] = lanes_min(gx[0]);
  s->gx[1] = lanes_max(gx[1]);
  s->gy[0] = lanes_min(gy[0]);
  s->gy[1] = lanes_max(gy[1]);
  const float across = max(fabs(s->gx[0]), fabs(s->gx[1]));
  const float down = max(fabs(s->gy[0]), fabs(s->gy[1]));
  s->rounding = 0x1p-20f * fma(across, args.longest, down * args.longest);
  if (across > 0.0f || down > 0.0f)
    s->rounding =
        fma(0x1p-21f, ORTHOGRAPHIC ? lanes_max(size) : s->nearest, s->rounding);
}

/* Whether something in cell (i, j) of `size` pixels, the nearest of which is
 * `w`, may stand above a tangent plane of the span. */
INLINE bool may_rise(const hbil_gather_args args, const span *s, int i, int j,
                     int size, float w) {
  const hbil_view_args v = args.view;
  const int right = min((i + 1) * size, v.width) - 1;
  const int bottom = min((j + 1) * size, v.height) - 1;
  const float x0 = ((float)(i * size) + 0.5f - v.cx) * v.inv_fx - s->x;
  const float x1 = ((float)right + 0.5f - v.cx) * v.inv_fx - s->x;
  const float y0 = plane_y(v, j * size) - s->y;
  const float y1 = plane_y(v, bottom) - s->y;
  const float far_x = max(max(x0, -x1) - s->half_width, 0.0f);
  const float far_y = max(max(y0, -y1), 0.0f);
  const float away = max(far_x, far_y);
  if (away > s->reach)
    return false;
  const float gx =
      min(min(s->gx[0] * x0, s->gx[0] * x1), min(s->gx[1] * x0, s->gx[1] * x1));
  const float gy =
      min(min(s->gy[0] * y0, s->gy[0] * y1), min(s->gy[1] * y0, s->gy[1] * y1));
  const float plane = fma(s->least_excess, away, s->w + gx + gy);
  return w * args.keep > plane - s->rounding;
}

/* Cell (i, j), as the bounds have it. */
INLINE bool cell_may_rise(const hbil_gather_args args, const span *s, int i,
                          int j, global const uint *bounds) {
  const hbil_grid_args g = args.bounds.cell;
  const uint at = g.offset + 2u * (uint)(j * g.width + i);
  return may_rise(args, s, i, j, HBIL_CELL * HBIL_SIDE, as_float(bounds[at]));
}

/* Whether anything may stand above a tangent plane of the span: its own cell,
 * which settles nearly all that is not even; the whole picture; its blocks,
 * from the span's own on, since what is near stands out most, and the cells of
 * those that fail. */
INLINE bool any_may_rise(const hbil_gather_args args, const span *s, int own_x,
                         int own_y, global const uint *bounds) {
  const hbil_bounds_args b = args.bounds;
  const int block = HBIL_CELL * HBIL_SIDE * HBIL_BLOCK;
  if (cell_may_rise(args, s, own_x, own_y, bounds))
    return true;
  const int whole = max(args.view.width, args.view.height);
  if (!may_rise(args, s, 0, 0, whole, as_float(bounds[b.whole.offset])))
    return false;
  const int blocks = b.block.width * b.block.height;
  const int own = own_y / HBIL_BLOCK * b.block.width + own_x / HBIL_BLOCK;
  for (int k = 0; k < blocks; ++k) {
    const int at = own + k < blocks ? own + k : own + k - blocks;
    const int i = at % b.block.width, j = at / b.block.width;
    if (!may_rise(args, s, i, j, block,
                  as_float(bounds[b.block.offset + 2u * (uint)at])))
      continue;
    const int right = min((i + 1) * HBIL_BLOCK, b.cell.width);
    const int bottom = min((j + 1) * HBIL_BLOCK, b.cell.height);
    for (int y = j * HBIL_BLOCK; y < bottom; ++y)
      for (int x = i * HBIL_BLOCK; x < right; ++x)
        if (cell_may_rise(args, s, x, y, bounds))
          return true;
  }
  return false;
}
#endif

#if SKIP_DARK && GATHER_RADIANCE
/* The light in the reach of the span at (x, y), which is in two cells and in
 * one block; cells, or blocks where those are many. */
INLINE lights light_in_reach(const hbil_gather_args args, const span *s, int x,
                             int y, global const uint *bounds) {
  uint light = bounds[args.bounds.whole.offset + 1u];
  uint quadrants = HBIL_ALL_QUADRANTS;
#if LIMITED && !FALLBACK_FRAME_MEAN
  const hbil_view_args v = args.view;
  const float wide = (s->reach + s->half_width) * v.fx, high = s->reach * v.fy;
  const bool cells = max(wide, high) < (float)(HBIL_CELL * HBIL_SIDE * 2);
  const hbil_grid_args g = cells ? args.bounds.cell : args.bounds.block;
  const float size = (float)(HBIL_CELL * HBIL_SIDE * (cells ? 1 : HBIL_BLOCK));
  const float cx = fma(s->x, v.fx, v.cx), cy = fma(s->y, v.fy, v.cy);
  /* a pixel more on each side: samples are rounded to pixels */
  const int x0 = convert_int(max((cx - wide - 1.0f) / size, 0.0f));
  const int y0 = convert_int(max((cy - high - 1.0f) / size, 0.0f));
  const int x1 =
      convert_int(min((cx + wide + 1.0f) / size, (float)(g.width - 1)));
  const int y1 =
      convert_int(min((cy + high + 1.0f) / size, (float)(g.height - 1)));
  const int own = HBIL_CELL * (cells ? 1 : HBIL_BLOCK);
  const int left = x / own, right = (x + SPAN_VECTORS * HBIL_WIDTH - 1) / own;
  light = quadrants = 0u;
  for (int j = y0; j <= y1; ++j)
    for (int i = x0; i <= x1; ++i) {
      const uint here = bounds[g.offset + 2u * (uint)(j * g.width + i) + 1u];
      light |= here;
      if (here & HBIL_SOME_LIT)
        quadrants |= hbil_quadrants(left, y / own, i, j) |
                     hbil_quadrants(right, y / own, i, j);
    }
#elif !FALLBACK_FRAME_MEAN
  const int own = HBIL_CELL * HBIL_BLOCK;
  if (light & HBIL_SOME_DARK)
    quadrants = bounds[args.bounds.quadrants +
                       (uint)(y / own * args.bounds.block.width + x / own)];
#endif
  const lights found = {!(light & HBIL_SOME_LIT)   ? LIGHT_NONE
                        : (light & HBIL_SOME_DARK) ? LIGHT_SOME
                                                   : LIGHT_ALL,
                        quadrants};
  return found;
}
#endif

#if SKIP_UNUSED
/* Whether the picture has a use for light at a pixel of this span, or at one
 * whose filter reads it: up to 2 pixels away.  split.cl writes `uses`, a word
 * for 4 HBIL_WIDTH pixels of a row. */
INLINE bool is_used(const hbil_gather_args args, global const uint *uses, int x,
                    int y, int layer) {
  const int group = 4 * HBIL_WIDTH;
  const int across = (args.view.width + group - 1) / group;
  const int px = 4 * x + (layer & 3), py = 4 * y + (layer >> 2);
  const int first = max(px - 2, 0) / group;
  const int last =
      min((px + 4 * (SPAN_VECTORS * HBIL_WIDTH - 1) + 2) / group, across - 1);
  uint used = 0u;
  for (int j = max(py - 2, 0); j <= min(py + 2, args.view.height - 1); ++j)
    for (int i = first; i <= last; ++i)
      used |= uses[j * across + i];
  return used != 0u;
}
#endif

INLINE cut cut_of(const center *c, float ux, float uy) {
  cut s;
  s.u_wo = -(ux * c->rx + uy * c->ry) * c->inv_r;
  s.inv_ud = 1.0f / sqrt(fma(-s.u_wo, s.u_wo, (realv)1.0f));
  s.jacobian = c->inv_r * s.inv_ud * s.inv_ud;
  s.slope = c->r * c->z * s.inv_ud;
  const realv n_u = fma(c->nx, (realv)ux, c->ny * uy);
  s.nx = fma(-s.u_wo, c->cosine, n_u) * s.inv_ud;
  s.cot = -s.nx * c->inv_cosine;
  horizon_terms(s.cot, &s.g, &s.sin2);
  s.open = s.whole = s.open_g = s.open_sin2 = 0.0f;
  s.red = s.green = s.blue = s.unknown = 0.0f;
  return s;
}

#if EXTRAPOLATE
/*
 * Between samples there are occluders that none of them meets.  Half of the
 * samples would miss about twice as much, so what they miss is an estimate of
 * what all miss: the jackknife (Quenouille 1956), with a sample in both halves
 * where no pixel is missed around it (hbil_sample_halves()).  The even samples
 * and the odd ones leave open a_0 and a_1, all of them a; then
 *   a + (a - (a_0 + a_1) / 2)
 * is left open, at least nothing.  Directions and light stay what they are, so
 * sums over what is blocked grow with its measure, by `more`, and those over
 * what is open become `less`: factors, which are 1 where the halves agree,
 * since a quotient of equals need not be 1 in relaxed arithmetic.
 */
#if FINITE
/* In halves of sectors: whole numbers, which no order of operations rounds. */
INLINE void extrapolate(const march *m, realv *more, realv *less) {
  const realv all = 2 * HBIL_SECTORS, blocked = count_bits(m->covered);
  const realv open = all - 2.0f * blocked;
  const realv halves = count_bits(m->even) + count_bits(m->odd);
  const realv left = max(all - 4.0f * blocked + halves, (realv)0.0f);
  const intv fewer = left < open;
  *more = select((realv)1.0f, (all - left) / (2.0f * blocked), fewer);
  *less = select((realv)1.0f, left / open, fewer);
}
#else
/* One half has the highest sample, and leaves open what all do; the highest of
 * the other has excess `second`. */
INLINE void extrapolate(const center *c, const cut *s, const side_of *h,
                        const march *m, realv highest, realv second,
                        realv *more, realv *less) {
  realv g, sin2;
  const realv cot = fma(s->slope, second, h->cot_tangent);
  horizon_terms(cot, &g, &sin2);
  /* a rounding above the start, beside a horizon that is the start to the last
   * digit, would be infinitely more */
  const realv half_open =
      select(h->start, min(measure(cot, g, sin2, h->nx, c->cosine), h->start),
             second > c->least_excess);
  const realv a = max(fma((realv)-0.5f, half_open - m->a, m->a), (realv)0.0f);
  const intv fewer = (second < highest) & (a < m->a);
  *more = select((realv)1.0f, (h->start - a) / (h->start - m->a), fewer);
  *less = select((realv)1.0f, a / m->a, fewer);
}
#endif
#endif

/* Adds a side; `sign` is that of g.  All operations are fused: what a compiler
 * may do with others depends on what is around them. */
INLINE void add_side(cut *s, const march *m, realv whole, realv more,
                     realv less, float sign) {
  s->whole += whole;
  s->open = fma(less, m->a, s->open);
#if GATHER_BENT
  s->open_g = fma(less * sign, m->g, s->open_g);
  s->open_sin2 = fma(less, m->sin2, s->open_sin2);
#endif
#if GATHER_RADIANCE
  s->red = fma(more, m->light.red, s->red);
  s->green = fma(more, m->light.green, s->green);
  s->blue = fma(more, m->light.blue, s->blue);
#if FALLBACK_FRAME_MEAN
  s->unknown = fma(more, m->unknown, s->unknown);
#endif
#endif
}

/* What the two sides of a slice have come to. */
INLINE void add_slice(total *t, const cut *s, float ux, float uy) {
  t->open = fma(s->jacobian, s->open, t->open);
  t->whole = fma(s->jacobian, s->whole, t->whole);
#if GATHER_BENT
  const realv scale = 0.5f * s->jacobian;
  const realv open_u = scale * s->inv_ud * s->open_g;
  t->open_x = fma(open_u, (realv)ux, t->open_x);
  t->open_y = fma(open_u, (realv)uy, t->open_y);
  t->open_wo = fma(scale, s->open_sin2, fma(-open_u, s->u_wo, t->open_wo));
  const realv whole_u = scale * s->inv_ud * fma((realv)2.0f, s->g, (realv)-PI);
  t->whole_x = fma(whole_u, (realv)ux, t->whole_x);
  t->whole_y = fma(whole_u, (realv)uy, t->whole_y);
  t->whole_wo = fma(s->jacobian, s->sin2, fma(-whole_u, s->u_wo, t->whole_wo));
#endif
#if GATHER_RADIANCE
  t->red = fma(s->jacobian, s->red, t->red);
  t->green = fma(s->jacobian, s->green, t->green);
  t->blue = fma(s->jacobian, s->blue, t->blue);
#if FALLBACK_FRAME_MEAN
  t->unknown = fma(s->jacobian, s->unknown, t->unknown);
#endif
#endif
}

/* untouched: nothing stood above the tangent plane.  Then AO is 1, E_near 0 and
 * the bent normal n, which sums and their quotients are only to a rounding. */
INLINE void store_light(const center *c, const total *t, intv untouched,
                        float slices, int layer, global float *light,
                        uint plane, factors *kept) {
  const intv solid = c->w > SKY, taken = solid & ~untouched;
  /* whole is S at least in the mean; it falls to the size of a half-slice's
   * own rounding only where nothing can be seen (1e-6 of a slice). */
  const realv least_whole = max(t->whole, (realv)1e-6f);
  const realv inv_whole = 1.0f / least_whole;
  realv value[HBIL_GATHERED_PLANES];
#if WEIGHT_PLANE
  value[HBIL_LIGHT_WEIGHT] =
      slices > 1.0f ? (realv)1.0f : select((realv)1.0f, least_whole, solid);
#endif
  value[HBIL_LIGHT_AO] = select(
      (realv)1.0f, clamp(t->open * inv_whole, (realv)0.0f, (realv)1.0f), taken);
#if GATHER_RADIANCE
  const realv scale = select((realv)0.0f, PI * inv_whole, taken);
#if KEEP_FACTORS
  keep_factor(kept, scale);
#endif
  value[HBIL_LIGHT_RED] = t->red * scale;
  value[HBIL_LIGHT_RED + 1] = t->green * scale;
  value[HBIL_LIGHT_RED + 2] = t->blue * scale;
#endif
#if FALLBACK_FRAME_MEAN
  value[HBIL_LIGHT_UNKNOWN] =
      select((realv)0.0f, t->unknown * inv_whole, taken);
#endif
#if GATHER_BENT
  /* Few slices miss the full hemisphere's S n by whole_*; adding what is
   * missing in the measure of what is open makes a bare plane's bent normal
   * exactly n and leaves a closed point alone. */
  const realv ao = value[HBIL_LIGHT_AO];
  const realv wo_sum = fma(-ao, t->whole_wo, t->open_wo) * c->inv_r;
  const realv x =
      t->open_x + ao * fma((realv)slices, c->nx, -t->whole_x) - wo_sum * c->rx;
  const realv y =
      t->open_y + ao * fma((realv)slices, c->ny, -t->whole_y) - wo_sum * c->ry;
  const realv z = ao * slices * c->nz - wo_sum;
  const realv one = select((realv)0.0f, (realv)(1.0f / slices), solid);
  const realv bare = select((realv)0.0f, (realv)1.0f, solid);
  value[HBIL_LIGHT_BENT] = select(c->nx * bare, x * one, taken);
  value[HBIL_LIGHT_BENT + 1] = select(c->ny * bare, y * one, taken);
  value[HBIL_LIGHT_BENT + 2] = select(c->nz * bare, z * one, taken);
#endif
  store_gathered(value, layer, light, plane);
}

/* What the span has no need of. */
INLINE uint spared_of(const hbil_gather_args args, const center *c, span *s,
                      bool solid, global const uint *bounds,
                      global const uint *uses, int x, int y, int layer,
                      lights *found) {
#if SKIP_SKY
  if (!solid)
    return HBIL_SPAN_SKY;
#endif
#if SKIP_UNUSED
  if (!is_used(args, uses, x, y, layer))
    return HBIL_SPAN_UNUSED;
#endif
#if SKIP_OPEN
  bound_planes(args, c, s, x, layer);
  if (!any_may_rise(args, s, x / HBIL_CELL, y / HBIL_CELL, bounds))
    return HBIL_SPAN_OPEN;
#endif
#if SKIP_DARK && GATHER_RADIANCE
  if (ADAPTIVE && args.dark)
    found->how_much = LIGHT_NONE;
  else
    *found = light_in_reach(args, s, x, y, bounds);
#endif
  return found->how_much == LIGHT_NONE ? HBIL_SPAN_DARK : 0u;
}

/* Pixels of the span that show no surface. */
INLINE uint count_sky(const center *c) {
  uint sky = 0u;
  for (int v = 0; v < SPAN_VECTORS; ++v) {
    float lane[HBIL_WIDTH];
    STOREV(c[v].w, lane);
    for (int i = 0; i < HBIL_WIDTH; ++i)
      sky += lane[i] <= SKY;
  }
  return sky;
}

#if ADAPTIVE
/* Where the launch's span lies whose place in the row of those that are
 * measured is x; false where there is none, or nothing to measure any more. */
INLINE bool measured_span(const hbil_gather_args args, global const uint *tried,
                          int *x, int *y) {
  const int tile = *x / HBIL_SPAN, within = *x % HBIL_SPAN;
  const int measures = args.measures;
  if (tile >= args.tiles || *y > 0 ||
      (measures < HBIL_MOST_RUNGS && good_rung(tried, measures) < measures))
    return false;
  hbil_measured_tile(tile, args.tiles, hbil_spans(args.split.width),
                     args.split.height, x, y);
  *x = *x * HBIL_SPAN + within;
  return true;
}
#endif

kernel void gather(const hbil_gather_args args, global const float *split,
                   global const hbil_step *steps, global float *light,
                   global const uint *bounds, global const uint *uses,
                   global uchar *spans, global const uint *flags,
                   const int still, global const hbil_rung *ladder,
                   global const uint *tried
#if KEEP_FACTORS
                   ,
                   const hbil_factor_args factor_args, global float *all_kept
#endif
) {
  const hbil_layer_args in = args.split;
  int x = (int)get_global_id(0) * (SPAN_VECTORS * HBIL_WIDTH);
  int y = (int)get_global_id(1);
  const int layer = (int)get_global_id(2);
#if ADAPTIVE
  int chosen = args.measures;
  if (chosen < 0)
    chosen = good_rung(tried, args.rungs - 1);
  else if (!measured_span(args, tried, &x, &y))
    return;
#endif
  if (x >= in.width || y >= in.height || (still && !flags[HBIL_FLAG_CHANGED]))
    return;
#if KEEP_FACTORS
  if ((uint)y >= factor_args.rows)
    return;
#endif
  const uint at = (uint)layer * in.layer + in.origin + (uint)y * in.row;
  global const float *here = split + at + (uint)x;
  global const float *from = split + (uint)y * in.row + (uint)x;
  light += (uint)layer * args.light.layer + args.light.origin +
           (uint)y * args.light.row + (uint)x;

#if ADAPTIVE
  const hbil_rung rung = ladder[chosen];
  const int samples = rung.samples, all_slices = rung.slices;
  steps += rung.steps;
#else
  const int samples = args.samples, all_slices = args.slices;
#endif
  const uint pattern = 2u * (uint)all_slices * (uint)(samples + 1);
  steps += (uint)layer * pattern;
  const float dither = ((float)hbil_shift_slot(layer) + 0.5f) / 16.0f;

  center c[SPAN_VECTORS];
  total t[SPAN_VECTORS];
  intv solid = 0, sky = 0, untouched[SPAN_VECTORS];
  for (int v = 0; v < SPAN_VECTORS; ++v) {
    const total nothing = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f,
                           0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    c[v] = center_of(args, here + v * HBIL_WIDTH, x + v * HBIL_WIDTH, y, layer);
    t[v] = nothing;
    untouched[v] = TRUE_LANES;
    solid |= c[v].w > SKY;
    sky |= c[v].w <= SKY;
  }
  const float nearest = nearest_of(c, split + at, x);
  span whole = span_of(args, nearest, x, y, layer);
#if LIMITED
  steps += (uint)(hbil_level(args.reach,
                             ORTHOGRAPHIC ? args.radius : args.radius * nearest,
                             LEVELS) *
                  HBIL_LAYERS) *
           pattern;
#endif
  lights light_found = {LIGHT_ALL, HBIL_ALL_QUADRANTS};
  const uint spared = spared_of(args, c, &whole, ANY(solid), bounds, uses, x, y,
                                layer, &light_found);
  const int light_here = light_found.how_much;
  /* without light, what is asked for early is what is there already: a branch
   * on the way costs more */
  const uint plane = light_here == LIGHT_NONE ? 0u : in.plane;
#if MAY_BE_DARK
  const uint lit = light_here == LIGHT_NONE ? 0u : light_found.quadrants;
#endif
  /* for hbil_plan_statistics() */
  const uint span_x = (uint)(x / (SPAN_VECTORS * HBIL_WIDTH));
  const uint place = (uint)(layer * in.height + y) * args.spans + span_x;
  factors kept[SPAN_VECTORS];
#if KEEP_FACTORS
  for (uint v = 0u; v < SPAN_VECTORS; ++v)
    kept[v] =
        factors_of(factor_args, all_kept,
                   first_vector(factor_args, args.spans, layer, y, span_x) + v);
#endif
  spans += place;
  spans[0] = (uchar)spared;
  spans[(uint)(HBIL_LAYERS * in.height) * args.spans] =
      (uchar)(ANY(sky) ? count_sky(c) : 0u);
  const int spares_all = spared & ~HBIL_SPAN_DARK;
#if GATHER_RADIANCE && FALLBACK_LAST_ACCEPTED
  if (!spares_all)
    for (int v = 0; v < SPAN_VECTORS; ++v)
      split_radiance(here + v * HBIL_WIDTH, in.plane, c[v].own);
#endif
#if WEIGHT_PLANE
  /* the slice is weighed all the same, where there is a surface */
  const int slices = spares_all & HBIL_SPAN_SKY ? 0 : all_slices;
  const int looked_at = spares_all ? 0 : samples;
#else
  const int slices = spares_all ? 0 : all_slices, looked_at = samples;
#endif
  for (int slice = 0; slice < slices; ++slice) {
    const float ux = steps->ux, uy = steps->uy;
    cut s[SPAN_VECTORS];
    march m[SPAN_VECTORS];
    for (int v = 0; v < SPAN_VECTORS; ++v) {
      s[v] = cut_of(&c[v], ux, uy);
    }
    for (int side = 0; side < 2; ++side) {
      side_of half_slice[SPAN_VECTORS];
      realv top[SPAN_VECTORS];
      realv even[SPAN_VECTORS],
          odd[SPAN_VECTORS]; /* the highest of every other sample */
      for (int v = 0; v < SPAN_VECTORS; ++v) {
        side_of *h = &half_slice[v];
        h->nx = side ? -s[v].nx : s[v].nx;
        h->cot_tangent = side ? -s[v].cot : s[v].cot;
        h->start_g = side ? PI - s[v].g : s[v].g;
        h->start =
            measure(h->cot_tangent, h->start_g, s[v].sin2, h->nx, c[v].cosine);
        m[v].a = h->start;
        m[v].excess = top[v] = c[v].least_excess;
#if GATHER_RADIANCE
        m[v].light = no_light(c[v].own);
#endif
        m[v].unknown = 0.0f;
#if EXTRAPOLATE && !FINITE
        even[v] = odd[v] = c[v].least_excess;
#endif
#if HBAO
        m[v].blocked = 0.0f;
#endif
#if GATHER_BENT
        m[v].g = h->start_g;
        m[v].sin2 = s[v].sin2;
#endif
#if FINITE
        m[v].covered = 0u;
#if EXTRAPOLATE
        m[v].even = m[v].odd = 0u;
#endif
        m[v].sectors = HBIL_SECTORS / max(m[v].a, (realv)1e-6f);
        m[v].sector = m[v].a * (1.0f / HBIL_SECTORS);
#endif
      }
      ++steps;
#if KEEP_FACTORS
      for (int v = 0; v < SPAN_VECTORS; ++v)
        begin_list(&kept[v]);
#endif
      int first = 0;
#if MAY_BE_DARK
      const uint quadrant =
          hbil_quadrant((ux > 0.0f) != side, (uy > 0.0f) != side);
      if (!(lit >> quadrant & 1u)) {
        raise_to_highest(args, c, s, half_slice, m, steps, looked_at, from, x,
                         y, whole.reach, top, even, odd);
        first = looked_at;
      }
#endif
      for (; first < looked_at; first += BLOCK) {
        realv excess[BLOCK][SPAN_VECTORS];
        uchar hit[BLOCK * SPAN_VECTORS];
        uint hits;
        const int count = min(BLOCK, looked_at - first);
        const int k = look(args, c, steps + first, count, from, plane, x, y,
                           whole.reach, excess, hit, &hits, top);
#if EXTRAPOLATE && !FINITE
        for (int i = 0; i < k; ++i) {
          const int halves = steps[first + i].halves;
          for (int v = 0; v < SPAN_VECTORS; ++v) {
            if (halves & HBIL_HALF_EVEN)
              even[v] = max(even[v], excess[i][v]);
            if (halves & HBIL_HALF_ODD)
              odd[v] = max(odd[v], excess[i][v]);
          }
        }
#endif
#if SHARES
#if MAY_BE_DARK && !FALLBACK_FRAME_MEAN
        if (light_here == LIGHT_SOME)
          hits = leave_dark(c, s, half_slice, m, top, hit, hits, steps + first,
                            from, plane, args);
#endif
        for (uint i = 0u; i < hits; ++i) {
          const uint entry = HIT(hit, i), v = entry % SPAN_VECTORS;
          global const hbil_step *step = steps + first + entry / SPAN_VECTORS;
          global const float *there = from + v * HBIL_WIDTH + step->offset;
          const realv share =
              raise(&c[v], &s[v], &half_slice[v], &m[v],
                    excess[entry / SPAN_VECTORS][v], step, there, args, dither);
#if GATHER_RADIANCE
          /* what may be dark and is was looked at without a list */
          if (MAY_BE_DARK || light_here != LIGHT_NONE)
            add_light(&c[v], &m[v], share, step, there, plane, args, light_here,
                      &kept[v]);
#else
          (void)share;
#endif
        }
#endif
        if (k < count)
          break;
      }
      steps += samples;
      for (int v = 0; v < SPAN_VECTORS; ++v) {
#if !SHARES
        raise(&c[v], &s[v], &half_slice[v], &m[v], top[v], steps, from, args,
              dither);
#endif
#if GATHER_BENT && !FINITE
        const intv risen = top[v] > c[v].least_excess;
        m[v].g = select(half_slice[v].start_g, m[v].g, risen);
        m[v].sin2 = select(s[v].sin2, m[v].sin2, risen);
#endif
        realv more = 1.0f, less = 1.0f;
#if EXTRAPOLATE && FINITE
        extrapolate(&m[v], &more, &less);
#elif EXTRAPOLATE
        const realv second = min(even[v], odd[v]);
        if (ANY(second < top[v]))
          extrapolate(&c[v], &s[v], &half_slice[v], &m[v], top[v], second,
                      &more, &less);
#endif
#if KEEP_FACTORS && EXTRAPOLATE
        keep_factor(&kept[v], more);
#endif
#if HBAO
        m[v].a = fma(-more, m[v].blocked, half_slice[v].start);
        less = 1.0f;
#endif
#if SHARES
        untouched[v] &= m[v].a == half_slice[v].start;
#else
        untouched[v] &= top[v] <= c[v].least_excess;
#endif
        add_side(&s[v], &m[v], half_slice[v].start, more, less,
                 side ? -1.0f : 1.0f);
      }
    }
    for (int v = 0; v < SPAN_VECTORS; ++v) {
      add_slice(&t[v], &s[v], ux, uy);
#if KEEP_FACTORS
      keep_factor(&kept[v], s[v].jacobian);
#endif
    }
  }
  for (int v = 0; v < SPAN_VECTORS; ++v)
    store_light(&c[v], &t[v], untouched[v], all_slices, layer,
                light + v * HBIL_WIDTH, args.light.plane, &kept[v]);
}
