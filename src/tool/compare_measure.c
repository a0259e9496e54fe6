/* Measures of the difference of two images. */
#include "tool/compare_measure.h"

#include "dump/frame_camera.h"
#include "dump/read_channel_map.h"
#include "dump/read_gbuffer.h"
#include "dump/surface_points.h"
#include "image/camera_json.h"
#include "image/image_read.h"
#include "image/window.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* Which pixels are compared: the surfaces of a G-buffer                     */

/* Surfaces with less albedo count as black. */
static const float least_albedo = 0.02f;

/* Maps the channels, and takes the pixels of `like` where the two are of one
 * picture.  If the depth must be converted, the camera is needed. */
static int map_mask(const char *path, const image *like, channel_map *map,
                    image_error *error) {
  const image_window shown = image_display_window(like);
  image header;
  source_options guess;
  frame_camera seen;
  camera_file camera;
  source_options_init(&guess);
  if (image_read_header(path, &header, error) != 0)
    return -1;
  int failed = channel_map_read(path, &header, &guess, map, error);
  if (!failed)
    map->window = memcmp(&shown, &map->display, sizeof shown) == 0
                      ? image_data_window(like)
                      : image_window_common(map->data, map->display);
  if (!failed && map->count[ROLE_DEPTH] &&
      !conventions_depth_is_planar(&map->how))
    failed = frame_camera_read(path, &header, map, NULL, &guess, &seen, NULL,
                               error) != 0 ||
             frame_camera_aim(path, &seen, map, &camera, error) != 0;
  image_free(&header);
  return failed;
}

int compare_mask_read(const char *path, int albedo, const image *like,
                      compare_mask *out, image_error *error) {
  channel_map map;
  memset(out, 0, sizeof *out);
  if (!path)
    return 0;
  if (map_mask(path, like, &map, error) != 0)
    return -1;
  out->albedo = albedo;
  if (!map.count[ROLE_DEPTH] || (albedo && !map.count[ROLE_ALBEDO]))
    return image_fail(
        error, "%s: cannot be a mask: no %s; a G-buffer is needed", path,
        role_name(map.count[ROLE_DEPTH] ? ROLE_ALBEDO : ROLE_DEPTH));
  if (gbuffer_read(path, &map, 1u << ROLE_DEPTH | 1u << ROLE_ALBEDO, &out->g,
                   error) != 0)
    return -1;
  surface_depths_make_planar(&out->g);
  if (out->g.planes.width != like->width ||
      out->g.planes.height != like->height)
    return image_fail(error,
                      "%s: %u x %u pixels, but the images have %u x %u; a mask "
                      "of their size is needed",
                      path, out->g.planes.width, out->g.planes.height,
                      like->width, like->height);
  return 0;
}

void compare_mask_free(compare_mask *m) {
  gbuffer_free(&m->g);
}

channel_mask compare_mask_channel(const compare_mask *m, const char *letter) {
  const char *place = strlen(letter) == 1 ? strchr("RGB", *letter) : NULL;
  channel_mask out = {
      .depth = gbuffer_plane(&m->g, ROLE_DEPTH, 0),
  };
  if (m->albedo && place)
    out.albedo = gbuffer_plane(&m->g, ROLE_ALBEDO, (size_t)(place - "RGB"));
  return out;
}

int channel_mask_has(const channel_mask *m, size_t i) {
  return (!m->depth || m->depth[i] > 0.0f) &&
         (!m->albedo || m->albedo[i] > least_albedo);
}

/* ------------------------------------------------------------------------ */
/* Means over blocks of pixels                                               */

/* A channel of both images. */
typedef struct channel {
  float *a, *b;
  channel_mask mask;
  unsigned width, height;
} channel;

static int counts(const channel *c, size_t i) {
  return channel_mask_has(&c->mask, i) && isfinite(c->a[i]) &&
         isfinite(c->b[i]);
}

static void take_mean(channel *c, unsigned left, unsigned top, unsigned size) {
  const unsigned right = left + size < c->width ? left + size : c->width;
  const unsigned bottom = top + size < c->height ? top + size : c->height;
  double sum_a = 0.0, sum_b = 0.0, count = 0.0;
  for (unsigned y = top; y < bottom; y++)
    for (unsigned x = left; x < right; x++) {
      const size_t i = (size_t)y * c->width + x;
      if (!counts(c, i))
        continue;
      sum_a += (double)c->a[i];
      sum_b += (double)c->b[i];
      count++;
    }
  for (unsigned y = top; y < bottom; y++)
    for (unsigned x = left; x < right; x++) {
      const size_t i = (size_t)y * c->width + x;
      if (!counts(c, i))
        continue;
      c->a[i] = (float)(sum_a / count);
      c->b[i] = (float)(sum_b / count);
    }
}

void compare_take_means(compare_side *a, compare_side *b, const compare_mask *m,
                        unsigned size) {
  for (size_t i = 0; i < a->planes.count; i++) {
    const image_plane *plane = &a->planes.planes[i];
    channel c = {plane->pixels, compare_partner(a, b, plane->name)->pixels,
                 compare_mask_channel(m, channel_letter(plane->name)),
                 a->planes.width, a->planes.height};
    for (unsigned top = 0; top < c.height; top += size)
      for (unsigned left = 0; left < c.width; left += size)
        take_mean(&c, left, top, size);
  }
}

/* ------------------------------------------------------------------------ */
/* Measures                                                                  */

/* Bounds the relative error of dark pixels. */
static const double relative_epsilon = 0.01;

typedef struct sums {
  double square, relative, largest;
  double peak, sum_b; /* of b: largest value, sum */
  size_t values, not_finite;
} sums;

/* heat (or NULL) collects the squared errors of each pixel.  worst has the
 * largest error of each pixel's channels, and is negative where nothing is
 * compared. */
static void add_channel(const image_plane *a, const image_plane *b,
                        const compare_mask *m, size_t pixels, sums *s,
                        float *heat, float *worst) {
  const channel_mask mask = compare_mask_channel(m, channel_letter(a->name));
  for (size_t i = 0; i < pixels; i++) {
    if (!channel_mask_has(&mask, i))
      continue;
    if (!isfinite(a->pixels[i]) || !isfinite(b->pixels[i])) {
      s->not_finite++;
      continue;
    }
    const double value_b = b->pixels[i];
    const double off = a->pixels[i] - value_b;
    s->square += off * off;
    s->relative += off * off / (value_b * value_b + relative_epsilon);
    s->largest = fmax(s->largest, fabs(off));
    s->peak = fmax(s->peak, fabs(value_b));
    s->sum_b += value_b;
    s->values++;
    worst[i] = fmaxf(worst[i], (float)fabs(off));
    if (heat)
      heat[i] += (float)(off * off);
  }
}

static compare_result finish(const sums *s) {
  const double n = s->values ? (double)s->values : 1.0;
  compare_result r = {.rmse = sqrt(s->square / n),
                      .relative = s->relative / n,
                      .largest = s->largest,
                      .peak = s->peak,
                      .mean = s->sum_b / n,
                      .values = s->values,
                      .not_finite = s->not_finite};
  r.psnr = r.rmse > 0.0 ? 20.0 * log10(s->peak / r.rmse) : INFINITY;
  return r;
}

static int ascending(const void *a, const void *b) {
  const float x = *(const float *)a, y = *(const float *)b;
  return (x > y) - (x < y);
}

/* The error that 95 % of the compared pixels don't exceed.  Sorts. */
static double within_95(float *worst, size_t pixels) {
  size_t left_out = 0;
  qsort(worst, pixels, sizeof *worst, ascending);
  while (left_out < pixels && worst[left_out] < 0.0f)
    left_out++;
  const size_t count = pixels - left_out;
  return count ? (double)worst[left_out + (count - 1) * 95 / 100] : 0.0;
}

int compare_measure(const compare_side *a, const compare_side *b,
                    const compare_mask *m, float *heat, compare_result *out,
                    image_error *error) {
  const size_t pixels = (size_t)a->planes.width * a->planes.height;
  float *worst = malloc((pixels + 1) * sizeof *worst);
  sums s = {0};
  if (!worst)
    return image_no_memory(error, a->path);
  for (size_t i = 0; i < pixels; i++) {
    worst[i] = -1.0f;
    if (heat)
      heat[i] = 0.0f;
  }
  for (size_t i = 0; i < a->planes.count; i++)
    add_channel(&a->planes.planes[i],
                compare_partner(a, b, a->planes.planes[i].name), m, pixels, &s,
                heat, worst);
  for (size_t i = 0; heat && i < pixels; i++)
    heat[i] = sqrtf(heat[i]);
  *out = finish(&s);
  out->within = within_95(worst, pixels);
  free(worst);
  return 0;
}

int compare_heat_limit(const float *heat, size_t pixels, float *limit) {
  float *sorted = malloc(pixels * sizeof *sorted);
  if (!sorted)
    return -1;
  memcpy(sorted, heat, pixels * sizeof *sorted);
  qsort(sorted, pixels, sizeof *sorted, ascending);
  *limit = sorted[(pixels - 1) * 99 / 100];
  if (!(*limit > 0.0f))
    *limit = sorted[pixels - 1];
  free(sorted);
  return 0;
}
