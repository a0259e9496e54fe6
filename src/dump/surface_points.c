/* The points of a frame's surfaces, from its depth and camera. */
#include "dump/surface_points.h"

#include "dump/pixel_ray.h"

#include <math.h>

int surface_rays_are_parallel(const surface_points *s) {
  return s->g->map.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
}

double surface_depth(const surface_points *s, size_t x, size_t y) {
  const float z =
      gbuffer_plane(s->g, ROLE_DEPTH, 0)[y * s->g->planes.width + x];
  return gbuffer_is_surface(z, s->sky_depth) ? (double)z : 0.0;
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
