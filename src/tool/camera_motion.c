/* Whether the camera of a sequence moves. */
#include "tool/camera_motion.h"

#include "dump/matrix3.h"
#include "dump/pixel_ray.h"

#include <math.h>

/* Pixels across and down that are compared. */
enum { GRID = 9 };

/* An end of what a pixel's ray may show, in view space.  With perspective it is
 * divided by its depth, so that infinity is an end like any other. */
typedef struct ray_end {
  double from[3];
  double to_place; /* what a step of the camera is multiplied with; 0: nothing,
                    * as infinity is a direction */
} ray_end;

/* Where a camera that stands at `to` sees a point of the view space of `from`,
 * in pixels from its centre.  0 if it is behind the camera. */
static int project(const camera_path *path, const hbil_camera *from,
                   const hbil_camera *to, const ray_end *p, double out[2]) {
  const double *a = from->world_from_view, *b = to->world_from_view;
  double world[3], seen[3] = {0};
  for (int r = 0; r < 3; r++)
    world[r] = matrix3_dot(a + 4 * r, p->from) +
               (a[4 * r + 3] - b[4 * r + 3]) * p->to_place;
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++)
      seen[c] += b[4 * r + c] * world[r];
  const double depth =
      path->projection == HBIL_PROJECTION_ORTHOGRAPHIC ? 1.0 : seen[2];
  out[0] = to->fx * seen[0] / depth;
  out[1] = to->fy * seen[1] / depth;
  return depth > 0.0;
}

/* The end of a pixel's ray that is farther away, or nearer. */
static ray_end end_of(const camera_path *path, const pixel_ray *ray,
                      depth_range depths, int farther) {
  const int parallel = path->projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const double z = farther ? depths.high : depths.low;
  ray_end out;
  for (int c = 0; c < 3; c++)
    out.from[c] = parallel
                      ? ray->from[c] + (isfinite(z) ? z : 0.0) * ray->along[c]
                      : ray->along[c];
  out.to_place = parallel ? 1.0 : farther || !isfinite(z) ? 0.0 : 1.0 / z;
  return out;
}

/* How far a pixel moves at most from one camera to another, if both had the
 * same centre. */
static double farthest(const camera_path *path, const hbil_camera *from,
                       const hbil_camera *to, depth_range depths) {
  double most = 0.0;
  for (size_t i = 0; i < (size_t)GRID * GRID; i++) {
    const size_t x = i % GRID * (path->width - 1) / (GRID - 1);
    const size_t y = i / GRID * (path->height - 1) / (GRID - 1);
    const pixel_ray ray = pixel_ray_at(path->projection, from, x, y);
    for (int k = 0; k < 2; k++) {
      const ray_end end = end_of(path, &ray, depths, k);
      double before[2], after[2];
      if (!project(path, from, from, &end, before) ||
          !project(path, from, to, &end, after))
        return INFINITY;
      const double off = hypot(after[0] - before[0], after[1] - before[1]);
      most = off < INFINITY ? fmax(most, off) : INFINITY; /* NaN as well */
    }
  }
  return most;
}

/* Jitter is told from a camera that moves by its size alone.  While the centres
 * stay within one pixel, all frames show the same surfaces, so a radiance cache
 * would know no more than a frame. */
camera_motion camera_motion_find(const camera_path *path, depth_range depths) {
  const hbil_camera *first = path->cameras[0];
  double low[2] = {first->cx, first->cy}, high[2] = {first->cx, first->cy};
  double shift = 0.0;
  camera_motion out = {CAMERA_STANDS, 0.0, 0.0};
  for (size_t i = 1; i < path->count; i++) {
    const hbil_camera *c = path->cameras[i];
    out.pixels = fmax(out.pixels, farthest(path, first, c, depths));
    shift = fmax(shift, hypot(c->cx - first->cx, c->cy - first->cy));
    low[0] = fmin(low[0], c->cx);
    low[1] = fmin(low[1], c->cy);
    high[0] = fmax(high[0], c->cx);
    high[1] = fmax(high[1], c->cy);
  }
  out.jitter = fmax(high[0] - low[0], high[1] - low[1]);
  if (!(out.pixels <= CAMERA_SAME_PIXELS) || !(out.jitter < 1.0))
    out.kind = CAMERA_MOVES;
  else if (out.pixels + shift > CAMERA_SAME_PIXELS)
    out.kind = CAMERA_JITTERS;
  return out;
}

int camera_motion_needs_depths(const camera_path *path) {
  const depth_range nothing = {INFINITY, -INFINITY};
  const double *a = path->cameras[0]->world_from_view;
  int moved = 0;
  for (size_t i = 1; i < path->count; i++)
    for (int r = 0; r < 3; r++)
      moved |= path->cameras[i]->world_from_view[4 * r + 3] != a[4 * r + 3];
  return moved && camera_motion_find(path, nothing).kind != CAMERA_MOVES;
}
