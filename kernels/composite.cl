/*
 * composite: far light through the bent cone, the outputs, and the light that
 * the next frame starts from.
 *
 * Cone (doc/method.md, section 12): AO is cosine weighted, so a cone of
 * half-angle alpha has AO = sin^2(alpha), and t = cos(alpha) = sqrt(1 - AO).
 * Light of order-2 SH through it is
 *   E  = sum sqrt(4 pi / (2l+1)) c_l(t) L_lm Y_lm(bent)
 *   c0 = sqrt(pi)/2 (1-t^2)
 *   c1 = sqrt(3 pi)/3 (1-t^3)
 *   c2 = sqrt(5 pi)/8 (3 (1-t^4) - 2 (1-t^2))
 * The host multiplies the constants into the coefficients, which leaves
 *   E = (1-t^2) s0 + (1-t^3) s1 . Y1 + (3 (1-t^4) - 2 (1-t^2)) s2 . Y2
 * with Y1 = (y, z, x), Y2 = (xy, yz, 3z^2-1, zx, x^2-y^2).
 *
 * Fresnel: the share 1 - F0 of the light is reflected diffusely (Mayaux 2018,
 * 2.3.3).
 *
 * Launch: x = groups of LINE pixels of a row, y = rows.
 * In: resolved light, the estimate of unseen light, the caller's inputs.  Out:
 * the caller's outputs, history planes, counts of the sanitized inputs that
 * split does not read.
 */
#include "lib/depth.clh"
#include "lib/probe_light.clh"
#include "lib/radiance.clh"
#include "lib/sanitize.clh"
#include "lib/sh_light.clh"
#include "lib/sky_share.clh"
#include "lib/unseen_light.clh"

#if !defined(FAR) || FAR < 0 || FAR > 3
#error FAR must be 0 (none), 1 (constant), 2 (SH) or 3 (the frame's estimate)
#endif
#if !defined(LINE) || LINE < HBIL_WIDTH || LINE % HBIL_WIDTH
#error LINE must be a multiple of HBIL_WIDTH
#endif
#if OUT_ERROR && (!defined(ERROR_PLANE) || ERROR_PLANE < 1)
#error ERROR_PLANE must be the first plane behind the light
#endif
#if !defined(UNKNOWN_PLANE) || (UNKNOWN_PLANE && !OUT_UNKNOWN)
#error UNKNOWN_PLANE must be 0 without OUT_UNKNOWN
#endif
#if !defined(GATHER_RADIANCE) || GATHER_RADIANCE < 0 || GATHER_RADIANCE > 1
#error GATHER_RADIANCE must be 0..1
#endif
#if !defined(GATHER_BENT) || GATHER_BENT < 0 || GATHER_BENT > 1
#error GATHER_BENT must be 0..1
#endif
#if !defined(GATHER_EMISSION) || GATHER_EMISSION < 0 || GATHER_EMISSION > 1
#error GATHER_EMISSION must be 0..1
#endif
#if !defined(PROBES) || PROBES < 0 || PROBES > 1
#error PROBES must be 0..1
#endif
#if !defined(HISTORY) || HISTORY < 0 || HISTORY > 1
#error HISTORY must be 0..1
#endif
#if !defined(FEEDBACK_RADIANCE) || FEEDBACK_RADIANCE < 0 ||                    \
    FEEDBACK_RADIANCE > 1
#error FEEDBACK_RADIANCE must be 0..1
#endif
#if !defined(BENT_IS_WORLD) || BENT_IS_WORLD < 0 || BENT_IS_WORLD > 1
#error BENT_IS_WORLD must be 0..1
#endif
#if !defined(HAS_ALBEDO) || HAS_ALBEDO < 0 || HAS_ALBEDO > 1
#error HAS_ALBEDO must be 0..1
#endif
#if !defined(HAS_F0) || HAS_F0 < 0 || HAS_F0 > 1
#error HAS_F0 must be 0..1
#endif
#if !defined(HAS_DIRECT) || HAS_DIRECT < 0 || HAS_DIRECT > 1
#error HAS_DIRECT must be 0..1
#endif
#if !defined(HAS_EMISSION) || HAS_EMISSION < 0 || HAS_EMISSION > 1
#error HAS_EMISSION must be 0..1
#endif

LOADER(albedo, ALBEDO_TYPE, ALBEDO_STRIDE)
LOADER(f0, F0_TYPE, F0_STRIDE)
LOADER(emission, EMISSION_TYPE, EMISSION_STRIDE)
STORER(near_irradiance, NEAR_TYPE, NEAR_STRIDE)
STORER(far_irradiance, FAR_TYPE, FAR_STRIDE)
STORER(ao, AO_TYPE, AO_STRIDE)
STORER(bent_normal, BENT_TYPE, BENT_STRIDE)
STORER(cone_cosine, CONE_TYPE, CONE_STRIDE)
STORER(indirect, INDIRECT_TYPE, INDIRECT_STRIDE)
STORER(beauty, BEAUTY_TYPE, BEAUTY_STRIDE)
STORER(error_estimate, ERROR_TYPE, ERROR_STRIDE)
STORER(unknown, UNKNOWN_TYPE, UNKNOWN_STRIDE)

#define PI 3.14159265f

/* Vectors of a row that a work-item takes; on CPUs they make a cache line of
 * the outputs.  The work-item collects its results and stores them plane by
 * plane, a whole line at a time, past the caches.  Such stores, to twenty
 * planes in turn, take half as long as stores that first fetch what they
 * overwrite; with less than a line at a time they would take twice as long. */
#define PARTS (LINE / HBIL_WIDTH)

/* Where the collected planes begin.  Planes that are no outputs take no room.
 */
enum {
  PENDING_AO = 0,
  PENDING_CONE = PENDING_AO + OUT_AO,
  PENDING_ERROR = PENDING_CONE + OUT_CONE,
  PENDING_UNKNOWN = PENDING_ERROR + 2 * OUT_ERROR,
  PENDING_BENT = PENDING_UNKNOWN + OUT_UNKNOWN,
  PENDING_NEAR = PENDING_BENT + 3 * OUT_BENT,
  PENDING_FAR = PENDING_NEAR + 3 * OUT_NEAR,
  PENDING_INDIRECT = PENDING_FAR + 3 * OUT_FAR,
  PENDING_BEAUTY = PENDING_INDIRECT + 3 * OUT_INDIRECT,
  PENDING_HISTORY = PENDING_BEAUTY + 3 * OUT_BEAUTY,
  PENDING_COUNT = PENDING_HISTORY + HISTORY * HISTORY_PLANES
};

/* Whether reflected light is needed, and with it the inputs that make it. */
#define REFLECTED (OUT_BEAUTY || (HISTORY && FEEDBACK_RADIANCE))

/* The caller's inputs. */
typedef struct inputs {
  global const void *albedo, *f0, *direct, *emission;
} inputs;

/* --- far light ------------------------------------------------------------ */

/* Far irradiance of the three channels, and the radiance that shows where there
 * is no surface.  unlit: the share of the hemisphere, of `ao`, whose radiance
 * is estimated.  cached: what the radiance cache knows of the open directions;
 * the others get what they get without it.  near_light: E_near.  axis, bent:
 * the bent normal in world and view space; (rx, ry, 1): the ray. */
INLINE void far_light(const hbil_composite_args args,
                      global const float *estimate, const inputs *in,
                      global const void *depth, realv z, realv ao, realv t,
                      realv t2, const realv near_light[3], const realv bent[3],
                      const realv axis[3], realv rx, float ry, int x, int y,
                      const probe_light *cached, realv light[3],
                      realv behind[3], realv *unlit) {
  const realv other = 1.0f - cached->share;
  *unlit = 0.0f;
#if FAR == 1 || FAR == 2
  /* not indexed as an argument: see rotate_direction() */
  const hbil_sh_args far[3] = {args.environment.channel[0],
                               args.environment.channel[1],
                               args.environment.channel[2]};
#endif
#if FAR == 2
  const realv aperture[3] = {ao, fma(-t2, t, (realv)1.0f),
                             3.0f * fma(-t2, t2, (realv)1.0f) - 2.0f * ao};
  const realv unscaled[3] = {SH_RADIANCE_0, SH_RADIANCE_1, SH_RADIANCE_2};
  const realv ray[3] = {rx, ry, 1.0f};
  realv sky[3];
  rotate_direction(args.to_world, ray, sky);
  const realv inv_r = 1.0f / sqrt(fma(rx, rx, (realv)fma(ry, ry, 1.0f)));
#pragma unroll
  for (int c = 0; c < 3; ++c)
    sky[c] *= inv_r;
#elif FAR == 3
  realv frame[3];
  frame_light(estimate, bent[0], bent[1], bent[2], frame);
  *unlit = min(other * ao,
               unlit_share(estimate,
                           mean_sky_light(args, in->direct, depth, z, x, y), ao,
                           args.sky_share));
#endif
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    light[c] = behind[c] = 0.0f;
#if FAR == 1
    behind[c] = far[c].sh[0];
    light[c] = other * (PI * ao * behind[c]);
#elif FAR == 2
    behind[c] = sh_light(far[c], sky, unscaled);
    light[c] = other * sh_light(far[c], axis, aperture);
#elif FAR == 3
    light[c] = PI * *unlit *
               unseen_light(estimate, c, frame[c], near_light[c] * INV_PI,
                            1.0f - ao, cached->light[c], ao * cached->share);
#endif
#if PROBES
    light[c] += PI * cached->light[c];
#endif
  }
}

/* --- counts of sanitized pixels ------------------------------------------- */

/* Inputs that are shown, but that split has not read. */
#define COUNT_SURFACE (!GATHER_RADIANCE && OUT_BEAUTY)
#define COUNT_F0 (!GATHER_RADIANCE && (OUT_BEAUTY || OUT_INDIRECT))
#define COUNT_EMISSION (!(GATHER_RADIANCE && GATHER_EMISSION) && OUT_BEAUTY)

/* Counts them.  usable: a mask of pixels for each input. */
INLINE void count_sanitized(const intv *usable, intv solid,
                            volatile global uint *sanitized) {
  if (COUNT_SURFACE) {
    add_sanitized(sanitized + HBIL_SURFACE_ALBEDO,
                  count_lanes(solid & !usable[HBIL_SURFACE_ALBEDO]));
    add_sanitized(sanitized + HBIL_SURFACE_DIRECT,
                  count_lanes(solid & !usable[HBIL_SURFACE_DIRECT]));
  }
  if (COUNT_F0)
    add_sanitized(sanitized + HBIL_SURFACE_F0,
                  count_lanes(solid & !usable[HBIL_SURFACE_F0]));
  if (COUNT_EMISSION)
    add_sanitized(sanitized + HBIL_SURFACE_EMISSION,
                  count_lanes(!usable[HBIL_SURFACE_EMISSION]));
}

/* --- a vector of pixels --------------------------------------------------- */

/* Computes the outputs of a channel and stores them in part `part` of the
 * collected planes.  near_light: E_near, far: E_far, both of the channel;
 * behind: what the sky shows.  Returns the light that is carried over. */
INLINE realv compose_channel(const hbil_composite_args args, const inputs *in,
                             realv near_light, realv far, realv behind,
                             intv solid, int c, int x, int y, int count,
                             intv *usable, realv pending[][PARTS], int part) {
  realv albedo = 1.0f, diffuse = 1.0f, irradiance = 0.0f, emitted = 0.0f;
#if HAS_ALBEDO && REFLECTED
  albedo =
      usable_reflectance(load_albedo(in->albedo, args.albedo, x, y, c, count),
                         usable + HBIL_SURFACE_ALBEDO);
#endif
#if HAS_F0 && (REFLECTED || OUT_INDIRECT)
  diffuse -= usable_reflectance(load_f0(in->f0, args.f0, x, y, c, count),
                                usable + HBIL_SURFACE_F0);
#endif
#if HAS_DIRECT && REFLECTED
  irradiance = usable_light(
      args.direct_scale * load_direct(in->direct, args.direct, x, y, c, count),
      usable + HBIL_SURFACE_DIRECT);
#endif
#if HAS_EMISSION && REFLECTED
  emitted =
      usable_light(load_emission(in->emission, args.emission, x, y, c, count),
                   usable + HBIL_SURFACE_EMISSION);
  behind = emitted;
#endif
  const realv light = near_light + far;
  const realv indirect = diffuse * INV_PI * light;
  const realv reflected = albedo * fma(diffuse * INV_PI, irradiance, indirect);
  if (OUT_NEAR)
    pending[PENDING_NEAR + c][part] = near_light;
  if (OUT_FAR)
    pending[PENDING_FAR + c][part] = far;
  if (OUT_INDIRECT)
    pending[PENDING_INDIRECT + c][part] = select((realv)0.0f, indirect, solid);
  if (OUT_BEAUTY)
    pending[PENDING_BEAUTY + c][part] =
        select(behind, reflected + emitted, solid);
  const realv carried = !FEEDBACK_RADIANCE ? light
                        : GATHER_EMISSION  ? reflected + emitted
                                           : reflected;
  return select((realv)0.0f, carried, solid);
}

INLINE void read_near_light(global const float *at, uint plane,
                            realv near_light[3]) {
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    /* A sum of differences of angles may round to just below 0.  NaN remains
     * NaN, so that it can be seen. */
    const realv light = READV(at + (HBIL_LIGHT_RED + c) * plane);
    near_light[c] = select(light, (realv)0.0f, light < 0.0f);
  }
}

INLINE void collect_carried(const realv carried[3], realv pending[][PARTS],
                            int part) {
  realv value[RADIANCE_PLANES];
  pack_radiance(carried, value);
#pragma unroll
  for (int p = 0; p < RADIANCE_PLANES; ++p)
    pending[PENDING_HISTORY + HBIL_HISTORY_RED + p][part] = value[p];
}

/* Collects all planes of the pixels from (x, y) on. */
INLINE void compose(const hbil_composite_args args,
                    global const float *resolved, global const float *estimate,
                    global const void *depth_buffer, const inputs *in,
                    global const float *probes, int x, int y,
                    realv pending[][PARTS], int part,
                    volatile global uint *sanitized) {
  const hbil_view_args view = args.view;
  const uint plane = args.planes.plane;
  const int count = view.width - x;
  global const float *at = resolved + (uint)y * args.planes.row + (uint)x;
  const realv rx = ray_x(view, x, 1);
  const float ry = ray_y(view, y);
  const realv z = planar_depth(
      stored_depth(depth_buffer, args.depth, args.decode, x, y, count), rx, ry,
      args.decode);
  const intv solid = z > 0.0f;
  /* a mean of values up to 1 may round to just above it */
  const realv ao = clamp(READV(at), 0.0f, 1.0f);
  const realv t2 = 1.0f - ao;
  const realv t = select((realv)0.0f, sqrt(t2), solid);
  if (OUT_AO)
    pending[PENDING_AO][part] = ao;
  if (OUT_CONE)
    pending[PENDING_CONE][part] = t;
#if OUT_ERROR
  pending[PENDING_ERROR][part] = READV(at + ERROR_PLANE * plane);
  pending[PENDING_ERROR + 1][part] =
      GATHER_RADIANCE ? READV(at + (ERROR_PLANE + 1) * plane) : (realv)0.0f;
#endif
  if (HISTORY)
    pending[PENDING_HISTORY + HBIL_HISTORY_W][part] =
        select((realv)0.0f, 1.0f / z, solid);
  realv bent[3] = {0.0f, 0.0f, 0.0f}, axis[3] = {0.0f, 0.0f, 0.0f};
  if (GATHER_BENT) {
#pragma unroll
    for (int c = 0; c < 3; ++c)
      bent[c] = READV(at + (HBIL_LIGHT_BENT + c) * plane);
    rotate_direction(args.to_world, bent, axis);
  }
  if (OUT_BENT) {
#pragma unroll
    for (int c = 0; c < 3; ++c)
      pending[PENDING_BENT + c][part] = BENT_IS_WORLD ? axis[c] : bent[c];
  }
  realv near_light[3] = {0.0f, 0.0f, 0.0f}, far[3], behind[3], unlit;
  if (GATHER_RADIANCE)
    read_near_light(at, plane, near_light);
  probe_light cached = {{0.0f, 0.0f, 0.0f}, 0.0f};
#if PROBES
  if (args.probes.columns > 0)
    cached = light_of_probes(args.probes, view, probes, x, y, z, ao, t, bent);
#endif
  far_light(args, estimate, in, depth_buffer, z, ao, t, t2, near_light, bent,
            axis, rx, ry, x, y, &cached, far, behind, &unlit);
#if OUT_UNKNOWN
  realv unknown = unlit;
#if UNKNOWN_PLANE
  unknown += READV(at + UNKNOWN_PLANE * plane);
#endif
  /* both shares are rounded, and a packed one is dithered */
  pending[PENDING_UNKNOWN][part] =
      select((realv)0.0f, min(unknown, (realv)1.0f), solid);
#endif
  intv usable[HBIL_SURFACE_INPUTS] = {TRUE_LANES, TRUE_LANES, TRUE_LANES,
                                      TRUE_LANES};
  realv carried[3];
#pragma unroll
  for (int c = 0; c < 3; ++c)
    carried[c] = compose_channel(args, in, near_light[c],
                                 select((realv)0.0f, far[c], solid), behind[c],
                                 solid, c, x, y, count, usable, pending, part);
  if (HISTORY)
    collect_carried(carried, pending, part);
  if (COUNT_SURFACE || COUNT_F0 || COUNT_EMISSION)
    count_sanitized(usable, solid, sanitized + HBIL_SANITIZED_LATE);
}

/* --- the kernel ----------------------------------------------------------- */

#define STORE_CHANNELS(name, channels, first)                                  \
  for (int c = 0; c < (channels); ++c)                                         \
    for (int part = 0; part < parts; ++part)                                   \
      store_##name(pending[(first) + c][part], name, args.name,                \
                   x0 + part * HBIL_WIDTH, y, c,                               \
                   args.view.width - x0 - part * HBIL_WIDTH);

/* The planes are the caller's and each may be a buffer of its own, so there are
 * more arguments than in other passes. */
kernel void composite(
    const hbil_composite_args args, global const float *resolved,
    global const float *estimate, global float *history,
    global const void *depth, global const void *albedo, global const void *f0,
    global const void *direct, global const void *emission,
    global void *near_irradiance, global void *far_irradiance, global void *ao,
    global void *bent_normal, global void *cone_cosine, global void *indirect,
    global void *beauty, global void *error_estimate, global void *unknown,
    global const float *probes, volatile global uint *sanitized) {
  const int x0 = (int)get_global_id(0) * (PARTS * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  if (x0 >= args.view.width || y >= args.view.height)
    return;
  const inputs in = {albedo, f0, direct, emission};
  const int parts =
      min(PARTS, (args.view.width - x0 + HBIL_WIDTH - 1) / HBIL_WIDTH);
  realv pending[PENDING_COUNT][PARTS];
  for (int part = 0; part < parts; ++part)
    compose(args, resolved, estimate, depth, &in, probes,
            x0 + part * HBIL_WIDTH, y, pending, part, sanitized);
  STORE_CHANNELS(ao, OUT_AO, PENDING_AO)
  STORE_CHANNELS(cone_cosine, OUT_CONE, PENDING_CONE)
  STORE_CHANNELS(error_estimate, 2 * OUT_ERROR, PENDING_ERROR)
  STORE_CHANNELS(unknown, OUT_UNKNOWN, PENDING_UNKNOWN)
  STORE_CHANNELS(bent_normal, 3 * OUT_BENT, PENDING_BENT)
  STORE_CHANNELS(near_irradiance, 3 * OUT_NEAR, PENDING_NEAR)
  STORE_CHANNELS(far_irradiance, 3 * OUT_FAR, PENDING_FAR)
  STORE_CHANNELS(indirect, 3 * OUT_INDIRECT, PENDING_INDIRECT)
  STORE_CHANNELS(beauty, 3 * OUT_BEAUTY, PENDING_BEAUTY)
#if HISTORY
  history +=
      hbil_history_origin(args.planes) + (uint)y * args.planes.row + (uint)x0;
  for (int p = 0; p < HISTORY_PLANES; ++p)
    for (int part = 0; part < parts; ++part)
      STREAMV(pending[PENDING_HISTORY + p][part],
              history + (uint)p * args.planes.plane + part * HBIL_WIDTH);
#endif
}
