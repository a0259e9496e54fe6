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
 * Where no near light is computed, a factor may stand in for what occluders
 * reflect (lib/ao_bounces.clh).
 *
 * Fresnel: the share 1 - F0 of the light is reflected diffusely (Mayaux 2018,
 * 2.3.3).
 *
 * Launch: x = groups of LINE pixels of a row, y = rows.
 * In: resolved light, with AO_SEARCH also that of the search for the outputs,
 * the estimate of unseen light, the caller's inputs.  Out: the caller's
 * outputs, history planes, counts of the sanitized inputs that split does not
 * read.
 */
#include "lib/ao_bounces.clh"
#include "lib/depth.clh"
#include "lib/far_light.clh"
#include "lib/flags.clh"
#include "lib/probe_light.clh"
#include "lib/radiance.clh"
#include "lib/surface_inputs.clh"

/* 1: ao, bent_normal, cone_cosine and the error of AO are of another search
 * than light; AO_ERROR_PLANE is where the latter is */
FLAG(AO_SEARCH)
FLAG(GATHER_RADIANCE)
FLAG(GATHER_BENT)
FLAG(GATHER_EMISSION)
FLAG(PROBES)
FLAG(HISTORY)
FLAG(FEEDBACK_RADIANCE)
FLAG(BENT_IS_WORLD)

#if LINE < HBIL_WIDTH || LINE % HBIL_WIDTH
#error LINE must be a multiple of HBIL_WIDTH
#endif
#if OUT_ERROR && ERROR_PLANE < 1
#error ERROR_PLANE must be the first plane behind the light
#endif
#if !defined(UNKNOWN_PLANE) || (UNKNOWN_PLANE && !OUT_UNKNOWN)
#error UNKNOWN_PLANE must be 0 without OUT_UNKNOWN
#endif

STORER(near_irradiance, NEAR_TYPE, NEAR_STRIDE)
STORER(far_irradiance, FAR_TYPE, FAR_STRIDE)
STORER(ao, AO_TYPE, AO_STRIDE)
STORER(bent_normal, BENT_TYPE, BENT_STRIDE)
STORER(cone_cosine, CONE_TYPE, CONE_STRIDE)
STORER(indirect, INDIRECT_TYPE, INDIRECT_STRIDE)
STORER(beauty, BEAUTY_TYPE, BEAUTY_STRIDE)
STORER(error_estimate, ERROR_TYPE, ERROR_STRIDE)
STORER(unknown, UNKNOWN_TYPE, UNKNOWN_STRIDE)

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

#if AO_BOUNCES && GATHER_RADIANCE
#error AO_BOUNCES must be 0 where near light is computed
#endif

/* What all pixels are composed of: planes of the passes before, and the
 * caller's. */
typedef struct inputs {
  global const float *resolved, *ao_search, *probes;
  surface_inputs surface;
  far_inputs far;
} inputs;

/* --- far light ------------------------------------------------------------ */

/* What a cone of t = cos(alpha) leaves of the orders of an environment. */
INLINE void cone_orders(realv ao, realv t, realv t2, realv orders[3]) {
  orders[0] = FAR == 1 ? PI * ao : ao;
  orders[1] = fma(-t2, t, (realv)1.0f);
  orders[2] = 3.0f * fma(-t2, t2, (realv)1.0f) - 2.0f * ao;
}

INLINE void set_known_light(far_receiver *r, const realv near_light[3],
                            const probe_light *cached) {
  r->shown_share = 1.0f - r->ao;
  r->cached_share = r->ao * cached->share;
  r->guess_share = cached->guess_share;
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    r->shown[c] = near_light[c] * INV_PI;
    r->cached[c] = cached->light[c];
    r->guess[c] = cached->guess[c];
  }
}

/* Far irradiance of a pixel from its open directions: from those that the cache
 * knows, and from the others.  Returns the share of the hemisphere whose
 * radiance is guessed. */
INLINE realv far_irradiance(const hbil_composite_args args, const inputs *in,
                            const far_receiver *r, const probe_light *cached,
                            realv irradiance[3]) {
  realv others = 1.0f - cached->share, guessed = 0.0f;
#if FAR == 3
  guessed = min(others * r->ao, guessed_share(args, &in->far, r));
  others = PI * guessed;
#endif
  far_light(args, &in->far, r, irradiance);
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    irradiance[c] *= others;
#if PROBES
    irradiance[c] += PI * cached->light[c];
#endif
  }
  return guessed;
}

/* What shows where there is no surface, along the rays (rx, ry, 1). */
INLINE void sky_behind(const hbil_composite_args args, realv rx, float ry,
                       realv radiance[3]) {
  const realv orders[3] = {FAR == 1 ? 1.0f : SH_RADIANCE_0, SH_RADIANCE_1,
                           SH_RADIANCE_2};
  const realv ray[3] = {rx, ry, 1.0f};
  const realv inv_r = 1.0f / sqrt(fma(rx, rx, (realv)fma(ry, ry, 1.0f)));
  realv direction[3];
  rotate_direction(args.to_world, ray, direction);
#pragma unroll
  for (int c = 0; c < 3; ++c)
    direction[c] *= inv_r;
  environment_light(args.environment, direction, orders, radiance);
}

/* --- counts of sanitized pixels ------------------------------------------- */

/* Inputs that are shown, but that split has not read. */
#define COUNT_ALBEDO (!GATHER_RADIANCE && (OUT_BEAUTY || AO_BOUNCES == 2))
#define COUNT_DIRECT (!GATHER_RADIANCE && OUT_BEAUTY)
#define COUNT_F0 (!GATHER_RADIANCE && (OUT_BEAUTY || OUT_INDIRECT))
#define COUNT_EMISSION (!(GATHER_RADIANCE && GATHER_EMISSION) && OUT_BEAUTY)

/* Counts them.  usable: a mask of pixels for each input. */
INLINE void count_sanitized(const intv *usable, intv solid,
                            volatile global uint *sanitized) {
  if (COUNT_ALBEDO)
    add_sanitized(sanitized + HBIL_SURFACE_ALBEDO,
                  count_lanes(solid & !usable[HBIL_SURFACE_ALBEDO]));
  if (COUNT_DIRECT)
    add_sanitized(sanitized + HBIL_SURFACE_DIRECT,
                  count_lanes(solid & !usable[HBIL_SURFACE_DIRECT]));
  if (COUNT_F0)
    add_sanitized(sanitized + HBIL_SURFACE_F0,
                  count_lanes(solid & !usable[HBIL_SURFACE_F0]));
  if (COUNT_EMISSION)
    add_sanitized(sanitized + HBIL_SURFACE_EMISSION,
                  count_lanes(!usable[HBIL_SURFACE_EMISSION]));
}

/* --- a vector of pixels --------------------------------------------------- */

/* Computes the outputs of a channel and stores them in part `part` of the
 * collected planes.  near_light: E_near, far: E_far without the light that
 * occluders reflect, both of the channel; behind: what the sky shows; t: the
 * cone's cosine.  Returns the light that is carried over. */
INLINE realv compose_channel(const hbil_composite_args args, const inputs *in,
                             realv near_light, realv far, realv behind, realv t,
                             intv solid, int c, const far_receiver *r,
                             int count, intv *usable, realv pending[][PARTS],
                             int part) {
  const int x = r->x, y = r->y;
  const hbil_surface_args surface = args.surface;
  realv albedo = 1.0f, diffuse = 1.0f, irradiance = 0.0f, emitted = 0.0f;
  if (REFLECTED || OUT_INDIRECT)
    diffuse = surface_diffuse(surface, &in->surface, c, x, y, count,
                              usable + HBIL_SURFACE_F0);
#if REFLECTED || AO_BOUNCES == 2
  albedo = surface_albedo(surface, &in->surface, c, x, y, count,
                          usable + HBIL_SURFACE_ALBEDO);
#endif
#if REFLECTED
  irradiance = irradiance_of(direct_light(surface, in->surface.direct, c, x, y,
                                          count, usable + HBIL_SURFACE_DIRECT),
                             albedo);
  emitted = surface_emission(surface, &in->surface, c, x, y, count,
                             usable + HBIL_SURFACE_EMISSION);
  if (HAS_EMISSION)
    behind = emitted;
#endif
  if (AO_BOUNCES)
    far *= ao_bounces(r->ao, t, albedo);
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

INLINE void read_near_light(global const float *resolved, uint plane,
                            realv near_light[3]) {
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    /* A sum of differences of angles may round to just below 0.  NaN remains
     * NaN, so that it can be seen. */
    const realv light = READV(resolved + (HBIL_LIGHT_RED + c) * plane);
    near_light[c] = select(light, (realv)0.0f, light < 0.0f);
  }
}

INLINE void collect_carried(const hbil_composite_args args,
                            const realv carried[3], realv pending[][PARTS],
                            int part) {
  const realv scale = args.per_exposure;
  const realv light[3] = {scale * carried[0], scale * carried[1],
                          scale * carried[2]};
  realv value[RADIANCE_PLANES];
  pack_radiance(light, value);
#pragma unroll
  for (int p = 0; p < RADIANCE_PLANES; ++p)
    pending[PENDING_HISTORY + HBIL_HISTORY_RED + p][part] = value[p];
}

/* Reads the bent cone of the light planes at `at`, with its axis if there is
 * one.  Returns the cosine of its half-angle. */
INLINE realv read_cone(const hbil_composite_args args, global const float *at,
                       intv solid, bool bent, far_receiver *r) {
  /* a mean of values up to 1 may round to just above it */
  r->ao = clamp(READV(at), 0.0f, 1.0f);
  if (bent) {
#pragma unroll
    for (int c = 0; c < 3; ++c)
      r->view_axis[c] = READV(at + (HBIL_LIGHT_BENT + c) * args.planes.plane);
    rotate_direction(args.to_world, r->view_axis, r->world_axis);
  }
  return select((realv)0.0f, sqrt(1.0f - r->ao), solid);
}

/* Collects the outputs that show such a cone. */
INLINE void collect_cone(const far_receiver *r, realv t,
                         global const float *error, realv pending[][PARTS],
                         int part) {
  if (OUT_AO)
    pending[PENDING_AO][part] = r->ao;
  if (OUT_CONE)
    pending[PENDING_CONE][part] = t;
  if (OUT_ERROR)
    pending[PENDING_ERROR][part] = READV(error);
  if (OUT_BENT) {
#pragma unroll
    for (int c = 0; c < 3; ++c)
      pending[PENDING_BENT + c][part] =
          BENT_IS_WORLD ? r->world_axis[c] : r->view_axis[c];
  }
}

/* Collects all planes of the pixels from (x, y) on. */
INLINE void compose(const hbil_composite_args args, const inputs *in, int x,
                    int y, realv pending[][PARTS], int part,
                    volatile global uint *sanitized) {
  const hbil_view_args view = args.view;
  const uint plane = args.planes.plane;
  const int count = view.width - x;
  global const float *here = in->resolved + (uint)y * args.planes.row + (uint)x;
  const realv rx = ray_x(view, x, 1);
  const float ry = ray_y(view, y);
  const realv z = planar_depth(
      stored_depth(in->far.depth, args.depth, args.decode, x, y, count), rx, ry,
      args.decode);
  const intv solid = z > 0.0f;
  far_receiver r = {.x = x, .y = y, .z = z};
  const realv t = read_cone(args, here, solid, GATHER_BENT, &r);
#if AO_SEARCH
  global const float *const shown = in->ao_search + (here - in->resolved);
  far_receiver open = {.x = x, .y = y, .z = z};
  const realv open_t = read_cone(args, shown, solid, OUT_BENT, &open);
  collect_cone(&open, open_t, shown + AO_ERROR_PLANE * plane, pending, part);
#else
  collect_cone(&r, t, here + ERROR_PLANE * plane, pending, part);
#endif
#if OUT_ERROR
  pending[PENDING_ERROR + 1][part] =
      GATHER_RADIANCE ? READV(here + (ERROR_PLANE + 1) * plane) : (realv)0.0f;
#endif
  if (HISTORY)
    pending[PENDING_HISTORY + HBIL_HISTORY_W][part] =
        select((realv)0.0f, 1.0f / z, solid);
  realv near_light[3] = {0.0f, 0.0f, 0.0f}, far[3], behind[3];
  if (GATHER_RADIANCE)
    read_near_light(here, plane, near_light);
  probe_light cached = {{0.0f, 0.0f, 0.0f}, 0.0f};
#if PROBES
  if (args.probes.columns > 0)
    cached = light_of_probes(args.probes, view, in->probes, x, y, z, r.ao, t,
                             r.view_axis, args.exposure);
#endif
  cone_orders(r.ao, t, 1.0f - r.ao, r.orders);
  set_known_light(&r, near_light, &cached);
  const realv guessed = far_irradiance(args, in, &r, &cached, far);
  sky_behind(args, rx, ry, behind);
#if OUT_UNKNOWN
  realv unknown = guessed;
#if UNKNOWN_PLANE
  unknown += READV(here + UNKNOWN_PLANE * plane);
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
                                 t, solid, c, &r, count, usable, pending, part);
  if (HISTORY)
    collect_carried(args, carried, pending, part);
  if (COUNT_ALBEDO || COUNT_DIRECT || COUNT_F0 || COUNT_EMISSION)
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
kernel void
composite(const hbil_composite_args args, global const float *resolved,
          global const float *ao_search, global const float *estimate,
          global float *history, global const void *depth,
          global const void *albedo, global const void *f0,
          global const void *direct, global const void *emission,
          global void *near_irradiance, global void *far_irradiance,
          global void *ao, global void *bent_normal, global void *cone_cosine,
          global void *indirect, global void *beauty,
          global void *error_estimate, global void *unknown,
          global const float *probes, volatile global uint *sanitized) {
  const int x0 = (int)get_global_id(0) * (PARTS * HBIL_WIDTH);
  const int y = (int)get_global_id(1);
  if (x0 >= args.view.width || y >= args.view.height)
    return;
  const inputs in = {.resolved = resolved,
                     .ao_search = ao_search,
                     .probes = probes,
                     .surface = {albedo, f0, direct, emission},
                     .far = {estimate, depth, albedo, direct}};
  const int parts =
      min(PARTS, (args.view.width - x0 + HBIL_WIDTH - 1) / HBIL_WIDTH);
  realv pending[PENDING_COUNT][PARTS];
  for (int part = 0; part < parts; ++part)
    compose(args, &in, x0 + part * HBIL_WIDTH, y, pending, part, sanitized);
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
