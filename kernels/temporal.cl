/*
 * temporal: the resolved light, averaged over frames.
 *
 * The sampling pattern rotates with hbil_frame.frame_index, so each frame
 * samples other directions and other pixels.  The mean over frames converges
 * where the filter of a single frame can't.
 *
 * For every surface the kernel finds where it was in the last frame, by the
 * cameras or by motion vectors.  It takes the mean of those of the four pixels
 * there that show the same surface.  Their distance from the surface's tangent
 * plane is at most disocclusion_threshold, as a share of the plane's own
 * depth, so tilted surfaces are not cut.  Their normal differs by less than
 * the limit of recompose's filter.
 *
 * Each pixel stores the number of frames that it is the mean of.  The four
 * numbers are averaged with the weights of the light; pixels that are left out
 * count as 0.  Frame n has weight 1/n until n is most_frames, then
 * 1/most_frames.  If nothing is found, or something that is not finite, the
 * result is the new frame, bit for bit, and counting starts again.
 *
 * Launch: x = groups of 4*HBIL_WIDTH pixels of a row, y = rows.
 * In: split planes (guides), resolved light, the history of the last frame.
 * Out: resolved light, the history of this frame, whose bent normals have any
 * length.
 */
#include "lib/flags.clh"
#include "lib/glossy_args.h"
#include "lib/guides.clh"
#include "lib/light_planes.clh"
#include "lib/past_place.clh"
#include "lib/split_planes.clh"

FLAG(DISOCCLUSION)
FLAG(OUT_GLOSSY)
/* 1: counts unusable motion vectors, as no other pass does */
FLAG(COUNTS_MOTION)

/* The planes that are averaged: those of each configuration, and behind the
 * bent normal those of glossy light. */
#if OUT_GLOSSY
#define EACH_AVERAGED(do_this)                                                 \
  EACH_RESOLVED(do_this) do_this(7) do_this(8) do_this(9) do_this(10)
#define AVERAGED_PLANES (HBIL_LIGHT_PLANES + HBIL_GLOSSY_PLANES)
#if GLOSSY_RESOLVED != 7
#error glossy light must be behind the bent normal
#endif
#else
#define EACH_AVERAGED(do_this) EACH_RESOLVED(do_this)
#define AVERAGED_PLANES HBIL_LIGHT_PLANES
#endif

/* A place in the last frame, and the normal that is expected there. */
typedef struct past {
  past_place place;
  realv n[3];
} past;

/* --- what is there ------------------------------------------------------- */

/* The history of a vector of pixels: the number of frames (0: there is none)
 * and the mean over them. */
typedef struct past_light {
  realv frames, value[AVERAGED_PLANES];
} past_light;

/* The past light at `four`, from those pixels that show what `then` expects. */
INLINE past_light recall_from(const hbil_view_args before, const past *then,
                              const corners *four, global const float *history,
                              const hbil_plane_args planes, float disocclusion,
                              const addresses *from, int how) {
  const int taps = how == READ_ONE ? 1 : 4;
  past_light m;
  realv total = 0.0f, tap[4];
  intv same[4];
#if DISOCCLUSION && ORTHOGRAPHIC
  /* The plane n.P through the expected point: n_z (z_tap - z) is -(n_x, n_y)
   * times the way there. */
  const realv step_x = then->n[0] * before.inv_fx;
  const realv step_y = then->n[1] * before.inv_fy;
  const realv limit =
      disocclusion * depth_unit(before, then->place.z) * fabs(then->n[2]);
#elif DISOCCLUSION
  /* The plane n.P = n.(r z) through the expected point has inverse depth
   * n.r_tap / (z n.r) at another ray. */
  const realv step_x = then->n[0] * before.inv_fx;
  const realv step_y = then->n[1] * before.inv_fy;
  const realv rx = (TO_REALV(four->left) + 0.5f - before.cx) * before.inv_fx;
  const realv ry = (TO_REALV(four->top) + 0.5f - before.cy) * before.inv_fy;
  const realv first = fma(then->n[0], rx, fma(then->n[1], ry, then->n[2]));
  const realv scale =
      then->place.z * fma(step_x, four->a, fma(step_y, four->b, first));
#endif
#define LOAD_TAPS(p)                                                           \
  load_taps(history + (p)*planes.plane, from, how, planes.row, tap);
  LOAD_TAPS(HBIL_TEMPORAL_W)
#pragma unroll
  for (int t = 0; t < taps; ++t) {
    const int i = t & 1, j = t >> 1;
    same[t] = four->allowed[t] & (four->weight[t] > 0.0f) & (tap[t] > SKY);
#if DISOCCLUSION && ORTHOGRAPHIC
    const realv away =
        fma(step_x, (float)i - four->a, step_y * ((float)j - four->b));
    same[t] &= fabs(fma(tap[t] + then->place.z, -then->n[2], away)) <= limit;
#elif DISOCCLUSION
    const realv plane = fma((realv)i, step_x, fma((realv)j, step_y, first));
    same[t] &= fabs(fma(tap[t], scale, -plane)) <= disocclusion * fabs(plane);
#endif
  }
  LOAD_TAPS(HBIL_TEMPORAL_NORMAL)
#pragma unroll
  for (int t = 0; t < taps; ++t) {
    realv n[3];
    unpack_normal(REALV_AS_WORDS(tap[t]), n);
    same[t] &= fma(n[0], then->n[0], fma(n[1], then->n[1], n[2] * then->n[2])) >
               1.0f - HBIL_TURN_TOLERANCE;
  }
  LOAD_TAPS(HBIL_TEMPORAL_FRAMES)
  m.frames = 0.0f;
#pragma unroll
  for (int t = 0; t < taps; ++t) {
    same[t] &= tap[t] > 0.0f;
    total = select(total, total + four->weight[t], same[t]);
    m.frames =
        select(m.frames, fma(four->weight[t], tap[t], m.frames), same[t]);
  }
  realv size = 0.0f;
#define RECALL(p)                                                              \
  LOAD_TAPS(HBIL_TEMPORAL_LIGHT + (p))                                         \
  m.value[p] = 0.0f;                                                           \
  _Pragma("unroll") for (int t = 0; t < taps; ++t) m.value[p] =                \
      select(m.value[p], fma(four->weight[t], tap[t], m.value[p]), same[t]);   \
  m.value[p] /= total;                                                         \
  size += fabs(m.value[p]);
  EACH_AVERAGED(RECALL)
  /* false for NaN */
  m.frames = select((realv)0.0f, m.frames, size <= FLT_MAX);
  return m;
}

/* Chooses how to read.  Each way has a body of its own, without branches. */
INLINE past_light recall(const hbil_view_args before, const past *then,
                         const corners *four, global const float *history,
                         const hbil_plane_args planes, float disocclusion) {
  addresses from;
  if (!ANY(four->inside)) {
    past_light nothing;
    nothing.frames = 0.0f;
#define FORGET(p) nothing.value[p] = 0.0f;
    EACH_AVERAGED(FORGET)
    return nothing;
  }
#define RECALL_FROM(how)                                                       \
  recall_from(before, then, four, history, planes, disocclusion, &from, how)
  const int how = find_addresses(four, planes.row, &from);
  return how == READ_ONE    ? RECALL_FROM(READ_ONE)
         : how == READ_FOUR ? RECALL_FROM(READ_FOUR)
                            : RECALL_FROM(READ_RUNS);
}

/* --- the mean ----------------------------------------------------------------
 */

#if GATHER_BENT
/* A mean of unit vectors, to unit length; 0 where they cancel. */
INLINE void normalize_bent(realv *value) {
  realv length2 = 0.0f;
#pragma unroll
  for (int p = HBIL_LIGHT_BENT; p < HBIL_LIGHT_PLANES; ++p)
    length2 = fma(value[p], value[p], length2);
  const realv scale =
      select((realv)0.0f, 1.0f / sqrt(length2), length2 > 1e-24f);
#pragma unroll
  for (int p = HBIL_LIGHT_BENT; p < HBIL_LIGHT_PLANES; ++p)
    value[p] *= scale;
}
#endif

/* Blends a vector of pixels into the mean.  w, n: their inverse depth and
 * normal; history, resolved: this frame's planes, at these pixels. */
INLINE void blend(const past_light *m, realv w, const realv n[3], intv solid,
                  float most, global float *history, global float *resolved,
                  const hbil_plane_args planes) {
  const intv found = solid & (m->frames > 0.0f);
  const realv frames =
      select((realv)1.0f, min(m->frames + 1.0f, (realv)most), found);
  const realv share = 1.0f / frames;
  realv fresh[AVERAGED_PLANES], mean[AVERAGED_PLANES], size = 0.0f;
#define BLEND(p)                                                               \
  fresh[p] = READV(resolved + (p)*planes.plane);                               \
  mean[p] = select(fresh[p], fma(fresh[p] - m->value[p], share, m->value[p]),  \
                   found);                                                     \
  size += fabs(mean[p]);                                                       \
  STREAMV(mean[p], history + (HBIL_TEMPORAL_LIGHT + (p)) * planes.plane);
  EACH_AVERAGED(BLEND)
  STREAMV(w, history + HBIL_TEMPORAL_W * planes.plane);
  STREAMV(AS_REALV(AS_INTV(pack_normal(n[0], n[1], n[2]))),
          history + HBIL_TEMPORAL_NORMAL * planes.plane);
  STREAMV(select((realv)0.0f, frames, solid & (size <= FLT_MAX)),
          history + HBIL_TEMPORAL_FRAMES * planes.plane);
#if GATHER_BENT
  normalize_bent(mean);
#endif
#define SHOW(p)                                                                \
  STOREV(select(fresh[p], mean[p], found), resolved + (p)*planes.plane);
  EACH_AVERAGED(SHOW)
}

kernel void temporal(const hbil_temporal_args args, global const float *split,
                     global float *resolved, global const float *history_before,
                     global float *history, global const void *motion_buffer,
                     volatile global uint *sanitized) {
  const hbil_view_args view = args.view, before = args.before;
  const hbil_transform_args back = args.back;
  const hbil_plane_args planes = args.planes;
  const int x0 = (int)get_global_id(0) * 4 * HBIL_WIDTH;
  const int y = (int)get_global_id(1);
  if (x0 >= view.width || y >= view.height)
    return;
  realv w[4], normals[3][4];
  load_guides(args.split, split, x0, y, w, normals);
  history_before += hbil_history_origin(planes);
  history += hbil_history_origin(planes);
  for (int i = 0; i < 4; ++i) {
    const int x = x0 + i * HBIL_WIDTH;
    const uint pixel = (uint)y * planes.row + (uint)x;
    const realv n[3] = {normals[0][i], normals[1][i], normals[2][i]};
    const intv solid = (w[i] > SKY) & (x + EACH_LANE < view.width);
    const realv z = depth_at(w[i]), spread = spread_at(z);
    const realv p[3] = {plane_x(view, x, 1) * spread, plane_y(view, y) * spread,
                        z};
    const intv known = args.has_before ? solid : (intv)0;
    realv move[2] = {0.0f, 0.0f};
#if REPROJECT_MOTION
    if (args.has_before)
      motion_of(motion_buffer, args.motion, args.motion_scale, x, y,
                view.width - x, solid, COUNTS_MOTION ? sanitized : 0, move);
#endif
    past then = {past_place_of(before, back, p, move, x, y)};
    rotate_direction(back, n, then.n);
    const corners four = past_corners(&then.place, known, before);
    const past_light m = recall(before, &then, &four, history_before, planes,
                                args.disocclusion_threshold);
    blend(&m, w[i], n, solid, args.most_frames, history + pixel,
          resolved + pixel, planes);
  }
}
