/*
 * composite: far light through the bent cone, the outputs, and the light that
 * the next frame starts from.
 *
 * Cone (HACKING.md): AO is cosine weighted, so a cone of half-angle alpha has
 * AO = sin^2(alpha) and t = cos(alpha) = sqrt(1 - AO).  Order-2 SH through it:
 *   E = sum sqrt(4 pi / (2l+1)) c_l(t) L_lm Y_lm(bent)
 *   c0 = sqrt(pi)/2 (1-t^2), c1 = sqrt(3 pi)/3 (1-t^3),
 *   c2 = sqrt(5 pi)/8 (3 (1-t^4) - 2 (1-t^2))
 * With the constants pulled into the coefficients (host, farfield.c) this is
 *   E = (1-t^2) s0 + (1-t^3) s1 . Y1 + (3 (1-t^4) - 2 (1-t^2)) s2 . Y2
 * with Y1 = (y, z, x), Y2 = (xy, yz, 3z^2-1, zx, x^2-y^2).
 * Fresnel: the diffuse part of the light is (1 - F0) of it (paper 2.3.3).
 *
 * Counts what it could not use as it was (hbil_plan_sanitized()), of the inputs
 * that split had no use for.
 *
 * Builds: FAR (0 none, 1 constant, 2 SH, 3 the frame's own estimate), inputs'
 * and outputs' formats, HAS_*, OUT_*, BENT_IS_WORLD, FEEDBACK_RADIANCE,
 * GATHER_EMISSION, GATHER_RADIANCE, GATHER_BENT, HISTORY, LINE (pixels that a
 * work-item takes). Launch: x = groups of LINE pixels of a row, y = rows.
 */

#if OUT_NEAR
STORER(near, NEAR_TYPE, NEAR_STRIDE)
#endif
#if OUT_FAR
STORER(far, FAR_TYPE, FAR_STRIDE)
#endif
#if OUT_AO
STORER(ao, AO_TYPE, AO_STRIDE)
#endif
#if OUT_BENT
STORER(bent, BENT_TYPE, BENT_STRIDE)
#endif
#if OUT_CONE
STORER(cone, CONE_TYPE, CONE_STRIDE)
#endif
#if OUT_INDIRECT
STORER(indirect, INDIRECT_TYPE, INDIRECT_STRIDE)
#endif
#if OUT_BEAUTY
STORER(radiance, BEAUTY_TYPE, BEAUTY_STRIDE)
#endif
#if OUT_ERROR
STORER(error, ERROR_TYPE, ERROR_STRIDE)
#endif

/* Vectors of a row that a work-item takes: on CPUs a cache line of the outputs.
 * It keeps what they come to and stores plane by plane: stores past the caches
 * of less than a line, to twenty planes in turn, take twice as long as fetching
 * what they overwrite, whole ones half. */
#define PARTS (LINE / HBIL_WIDTH)

/* What is pending, each PARTS vectors. */
enum {
  PENDING_AO = 0,
  PENDING_CONE = PENDING_AO + OUT_AO,
  PENDING_ERROR = PENDING_CONE + OUT_CONE,
  PENDING_BENT = PENDING_ERROR + 2 * OUT_ERROR,
  PENDING_NEAR = PENDING_BENT + 3 * OUT_BENT,
  PENDING_FAR = PENDING_NEAR + 3 * OUT_NEAR,
  PENDING_INDIRECT = PENDING_FAR + 3 * OUT_FAR,
  PENDING_RADIANCE = PENDING_INDIRECT + 3 * OUT_INDIRECT,
  PENDING_HISTORY = PENDING_RADIANCE + 3 * OUT_BEAUTY,
  PENDING_COUNT = PENDING_HISTORY + HISTORY * HBIL_HISTORY_PLANES
};

#define INV_PI 0.318309886f
#define PI 3.14159265f

/* What is reflected is asked for, and so are the inputs that make it. */
#define REFLECTED (OUT_BEAUTY || (HISTORY && FEEDBACK_RADIANCE))

#if FAR == 2
/* Irradiance through a cone (world axis d); k: the three aperture factors. */
INLINE realv sh_light(const hbil_sh_args e, const realv *d, const realv *k) {
  const realv first =
      fma(d[1], (realv)e.sh[1], fma(d[2], (realv)e.sh[2], d[0] * e.sh[3]));
  const realv second =
      fma(d[0] * d[1], (realv)e.sh[4],
          fma(d[1] * d[2], (realv)e.sh[5],
              fma(fma(3.0f * d[2], d[2], (realv)-1.0f), (realv)e.sh[6],
                  fma(d[2] * d[0], (realv)e.sh[7],
                      fma(d[0], d[0], -d[1] * d[1]) * e.sh[8]))));
  return max(fma(k[0], (realv)e.sh[0], fma(k[1], first, k[2] * second)),
             (realv)0.0f);
}
#endif

#if FAR == 3
/*
 * How much of the hemisphere neither the screen blocks nor the sky lights.  In
 * a frame whose sky sends environment[0] and whose direct light holds that, a
 * pixel with direct light D (radiance of the same scale) sees at most the share
 * D / sky of it (the largest over the channels: without albedo renderers give
 * no light).  So of the share that is open on the screen, AO, at least
 *   dark = max(0, AO - D / sky)
 * ends on something unseen, or on a darker part of the sky.  An open direction
 * is taken for blocked as often as open ones are dark, dark / AO: where the sky
 * lights nothing all of the dark share is blocked, and a sky that is not the
 * same everywhere counts in second order only.  AO where no sky is given.
 */
INLINE realv unlit_share(const hbil_environment_args e, realv ao,
                         float direct_scale, global const void *buffer,
                         const hbil_external_plane_args image, int x, int y,
                         int count) {
  realv lit = 0.0f;
#if HAS_DIRECT
  intv sound = TRUE_LANES;
#pragma unroll
  for (int c = 0; c < 3; ++c)
    if (e.channel[c].sh[0] > 0.0f)
      lit = max(lit, INV_PI / e.channel[c].sh[0] *
                         sound_light(direct_scale * load_direct(buffer, image,
                                                                x, y, c, count),
                                     &sound));
#endif
  const realv dark = max(1.0f - lit / max(ao, (realv)1e-6f), (realv)0.0f);
  return ao * dark * dark;
}
#endif

/* What turns the coefficients' irradiance scale of order l back into radiance:
 * the inverse of pi, 2 pi / 3, pi / 4 (Ramamoorthi and Hanrahan 2001). */
#define SH_RADIANCE_0 0.318309886f /* 1 / pi */
#define SH_RADIANCE_1 0.477464829f /* 3 / (2 pi) */
#define SH_RADIANCE_2 1.273239545f /* 4 / pi */

/* Which inputs are shown, but have not been read by split. */
#define COUNT_SURFACE (!GATHER_RADIANCE && OUT_BEAUTY)
#define COUNT_F0 (!GATHER_RADIANCE && (OUT_BEAUTY || OUT_INDIRECT))
#define COUNT_EMISSION (!(GATHER_RADIANCE && GATHER_EMISSION) && OUT_BEAUTY)

/* sound: of each input, by pixel. */
INLINE void count_repaired(const intv *sound, intv solid,
                           volatile global uint *repaired) {
#if COUNT_SURFACE
  add_repaired(repaired + HBIL_SURFACE_ALBEDO,
               count_lanes(solid & !sound[HBIL_SURFACE_ALBEDO]));
  add_repaired(repaired + HBIL_SURFACE_DIRECT,
               count_lanes(solid & !sound[HBIL_SURFACE_DIRECT]));
#endif
#if COUNT_F0
  add_repaired(repaired + HBIL_SURFACE_F0,
               count_lanes(solid & !sound[HBIL_SURFACE_F0]));
#endif
#if COUNT_EMISSION
  add_repaired(repaired + HBIL_SURFACE_EMISSION,
               count_lanes(!sound[HBIL_SURFACE_EMISSION]));
#endif
}

kernel void composite(
    const hbil_view_args view, const hbil_transform_args world,
    global const float *resolved, global const float *estimate,
    global float *history, const hbil_plane_args planes,
    const hbil_environment_args environment, const float background,
    const float direct_scale, global const void *depth_buffer,
    const hbil_external_plane_args depth_image,
    global const void *albedo_buffer,
    const hbil_external_plane_args albedo_image, global const void *f0_buffer,
    const hbil_external_plane_args f0_image, global const void *direct_buffer,
    const hbil_external_plane_args direct_image,
    global const void *emission_buffer,
    const hbil_external_plane_args emission_image, global void *near_buffer,
    const hbil_external_plane_args near_image, global void *far_buffer,
    const hbil_external_plane_args far_image, global void *ao_buffer,
    const hbil_external_plane_args ao_image, global void *bent_buffer,
    const hbil_external_plane_args bent_image, global void *cone_buffer,
    const hbil_external_plane_args cone_image, global void *indirect_buffer,
    const hbil_external_plane_args indirect_image, global void *radiance_buffer,
    const hbil_external_plane_args radiance_image, global void *error_buffer,
    const hbil_external_plane_args error_image,
    volatile global uint *repaired) {
  const int x0 = (int)get_global_id(0) * (PARTS * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  if (x0 >= view.width || y >= view.height)
    return;
  const int parts = min(PARTS, (view.width - x0 + HBIL_WIDTH - 1) / HBIL_WIDTH);
  realv pending[PENDING_COUNT][PARTS];
  for (int part = 0; part < parts; ++part) {
    const int x = x0 + part * HBIL_WIDTH, count = view.width - x;
    global const float *at = resolved + (uint)y * planes.row + (uint)x;
    const realv rx = ray_x(view, x, 1);
    const float ry = ray_y(view, y);
    const realv z =
        planar_depth(load_depth(depth_buffer, depth_image, x, y, 0, count), rx,
                     ry, background);
    const intv solid = z > 0.0f;
    /* a mean of values up to 1 may round to just above it */
    const realv ao = clamp(READV(at), 0.0f, 1.0f);
    const realv t2 = 1.0f - ao;
    const realv t = select((realv)0.0f, sqrt(t2), solid);
#if OUT_AO
    pending[PENDING_AO][part] = ao;
#endif
#if OUT_CONE
    pending[PENDING_CONE][part] = t;
#endif
#if OUT_ERROR
    pending[PENDING_ERROR][part] = READV(at + ERROR_PLANE * planes.plane);
#if GATHER_RADIANCE
    pending[PENDING_ERROR + 1][part] =
        READV(at + (ERROR_PLANE + 1) * planes.plane);
#else
    pending[PENDING_ERROR + 1][part] = 0.0f;
#endif
#endif
#if GATHER_BENT
    realv bent[3], axis[3];
#pragma unroll
    for (int c = 0; c < 3; ++c)
      bent[c] = READV(at + (HBIL_LIGHT_BENT + c) * planes.plane);
    turned(world, bent, axis);
#if OUT_BENT
#pragma unroll
    for (int c = 0; c < 3; ++c)
      pending[PENDING_BENT + c][part] = BENT_IS_WORLD ? axis[c] : bent[c];
#endif
#endif
#if FAR == 2
    const realv aperture[3] = {ao, fma(-t2, t, (realv)1.0f),
                               3.0f * fma(-t2, t2, (realv)1.0f) - 2.0f * ao};
    const realv ray[3] = {rx, ry, 1.0f};
    realv sky[3];
    turned(world, ray, sky);
    const realv inv_r = 1.0f / sqrt(fma(rx, rx, (realv)fma(ry, ry, 1.0f)));
#pragma unroll
    for (int c = 0; c < 3; ++c)
      sky[c] *= inv_r;
    const realv unscaled[3] = {SH_RADIANCE_0, SH_RADIANCE_1, SH_RADIANCE_2};
#endif
#if HISTORY
    pending[PENDING_HISTORY + HBIL_HISTORY_W][part] =
        select((realv)0.0f, 1.0f / z, solid);
#endif
#if FAR == 3
    realv frame[3];
    frame_light(estimate, bent[0], bent[1], bent[2], frame);
    const realv unlit = unlit_share(environment, ao, direct_scale,
                                    direct_buffer, direct_image, x, y, count);
#endif
#if FAR == 1 || FAR == 2
    /* a loop may not index the argument: see turned() */
    const hbil_sh_args far[3] = {environment.channel[0], environment.channel[1],
                                 environment.channel[2]};
#endif
    intv sound[HBIL_SURFACE_INPUTS] = {TRUE_LANES, TRUE_LANES, TRUE_LANES,
                                       TRUE_LANES};
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      realv near_irradiance = 0.0f, far_irradiance = 0.0f, behind = 0.0f;
#if GATHER_RADIANCE
      /* a sum of differences of angles may round to just below 0; what is no
       * number stays none, to be seen */
      near_irradiance = READV(at + (HBIL_LIGHT_RED + c) * planes.plane);
      near_irradiance =
          select(near_irradiance, (realv)0.0f, near_irradiance < 0.0f);
#endif
#if FAR == 1
      behind = far[c].sh[0];
      far_irradiance = PI * ao * behind;
#elif FAR == 3
      far_irradiance =
          PI * unlit *
          unseen_light(frame[c], near_irradiance * INV_PI, 1.0f - ao);
#elif FAR == 2
      behind = sh_light(far[c], sky, unscaled);
      far_irradiance = sh_light(far[c], axis, aperture);
#endif
      far_irradiance = select((realv)0.0f, far_irradiance, solid);
      realv reflectance = 1.0f, diffuse = 1.0f, irradiance = 0.0f;
      realv emitted = 0.0f;
#if HAS_ALBEDO && REFLECTED
      reflectance =
          sound_share(load_albedo(albedo_buffer, albedo_image, x, y, c, count),
                      sound + HBIL_SURFACE_ALBEDO);
#endif
#if HAS_F0 && (REFLECTED || OUT_INDIRECT)
      diffuse -= sound_share(load_f0(f0_buffer, f0_image, x, y, c, count),
                             sound + HBIL_SURFACE_F0);
#endif
#if HAS_DIRECT && REFLECTED
      irradiance =
          sound_light(direct_scale * load_direct(direct_buffer, direct_image, x,
                                                 y, c, count),
                      sound + HBIL_SURFACE_DIRECT);
#endif
#if HAS_EMISSION && REFLECTED
      emitted = sound_light(
          load_emission(emission_buffer, emission_image, x, y, c, count),
          sound + HBIL_SURFACE_EMISSION);
      behind = emitted;
#endif
      const realv light = near_irradiance + far_irradiance;
      const realv indirect = diffuse * INV_PI * light;
      const realv reflected =
          reflectance * fma(diffuse * INV_PI, irradiance, indirect);
#if OUT_NEAR
      pending[PENDING_NEAR + c][part] = near_irradiance;
#endif
#if OUT_FAR
      pending[PENDING_FAR + c][part] = far_irradiance;
#endif
#if OUT_INDIRECT
      pending[PENDING_INDIRECT + c][part] =
          select((realv)0.0f, indirect, solid);
#endif
#if OUT_BEAUTY
      pending[PENDING_RADIANCE + c][part] =
          select(behind, reflected + emitted, solid);
#endif
#if HISTORY
#if FEEDBACK_RADIANCE
      const realv carried = GATHER_EMISSION ? reflected + emitted : reflected;
#else
      const realv carried = light;
#endif
      pending[PENDING_HISTORY + HBIL_HISTORY_RED + c][part] =
          select((realv)0.0f, carried, solid);
#endif
    }
#if COUNT_SURFACE || COUNT_F0 || COUNT_EMISSION
    count_repaired(sound, solid, repaired + HBIL_SANITIZED_LATE);
#endif
  }
#define STORE_CHANNELS(name, channels, first)                                  \
  for (int c = 0; c < (channels); ++c)                                         \
    for (int part = 0; part < parts; ++part)                                   \
      store_##name(pending[(first) + c][part], name##_buffer, name##_image,    \
                   x0 + part * HBIL_WIDTH, y, c,                               \
                   view.width - x0 - part * HBIL_WIDTH);
#if OUT_AO
  STORE_CHANNELS(ao, 1, PENDING_AO)
#endif
#if OUT_CONE
  STORE_CHANNELS(cone, 1, PENDING_CONE)
#endif
#if OUT_ERROR
  STORE_CHANNELS(error, 2, PENDING_ERROR)
#endif
#if OUT_BENT
  STORE_CHANNELS(bent, 3, PENDING_BENT)
#endif
#if OUT_NEAR
  STORE_CHANNELS(near, 3, PENDING_NEAR)
#endif
#if OUT_FAR
  STORE_CHANNELS(far, 3, PENDING_FAR)
#endif
#if OUT_INDIRECT
  STORE_CHANNELS(indirect, 3, PENDING_INDIRECT)
#endif
#if OUT_BEAUTY
  STORE_CHANNELS(radiance, 3, PENDING_RADIANCE)
#endif
#if HISTORY
  history += hbil_history_origin(planes) + (uint)y * planes.row + (uint)x0;
  for (int p = 0; p < HBIL_HISTORY_PLANES; ++p)
    for (int part = 0; part < parts; ++part)
      STREAMV(pending[PENDING_HISTORY + p][part],
              history + (uint)p * planes.plane + part * HBIL_WIDTH);
#endif
}
