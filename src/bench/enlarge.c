/* A captured frame with several pixels in the place of each, for times that
 * small frames can't tell.  Of a plane inverse depth is linear in the picture
 * (orthographic: depth), so that surfaces stay what they are; all else is
 * repeated. */
#include "bench/bench.h"

#include <math.h>
#include <stdlib.h>

/* Neighbours whose depths differ by more are two surfaces. */
static const float one_surface = 1.1f;

typedef struct grid {
  size_t width, height, times; /* before; enlarged by */
} grid;

/* A pixel of the larger picture's, before. */
static float nearest_of(const grid *g, const float *plane, size_t x, size_t y) {
  return plane[y / g->times * g->width + x / g->times];
}

/* The first of two pixels that a place lies between, and how far on. */
static size_t first_of(size_t at, size_t times, size_t count, float *part) {
  const float place = ((float)at + 0.5f) / (float)times - 0.5f;
  const float low = fminf(fmaxf(floorf(place), 0.0f), (float)(count - 1));
  *part = fminf(fmaxf(place - low, 0.0f), 1.0f);
  return (size_t)low;
}

static float mix(float a, float b, float part) {
  return a + part * (b - a);
}

static float depth_of(const grid *g, const bench_content *content,
                      const float *plane, size_t x, size_t y) {
  float a, b, z[4], least = INFINITY, most = 0.0f;
  const size_t left = first_of(x, g->times, g->width, &a);
  const size_t top = first_of(y, g->times, g->height, &b);
  const size_t right = left + 1 < g->width ? left + 1 : left;
  const size_t bottom = top + 1 < g->height ? top + 1 : top;
  const int inverse =
      content->config.projection != HBIL_PROJECTION_ORTHOGRAPHIC;
  for (int i = 0; i < 4; i++) {
    z[i] = plane[(i & 2 ? bottom : top) * g->width + (i & 1 ? right : left)];
    if (!gbuffer_is_surface(z[i], content->config.sky_depth))
      return nearest_of(g, plane, x, y);
    least = fminf(least, z[i]);
    most = fmaxf(most, z[i]);
    z[i] = inverse ? 1.0f / z[i] : z[i];
  }
  if (most > one_surface * least)
    return nearest_of(g, plane, x, y);
  const float found = mix(mix(z[0], z[1], a), mix(z[2], z[3], a), b);
  return inverse ? 1.0f / found : found;
}

/* Puts larger planes in the place of some that lie one after the other. */
static int enlarge(const grid *g, const bench_content *content, float **planes,
                   size_t channels, int depth, image_error *error) {
  const size_t width = g->width * g->times, height = g->height * g->times;
  if (!*planes)
    return 0;
  float *out = malloc(channels * width * height * sizeof *out);
  if (!out)
    return image_no_memory(error, content->name);
  for (size_t c = 0; c < channels; c++) {
    const float *from = *planes + c * g->width * g->height;
    for (size_t y = 0; y < height; y++)
      for (size_t x = 0; x < width; x++)
        out[(c * height + y) * width + x] =
            depth ? depth_of(g, content, from, x, y)
                  : nearest_of(g, from, x, y);
  }
  free(*planes);
  *planes = out;
  return 0;
}

static int enlarge_frame(const grid *g, const bench_content *content,
                         bench_frame *frame, image_error *error) {
  for (int i = 0; i < BENCH_INPUTS; i++)
    if (enlarge(g, content, &frame->plane[i],
                bench_input_channels((bench_input)i), i == BENCH_DEPTH,
                error) != 0)
      return -1;
  const float times = (float)g->times;
  frame->camera.fx *= times;
  frame->camera.fy *= times;
  frame->camera.cx *= times;
  frame->camera.cy *= times;
  return enlarge(g, content, &frame->motion, 2, 0, error);
}

int bench_content_enlarge(bench_content *content, unsigned times,
                          image_error *error) {
  const grid g = {content->width, content->height, times};
  if (g.width * times > HBIL_MAX_SIZE || g.height * times > HBIL_MAX_SIZE)
    return image_fail(error,
                      "--scale %u: of %u x %u pixels; no more than %u in a row "
                      "or column are possible",
                      times, content->width, content->height,
                      (unsigned)HBIL_MAX_SIZE);
  for (unsigned f = 0; f < content->frames; f++)
    if (enlarge_frame(&g, content, &content->frame[f], error) != 0)
      return -1;
  if (enlarge(&g, content, &content->truth, 3, 0, error) != 0)
    return -1;
  for (int i = 0; i < 2; i++)
    content->config.motion_scale[i] *= (float)times;
  content->width *= times;
  content->height *= times;
  return 0;
}
