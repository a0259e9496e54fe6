/* Whether a job's camera moves. */
#include "tool/job_camera.h"

#include "dump/read_gbuffer.h"
#include "dump/surface_points.h"
#include "tool/camera_motion.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

depth_range job_camera_depths(const gbuffer *g) {
  const surface_points s = surface_points_of(g, &g->map.camera);
  const size_t width = g->planes.width;
  depth_range out = {INFINITY, -INFINITY};
  for (size_t i = 0; i < gbuffer_pixels(g); i++) {
    const double z = surface_depth(&s, i % width, i / width);
    out.low = z > 0.0 ? fmin(out.low, z) : out.low;
    out.high = z > 0.0 ? fmax(out.high, z) : out.high;
  }
  return out;
}

/* The depths of the first frame that shows a surface. */
static int read_depths(const job *j, depth_range *out, image_error *error) {
  *out = (depth_range){INFINITY, -INFINITY};
  for (int i = 0; i < j->count && !(out->low < INFINITY); i++) {
    const job_frame *f = &j->frames[i];
    gbuffer g;
    if (gbuffer_read(f->path, &f->map, 1u << ROLE_DEPTH, &g, error) != 0)
      return -1;
    *out = job_camera_depths(&g);
    gbuffer_free(&g);
  }
  return 0;
}

static void tell(const camera_motion *m) {
  char how[64] = "";
  if (m->kind == CAMERA_JITTERS)
    snprintf(how, sizeof how, " but for a jitter of %.2g pixels", m->jitter);
  fprintf(stderr,
          "hbil: the camera stands still%s: no radiance cache (--far rays "
          "makes one)\n",
          how);
}

/* The camera of the frame that decides for a whole sequence, of which the job's
 * frames may be a part.  Its pixels are counted from its own window. */
static hbil_camera deciding_camera(const job *j) {
  const channel_map *map = &j->decider->map;
  hbil_camera out = map->camera;
  out.cx += (double)map->window.x - (double)j->window.x;
  out.cy += (double)map->window.y - (double)j->window.y;
  return out;
}

/* Whether there is such a frame, and its pixels are those of the job's. */
static int has_deciding_camera(const job *j) {
  const image_window *own = &j->frames[0].map.display;
  return j->decider && j->decider->map.display.width == own->width &&
         j->decider->map.display.height == own->height &&
         j->decider->map.projection == j->frames[0].map.projection;
}

int job_camera_moves(const job *j, int *moves, image_error *error) {
  const size_t count = (size_t)j->count, more = (size_t)has_deciding_camera(j);
  const hbil_camera first = more ? deciding_camera(j) : j->frames[0].map.camera;
  const hbil_camera **cameras = malloc((count + 1) * sizeof *cameras);
  const camera_path path = {cameras, count + more, j->frames[0].map.projection,
                            j->width, j->height};
  depth_range depths = {INFINITY, -INFINITY};
  if (!cameras)
    return image_no_memory(error, j->frames[0].path);
  cameras[0] = &first;
  for (size_t i = 0; i < count; i++)
    cameras[i + more] = &j->frames[i].map.camera;
  const int failed =
      camera_motion_needs_depths(&path) ? read_depths(j, &depths, error) : 0;
  const camera_motion found = camera_motion_find(&path, depths);
  free(cameras);
  *moves = found.kind == CAMERA_MOVES;
  if (!failed && !*moves && !j->settings->quiet && path.count > 1)
    tell(&found);
  return failed;
}
