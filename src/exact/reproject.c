/*
 * Reprojection: the light of the last frame, moved to where its surfaces are
 * now.
 *
 * This pass is specified in single precision, rounding by rounding, so that
 * every device finds the same pixel: a pixel of this frame at ray r and depth z
 * is the point P = r z; M = view_before^-1 view_now takes it to Q = M P, and Q
 * appeared at pixel (fx Q.x / Q.z + cx, fy Q.y / Q.z + cy) of the old frame.
 * Motion vectors give that position themselves.  The light of the old pixel
 * there counts if its depth agrees with Q.z.
 */
#include <math.h>

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

/* The last frame has the history's size. */
static hbil_view_args old_view(const exact_frame *frame,
                               const exact_planes *history) {
  hbil_view_args view = exact_view(frame->config, &frame->previous);
  view.width = history->width;
  view.height = history->height;
  return view;
}

/* Whether an old pixel shows the surface that was at depth z. */
static bool shows_surface(const exact_frame *frame, const exact_planes *history,
                          int x, int y, float z) {
  const hbil_view_args view = old_view(frame, history);
  const float w = (float)*exact_at(history, HBIL_HISTORY_W, x, y);
  /* |1/w - z| <= tolerance, times w */
  return w > 0.0f &&
         fabsf(fmaf(w, z, -1.0f)) <= w * depth_tolerance(frame, &view, z);
}

/* A place in pixels of this frame, in those of the last one. */
static float scaled(float place, int then, cl_uint now) {
  const float ratio = (float)then / (float)now;
  return ratio == 1.0f ? place : fmaf(place + 0.5f, ratio, -0.5f);
}

/* Where the pixel's surface was in the old frame, in pixels from the centre of
 * the first one.  q: its point in the old view. */
static void past_place(const exact_frame *frame, const exact_planes *history,
                       float3 q, int x, int y, float place[2]) {
  const hbil_config *config = frame->config;
  if (config->history.reprojection == HBIL_REPROJECTION_MOTION) {
    const float *scale = config->inputs.motion_scale;
    place[0] = (float)x + exact_input(frame, EXACT_MOTION, x, y) * scale[0];
    place[1] = (float)y + exact_input(frame, EXACT_MOTION + 1, x, y) * scale[1];
    place[0] = scaled(place[0], history->width, config->width);
    place[1] = scaled(place[1], history->height, config->height);
  } else {
    const hbil_view_args old = old_view(frame, history);
    const float inv_z = 1.0f / spread_at(config, q.z);
    place[0] = fmaf(old.fx * q.x, inv_z, old.cx - 0.5f);
    place[1] = fmaf(old.fy * q.y, inv_z, old.cy - 0.5f);
  }
}

static void reproject_pixel(const exact_frame *frame,
                            const exact_planes *history, const float m[12],
                            int x, int y, exact_planes *carried) {
  const hbil_view_args now = exact_view(frame->config, &frame->camera);
  const float z = planar_depth(frame, &now, x, y);
  const float3 q = transform(m, point_at(frame->config, &now, x, y, z));
  float place[2];
  past_place(frame, history, q, x, y, place);
  const float u = place[0] + 0.5f, v = place[1] + 0.5f;
  /* false for NaN, too */
  if (!(q.z > 0.0f && q.z < INFINITY && u >= 0.0f &&
        u < (float)history->width && v >= 0.0f && v < (float)history->height) ||
      !shows_surface(frame, history, (int)u, (int)v, q.z))
    return;
  for (int c = 0; c < 3; ++c)
    *exact_at(carried, HBIL_CARRIED_RED + c, x, y) =
        *exact_at(history, HBIL_HISTORY_RED + c, (int)u, (int)v);
  *exact_at(carried, HBIL_CARRIED_WEIGHT, x, y) = 1.0;
}

/* ------------------------------------------------------------------------ */

exact_status exact_reproject(const exact_frame *frame,
                             const exact_planes *history,
                             exact_planes *carried) {
  const cl_uint width = frame->config->width, height = frame->config->height;
  if (!history ||
      !exact_planes_fit(history, (cl_uint)history->width,
                        (cl_uint)history->height, HBIL_HISTORY_PLANES) ||
      !exact_planes_fit(carried, width, height, HBIL_CARRIED_PLANES) ||
      !frame->input[EXACT_DEPTH])
    return EXACT_BAD_ARGUMENT;
  if (frame->config->history.reprojection == HBIL_REPROJECTION_MOTION &&
      (!frame->input[EXACT_MOTION] || !frame->input[EXACT_MOTION + 1]))
    return EXACT_BAD_ARGUMENT;
  float m[12];
  view_from_view(&frame->previous, &frame->camera, m);
  for (int y = 0; y < carried->height; ++y)
    for (int x = 0; x < carried->width; ++x) {
      exact_planes_clear(carried, x, y);
      if (exact_is_sky(frame, x, y))
        *exact_at(carried, HBIL_CARRIED_WEIGHT, x, y) = -1.0;
      else
        reproject_pixel(frame, history, m, x, y, carried);
    }
  return EXACT_SUCCESS;
}
