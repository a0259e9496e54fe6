/* See flicker_measure.h. */
#include "bench/flicker_measure.h"

#include <stdlib.h>

enum { REACH = 12 }; /* of the blur: three times its sigma */

/* The same point and surface in both frames: places that differ by less than so
 * many pixels and by less than this share of the depth, for roundings; cosine
 * of normals; difference of albedo; and enough albedo to be seen. */
static const double same_pixels = 2.5, same_depth = 0.001, same_normal = 0.98,
                    same_albedo = 0.1, least_albedo = 1e-3;

typedef struct point {
  double at[3], normal[3], albedo[3];
} point;

/* What is compared of a pair: the change of each pixel, 0 where mask is. */
typedef struct changes {
  double *value, *mask, *blurred, *row;
  double mean, count; /* of the light; pixels */
} changes;

const char *flicker_lacks(const bench_content *content) {
  const bench_frame *frame = content->frame;
  if (content->frames < 2)
    return "a second frame";
  if (content->config.inputs.depth_kind != HBIL_DEPTH_PLANAR ||
      content->config.inputs.projection != HBIL_PROJECTION_PERSPECTIVE)
    return "planar depth and a perspective camera";
  if (content->config.inputs.normal_space != HBIL_SPACE_WORLD ||
      !frame->plane[BENCH_NORMAL])
    return "normals in world space";
  return frame->plane[BENCH_ALBEDO] ? NULL : "albedo";
}

/* --- points --- */

static void read_point(const bench_content *content, const bench_frame *frame,
                       size_t x, size_t y, point *out) {
  const size_t pixels = bench_pixels(content), i = y * content->width + x;
  const hbil_camera *c = &frame->camera;
  const double z = (double)frame->plane[BENCH_DEPTH][i];
  const double view[3] = {((double)x + 0.5 - c->cx) / c->fx * z,
                          ((double)y + 0.5 - c->cy) / c->fy * z, z};
  for (size_t r = 0; r < 3; r++) {
    const double *m = c->world_from_view + 4 * r;
    out->at[r] = m[0] * view[0] + m[1] * view[1] + m[2] * view[2] + m[3];
    out->normal[r] = (double)frame->plane[BENCH_NORMAL][r * pixels + i];
    out->albedo[r] = (double)frame->plane[BENCH_ALBEDO][r * pixels + i];
  }
}

static int is_surface(const bench_content *content, const bench_frame *frame,
                      size_t i) {
  const float z = frame->plane[BENCH_DEPTH][i];
  return isfinite(z) && z > 0.0f && z < content->config.inputs.sky_depth;
}

/* Where a point is in a frame, in pixels, 0 at the centre of the first one.
 * Returns its depth. */
static double project(const hbil_camera *c, const double at[3], double uv[2]) {
  double view[3] = {0.0, 0.0, 0.0};
  for (int r = 0; r < 3; r++)
    for (int k = 0; k < 3; k++)
      view[k] += c->world_from_view[4 * r + k] *
                 (at[r] - c->world_from_view[4 * r + 3]);
  uv[0] = c->cx + c->fx * view[0] / view[2] - 0.5;
  uv[1] = c->cy + c->fy * view[1] / view[2] - 0.5;
  return view[2];
}

static int same_point(const point *a, const point *b, double limit) {
  double away = 0.0, facing = 0.0, bright = 0.0;
  for (int k = 0; k < 3; k++) {
    away += (a->at[k] - b->at[k]) * (a->at[k] - b->at[k]);
    facing += a->normal[k] * b->normal[k];
    bright = fmax(bright, a->albedo[k]);
    if (fabs(a->albedo[k] - b->albedo[k]) >= same_albedo)
      return 0;
  }
  return sqrt(away) < limit && facing > same_normal && bright > least_albedo;
}

/* Whether the second frame shows what pixel (x, y) of the first one does; if
 * so, uv is where. */
static int find_again(const bench_content *content, unsigned first, size_t x,
                      size_t y, double uv[2]) {
  const bench_frame *a = &content->frame[first], *b = a + 1;
  point here, there;
  if (!is_surface(content, a, y * content->width + x))
    return 0;
  read_point(content, a, x, y, &here);
  const double z = project(&b->camera, here.at, uv);
  if (!(z > 0.0 && uv[0] >= 0.0 && uv[0] < content->width - 1.0 &&
        uv[1] >= 0.0 && uv[1] < content->height - 1.0))
    return 0;
  const size_t u = (size_t)(uv[0] + 0.5), v = (size_t)(uv[1] + 0.5);
  if (!is_surface(content, b, v * content->width + u))
    return 0;
  read_point(content, b, u, v, &there);
  return same_point(&here, &there,
                    (same_pixels / b->camera.fx + same_depth) * z);
}

static double between(const float *plane, size_t width, const double uv[2]) {
  const size_t x = (size_t)uv[0], y = (size_t)uv[1];
  const double s = uv[0] - (double)x, t = uv[1] - (double)y;
  const float *p = plane + y * width + x;
  return ((double)p[0] * (1.0 - s) + (double)p[1] * s) * (1.0 - t) +
         ((double)p[width] * (1.0 - s) + (double)p[width + 1] * s) * t;
}

/* --- changes --- */

static void compare(const bench_content *content, unsigned first,
                    const float *const light[2], changes *c) {
  const size_t width = content->width, pixels = bench_pixels(content);
  for (size_t i = 0; i < pixels; i++) {
    double uv[2], change = 0.0, here = 0.0;
    if (!find_again(content, first, i % width, i / width, uv))
      continue;
    for (size_t k = 0; k < 3; k++) {
      const double value = (double)light[0][k * pixels + i];
      change += (between(light[1] + k * pixels, width, uv) - value) / 3.0;
      here += value / 3.0;
    }
    c->value[i] = change;
    c->mask[i] = 1.0;
    c->mean += here;
    c->count += 1.0;
  }
  c->mean /= fmax(c->count, 1.0);
  for (size_t i = 0; i < pixels && c->mean > 0.0; i++)
    c->value[i] /= c->mean;
}

/* Blurs a plane in one direction into another. */
static void blur_lines(const double *from, double *to, size_t lines,
                       size_t count, size_t line, size_t step) {
  double kernel[2 * REACH + 1], sum = 0.0;
  for (int k = -REACH; k <= REACH; k++)
    sum += kernel[k + REACH] =
        exp(-0.5 * k * k / (FLICKER_SIGMA * FLICKER_SIGMA));
  for (size_t l = 0; l < lines; l++)
    for (long i = 0; i < (long)count; i++) {
      double value = 0.0;
      for (long k = -REACH; k <= REACH; k++)
        if (i + k >= 0 && i + k < (long)count)
          value +=
              kernel[k + REACH] * from[l * line + (size_t)(i + k) * step] / sum;
      to[l * line + (size_t)i * step] = value;
    }
}

static void blur(const bench_content *content, const double *from,
                 double *between_passes, double *to) {
  const size_t width = content->width, height = content->height;
  blur_lines(from, between_passes, height, width, width, 1);
  blur_lines(between_passes, to, width, height, 1, width);
}

/* The RMS over the compared pixels. */
static double rms_of(const changes *c, const double *value, size_t pixels) {
  double sum = 0.0;
  for (size_t i = 0; i < pixels; i++)
    sum += c->mask[i] * value[i] * value[i];
  return sqrt(sum / c->count);
}

static void measure_patches(const bench_content *content, changes *c,
                            flicker_change *out) {
  const size_t pixels = bench_pixels(content);
  double mean = 0.0;
  for (size_t i = 0; i < pixels; i++)
    mean += c->value[i] / c->count;
  for (size_t i = 0; i < pixels; i++)
    c->value[i] -= mean * c->mask[i];
  blur(content, c->value, c->row, c->blurred);
  blur(content, c->mask, c->row, c->value);
  for (size_t i = 0; i < pixels; i++)
    c->blurred[i] = c->mask[i] > 0.0 ? c->blurred[i] / c->value[i] : 0.0;
  out->patches = rms_of(c, c->blurred, pixels);
}

int flicker_measure(const bench_content *content, unsigned first,
                    const float *const light[2], flicker_change *out,
                    image_error *error) {
  const size_t pixels = bench_pixels(content);
  double *planes = calloc(4 * pixels, sizeof *planes);
  if (!planes)
    return image_no_memory(error, content->name);
  changes c = {
      planes, planes + pixels, planes + 2 * pixels, planes + 3 * pixels, 0.0,
      0.0};
  compare(content, first, light, &c);
  if (!(c.count > 0.0)) {
    free(planes);
    return image_fail(error, "%s: frames %u and %u show nothing in common",
                      content->name, first + 1, first + 2);
  }
  out->compared = c.count / (double)pixels;
  out->rms = rms_of(&c, c.value, pixels);
  measure_patches(content, &c, out);
  free(planes);
  return 0;
}
