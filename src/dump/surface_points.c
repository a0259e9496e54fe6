/* The points of a frame's surfaces, from its depth and camera. */
#include "dump/surface_points.h"

#include "dump/pixel_ray.h"

#include <math.h>

int surface_rays_are_parallel(const surface_points *s) {
  return s->g->map.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
}

/* Pixels that a check looks at, about. */
enum { PIXELS_MEASURED = 1 << 17 };

size_t surface_next(const surface_points *s, size_t i) {
  const size_t width = s->g->planes.width;
  return i + 1 + ((i + 1) % width ? 0 : (s->row_step - 1) * width);
}

size_t surface_looks(const surface_points *s) {
  const size_t height = s->g->planes.height;
  return (height + s->row_step - 1) / s->row_step * s->g->planes.width;
}

surface_points surface_points_of(const gbuffer *g, const hbil_camera *camera) {
  surface_points s = {.g = g,
                      .camera = camera,
                      .row_step = gbuffer_pixels(g) / PIXELS_MEASURED + 1};
  hbil_config config;
  hbil_config_init(&config);
  channel_map_configure(&g->map, &config);
  channel_map_hardware_depth(&g->map, s.hardware_depth);
  s.inputs = config.inputs;
  return s;
}

/* Planar depth of a value of a depth buffer; 0 at the far end and beyond. */
static double hardware_depth(const surface_points *s, double value) {
  const double a = s->hardware_depth[0];
  const double b = s->hardware_depth[1];
  const int parallel = surface_rays_are_parallel(s);
  const int grows = parallel ? b > 0 : b < 0; /* with the distance */
  if (grows ? value >= 1 : value <= 0)
    return 0;
  return parallel ? (value - a) / b : b / (value - a);
}

/* The depth, planar or from the eye, that a value stands for; 0: no surface. */
static double meant_depth(const surface_points *s, float stored) {
  const double depth = s->inputs.depth_kind == HBIL_DEPTH_HARDWARE
                           ? hardware_depth(s, (double)stored)
                           : (double)(stored * s->inputs.depth_scale);
  return gbuffer_is_surface((float)depth, s->inputs.sky_depth) ? depth : 0.0;
}

int surface_is_shown(const surface_points *s, float stored) {
  return meant_depth(s, stored) > 0.0;
}

double surface_depth(const surface_points *s, size_t x, size_t y) {
  const double depth = meant_depth(
      s, gbuffer_plane(s->g, ROLE_DEPTH, 0)[y * s->g->planes.width + x]);
  if (s->inputs.depth_kind != HBIL_DEPTH_RAY || !(depth > 0.0))
    return depth;
  const pixel_ray ray = pixel_ray_at(s->g->map.projection, s->camera, x, y);
  return depth / sqrt(matrix3_dot(ray.along, ray.along));
}

void surface_point(const surface_points *s, size_t x, size_t y, int other,
                   double out[3]) {
  const pixel_ray ray = pixel_ray_at(s->g->map.projection, s->camera, x, y);
  const double length = other ? sqrt(matrix3_dot(ray.along, ray.along)) : 1.0;
  const double z = s->g->map.how.depth == DEPTH_RAY
                       ? surface_depth(s, x, y) * length
                       : surface_depth(s, x, y) / length;
  for (int c = 0; c < 3; c++)
    out[c] = ray.from[c] + z * ray.along[c];
}

matrix3 surface_view_from(const surface_points *s, dump_space space) {
  const double *m = s->camera->world_from_view;
  matrix3 out = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (int i = 0; i < 3 && space == SPACE_WORLD; i++)
    for (int j = 0; j < 3; j++)
      out.m[i][j] = m[4 * j + i];
  return out;
}

matrix3 surface_view_from_normals(const surface_points *s) {
  matrix3 out = surface_view_from(s, s->g->map.how.normals);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      out.m[i][j] *= (double)s->inputs.normal_scale[j];
  return out;
}

void surface_depths_make_planar(gbuffer *g) {
  const surface_points s = surface_points_of(g, &g->map.camera);
  const size_t width = g->planes.width;
  conventions *how = &g->map.how;
  float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  for (size_t i = 0; depth && i < gbuffer_pixels(g); i++)
    depth[i] = (float)surface_depth(&s, i % width, i / width);
  how->depth = DEPTH_PLANAR;
  how->backwards = how->from_near = 0;
  how->unit = 1;
  how->sky_depth = INFINITY;
}
