/*
 * Reprojection: the light of the last frame, moved to where its surfaces are
 * now.
 *
 * This pass is specified in single precision, rounding by rounding, so that the
 * same pixel wins on every device: a pixel of the old frame at ray r and
 * inverse depth w is the point P = r / w; M = view_now^-1 view_before takes it
 * to Q = M P, and Q appears at pixel (fx Q.x / Q.z + cx, fy Q.y / Q.z + cy).
 *
 * Scatter does that for every old pixel; of several that land on one pixel the
 * nearest wins, and of equally near ones the first.  Its light is used if its
 * depth is within the disocclusion threshold of what the pixel shows now.
 * Motion vectors go the other way: they tell where a pixel's surface was, and
 * the four old pixels around that position are interpolated, as far as their
 * depths agree with where the surface then must have been.
 */
#include <math.h>
#include <stdlib.h>

#include "exact/input.h"
#include "exact/passes.h"
#include "exact/planes.h"
#include "exact/settings.h"

typedef struct float3 {
  float x, y, z;
} float3;

/* The upper three rows of to^-1 from, computed in double and then rounded. */
static void view_from_view(const hbil_camera *to, const hbil_camera *from,
                           float m[12]) {
  const double *t = to->world_from_view, *f = from->world_from_view;
  for (int i = 0; i < 3; ++i) {
    double offset = 0.0;
    for (int j = 0; j < 3; ++j) {
      double sum = 0.0;
      for (int k = 0; k < 3; ++k)
        sum += t[4 * k + i] * f[4 * k + j];
      m[4 * i + j] = (float)sum;
    }
    for (int k = 0; k < 3; ++k)
      offset += t[4 * k + i] * (f[4 * k + 3] - t[4 * k + 3]);
    m[4 * i + 3] = (float)offset;
  }
}

static float row_times(const float m[4], float3 p) {
  return fmaf(m[0], p.x, fmaf(m[1], p.y, fmaf(m[2], p.z, m[3])));
}

static float3 transform(const float m[12], float3 p) {
  const float3 q = {row_times(m, p), row_times(m + 4, p), row_times(m + 8, p)};
  return q;
}

/* World units to one unit of the image plane, at depth z. */
static float spread_at(const hbil_config *c, float z) {
  return exact_is_orthographic(c) ? 1.0f : z;
}

static float3 point_at(const hbil_config *c, const hbil_view_args *v, int x,
                       int y, float z) {
  const float3 p = {((float)x + 0.5f - v->cx) * v->inv_fx * spread_at(c, z),
                    ((float)y + 0.5f - v->cy) * v->inv_fy * spread_at(c, z), z};
  return p;
}

/* exact_planar_depth() as the kernels round it. */
static float planar_depth(const exact_frame *frame, const hbil_view_args *v,
                          int x, int y) {
  const float d = exact_scaled_depth(frame, x, y);
  const float3 r = point_at(frame->config, v, x, y, 1.0f);
  if (frame->config->inputs.depth_kind != HBIL_DEPTH_RAY ||
      exact_is_orthographic(frame->config))
    return d;
  return d / sqrtf(fmaf(r.x, r.x, fmaf(r.y, r.y, 1.0f)));
}

/* The largest difference of depths that is still the same surface, at z. */
static float depth_tolerance(const exact_frame *frame, const hbil_view_args *v,
                             float z) {
  const float unit =
      exact_is_orthographic(frame->config) ? (float)v->width * v->inv_fx : z;
  return frame->config->history.disocclusion_threshold * unit;
}

/* ------------------------------------------------------------------------ */
/* Scatter                                                                   */

/* The old pixel that won a pixel of this frame. */
typedef struct winner {
  int source; /* its index; -1: none */
  float z;    /* its depth in this frame */
} winner;

/* The index of the pixel that a point appears in; -1: none. */
static int scatter_target(const hbil_config *c, const hbil_view_args *v,
                          float3 q) {
  if (!(q.z > 0.0f))
    return -1;
  const float u = fmaf(v->fx, q.x / spread_at(c, q.z), v->cx);
  const float w = fmaf(v->fy, q.y / spread_at(c, q.z), v->cy);
  if (!(u >= 0.0f && u < (float)v->width && w >= 0.0f && w < (float)v->height))
    return -1;
  return (int)w * v->width + (int)u;
}

static void scatter_pixel(const exact_frame *frame, const float m[12], int x,
                          int y, float w, winner *winners) {
  const hbil_view_args old = exact_view(frame->config, &frame->previous);
  const hbil_view_args now = exact_view(frame->config, &frame->camera);
  const float3 q = transform(m, point_at(frame->config, &old, x, y, 1.0f / w));
  const int target = scatter_target(frame->config, &now, q);
  if (target < 0)
    return;
  /* sources come in ascending order, so the first of equally near ones stays */
  winner *best = winners + target;
  if (best->source < 0 || q.z < best->z) {
    best->source = y * now.width + x;
    best->z = q.z;
  }
}

static void carry_winner(const exact_frame *frame, const exact_planes *history,
                         const winner *best, int x, int y,
                         exact_planes *carried) {
  const hbil_view_args now = exact_view(frame->config, &frame->camera);
  const int sx = best->source % now.width, sy = best->source / now.width;
  const float z = planar_depth(frame, &now, x, y);
  if (!(fabsf(best->z - z) <= depth_tolerance(frame, &now, z)))
    return;
  for (int c = 0; c < 3; ++c)
    *exact_at(carried, HBIL_CARRIED_RED + c, x, y) =
        *exact_at(history, HBIL_HISTORY_RED + c, sx, sy);
  *exact_at(carried, HBIL_CARRIED_WEIGHT, x, y) = 1.0;
}

static exact_status scatter(const exact_frame *frame,
                            const exact_planes *history,
                            exact_planes *carried) {
  const int width = history->width, height = history->height;
  const size_t pixels = (size_t)width * (size_t)height;
  winner *winners = calloc(pixels, sizeof(*winners));
  float m[12];
  if (!winners)
    return EXACT_OUT_OF_MEMORY;
  for (size_t i = 0; i < pixels; ++i)
    winners[i].source = -1;
  view_from_view(&frame->camera, &frame->previous, m);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float w = (float)*exact_at(history, HBIL_HISTORY_W, x, y);
      if (w > 0.0f)
        scatter_pixel(frame, m, x, y, w, winners);
    }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const winner *best = winners + (size_t)y * (size_t)width + (size_t)x;
      if (best->source >= 0 && !exact_is_sky(frame, x, y))
        carry_winner(frame, history, best, x, y, carried);
    }
  free(winners);
  return EXACT_SUCCESS;
}

/* ------------------------------------------------------------------------ */
/* Motion vectors                                                            */

/* Whether an old pixel shows the surface that was at depth z. */
static bool shows_surface(const exact_frame *frame, const exact_planes *history,
                          int x, int y, float z) {
  if (!exact_planes_contain(history, x, y))
    return false;
  const hbil_view_args view = exact_view(frame->config, &frame->camera);
  const float w = (float)*exact_at(history, HBIL_HISTORY_W, x, y);
  /* |1/w - z| <= tolerance, times w */
  return w > 0.0f &&
         fabsf(fmaf(w, z, -1.0f)) <= w * depth_tolerance(frame, &view, z);
}

/* Interpolates red, green and blue of the old frame at (u, v), in pixels from
 * the first one's centre; out[3]: 1 where any of the four counts, else 0. */
static void interpolate_history(const exact_frame *frame,
                                const exact_planes *history, float u, float v,
                                float z, float out[4]) {
  const float a = u - floorf(u), c = v - floorf(v);
  const float share[4] = {(1.0f - a) * (1.0f - c), a * (1.0f - c),
                          (1.0f - a) * c, a * c};
  float sum[3] = {0.0f, 0.0f, 0.0f}, total = 0.0f;
  for (int tap = 0; tap < 4; ++tap) {
    const int x = (int)floorf(u) + (tap & 1), y = (int)floorf(v) + (tap >> 1);
    if (!shows_surface(frame, history, x, y, z))
      continue;
    total = total + share[tap];
    for (int i = 0; i < 3; ++i)
      sum[i] =
          fmaf(share[tap],
               (float)*exact_at(history, HBIL_HISTORY_RED + i, x, y), sum[i]);
  }
  for (int i = 0; i < 3; ++i)
    out[i] = total > 0.0f ? sum[i] * (1.0f / total) : 0.0f;
  out[3] = total > 0.0f ? 1.0f : 0.0f;
}

static void follow_pixel(const exact_frame *frame, const exact_planes *history,
                         const float m[12], int x, int y,
                         exact_planes *carried) {
  const hbil_config *config = frame->config;
  const hbil_view_args now = exact_view(config, &frame->camera);
  const float z = planar_depth(frame, &now, x, y);
  const float3 q = transform(m, point_at(config, &now, x, y, z));
  const float dx =
      exact_input(frame, EXACT_MOTION, x, y) * config->inputs.motion_scale[0];
  const float dy = exact_input(frame, EXACT_MOTION + 1, x, y) *
                   config->inputs.motion_scale[1];
  float u = ((float)x + 0.5f) + dx, v = ((float)y + 0.5f) + dy, light[4];
  u = u - 0.5f;
  v = v - 0.5f;
  if (!(q.z > 0.0f && u > -1.0f && u < (float)now.width && v > -1.0f &&
        v < (float)now.height))
    return;
  interpolate_history(frame, history, u, v, q.z, light);
  for (int i = 0; i < 4; ++i)
    *exact_at(carried, i, x, y) = light[i];
}

static void follow_motion(const exact_frame *frame, const exact_planes *history,
                          exact_planes *carried) {
  float m[12];
  view_from_view(&frame->previous, &frame->camera, m);
  for (int y = 0; y < history->height; ++y)
    for (int x = 0; x < history->width; ++x)
      if (!exact_is_sky(frame, x, y))
        follow_pixel(frame, history, m, x, y, carried);
}

/* ------------------------------------------------------------------------ */

exact_status exact_reproject(const exact_frame *frame,
                             const exact_planes *history,
                             exact_planes *carried) {
  const cl_uint width = frame->config->width, height = frame->config->height;
  if (!exact_planes_fit(history, width, height, HBIL_HISTORY_PLANES) ||
      !exact_planes_fit(carried, width, height, HBIL_CARRIED_PLANES) ||
      !frame->input[EXACT_DEPTH])
    return EXACT_BAD_ARGUMENT;
  for (int y = 0; y < carried->height; ++y)
    for (int x = 0; x < carried->width; ++x) {
      exact_planes_clear(carried, x, y);
      if (exact_is_sky(frame, x, y))
        *exact_at(carried, HBIL_CARRIED_WEIGHT, x, y) = -1.0;
    }
  if (frame->config->history.reprojection == HBIL_REPROJECTION_SCATTER)
    return scatter(frame, history, carried);
  if (!frame->input[EXACT_MOTION] || !frame->input[EXACT_MOTION + 1])
    return EXACT_BAD_ARGUMENT;
  follow_motion(frame, history, carried);
  return EXACT_SUCCESS;
}
