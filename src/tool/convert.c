/*
 * Planes as a renderer wrote them become planes as the library takes them:
 * depth along the camera's axis, normals of full range in the world or in view
 * space, linear light.  What is so already isn't touched.
 */
#include "tool/tool.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static float *plane(gbuffer *g, role r, size_t c) {
  if (c >= g->map.count[r])
    return NULL;
  image_plane *found = image_find(&g->planes, g->map.names[r][c]);
  return found ? found->pixels : NULL;
}

static size_t pixel_count(const gbuffer *g) {
  return (size_t)g->planes.width * g->planes.height;
}

/* ------------------------------------------------------------------------ */
/* Colours                                                                   */

/* IEC 61966-2-1 */
static float linear_of_srgb(float v) {
  return v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f);
}

static void decode_colours(gbuffer *g) {
  static const role colours[] = {ROLE_ALBEDO, ROLE_DIRECT, ROLE_EMISSION,
                                 ROLE_BACKGROUND};
  for (size_t k = 0; k < sizeof colours / sizeof *colours; k++)
    for (size_t c = 0; g->map.gamma[colours[k]] && c < g->map.count[colours[k]];
         c++) {
      float *v = plane(g, colours[k], c);
      for (size_t i = 0; i < pixel_count(g); i++)
        v[i] = linear_of_srgb(v[i]);
    }
}

/* Where nothing is reflected nothing tells what fell in. */
static void take_out_albedo(gbuffer *g) {
  for (size_t c = 0; c < g->map.count[ROLE_DIRECT]; c++) {
    const float *albedo = plane(g, ROLE_ALBEDO, c);
    float *direct = plane(g, ROLE_DIRECT, c);
    for (size_t i = 0; albedo && i < pixel_count(g); i++)
      direct[i] = albedo[i] > 0.0f ? direct[i] / albedo[i] : 0.0f;
  }
}

static void centre_motion(gbuffer *g) {
  for (size_t c = 0; c < g->map.count[ROLE_MOTION]; c++) {
    float *v = plane(g, ROLE_MOTION, c);
    for (size_t i = 0; i < pixel_count(g); i++)
      v[i] -= g->map.how.motion_zero;
  }
}

/* ------------------------------------------------------------------------ */
/* Vectors                                                                   */

/* The sign of each axis: the user's and the source's flips, then those that
 * lead from camera space to view space, or to a right-handed world. */
void convert_signs(const channel_map *map, dump_space space, float sign[3]) {
  unsigned flips = map->how.flips;
  flips ^= space == SPACE_CAMERA ? 6u : map->mirrored ? 4u : 0u;
  for (int c = 0; c < 3; c++)
    sign[c] = flips >> c & 1 ? -1.0f : 1.0f;
}

static void scale_plane(gbuffer *g, role r, size_t c, float by, float shift) {
  float *v = plane(g, r, c);
  for (size_t i = 0; v && (by != 1.0f || shift != 0.0f) && i < pixel_count(g);
       i++)
    v[i] = v[i] * by + shift;
}

static void turn_normals(gbuffer *g) {
  const conventions *how = &g->map.how;
  float sign[3];
  convert_signs(&g->map, how->normals, sign);
  for (size_t c = 0; c < 3; c++)
    scale_plane(g, ROLE_NORMAL, c, how->encoded ? 2.0f * sign[c] : sign[c],
                how->encoded ? -sign[c] : 0.0f);
}

/* From view space into the world. */
static void place_positions(gbuffer *g) {
  const double *m = g->map.camera.world_from_view;
  float *p[3];
  for (size_t c = 0; c < 3; c++)
    p[c] = plane(g, ROLE_POSITION, c);
  for (size_t i = 0; i < pixel_count(g); i++) {
    const double v[3] = {p[0][i], p[1][i], p[2][i]};
    for (int c = 0; c < 3; c++)
      p[c][i] = (float)(m[4 * c] * v[0] + m[4 * c + 1] * v[1] +
                        m[4 * c + 2] * v[2] + m[4 * c + 3]);
  }
}

static void turn_positions(gbuffer *g) {
  float sign[3];
  if (g->map.count[ROLE_POSITION] < 3)
    return;
  convert_signs(&g->map, g->map.how.positions, sign);
  for (size_t c = 0; c < 3; c++)
    scale_plane(g, ROLE_POSITION, c, sign[c] * (float)g->map.how.unit, 0.0f);
  if (g->map.how.positions == SPACE_CAMERA)
    place_positions(g);
}

/* ------------------------------------------------------------------------ */
/* Depth                                                                     */

/* What of a position, as it is stored, is depth: row . p + offset. */
static double depth_row(const channel_map *map, double row[3]) {
  const double *m = map->camera.world_from_view;
  double offset = 0;
  float sign[3];
  convert_signs(map, map->how.positions, sign);
  for (int c = 0; c < 3; c++) {
    const int camera = map->how.positions == SPACE_CAMERA;
    const double axis = camera ? c == 2 : m[4 * c + 2];
    row[c] = axis * (double)sign[c] * map->how.unit;
    offset -= camera ? 0 : axis * m[4 * c + 3];
  }
  return offset;
}

/* A position of all zeros is none. */
static int make_depth(gbuffer *g) {
  char *name = g->map.names[ROLE_DEPTH][0];
  const float *p[3];
  double row[3];
  const double offset = depth_row(&g->map, row);
  for (size_t c = 0; c < 3; c++)
    p[c] = plane(g, ROLE_POSITION, c);
  snprintf(name, sizeof g->map.names[ROLE_DEPTH][0], "%s.0",
           role_name(ROLE_DEPTH));
  const image_plane *added = image_add(&g->planes, name);
  if (!added)
    return -1;
  for (size_t i = 0; i < pixel_count(g); i++) {
    const double v[3] = {p[0][i], p[1][i], p[2][i]};
    if (v[0] != 0.0 || v[1] != 0.0 || v[2] != 0.0)
      added->pixels[i] =
          (float)(row[0] * v[0] + row[1] * v[1] + row[2] * v[2] + offset);
  }
  g->map.count[ROLE_DEPTH] = 1;
  return 0;
}

/* Between the clipping planes: 0 at the near one.  A perspective stores the
 * inverse of depth, parallel rays depth itself. */
static double of_device(const channel_map *map, double d) {
  const double near = map->how.near, far = map->how.far;
  if (map->projection == HBIL_PROJECTION_ORTHOGRAPHIC)
    return near + d * (far - near);
  return isinf(far) ? near / (1 - d) : near * far / (far - d * (far - near));
}

static double planar(const channel_map *map, double depth, double ray_length) {
  const conventions *how = &map->how;
  switch (how->depth) {
  case DEPTH_RAY: /* what lies before the near plane is as long as it is far */
    return depth * how->unit / ray_length + (how->from_near ? how->near : 0);
  case DEPTH_DEVICE:
    return of_device(map, depth);
  case DEPTH_REVERSED:
    return of_device(map, 1 - depth);
  default:
    return depth * how->unit;
  }
}

/* Where there is nothing: 0, and from the background on; the far plane of a
 * device's depth, which is 0 where it is reversed. */
static int is_nothing(const conventions *how, double depth) {
  if (how->depth == DEPTH_DEVICE && depth >= 1)
    return 1;
  const int zero = depth <= 0 && how->depth != DEPTH_DEVICE;
  return !isfinite(depth) || zero || depth >= (double)how->background;
}

static void straighten_depth(gbuffer *g) {
  const conventions *how = &g->map.how;
  float *depth = plane(g, ROLE_DEPTH, 0);
  const size_t width = g->planes.width;
  for (size_t i = 0; i < pixel_count(g); i++) {
    const gbuffer_ray ray =
        gbuffer_look(g->map.projection, &g->map.camera, i % width, i / width);
    const double *r = ray.along;
    const double length = sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    const double stored = (double)depth[i] * (how->backwards ? -1 : 1);
    depth[i] =
        is_nothing(how, stored) ? 0.0f : (float)planar(&g->map, stored, length);
  }
}

int convert_is_straight(const conventions *how) {
  return how->depth == DEPTH_PLANAR && how->unit == 1.0 && !how->backwards;
}

int convert_planes(const char *path, gbuffer *g, image_error *error) {
  const conventions *how = &g->map.how;
  decode_colours(g);
  if (how->direct == DIRECT_RADIANCE)
    take_out_albedo(g);
  if (how->motion_zero != 0.0f)
    centre_motion(g);
  turn_normals(g);
  if (how->depth == DEPTH_POSITION) {
    if (g->map.count[ROLE_POSITION] == 3 && make_depth(g) != 0)
      return image_no_memory(error, path);
  } else if (g->map.count[ROLE_DEPTH] && !convert_is_straight(how))
    straighten_depth(g);
  turn_positions(g);
  return 0;
}
