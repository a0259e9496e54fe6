/*
 * estimate: the light of surfaces that the screen doesn't show, guessed from
 * those that it shows, after all bounces at once (doc/method.md, section 11).
 *
 * The guess is what the visible surfaces send on average: for a receiver of
 * normal n, a mean over the visible pixels, each weighted by how much it faces
 * the receiver.  With c = -n_i.n the weight is the clamped cosine convolved
 * with itself, to order 2: 1 + 4/3 c + 5/16 P2(c), plus HBIL_UNSEEN_EVEN.  So
 * 4 x 9 numbers are enough: sums of (L, 1) times the order-2 polynomials of
 * -n_i.
 *
 * L is the radiance of the first bounce, of direct light and emission alone.
 * With the mean reflectance, the mean share s of the hemisphere whose light is
 * shown and the share u whose light is guessed, the gain of a bounce is
 * g = reflectance (s + unseen_light u), and the radiance after all bounces is
 * L / (1 - g), in closed form.  After n frames of carried light, near light has
 * reached the share 1 - g (reflectance s)^n of this limit; the estimate adds
 * what is missing. So the result hardly depends on the number of earlier
 * frames, and can't grow.
 *
 * In: split planes, gathered light, the caller's planes.  Out: the values of
 * HBIL_FILL_*, which unseen_light.clh and sky_light.clh read.
 */
#include "lib/camera.clh"
#include "lib/external_planes.clh"
#include "lib/flags.clh"
#include "lib/gathered_planes.clh"
#include "lib/interleave.clh"
#include "lib/sky_light.clh"
#include "lib/split_planes.clh"
#include "lib/surface_inputs.clh"

FLAG(GATHER_EMISSION)

FETCHER(albedo, ALBEDO_TYPE, ALBEDO_STRIDE)
FETCHER(direct, DIRECT_TYPE, DIRECT_STRIDE)

/* Neighbouring layers of a row are done together, as their pixels alternate in
 * the caller's planes.  GPUs have no registers for so many sums. */
#if HBIL_WIDTH == 1
#define COLUMNS 1
#define PART_LANES HBIL_ESTIMATE_LANES
#define PART_ACROSS HBIL_ESTIMATE_BLOCK
#else
#define COLUMNS 4
#define PART_LANES 1
#define PART_ACROSS 1
#endif

/* A vector of each of those layers: every fourth one of the picture's pixels
 * from (x, y) on, from column `column` of four on. */
typedef struct row_place {
  int x, y, column, width;
} row_place;

/* columns_NAME(): a channel of such pixels, one vector a layer; those outside
 * the picture have any value. */
#if COLUMNS == 1
#define COLUMN_LOADER(name)                                                    \
  INLINE void columns_##name(global const void *buffer,                        \
                             const hbil_external_plane_args plane,             \
                             row_place at, int c, realv *columns) {            \
    const int x = at.x + at.column;                                            \
    columns[0] = load_##name(buffer, plane, x, at.y, c, at.width - x);         \
  }
#else
#define COLUMN_LOADER(name)                                                    \
  INLINE void columns_##name(global const void *buffer,                        \
                             const hbil_external_plane_args plane,             \
                             row_place at, int c, realv *columns) {            \
    realv quad[4];                                                             \
    for (int i = 0; i < 4; ++i) {                                              \
      const int x = at.x + i * HBIL_WIDTH;                                     \
      quad[i] = load_##name(buffer, plane, x, at.y, c, at.width - x);          \
    }                                                                          \
    DEINTERLEAVE(quad, columns);                                               \
  }
#endif
#if HAS_ALBEDO
COLUMN_LOADER(albedo)
#endif
#if HAS_F0
COLUMN_LOADER(f0)
#endif
#if HAS_DIRECT
COLUMN_LOADER(direct)
#endif
#if HAS_EMISSION && GATHER_EMISSION
COLUMN_LOADER(emission)
#endif

/* What the caller's planes tell of a vector of pixels. */
typedef struct surface {
  realv reflectance[3]; /* diffuse */
  realv sent[3];        /* radiance of the first bounce */
  /* direct light over that of a whole hemisphere of sky, the largest quotient
   * of the three channels; 0 without a sky */
  realv sky_light;
} surface;

/* Prefetches albedo and direct light, which nearly every frame has, before any
 * of it is loaded.  Blocks lie so far apart that a CPU doesn't prefetch them by
 * itself; without this it waits for each line in turn.  Of interleaved planes
 * only the first line of each vector is requested. */
INLINE void fetch_surfaces(const hbil_estimate_args args,
                           const surface_inputs *in, row_place at) {
#if HBIL_WIDTH > 1
#pragma unroll
  for (int c = 0; c < 3; ++c)
#pragma unroll
    for (int i = 0; i < COLUMNS; ++i) {
      const int x = at.x + i * HBIL_WIDTH;
#if HAS_ALBEDO
      fetch_albedo(in->albedo, args.surface.albedo, x, at.y, c);
#endif
#if HAS_DIRECT
      fetch_direct(in->direct, args.surface.direct, x, at.y, c);
#endif
    }
#endif
}

/* Those of the layers of a row_place. */
INLINE void load_surfaces(const hbil_estimate_args args,
                          const surface_inputs *in, row_place at,
                          surface *surfaces) {
  intv usable = TRUE_LANES;
  for (int i = 0; i < COLUMNS; ++i)
    surfaces[i].sky_light = 0.0f;
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    realv share[COLUMNS], irradiance[COLUMNS], values[COLUMNS];
    for (int i = 0; i < COLUMNS; ++i) {
      share[i] = 1.0f;
      irradiance[i] = 0.0f;
    }
#if HAS_ALBEDO
    columns_albedo(in->albedo, args.surface.albedo, at, c, values);
    for (int i = 0; i < COLUMNS; ++i)
      share[i] = usable_reflectance(values[i], &usable);
#endif
#if HAS_DIRECT
    columns_direct(in->direct, args.surface.direct, at, c, values);
    for (int i = 0; i < COLUMNS; ++i)
      irradiance[i] = irradiance_of(
          usable_light(args.surface.direct_scale * values[i], &usable),
          share[i]);
#endif
#if HAS_F0
    columns_f0(in->f0, args.surface.f0, at, c, values);
    for (int i = 0; i < COLUMNS; ++i)
      share[i] *= 1.0f - usable_reflectance(values[i], &usable);
#endif
    for (int i = 0; i < COLUMNS; ++i) {
      surfaces[i].reflectance[c] = share[i];
      surfaces[i].sent[c] = INV_PI * share[i] * irradiance[i];
      if (args.sky[c] > 0.0f)
        surfaces[i].sky_light =
            max(surfaces[i].sky_light, INV_PI / args.sky[c] * irradiance[i]);
    }
#if HAS_EMISSION && GATHER_EMISSION
    columns_emission(in->emission, args.surface.emission, at, c, values);
    for (int i = 0; i < COLUMNS; ++i)
      surfaces[i].sent[c] += usable_light(values[i], &usable);
#endif
  }
}

/* The polynomials of the real basis in order (0,0) (1,-1..1) (2,-2..2). */
INLINE void polynomials(realv x, realv y, realv z, realv *p) {
  p[0] = 1.0f;
  p[1] = y;
  p[2] = z;
  p[3] = x;
  p[4] = x * y;
  p[5] = y * z;
  p[6] = 3.0f * z * z - 1.0f;
  p[7] = z * x;
  p[8] = x * x - y * y;
}

/* The mean AO of the four pixels of a row that a pixel belongs to, as far as
 * they show a surface and are gathered.  A single pixel looks along few
 * directions, and what unlit_part() makes of its noise isn't its mean.  split,
 * light: of the first of the four, which is in layer `layer`. */
INLINE realv open_row(const hbil_estimate_args args, global const float *split,
                      global const float *light, int layer) {
  realv open = 0.0f, total = 0.0f;
  for (uint i = 0u; i < 4u; ++i) {
    realv gathered[HBIL_GATHERED_PLANES], weight = 1.0f;
    if (!hbil_is_gathered(layer + (int)i, GATHERED))
      continue;
    gathered_light(light + i * args.light.layer, args.light.plane, gathered);
#if WEIGHT_PLANE
    weight = gathered[HBIL_LIGHT_WEIGHT];
#endif
    weight =
        select((realv)0.0f, weight, LOADV(split + i * args.split.layer) > SKY);
    open = fma(weight, gathered[HBIL_LIGHT_AO], open);
    total += weight;
  }
  return open / max(total, (realv)FLT_MIN);
}

#define ADD(to, value) sum[to] += select((realv)0.0f, value, solid)

/* Adds a vector of a layer's pixels. */
INLINE void add_pixels(const hbil_estimate_args args, global const float *split,
                       global const float *light, const surface *surface,
                       realv open, realv *sum) {
  const intv solid = LOADV(split) > SKY;
  realv n[3], p[9], gathered[HBIL_GATHERED_PLANES];
  split_normal(split, args.split.plane, n);
  gathered_light(light, args.light.plane, gathered);
  polynomials(-n[0], -n[1], -n[2], p);
#pragma unroll
  for (int k = 0; k < 9; ++k) {
    ADD(HBIL_SUM_LIGHT + k, surface->sent[0] * p[k]);
    ADD(HBIL_SUM_LIGHT + 9 + k, surface->sent[1] * p[k]);
    ADD(HBIL_SUM_LIGHT + 18 + k, surface->sent[2] * p[k]);
    ADD(HBIL_SUM_WEIGHT + k, p[k]);
  }
#pragma unroll
  for (int c = 0; c < 3; ++c)
    ADD(HBIL_SUM_REFLECTANCE + c, surface->reflectance[c]);
#pragma unroll
  for (int c = 0; c < 3; ++c)
    ADD(HBIL_SUM_NEAR + c, INV_PI * gathered[HBIL_LIGHT_RED + c]);
  realv lit;
  const realv unlit = unlit_part(surface->sky_light, open, &lit);
  const realv dark = open - lit * open;
  ADD(HBIL_SUM_OPEN, gathered[HBIL_LIGHT_AO]);
#if FALLBACK_FRAME_MEAN
  ADD(HBIL_SUM_BEHIND, gathered[HBIL_LIGHT_UNKNOWN]);
#endif
  ADD(HBIL_SUM_DARK, dark);
  ADD(HBIL_SUM_DARK + 1, dark * unlit);
  ADD(HBIL_SUM_DARK + 2, dark * unlit * unlit);
  ADD(HBIL_SUM_LIT, lit);
  ADD(HBIL_SUM_LIT_OPEN, lit * open);
}

/* Adds a vector of each of the layers from `split` and `light` on, as far as
 * they are gathered. */
INLINE void add_layers(const hbil_estimate_args args, const surface_inputs *in,
                       global const float *split, global const float *light,
                       row_place at, realv (*sum)[HBIL_ESTIMATE_SUMS]) {
  const int layer = 4 * (at.y & 3) + at.column;
  surface surfaces[COLUMNS];
  fetch_surfaces(args, in, at);
  intv solid = LOADV(split) > SKY;
  for (int i = 1; i < COLUMNS; ++i)
    solid |= LOADV(split + (uint)i * args.split.layer) > SKY;
  if (!ANY(solid))
    return;
  load_surfaces(args, in, at, surfaces);
  const uint before = COLUMNS == 1 ? (uint)at.column : 0u;
  const realv open =
      open_row(args, split - before * args.split.layer,
               light - before * args.light.layer, layer - (int)before);
  for (int i = 0; i < COLUMNS; ++i)
    if (hbil_is_gathered(layer + i, GATHERED))
      add_pixels(args, split + (uint)i * args.split.layer,
                 light + (uint)i * args.light.layer, &surfaces[i], open,
                 sum[i]);
}

/* Launch: x = lanes of a part, one unless HBIL_WIDTH is 1;
 * y = HBIL_ESTIMATE_PARTS.  Layers with few rows need fewer lanes than
 * HBIL_ESTIMATE_LANES. */
kernel void estimate_part(const hbil_estimate_args args,
                          global const float *split, global const float *light,
                          global const void *albedo, global const void *f0,
                          global const void *direct,
                          global const void *emission, global const uint *flags,
                          global float *estimate) {
  const hbil_layer_args in = args.split;
  const int lane = (int)get_global_id(0);
  const int part = (int)get_global_id(1), layer = part % HBIL_LAYERS;
  if (lane >= PART_LANES || part >= HBIL_ESTIMATE_PARTS || part % COLUMNS > 0)
    return;
  if (args.is_static && !flags[HBIL_FLAG_CHANGED])
    return;
  const surface_inputs planes = {albedo, f0, direct, emission};
  realv sum[COLUMNS][HBIL_ESTIMATE_SUMS];
  for (int i = 0; i < COLUMNS; ++i)
    for (int k = 0; k < HBIL_ESTIMATE_SUMS; ++k)
      sum[i][k] = 0.0f;
  split += (uint)layer * in.layer + in.origin;
  light += (uint)layer * args.light.layer + args.light.origin;
  /* of these COLUMNS layers the first one is gathered if any of them is */
  const int end = hbil_is_gathered(layer, GATHERED) ? in.height : 0;
  const int row = hbil_estimate_row(part) + 4 * (lane / PART_ACROSS);
  const int column = lane % PART_ACROSS * HBIL_WIDTH;
  for (int y = row; y < end; y += 4 * (PART_LANES / PART_ACROSS))
    for (int x = column; x < in.width; x += PART_ACROSS * HBIL_WIDTH) {
      const row_place at = {4 * x, 4 * y + layer / 4, layer % 4, args.width};
      /* what lies right of the picture is sky */
      if (at.y < args.height && at.x < args.width &&
          hbil_estimate_uses(x / HBIL_ESTIMATE_BLOCK, at.y))
        add_layers(args, &planes, split + (uint)y * in.row + (uint)x,
                   light + (uint)y * args.light.row + (uint)x, at, sum);
    }
#if HBIL_WIDTH == 1
  estimate +=
      HBIL_ESTIMATE_SIZE + (part * PART_LANES + lane) * HBIL_ESTIMATE_SUMS;
#else
  estimate += HBIL_FILL_SIZE + (part + 1) * HBIL_ESTIMATE_SUMS;
#endif
  for (int i = 0; i < COLUMNS; ++i)
    for (int k = 0; k < HBIL_ESTIMATE_SUMS; ++k)
      estimate[i * HBIL_ESTIMATE_SUMS + k] = lanes_sum(sum[i][k]);
}

#if HBIL_WIDTH == 1
/* Adds up the lanes of each part that were launched, in their order.
 * Launch: x = HBIL_ESTIMATE_SUMS, y = HBIL_ESTIMATE_PARTS work-items. */
kernel void estimate_lanes(const int lanes, global float *estimate) {
  const int k = (int)get_global_id(0), part = (int)get_global_id(1);
  if (k >= HBIL_ESTIMATE_SUMS || part >= HBIL_ESTIMATE_PARTS)
    return;
  global const float *sums = estimate + HBIL_ESTIMATE_SIZE +
                             part * (PART_LANES * HBIL_ESTIMATE_SUMS) + k;
  float sum = 0.0f;
  for (int lane = 0; lane < min(lanes, PART_LANES); ++lane)
    sum += sums[lane * HBIL_ESTIMATE_SUMS];
  estimate[HBIL_FILL_SIZE + (part + 1) * HBIL_ESTIMATE_SUMS + k] = sum;
}
#endif

/* --- the sums of all parts ------------------------------------------------ */

/* Radiance of a part's surfaces, added up. */
INLINE float radiance_of_part(global const float *part) {
  return part[HBIL_SUM_LIGHT] + part[HBIL_SUM_LIGHT + 9] +
         part[HBIL_SUM_LIGHT + 18];
}

/* Radiance of typical parts: the mean of eighth roots, to the eighth, on which
 * a part of a million times the others has little effect. */
INLINE float typical_radiance(global const float *parts) {
  float roots = 0.0f, surfaces = 0.0f;
  for (int i = 0; i < HBIL_ESTIMATE_PARTS; ++i) {
    global const float *part = parts + i * HBIL_ESTIMATE_SUMS;
    const float weight = part[HBIL_SUM_WEIGHT];
    roots +=
        weight * sqrt(sqrt(sqrt(radiance_of_part(part) / max(weight, 1.0f))));
    surfaces += weight;
  }
  float typical = roots / max(surfaces, 1.0f);
  for (int i = 0; i < 3; ++i)
    typical *= typical;
  return typical;
}

/* Launch: x = HBIL_ESTIMATE_SUMS work-items.  The order of the sum is fixed. */
kernel void estimate_sum(global float *estimate) {
  const int i = (int)get_global_id(0);
  if (i >= HBIL_ESTIMATE_SUMS || get_global_id(1) > 0)
    return;
  global float *sums = estimate + HBIL_FILL_SIZE;
  global const float *parts = sums + HBIL_ESTIMATE_SUMS;
  const float most = HBIL_UNSEEN_SPIKE * typical_radiance(parts);
  float sum = 0.0f;
  for (int p = 0; p < HBIL_ESTIMATE_PARTS; ++p) {
    global const float *part = parts + p * HBIL_ESTIMATE_SUMS;
    const float limit = most * part[HBIL_SUM_WEIGHT];
    const float radiance = radiance_of_part(part);
    const bool is_spike = i < HBIL_SUM_WEIGHT && radiance > limit;
    sum += is_spike ? part[i] * (limit / radiance) : part[i];
  }
  sums[i] = sum;
}

/* The share of what near light lacks that is really to come.  Surfaces may see
 * less of the direct light than the mean surface would, the factor r, for
 * instance where a lamp lights the floor alone.  Their second bounce is then
 * smaller by that, and later ones by a part of it.
 * seen: radiance of the shown directions, of which `expected` was expected;
 * shown, guessed: their shares of what a bounce returns; reflectance: times the
 * shown share of the hemisphere. */
INLINE float coming_share(float seen, float expected, float shown,
                          float guessed, float reflectance) {
  const float r = min(seen / max(expected, FLT_MIN), 1.0f);
  const float later = 1.0f - HBIL_UNSEEN_COUPLING * (1.0f - r);
  return (r * shown + guessed) / max(shown + guessed, FLT_MIN) *
         (1.0f - reflectance) / (1.0f - later * reflectance);
}

/* Launch: one work-item. */
kernel void estimate_fill(const hbil_estimate_args args,
                          global float *estimate) {
  if (get_global_id(0) > 0 || get_global_id(1) > 0)
    return;
  global const float *sum = estimate + HBIL_FILL_SIZE;
  /* Means, whose products don't overflow where every pixel has 1e30.  Factors:
   * the constants of the basis functions times the weight's coefficients */
  const float factor[9] = {1.0f,        1.33333333f, 1.33333333f,
                           1.33333333f, 0.9375f,     0.9375f,
                           0.078125f,   0.9375f,     0.234375f};
  const float surfaces = sum[HBIL_SUM_WEIGHT];
  const float inv = surfaces > 0.0f ? 1.0f / surfaces : 0.0f;
  const float open = sum[HBIL_SUM_OPEN], behind = sum[HBIL_SUM_BEHIND];
  const float shown = max(1.0f - inv * (open + behind), 0.0f);
  const float sun = clamp((inv * sum[HBIL_SUM_LIT] - HBIL_SUN_NONE) /
                              (HBIL_SUN_FULL - HBIL_SUN_NONE),
                          0.0f, 1.0f);
  const float unlit = sum[HBIL_SUM_DARK + 1] /
                      max(sum[HBIL_SUM_DARK] + HBIL_DARK_PRIOR * open, FLT_MIN);
  const float guessed =
      inv *
      (behind + (1.0f - args.sky_share) *
                    (sun * sum[HBIL_SUM_DARK + 1] +
                     (1.0f - sun) * sum[HBIL_SUM_DARK + 2] +
                     sum[HBIL_SUM_LIT_OPEN] * unlit * mix(unlit, 1.0f, sun)));
  const float unseen = args.unseen_light * guessed;
  for (int c = 0; c < 3; ++c) {
    const float reflectance = inv * sum[HBIL_SUM_REFLECTANCE + c];
    const float gain = min(reflectance * (shown + unseen), HBIL_UNSEEN_GAIN);
    const float bounces = 1.0f / (1.0f - gain);
    const float radiance = bounces * inv * sum[HBIL_SUM_LIGHT + 9 * c];
    /* What near light lacks shrinks by the factor reflectance x shown with each
     * bounce.  Near light that contains guesses has all bounces of those. */
    const float lacks = FALLBACK_FRAME_MEAN
                            ? 0.0f
                            : gain * pown(reflectance * shown, args.bounces);
    /* reflectance x shown is below 1 as long as the gain isn't limited */
    const float expected = shown * (1.0f - lacks) * radiance;
    const float coming =
        coming_share(inv * sum[HBIL_SUM_NEAR + c], expected, shown, unseen,
                     min(reflectance * shown, HBIL_UNSEEN_GAIN));
    estimate[HBIL_FILL_LACKS + c] = coming * lacks * radiance;
    for (int k = 0; k < 9; ++k)
      estimate[HBIL_FILL_LIGHT + 9 * c + k] =
          bounces * factor[k] * (inv * sum[HBIL_SUM_LIGHT + 9 * c + k]);
  }
  for (int k = 0; k < 9; ++k)
    estimate[HBIL_FILL_WEIGHT + k] =
        factor[k] * (inv * sum[HBIL_SUM_WEIGHT + k]);
  estimate[HBIL_FILL_UNLIT] = unlit;
  estimate[HBIL_FILL_SUN] = sun;
  estimate[HBIL_FILL_UNSEEN] = args.unseen_light;
}
