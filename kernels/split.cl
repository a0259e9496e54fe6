/*
 * split: G-buffer -> 4x4 interleaved layers of inverse depth, view-space unit
 * normal that faces the eye, and the radiance the pixel sends.
 *
 * Builds: the inputs' formats, HAS_*, NORMAL_IS_WORLD, FEEDBACK_RADIANCE,
 * GATHER_RADIANCE (0: no radiance planes are written), GATHER_EMISSION,
 * SKIP_UNUSED (notes, a word for each work-item, where light has a use),
 * SKIP_OPEN, SKIP_DARK (notes what bounds.cl makes bounds of).
 * Counts what it could not use as it was (hbil_plan_sanitized()).
 * Launch: x = groups of 4*HBIL_WIDTH pixels of a row, y = rows.
 */

#define INV_PI 0.318309886f

/* The input's normal in view space. */
INLINE void view_normal(const hbil_transform_args to_view,
                        global const void *buffer,
                        const hbil_external_plane_args image, int x, int y,
                        int count, realv n[3]) {
#pragma unroll
  for (int c = 0; c < 3; ++c)
    n[c] = load_normal(buffer, image, x, y, c, count);
#if NORMAL_IS_WORLD
  const realv world[3] = {n[0], n[1], n[2]};
  turned(to_view, world, n);
#endif
}

/* Whether a normal has a direction, by the square of its length. */
INLINE intv sound_normal(realv length2) {
  return (length2 >= 1e-20f) & (length2 < INFINITY);
}

INLINE realv squared_length(const realv n[3]) {
  return fma(n[0], n[0], fma(n[1], n[1], n[2] * n[2]));
}

/* Makes it a normal that faces the eye by at least HBIL_MIN_COSINE, of unit
 * length unless pack_normal() will see to that; (rx, ry, 1) is the ray, a
 * normal that cannot be used becomes -ray and is taken from `sound`. */
INLINE void facing_normal(realv n[3], realv rx, float ry, intv *sound) {
  const realv ray2 = fma(rx, rx, (realv)fma(ry, ry, 1.0f));
  const realv length2 = squared_length(n);
  const intv usable = sound_normal(length2);
  *sound &= usable;
  /* times both lengths: nearly every normal is plain, and the roots and
   * quotients below are a tenth of this kernel's time.  A hundredth more than
   * enough, so that no rounding matters. */
  const realv towards = -fma(n[0], rx, fma(n[1], (realv)ry, n[2]));
  const float least = 1.01f * HBIL_MIN_COSINE;
  const intv plain = usable & (towards > 0.0f) &
                     (towards * towards > least * least * ray2 * length2);
#if PACKED
  const realv scale = 1.0f, eye_scale = 1.0f;
#else
  const realv scale = 1.0f / sqrt(length2), eye_scale = 1.0f / sqrt(ray2);
#endif
  const intv odd = !plain;
  if (ANY(odd)) {
    const realv inv_r = 1.0f / sqrt(ray2), inv_length = 1.0f / sqrt(length2);
    const realv eye[3] = {-rx, (realv)-ry, -1.0f};
    realv cosine = 0.0f, bent[3], bent2 = 0.0f;
#pragma unroll
    for (int c = 0; c < 3; ++c)
      cosine = fma(n[c] * inv_length, eye[c] * inv_r, cosine);
    const realv missing = max(HBIL_MIN_COSINE - cosine, (realv)0.0f);
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      bent[c] = fma(missing, eye[c] * inv_r, n[c] * inv_length);
      bent2 = fma(bent[c], bent[c], bent2);
    }
#pragma unroll
    for (int c = 0; c < 3; ++c)
      n[c] = select(select(eye[c] * eye_scale, bent[c] / sqrt(bent2), usable),
                    n[c] * scale, plain);
  } else {
#pragma unroll
    for (int c = 0; c < 3; ++c)
      n[c] *= scale;
  }
}

/* What makes radiance.  light, weight: of the last frame, light from the plane
 * of red on; null where there is none. */
typedef struct sources {
  global const void *albedo, *f0, *direct, *emission;
  hbil_external_plane_args albedo_image, f0_image, direct_image, emission_image;
  float direct_scale;
  global const float *light, *weight;
  uint plane;
} sources;

/* Diffuse reflectance of channel c.  sound: of each input. */
INLINE realv reflectance_of(const sources *s, int c, int x, int y, int count,
                            intv *sound) {
  realv reflectance = INV_PI;
#if HAS_ALBEDO
  reflectance *=
      sound_share(load_albedo(s->albedo, s->albedo_image, x, y, c, count),
                  sound + HBIL_SURFACE_ALBEDO);
#endif
#if HAS_F0
  reflectance *= 1.0f - sound_share(load_f0(s->f0, s->f0_image, x, y, c, count),
                                    sound + HBIL_SURFACE_F0);
#endif
  return reflectance;
}

#if GATHER_RADIANCE
/* Radiance that pixels from (x, y) on send; `at`: their place in the planes.
 * Anything where there is no surface. */
INLINE void radiance_of(const sources *s, int x, int y, int count, uint at,
                        realv light[3], intv *sound) {
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    realv irradiance = 0.0f, emitted = 0.0f;
    const realv reflectance = reflectance_of(s, c, x, y, count, sound);
#if HAS_DIRECT
    irradiance =
        sound_light(s->direct_scale *
                        load_direct(s->direct, s->direct_image, x, y, c, count),
                    sound + HBIL_SURFACE_DIRECT);
#endif
#if HAS_EMISSION && GATHER_EMISSION
    emitted = sound_light(
        load_emission(s->emission, s->emission_image, x, y, c, count),
        sound + HBIL_SURFACE_EMISSION);
#endif
#if FEEDBACK_RADIANCE
    light[c] = fma(reflectance, irradiance, emitted);
    if (s->light)
      light[c] = select(light[c], READV(s->light + c * s->plane + at),
                        READV(s->weight + at) > 0.0f);
#else
    if (s->light)
      irradiance += READV(s->light + c * s->plane + at);
    light[c] = fma(reflectance, irradiance, emitted);
#endif
  }
}
#endif

/* What is there to be counted of inputs that were found wanting, in the
 * work-item's 4 HBIL_WIDTH pixels: read once more, since it is hardly ever. */
INLINE void count_repaired(const hbil_view_args view,
                           const hbil_transform_args to_view,
                           const sources *from, global const void *depth_buffer,
                           const hbil_external_plane_args depth_image,
                           global const void *normal_buffer,
                           const hbil_external_plane_args normal_image,
                           float background, int x0, int y,
                           volatile global uint *repaired) {
  uint depths = 0u, normals = 0u, inputs[HBIL_SURFACE_INPUTS] = {0u};
  for (int x = x0; x < min(x0 + 4 * HBIL_WIDTH, view.width); x += HBIL_WIDTH) {
    const int count = view.width - x;
    const realv depth = load_depth(depth_buffer, depth_image, x, y, 0, count);
    const intv solid = planar_depth(depth, ray_x(view, x, 1), ray_y(view, y),
                                    background) > 0.0f;
    realv n[3];
    view_normal(to_view, normal_buffer, normal_image, x, y, count, n);
    depths += count_lanes(!sound_depth(depth));
    normals += count_lanes(solid & !sound_normal(squared_length(n)));
#if GATHER_RADIANCE
    realv light[3];
    intv sound[HBIL_SURFACE_INPUTS];
    for (int i = 0; i < HBIL_SURFACE_INPUTS; ++i)
      sound[i] = TRUE_LANES;
    sources anew = *from;
    anew.light = 0;
    radiance_of(&anew, x, y, count, 0u, light, sound);
    for (int i = 0; i < HBIL_SURFACE_INPUTS; ++i)
      inputs[i] += count_lanes(
          (i == HBIL_SURFACE_EMISSION ? TRUE_LANES : solid) & !sound[i]);
#endif
  }
  add_repaired(repaired + HBIL_SANITIZED_DEPTH, depths);
  add_repaired(repaired + HBIL_SANITIZED_NORMAL, normals);
  for (int i = 0; i < HBIL_SURFACE_INPUTS; ++i)
    add_repaired(repaired + HBIL_SANITIZED_SURFACE + i, inputs[i]);
}

/* Where row y's layers have pixel x0 and those to its right. */
INLINE uint place(const hbil_layer_args layout, int x0, int y) {
  return layout.origin + (uint)(y & 3) * 4u * layout.layer +
         (uint)(y >> 2) * layout.row + (uint)(x0 >> 2);
}

#define HAS_BOUNDS (SKIP_OPEN || SKIP_DARK)

#if HAS_BOUNDS && GATHER_RADIANCE
/* Of 4*HBIL_WIDTH pixels: HBIL_SOME_.  value: planes of radiance.  Dark is what
 * has no light in some lane of all four vectors: a few pixels are not worth
 * asking every sample. */
INLINE uint light_of(const realv w[4], realv value[][4]) {
  intv lit = 0, dark = TRUE_LANES, solid = 0;
#pragma unroll
  for (int part = 0; part < 4; ++part) {
    realv light[RADIANCE_PLANES];
#pragma unroll
    for (int p = 0; p < RADIANCE_PLANES; ++p)
      light[p] = value[p][part];
    const intv is_lit = shines(light);
    lit |= is_lit;
    dark &= !is_lit;
    solid |= w[part] > SKY;
  }
  return (ANY(lit) ? HBIL_SOME_LIT : 0u) |
         (ANY(dark & solid) ? HBIL_SOME_DARK : 0u);
}
#endif

kernel void split(const hbil_view_args view, const hbil_transform_args to_view,
                  global float *layers, const hbil_layer_args layout,
                  global const float *carried, const hbil_plane_args planes,
                  const int has_history, const float background,
                  const float direct_scale, global const void *depth_buffer,
                  const hbil_external_plane_args depth_image,
                  global const void *normal_buffer,
                  const hbil_external_plane_args normal_image,
                  global const void *albedo_buffer,
                  const hbil_external_plane_args albedo_image,
                  global const void *f0_buffer,
                  const hbil_external_plane_args f0_image,
                  global const void *direct_buffer,
                  const hbil_external_plane_args direct_image,
                  global const void *emission_buffer,
                  const hbil_external_plane_args emission_image,
                  global uint *uses, volatile global uint *repaired,
                  const hbil_grid_args groups, global uint *bounds) {
  const int x0 = (int)get_global_id(0) * (4 * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  if (x0 >= view.width || y >= view.height)
    return;
  const sources from = {albedo_buffer,
                        f0_buffer,
                        direct_buffer,
                        emission_buffer,
                        albedo_image,
                        f0_image,
                        direct_image,
                        emission_image,
                        direct_scale,
                        has_history ? carried : 0,
                        carried + HBIL_CARRIED_WEIGHT * planes.plane,
                        planes.plane};
#if SKIP_UNUSED
  intv used = 0;
#endif
  intv wanting = 0;
  realv value[SPLIT_PLANES][4];
  const float ry = ray_y(view, y);
#pragma unroll
  for (int part = 0; part < 4; ++part) {
    const int x = x0 + part * HBIL_WIDTH, count = view.width - x;
    const realv rx = ray_x(view, x, 1);
    const realv depth = load_depth(depth_buffer, depth_image, x, y, 0, count);
    const realv z = planar_depth(depth, rx, ry, background);
    const intv solid = z > 0.0f;
    const realv w = w_at(z);
    /* normals share the first; only emission counts in the sky, too */
    intv sound[HBIL_SURFACE_INPUTS] = {TRUE_LANES, TRUE_LANES, TRUE_LANES,
                                       TRUE_LANES};
    realv n[3];
    view_normal(to_view, normal_buffer, normal_image, x, y, count, n);
    facing_normal(n, rx, ry, sound);
    value[HBIL_SPLIT_W][part] = select((realv)HBIL_NOTHING, w, solid);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      n[c] = select((realv)0.0f, n[c], solid);
    pack_split_normal(n, value + HBIL_SPLIT_NORMAL, part);
#if GATHER_RADIANCE
    realv light[3];
    radiance_of(&from, x, y, count, (uint)y * planes.row + (uint)x, light,
                sound);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      light[c] = select((realv)0.0f, light[c], solid);
    pack_split_radiance(light, value + RADIANCE_PLANE, part);
#endif
#if SKIP_UNUSED
#pragma unroll
    for (int c = 0; c < 3; ++c)
      used |= solid & (reflectance_of(&from, c, x, y, count, sound) > 0.0f);
#endif
    wanting |= !sound_depth(depth) | !sound[HBIL_SURFACE_EMISSION] |
               (solid & !(sound[HBIL_SURFACE_ALBEDO] & sound[HBIL_SURFACE_F0] &
                          sound[HBIL_SURFACE_DIRECT]));
  }
  if (ANY(wanting))
    count_repaired(view, to_view, &from, depth_buffer, depth_image,
                   normal_buffer, normal_image, background, x0, y, repaired);
#if SKIP_UNUSED
  uses[(uint)y * (uint)((view.width + 4 * HBIL_WIDTH - 1) / (4 * HBIL_WIDTH)) +
       (uint)get_global_id(0)] = ANY(used);
#endif
#if HAS_BOUNDS
  bounds +=
      groups.offset + 2u * (uint)(y * groups.width + (int)get_global_id(0));
  const realv *const nearest = value[HBIL_SPLIT_W];
  bounds[0] = as_uint(
      lanes_max(max(max(nearest[0], nearest[1]), max(nearest[2], nearest[3]))));
#if GATHER_RADIANCE
  bounds[1] = light_of(value[HBIL_SPLIT_W], value + RADIANCE_PLANE);
#else
  bounds[1] = 0u;
#endif
#endif
  /* Lanes right of the image loaded depth 0: they are sky, and so is the
   * layers' right-hand rest. */
  global float *out = layers + place(layout, x0, y);
  const int planes_out = GATHER_RADIANCE ? SPLIT_PLANES : RADIANCE_PLANE;
  for (int p = 0; p < planes_out; ++p) {
    realv column[4];
    DEINTERLEAVE(value[p], column);
#pragma unroll
    for (int i = 0; i < 4; ++i)
      STREAMV(column[i], out + p * layout.plane + (uint)i * layout.layer);
  }
}

#if GATHER_RADIANCE
/*
 * The radiance alone, of a frame that is the one before but for its light:
 * nothing has moved, so `history` is this view's.  Raises HBIL_FLAG_CHANGED,
 * filled with 0, where anything differs from what is there already.
 */
kernel void relight(
    const hbil_view_args view, global float *layers,
    const hbil_layer_args layout, global const float *history,
    const hbil_plane_args planes, const int has_history, const float background,
    const float direct_scale, global const void *depth_buffer,
    const hbil_external_plane_args depth_image,
    global const void *albedo_buffer,
    const hbil_external_plane_args albedo_image, global const void *f0_buffer,
    const hbil_external_plane_args f0_image, global const void *direct_buffer,
    const hbil_external_plane_args direct_image,
    global const void *emission_buffer,
    const hbil_external_plane_args emission_image, global uint *flags,
    const hbil_grid_args groups, global uint *bounds) {
  const int x0 = (int)get_global_id(0) * (4 * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  if (x0 >= view.width || y >= view.height)
    return;
  history += hbil_history_origin(planes);
  /* where there is a surface its inverse depth is above 0, a weight */
  const sources from = {albedo_buffer,
                        f0_buffer,
                        direct_buffer,
                        emission_buffer,
                        albedo_image,
                        f0_image,
                        direct_image,
                        emission_image,
                        direct_scale,
                        has_history ? history + HBIL_HISTORY_RED * planes.plane
                                    : 0,
                        history + HBIL_HISTORY_W * planes.plane,
                        planes.plane};
  realv value[RADIANCE_PLANES][4];
#if HAS_BOUNDS
  realv w[4];
#endif
#pragma unroll
  for (int part = 0; part < 4; ++part) {
    const int x = x0 + part * HBIL_WIDTH, count = view.width - x;
    const intv solid =
        planar_depth(load_depth(depth_buffer, depth_image, x, y, 0, count),
                     ray_x(view, x, 1), ray_y(view, y), background) > 0.0f;
    /* counted when they were split */
    intv sound[HBIL_SURFACE_INPUTS] = {0};
    realv light[3];
    radiance_of(&from, x, y, count, (uint)y * planes.row + (uint)x, light,
                sound);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      light[c] = select((realv)0.0f, light[c], solid);
    pack_split_radiance(light, value, part);
#if HAS_BOUNDS
    w[part] = select((realv)HBIL_NOTHING, (realv)1.0f, solid);
#endif
  }
#if HAS_BOUNDS
  bounds[groups.offset + 2u * (uint)(y * groups.width + (int)get_global_id(0)) +
         1u] = light_of(w, value);
#endif
  global float *out =
      layers + place(layout, x0, y) + RADIANCE_PLANE * layout.plane;
  for (int p = 0; p < RADIANCE_PLANES; ++p) {
    realv column[4];
    intv changed = 0;
    DEINTERLEAVE(value[p], column);
#pragma unroll
    for (int i = 0; i < 4; ++i) {
      global float *to = out + p * layout.plane + (uint)i * layout.layer;
      changed |= AS_INTV(LOADV(to)) != AS_INTV(column[i]);
      STOREV(column[i], to);
    }
    if (ANY(changed))
      flags[HBIL_FLAG_CHANGED] = 1u; /* whoever else writes writes the same */
  }
}
#endif
