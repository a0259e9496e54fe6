/* A picture in host memory: depth, normals and light of its pixels. */
#include "look.h"

#include <math.h>
#include <string.h>

#include "shared.h"

static const double pi = 3.14159265358979323846;

bool look_has(const hbil_host_plane *plane) {
  return plane->channel[0] != NULL;
}

double look_value(const look *l, const hbil_host_plane *plane, size_t c,
                  size_t i) {
  const size_t x = i % l->config->width, y = i / l->config->width;
  const float *first = plane->channel[c] ? plane->channel[c] : *plane->channel;
  return (double)first[y * (plane->row_pitch / sizeof *first) +
                       x * (plane->pixel_pitch / sizeof *first)];
}

double look_light(const look *l, const hbil_host_plane *plane, size_t c,
                  size_t i) {
  const double v = look_has(plane) ? look_value(l, plane, c, i) : 0;
  return isfinite(v) && v > 0 ? v : 0;
}

double look_irradiance(const look *l, size_t c, size_t i) {
  const hbil_inputs *in = &l->config->inputs;
  const double light =
      look_light(l, &l->planes.direct, c, i) * (double)in->direct_scale;
  if (in->direct_kind == HBIL_DIRECT_IRRADIANCE)
    return light;
  const double albedo = look_has(&l->planes.albedo)
                            ? fmin(look_light(l, &l->planes.albedo, c, i), 1)
                            : 1;
  return albedo >= (double)HBIL_LEAST_ALBEDO ? pi * light / albedo : 0;
}

double look_dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool is_parallel(const look *l) {
  return l->config->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
}

/* Planar depth of a value of a depth buffer; 0 at the far end and beyond. */
static double hardware_depth(const look *l, double d) {
  /* d = a + b w, where w is 1/z, or -z in an orthographic view */
  const double a = l->frame->hardware_depth[0];
  const double b = (is_parallel(l) ? -1 : 1) * l->frame->hardware_depth[1];
  const double far = b < 0 ? 1 : 0; /* d of the far end */
  const double w = (d - a) / b;
  return !((d - far) / b > 0) ? 0 : is_parallel(l) ? -w : 1 / w;
}

/* The depth of a surface, along the axis or the ray, or 0 for the sky: as the
 * kernels tell them apart, without their limit of 1e15. */
static double depth_at(const look *l, size_t i) {
  const hbil_inputs *inputs = &l->config->inputs;
  const double stored = look_value(l, &l->planes.depth, 0, i);
  const double depth = inputs->depth_kind == HBIL_DEPTH_HARDWARE
                           ? hardware_depth(l, stored)
                           : stored * (double)inputs->depth_scale;
  return isfinite(depth) && depth > 0 && depth < (double)inputs->sky_depth
             ? depth
             : 0;
}

bool look_is_sky(const look *l, size_t i) {
  return !(depth_at(l, i) > 0);
}

/* --- surfaces --- */

/* The point where a pixel looks from, and its ray, whose z is 1. */
static void ray_at(const look *l, size_t i, double from[3], double ray[3]) {
  const hbil_camera *camera = &l->frame->camera;
  const double right =
      ((double)(i % l->config->width) + 0.5 - camera->cx) / camera->fx;
  const double down =
      ((double)(i / l->config->width) + 0.5 - camera->cy) / camera->fy;
  const double at[3] = {right, down, 0}, ahead[3] = {0, 0, 1}, eye[3] = {0};
  const double through[3] = {right, down, 1};
  memcpy(from, is_parallel(l) ? at : eye, sizeof at);
  memcpy(ray, is_parallel(l) ? ahead : through, sizeof at);
}

/* Planar depth; 0 for the sky. */
static double z_at(const look *l, size_t i) {
  double from[3], ray[3];
  const double depth = depth_at(l, i);
  ray_at(l, i, from, ray);
  return l->config->inputs.depth_kind == HBIL_DEPTH_RAY
             ? depth / sqrt(look_dot(ray, ray))
             : depth;
}

/* 1/z, or -z in an orthographic view: affine in pixel coordinates on planes. */
static double w_at(const look *l, size_t i) {
  const double z = z_at(l, i);
  return is_parallel(l) ? -z : 1 / z;
}

/* The smaller difference of w to the neighbours before and behind; 0 if there
 * is none.  The kernels choose with more care (normals_from_depth.cl). */
static double gradient(const look *l, size_t i, size_t step, bool before,
                       bool behind) {
  double least = INFINITY;
  if (before && z_at(l, i - step) > 0)
    least = w_at(l, i) - w_at(l, i - step);
  if (behind && z_at(l, i + step) > 0) {
    const double other = w_at(l, i + step) - w_at(l, i);
    least = fabs(other) < fabs(least) ? other : least;
  }
  return isfinite(least) ? least : 0;
}

/* The normal of a pixel's surface by its depth, of any length. */
static void rebuild_normal(const look *l, size_t i, const double ray[3],
                           double out[3]) {
  const size_t width = l->config->width, x = i % width, y = i / width;
  const hbil_camera *camera = &l->frame->camera;
  out[0] = -camera->fx * gradient(l, i, 1, x > 0, x + 1 < width);
  out[1] =
      -camera->fy * gradient(l, i, width, y > 0, y + 1 < l->config->height);
  out[2] =
      is_parallel(l) ? -1 : -w_at(l, i) - out[0] * ray[0] - out[1] * ray[1];
}

/* The pixel's unit normal in view space, facing the eye.  Returns false if it
 * has none. */
static bool read_normal(const look *l, size_t i, const double ray[3],
                        double out[3]) {
  double n[3];
  for (size_t c = 0; c < 3 && look_has(&l->planes.normal); ++c)
    n[c] = look_value(l, &l->planes.normal, c, i) *
           (double)l->config->inputs.normal_scale[c];
  for (size_t c = 0; c < 3 && look_has(&l->planes.normal); ++c) {
    const double *m = l->frame->camera.world_from_view + c;
    out[c] = l->config->inputs.normal_space == HBIL_SPACE_VIEW
                 ? n[c]
                 : m[0] * n[0] + m[4] * n[1] + m[8] * n[2];
  }
  if (!look_has(&l->planes.normal))
    rebuild_normal(l, i, ray, out);
  const double length = sqrt(look_dot(out, out));
  const double sign = look_dot(out, ray) > 0 ? -1 : 1;
  for (size_t c = 0; c < 3; ++c)
    out[c] *= sign / length;
  return length > 0 && isfinite(length);
}

bool look_patch(const look *l, size_t i, patch *out) {
  const hbil_camera *camera = &l->frame->camera;
  const bool parallel = is_parallel(l);
  const double z = z_at(l, i);
  double from[3], ray[3];
  ray_at(l, i, from, ray);
  if (!(z > 0) || !read_normal(l, i, ray, out->normal))
    return false;
  /* A pixel has the solid angle 1 / (fx fy |r|^3); with parallel rays, all
   * pixels have the same area.  A grazing surface may be of any size; it counts
   * as if it were tilted by a tenth of a radian. */
  const double grazing = 0.1 * sqrt(look_dot(ray, ray));
  out->area =
      (parallel ? 1 : z * z) /
      (camera->fx * camera->fy * fmax(-look_dot(out->normal, ray), grazing));
  for (size_t c = 0; c < 3; ++c)
    out->at[c] = from[c] + z * ray[c];
  return true;
}
