/*
 * The exact gather: no sampling error.
 *
 * Slices are equally spaced, slice i of S at the angle (i + 1/2) pi / S, and
 * each crosses every pixel of its line: in every column, or in every row where
 * the line is steep, the one pixel whose centre is nearest.  So each pixel of a
 * column owns the directions through its own cell; none is left out and none
 * counts twice.  The sample lies on the line, to which the pixel's surface goes
 * on.  Occluders of finite thickness cover intervals, not sectors.
 *
 * With a radius, the walk ends where nothing farther along the line can be
 * within it.  The distance from the receiver's point to the ray of a pixel is a
 * lower bound of the distance to whatever that pixel shows, and it rises along
 * a half-slice, so the end is found by bisection.
 */
#include "exact/camera.h"
#include "exact/hemisphere.h"
#include "exact/passes.h"
#include "exact/planes.h"
#include "exact/settings.h"
#include "exact/threads.h"

typedef struct dense_gather {
  const exact_frame *frame;
  const exact_planes *split;
  const exact_dense *how;
  exact_planes *gathered;
} dense_gather;

/* The least distance from the receiver's point to anything that a pixel can
 * show. */
static double least_distance(const receiver *r, double x, double y) {
  const vec3 origin = exact_point(r->frame, x, y, 0.0);
  const vec3 to_point = vec_add(r->s.at, -1.0, origin);
  const vec3 ray = vec_normalize(exact_ray(r->frame, x, y));
  return vec_length(vec_add(to_point, -fmax(0.0, vec_dot(to_point, ray)), ray));
}

/* The number of steps (sx, sy) beyond which nothing is within the radius. */
static int steps_within_radius(const receiver *r, double sx, double sy) {
  const double radius = exact_radius(r->frame->config);
  int near = 0, far = r->split->width + r->split->height;
  if (isinf(radius))
    return far;
  while (near < far) {
    const int middle = (near + far + 1) / 2;
    if (least_distance(r, r->x + middle * sx, r->y + middle * sy) <= radius)
      near = middle;
    else
      far = middle - 1;
  }
  return near + 2; /* pixels lie up to half a pixel off the line */
}

static march march_along(const receiver *r, bool at_centres, double ux,
                         double uy) {
  const hbil_camera *camera = &r->frame->camera;
  march m = exact_march_begin(r, ux, uy);
  const double px = m.h.u.x * camera->fx, py = m.h.u.y * camera->fy;
  const double major = fmax(fabs(px), fabs(py));
  const double slope_x = fabs(px) / major, slope_y = fabs(py) / major;
  const int sign_x = px < 0.0 ? -1 : 1, sign_y = py < 0.0 ? -1 : 1;
  const int steps = steps_within_radius(r, px / major, py / major);
  for (int k = 1; k <= steps; ++k) {
    const double x = r->x + sign_x * k * slope_x;
    const double y = r->y + sign_y * k * slope_y;
    const int near_x = r->x + sign_x * (int)(k * slope_x + 0.5);
    const int near_y = r->y + sign_y * (int)(k * slope_y + 0.5);
    if (!exact_planes_contain(r->split, near_x, near_y))
      break;
    if (at_centres)
      exact_march_visit(r, &m, near_x, near_y, NULL);
    else
      exact_march_cross(r, &m, near_x, near_y, x, y);
  }
  exact_march_end(&m);
  return m;
}

static void gather_pixel(const dense_gather *g, int x, int y, interval *list) {
  const hbil_config *config = g->frame->config;
  const coverage_kind kind = exact_coverage_kind(config, COVERAGE_INTERVALS);
  receiver r = exact_receiver(g->frame, g->split, x, y, kind, list);
  hemisphere sum = {0};
  if (!r.s.is) {
    exact_store_sky(&r, g->gathered);
    return;
  }
  r.equal_weights = g->how->equal_weights;
  for (int slice = 0; slice < g->how->slices; ++slice) {
    const double psi = (slice + 0.5) / g->how->slices * PI;
    const double ux = cos(psi), uy = sin(psi);
    /* one after the other, because both use the same list */
    const march ahead = march_along(&r, g->how->at_centres, ux, uy);
    const march behind = march_along(&r, g->how->at_centres, -ux, -uy);
    exact_add_slice(&sum, config, &ahead, &behind);
  }
  exact_store_gathered(&r, &sum, g->how->slices, g->gathered);
}

static void gather_row(void *user, int y, void *scratch) {
  const dense_gather *g = user;
  const unsigned char *mask = g->how->mask;
  const size_t width = (size_t)g->split->width;
  for (int x = 0; x < g->split->width; ++x)
    if (!mask || mask[(size_t)y * width + (size_t)x])
      gather_pixel(g, x, y, scratch);
}

exact_status exact_gather_dense(const exact_frame *frame,
                                const exact_planes *split,
                                const exact_dense *how,
                                exact_planes *gathered) {
  const hbil_config *config = frame->config;
  dense_gather g = {frame, split, how, gathered};
  /* no line crosses more pixels, and a pixel adds one interval at most */
  const size_t longest = (size_t)split->width + (size_t)split->height;
  const exact_rows rows = {.run = gather_row,
                           .user = &g,
                           .height = split->height,
                           .threads = how->threads,
                           .scratch_size = longest * sizeof(interval),
                           .progress = how->progress,
                           .progress_user = how->user};
  if (!exact_planes_fit(split, config->width, config->height,
                        HBIL_SPLIT_PLANES) ||
      !exact_planes_fit(gathered, config->width, config->height,
                        HBIL_LIGHT_PLANES) ||
      how->slices < 1 || how->threads < 0)
    return EXACT_BAD_ARGUMENT;
  return exact_run_rows(&rows);
}
