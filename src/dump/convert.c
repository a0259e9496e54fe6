/* Converts what of a renderer's planes the library can't read. */
#include "dump/convert.h"

#include "dump/coverage.h"
#include "dump/light_sources.h"
#include "dump/pixel_ray.h"
#include "image/srgb.h"
#include "image/error.h"
#include "image/image.h"

#include <math.h>
#include <stdio.h>

/* ------------------------------------------------------------------------ */
/* Colours                                                                   */

static void decode_colours(gbuffer *g) {
  for (int r = 0; r < ROLE_COUNT; r++)
    for (size_t c = 0;
         role_is_colour((role)r) && g->map.gamma[r] && c < g->map.count[r];
         c++) {
      float *v = gbuffer_plane(g, (role)r, c);
      for (size_t i = 0; i < gbuffer_pixels(g); i++)
        v[i] = linear_of_srgb(v[i]);
    }
}

/* A black surface reflects nothing, so its irradiance is unknown and becomes 0.
 */
static void divide_by_albedo(gbuffer *g, role light) {
  for (size_t c = 0; c < g->map.count[light]; c++) {
    const float *albedo = gbuffer_plane(g, ROLE_ALBEDO, c);
    float *v = gbuffer_plane(g, light, c);
    for (size_t i = 0; albedo && i < gbuffer_pixels(g); i++)
      v[i] = albedo[i] > 0.0f ? v[i] / albedo[i] : 0.0f;
  }
}

static void centre_motion(gbuffer *g) {
  for (size_t c = 0; c < g->map.count[ROLE_MOTION]; c++) {
    float *v = gbuffer_plane(g, ROLE_MOTION, c);
    for (size_t i = 0; i < gbuffer_pixels(g); i++)
      v[i] -= g->map.how.motion_zero;
  }
}

/* ------------------------------------------------------------------------ */
/* Vectors                                                                   */

static void scale_plane(gbuffer *g, role r, size_t c, float by, float shift) {
  float *v = gbuffer_plane(g, r, c);
  for (size_t i = 0;
       v && (by != 1.0f || shift != 0.0f) && i < gbuffer_pixels(g); i++)
    v[i] = v[i] * by + shift;
}

/* The library reads (n + 1) / 2 from integers only, and files become floats. */
static void decode_normals(gbuffer *g) {
  for (size_t c = 0; c < 3 && g->map.how.encoded; c++)
    scale_plane(g, ROLE_NORMAL, c, 2.0f, -1.0f);
}

/* Moves positions from view space to world space. */
static void place_positions(gbuffer *g) {
  const double *m = g->map.camera.world_from_view;
  float *p[3];
  for (size_t c = 0; c < 3; c++)
    p[c] = gbuffer_plane(g, ROLE_POSITION, c);
  for (size_t i = 0; i < gbuffer_pixels(g); i++) {
    const double v[3] = {p[0][i], p[1][i], p[2][i]};
    for (int c = 0; c < 3; c++)
      p[c][i] = (float)(m[4 * c] * v[0] + m[4 * c + 1] * v[1] +
                        m[4 * c + 2] * v[2] + m[4 * c + 3]);
  }
}

static void convert_positions(gbuffer *g) {
  float sign[3];
  if (g->map.count[ROLE_POSITION] < 3)
    return;
  channel_map_signs(&g->map, g->map.how.positions, sign);
  for (size_t c = 0; c < 3; c++)
    scale_plane(g, ROLE_POSITION, c, sign[c] * (float)g->map.how.unit, 0.0f);
  if (g->map.how.positions == SPACE_CAMERA)
    place_positions(g);
}

/* ------------------------------------------------------------------------ */
/* Depth                                                                     */

/* Depth as a function of a stored position p: row . p + the returned offset. */
static double depth_row(const channel_map *map, double row[3]) {
  const double *m = map->camera.world_from_view;
  double offset = 0;
  float sign[3];
  channel_map_signs(map, map->how.positions, sign);
  for (int c = 0; c < 3; c++) {
    const int camera = map->how.positions == SPACE_CAMERA;
    const double axis = camera ? c == 2 : m[4 * c + 2];
    row[c] = axis * (double)sign[c] * map->how.unit;
    offset -= camera ? 0 : axis * m[4 * c + 3];
  }
  return offset;
}

/* Adds a depth plane that is computed from the positions.  A position of three
 * zeros is a pixel without a surface. */
static int make_depth(gbuffer *g) {
  char *name = g->map.names[ROLE_DEPTH][0];
  const float *p[3];
  double row[3];
  const double offset = depth_row(&g->map, row);
  for (size_t c = 0; c < 3; c++)
    p[c] = gbuffer_plane(g, ROLE_POSITION, c);
  snprintf(name, sizeof g->map.names[ROLE_DEPTH][0], "%s.0",
           role_name(ROLE_DEPTH));
  const image_plane *added = image_add(&g->planes, name);
  if (!added)
    return -1;
  for (size_t i = 0; i < gbuffer_pixels(g); i++) {
    const double v[3] = {p[0][i], p[1][i], p[2][i]};
    if (v[0] != 0.0 || v[1] != 0.0 || v[2] != 0.0)
      added->pixels[i] =
          (float)(row[0] * v[0] + row[1] * v[1] + row[2] * v[2] + offset);
  }
  g->map.count[ROLE_DEPTH] = 1;
  return 0;
}

/* Makes distances from the near plane those from the eye, since the part in
 * front of it is `near` deep.  Sky becomes 0: afterwards no value would tell it
 * from surfaces. */
static void add_near(gbuffer *g) {
  const conventions *how = &g->map.how;
  float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  const size_t width = g->planes.width;
  const double sign = how->backwards ? -1 : 1;
  for (size_t i = 0; i < gbuffer_pixels(g); i++) {
    const pixel_ray ray =
        pixel_ray_at(g->map.projection, &g->map.camera, i % width, i / width);
    const double *r = ray.along;
    const double length = sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    const double from_near = (double)depth[i] * sign;
    depth[i] =
        gbuffer_is_surface((float)from_near, how->sky_depth)
            ? (float)(sign * (from_near + length * how->near / how->unit))
            : 0.0f;
  }
}

/* Depth, which tells the sky, is already converted. */
static int convert_light(gbuffer *g) {
  if (g->map.how.direct != DIRECT_RADIANCE)
    return 0;
  divide_by_albedo(g, ROLE_INDIRECT);
  if (g->map.how.shows_sources && g->map.count[ROLE_DIRECT])
    return light_sources_split(g);
  divide_by_albedo(g, ROLE_DIRECT);
  return 0;
}

int convert_planes(const char *path, gbuffer *g, image_error *error) {
  const conventions *how = &g->map.how;
  decode_colours(g);
  coverage_divide(g);
  if (how->motion_zero != 0.0f)
    centre_motion(g);
  decode_normals(g);
  if (how->depth == DEPTH_POSITION) {
    if (g->map.count[ROLE_POSITION] == 3 && make_depth(g) != 0)
      return image_no_memory(error, path);
  } else if (g->map.count[ROLE_DEPTH] && conventions_begin_at_near(how))
    add_near(g);
  convert_positions(g);
  return convert_light(g) != 0 ? image_no_memory(error, path) : 0;
}
