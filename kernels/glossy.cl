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
#include "lib/far_light.clh"
#include "lib/flags.clh"
#include "lib/glossy_probes.clh"
#include "lib/guides.clh"

FLAG(PROBES)

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

/* Radiance of the open part of the lobe, which no surface on the screen is
 * known in: from the directions that the cache knows, and from the others. */
INLINE void far_glossy(const hbil_composite_args args, const far_inputs *in,
                       const far_receiver *r, realv open,
                       const probe_light *cached, realv light[3]) {
  realv others = 1.0f - cached->share, far[3];
#if FAR == 3
  others = min(others, guessed_share(args, in, r) / max(r->ao, (realv)1e-6f));
#endif
  far_light(args, in, r, far);
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    light[c] = open * cached->light[c];
    if (FAR)
      light[c] = fma(open * others, far[c], light[c]);
  }
}

kernel void glossy(const hbil_composite_args args, const hbil_glossy_args own,
                   global const float *split, global const float *resolved,
                   global const float *estimate, global const void *depth,
                   global const void *albedo, global const void *direct,
                   global const float *probes, global void *glossy) {
  const hbil_view_args view = args.view;
  const int x0 = (int)get_global_id(0) * 4 * HBIL_WIDTH;
  const int y = (int)get_global_id(1);
  if (x0 >= view.width || y >= view.height)
    return;
  const far_inputs in = {estimate, depth, albedo, direct};
  realv w[4], normals[3][4];
  load_guides(own.split, split, x0, y, w, normals);
  for (int i = 0; i < 4; ++i) {
    const int x = x0 + i * HBIL_WIDTH;
    if (x >= view.width)
      return;
    const uint plane = args.planes.plane;
    global const float *here = resolved + (uint)y * args.planes.row + (uint)x;
    global const float *lobe = here + GLOSSY_RESOLVED * plane;
    const realv n[3] = {normals[0][i], normals[1][i], normals[2][i]};
    const intv solid = w[i] > SKY;
    const mirror m =
        mirror_at(view, own.lobe, select((realv)1.0f, w[i], solid), n, x, y);
    const realv known =
        clamp(READV(lobe + HBIL_GLOSSY_KNOWN * plane), 0.0f, 1.0f);
    const realv open = 1.0f - known;
    probe_light cached = {{0.0f, 0.0f, 0.0f}, 0.0f};
#if PROBES
    if (args.probes.columns > 0)
      cached = glossy_of_probes(args.probes, view, probes, x, y, m.p, m.n, m.r,
                                m.k, solid, args.exposure);
#endif
    far_receiver r = {.x = x,
                      .y = y,
                      .z = m.z,
                      .ao = clamp(READV(here), 0.0f, 1.0f),
                      .view_axis = {m.r[0], m.r[1], m.r[2]},
                      .orders = {FAR == 1 ? 1.0f : SH_RADIANCE_0,
                                 own.bands[0] * SH_RADIANCE_1,
                                 own.bands[1] * SH_RADIANCE_2},
                      .shown_share = known,
                      .cached_share = open * cached.share};
    rotate_direction(args.to_world, m.r, r.world_axis);
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      r.shown[c] = READV(lobe + (HBIL_GLOSSY_RED + c) * plane);
      r.cached[c] = open * cached.light[c];
    }
    realv far[3];
    far_glossy(args, &in, &r, open, &cached, far);
#pragma unroll
    for (int c = 0; c < 3; ++c)
      store_glossy(select((realv)0.0f, r.shown[c] + far[c], solid), glossy,
                   own.glossy, x, y, c, view.width - x);
  }
}
