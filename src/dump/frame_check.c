/* Checks that a frame fits together. */
#include "dump/frame_check.h"

#include "dump/check_colours.h"
#include "dump/check_normals.h"
#include "dump/check_positions.h"
#include "dump/check_surfaces.h"
#include "dump/normal_fit.h"
#include "dump/pixel_ray.h"

#include <math.h>
#include <string.h>

/* Sums over the surfaces. */
typedef struct extent {
  double low[3], high[3];          /* of points in view space */
  size_t surface, facing, encoded; /* pixels */
} extent;

static void measure_pixel(const surface_points *s, const matrix3 *h, size_t i,
                          extent *e) {
  const size_t width = s->g->planes.width;
  const pixel_ray ray =
      pixel_ray_at(s->g->map.projection, s->camera, i % width, i / width);
  double p[3], n[3], seen[3];
  if (!(surface_depth(s, i % width, i / width) > 0.0))
    return;
  surface_point(s, i % width, i / width, 0, p);
  e->surface++;
  for (int c = 0; c < 3; c++) {
    e->low[c] = fmin(e->low[c], p[c]);
    e->high[c] = fmax(e->high[c], p[c]);
  }
  if (!s->g->map.count[ROLE_NORMAL])
    return;
  for (int c = 0; c < 3; c++)
    n[c] = (double)gbuffer_plane(s->g, ROLE_NORMAL, (size_t)c)[i];
  for (int c = 0; c < 3; c++)
    seen[c] = matrix3_dot(h->m[c], n);
  e->facing += matrix3_dot(seen, ray.along) <= 1e-3;
  e->encoded += normal_looks_encoded(n);
}

static extent measure(const surface_points *s) {
  extent e = {.low = {INFINITY, INFINITY, INFINITY},
              .high = {-INFINITY, -INFINITY, -INFINITY}};
  const matrix3 h = surface_view_from_normals(s);
  for (size_t i = 0; i < gbuffer_pixels(s->g); i = surface_next(s, i))
    measure_pixel(s, &h, i, &e);
  return e;
}

static void check_radius(const surface_points *s, const extent *e,
                         const char *option, float radius, findings *out) {
  double diagonal = 0.0;
  for (int c = 0; c < 3; c++)
    diagonal += (e->high[c] - e->low[c]) * (e->high[c] - e->low[c]);
  diagonal = sqrt(diagonal);
  const double pixel = (surface_rays_are_parallel(s) ? 1 : e->low[2]) /
                       fmax(s->camera->fx, s->camera->fy);
  if (isfinite(radius) && (double)radius > diagonal)
    findings_add(out,
                 "a radius of %g is larger than all that is seen, %.3g: metres "
                 "against centimetres? %s, --unit-scale",
                 (double)radius, diagonal, option);
  if ((double)radius < pixel)
    findings_add(
        out,
        "a radius of %g is less than a pixel, %.3g where it is nearest: "
        "metres against centimetres? %s, --unit-scale",
        (double)radius, pixel, option);
}

/* Whether values that no depth buffer has, and that mean no sky, are those of
 * more than a tenth of the pixels. */
static int check_buffer(const surface_points *s, findings *out) {
  const float *stored = gbuffer_plane(s->g, ROLE_DEPTH, 0);
  const float largest_half = 65504.0f;
  float most = 0.0f;
  size_t above = 0;
  if (!channel_map_depth_is_hardware(&s->g->map))
    return 0;
  for (size_t i = 0; i < gbuffer_pixels(s->g); i = surface_next(s, i))
    if (stored[i] > 1.001f && stored[i] < largest_half) {
      most = fmaxf(most, stored[i]);
      above++;
    }
  if (10 * above <= surface_looks(s))
    return 0;
  findings_add(out,
               "depths above 1, up to %g, can't be those of a depth buffer: "
               "--depth planar, or ray? --sky-depth, if they are the sky?",
               (double)most);
  return 1;
}

/* Why there is no surface at all. */
static void find_why_empty(const surface_points *s, findings *out) {
  surface_points all = *s;
  all.inputs.sky_depth = INFINITY;
  const extent e = measure(&all);
  if (e.surface)
    findings_add(out, "all depths are those of the sky: --sky-depth or "
                      "--unit-scale?");
  else
    findings_add(out,
                 "no pixel has a depth: --depth, --sky-depth or --map depth?");
}

static void check_radii(const surface_points *s, const extent *e,
                        const hbil_model *model, findings *out) {
  check_radius(s, e, "--radius", model->radius, out);
  if (model->ao_radius != model->radius)
    check_radius(s, e, "--ao-radius", model->ao_radius, out);
}

static void check(const surface_points *given, const hbil_config *config,
                  frame_check *out) {
  surface_points s = *given;
  const gbuffer *g = s.g;
  memset(out, 0, sizeof *out);
  out->agreement = out->positions = NAN;
  const int other_camera = check_positions_camera(&s, &out->found);
  const int no_buffer = check_buffer(&s, &out->found);
  extent e = measure(&s);
  if (e.surface == 0) { /* a small one may lie between the rows */
    s.row_step = 1;
    e = measure(&s);
  }
  out->surface = (double)e.surface / (double)surface_looks(&s);
  s.row_step = given->row_step;
  if (e.surface == 0 && (other_camera || no_buffer || !config))
    return;
  if (e.surface == 0) {
    find_why_empty(&s, &out->found);
    return;
  }
  out->low = e.low[2];
  out->high = e.high[2];
  out->facing = (double)e.facing / (double)e.surface;
  if (no_buffer)
    return;              /* all else would follow from that */
  findings hidden = {0}; /* what only follows from another camera */
  findings *others = other_camera ? &hidden : &out->found;
  const int has_normals = g->map.count[ROLE_NORMAL] > 0;
  if (has_normals && !g->map.how.encoded && e.encoded > e.surface / 10 * 9)
    findings_add(&out->found,
                 "normals look like stored as (n+1)/2: --normals encoded");
  else if (has_normals)
    out->agreement = check_normals(&s, out->high, others);
  out->positions = check_positions(&s, others);
  check_surfaces(&s, other_camera || others->count > 0, &out->found);
  if (config)
    check_radii(&s, &e, &config->model, &out->found);
  check_colours(&s, config != NULL, &out->found);
}

void frame_check_run(const gbuffer *g, const hbil_config *config,
                     const hbil_camera *camera, frame_check *out) {
  const surface_points s = surface_points_of(g, camera);
  check(&s, config, out);
}

void frame_check_whole(const gbuffer *g, const hbil_config *config,
                       const hbil_camera *camera, frame_check *out) {
  surface_points s = surface_points_of(g, camera);
  s.row_step = 1;
  check(&s, config, out);
}
