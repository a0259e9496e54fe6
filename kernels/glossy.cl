/*
 * glossy: the output `glossy`, the mean radiance over a rough mirror's lobe
 * (lib/lobe.clh): what the gather has found of it, and for the rest of the lobe
 * what the radiance cache knows, then the far field or the estimate of unseen
 * light.
 *
 * Launch: x = groups of 4*HBIL_WIDTH pixels of a row, y = rows.
 * In: split planes (guides), resolved light, the estimate of unseen light,
 * glossy probes; direct light and depth of the caller, for the sky's share.
 * Out: the caller's plane `glossy`.
 */
#include "lib/depth.clh"
#include "lib/glossy_probes.clh"
#include "lib/guides.clh"
#include "lib/lobe.clh"
#include "lib/sh_light.clh"
#include "lib/sky_share.clh"
#include "lib/unseen_light.clh"

#if !defined(FAR) || FAR < 0 || FAR > 3
#error FAR must be 0 (none), 1 (constant), 2 (SH) or 3 (the frame's estimate)
#endif
#if !defined(PROBES) || PROBES < 0 || PROBES > 1
#error PROBES must be 0..1
#endif

STORER(glossy, GLOSSY_TYPE, GLOSSY_STRIDE)

/* A vector of surfaces as their mirrors see it: place, direction to the eye,
 * reflected direction, all in view space. */
typedef struct mirror {
  realv p[3], r[3], n[3];
  realv z, k;
} mirror;

INLINE mirror mirror_at(const hbil_view_args view, float lobe, realv w,
                        const realv n[3], int x, int y) {
  mirror m;
  const realv rx = ray_x(view, x, 1);
  const float ry = ray_y(view, y);
  const realv inv_r = 1.0f / sqrt(fma(rx, rx, (realv)fma(ry, ry, 1.0f)));
  const realv wo[3] = {-rx * inv_r, -ry * inv_r, -inv_r};
  const realv cosine = fma(n[0], wo[0], fma(n[1], wo[1], n[2] * wo[2]));
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    m.n[c] = n[c];
    m.r[c] = fma(2.0f * cosine, n[c], -wo[c]);
  }
  m.z = depth_at(w);
  const realv spread = spread_at(m.z);
  m.p[0] = plane_x(view, x, 1) * spread;
  m.p[1] = plane_y(view, y) * spread;
  m.p[2] = m.z;
  m.k = lobe_at(lobe, 1.0f / cosine);
  return m;
}

/* Radiance of the part of the lobe that no surface is known in.  open: that
 * part of the lobe; shown, known: sum of radiance and part of the lobe that are
 * known from the screen; ao: of the pixel. */
INLINE void far_glossy(const hbil_composite_args args,
                       const hbil_glossy_args own, global const float *estimate,
                       global const void *direct, global const void *depth,
                       const mirror *m, realv open, const realv shown[3],
                       realv known, realv ao, const glossy_light *cached, int x,
                       int y, realv light[3]) {
  const realv other = 1.0f - cached->share;
#if FAR == 1 || FAR == 2
  /* not indexed as an argument: see rotate_direction() */
  const hbil_sh_args far[3] = {args.environment.channel[0],
                               args.environment.channel[1],
                               args.environment.channel[2]};
#endif
#if FAR == 2
  const realv bands[3] = {SH_RADIANCE_0, own.bands[0] * SH_RADIANCE_1,
                          own.bands[1] * SH_RADIANCE_2};
  realv axis[3];
  rotate_direction(args.to_world, m->r, axis);
#elif FAR == 3
  realv frame[3];
  frame_light(estimate, m->r[0], m->r[1], m->r[2], frame);
  const realv unlit =
      unlit_share(estimate, mean_sky_light(args, direct, depth, m->z, x, y), ao,
                  args.sky_share);
  const realv share = min(other, unlit / max(ao, (realv)1e-6f));
#endif
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    light[c] = open * cached->light[c];
#if FAR == 1
    light[c] = fma(open * other, (realv)far[c].sh[0], light[c]);
#elif FAR == 2
    light[c] = fma(open * other, sh_light(far[c], axis, bands), light[c]);
#elif FAR == 3
    light[c] = fma(open * share,
                   unseen_light(estimate, c, frame[c], shown[c], known,
                                light[c], open * cached->share),
                   light[c]);
#endif
  }
}

kernel void glossy(const hbil_composite_args args, const hbil_glossy_args own,
                   global const float *split, global const float *resolved,
                   global const float *estimate, global const void *depth,
                   global const void *direct, global const float *probes,
                   global void *glossy) {
  const hbil_view_args view = args.view;
  const int x0 = (int)get_global_id(0) * 4 * HBIL_WIDTH;
  const int y = (int)get_global_id(1);
  if (x0 >= view.width || y >= view.height)
    return;
  realv w[4], normals[3][4];
  load_guides(own.split, split, x0, y, w, normals);
  for (int i = 0; i < 4; ++i) {
    const int x = x0 + i * HBIL_WIDTH;
    if (x >= view.width)
      return;
    const uint plane = args.planes.plane;
    global const float *at = resolved + (uint)y * args.planes.row + (uint)x;
    global const float *lobe = at + GLOSSY_RESOLVED * plane;
    const realv n[3] = {normals[0][i], normals[1][i], normals[2][i]};
    const intv solid = w[i] > SKY;
    const mirror m =
        mirror_at(view, own.lobe, select((realv)1.0f, w[i], solid), n, x, y);
    const realv known =
        clamp(READV(lobe + HBIL_GLOSSY_KNOWN * plane), 0.0f, 1.0f);
    const realv ao = clamp(READV(at), 0.0f, 1.0f);
    realv shown[3], far[3];
#pragma unroll
    for (int c = 0; c < 3; ++c)
      shown[c] = READV(lobe + (HBIL_GLOSSY_RED + c) * plane);
    glossy_light cached = {{0.0f, 0.0f, 0.0f}, 0.0f};
#if PROBES
    if (args.probes.columns > 0)
      cached = glossy_of_probes(args.probes, view, probes, x, y, m.p, m.n, m.r,
                                m.k, solid);
#endif
    far_glossy(args, own, estimate, direct, depth, &m, 1.0f - known, shown,
               known, ao, &cached, x, y, far);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      store_glossy(select((realv)0.0f, shown[c] + far[c], solid), glossy,
                   own.glossy, x, y, c, view.width - x);
  }
}
