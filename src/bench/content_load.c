/* Loads what is measured on: the procedural room, or captured frames; and
 * chooses the pixels at which errors are measured. */
#include "bench/content.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene.h"

enum {
  ROOM_WIDTH = 1280,
  ROOM_HEIGHT = 720,
  QUICK_WIDTH = 320,
  QUICK_HEIGHT = 180,
  /* The exact integral of a pixel takes a CPU core about ten milliseconds, and
   * 8000 pixels give an error to within a few per cent. */
  COMPARED = 8000,
  QUICK_COMPARED = 1000
};

/* --- procedural scenes --- */

static const char *const scene_names[SCENE_KINDS] = {
    [SCENE_ROOM] = "the procedural room",
    [SCENE_SKY] = "the procedural ground under open sky",
    [SCENE_CORNER] = "the procedural corner"};

static int load_scene_frame(scene_kind kind, bench_content *out, unsigned index,
                            image_error *error) {
  bench_frame *frame = &out->frame[index];
  scene_frame scene;
  if (scene_render(kind, out->width, out->height, 0.0, index, &scene) != 0)
    return image_no_memory(error, out->name);
  const float *const planes[BENCH_INPUTS][3] = {
      [BENCH_DEPTH] = {scene.depth},
      [BENCH_NORMAL] = {scene.normal[0], scene.normal[1], scene.normal[2]},
      [BENCH_ALBEDO] = {scene.albedo[0], scene.albedo[1], scene.albedo[2]},
      [BENCH_DIRECT] = {scene.direct[0], scene.direct[1], scene.direct[2]},
      [BENCH_EMISSION] = {scene.emission[0], scene.emission[1],
                          scene.emission[2]},
      [BENCH_MOTION] = {scene.motion[0], scene.motion[1]}};
  int failed = 0;
  frame->camera = scene.camera;
  for (int i = 0; i < BENCH_INPUTS && !failed; i++)
    failed =
        bench_content_copy(out, frame, (bench_input)i, planes[i], error) != 0;
  scene_free(&scene);
  return failed ? -1 : 0;
}

static int load_scene(const bench_options *options, scene_kind kind,
                      unsigned frames, bench_content *out, image_error *error) {
  snprintf(out->name, sizeof out->name, "%s", scene_names[kind]);
  out->width = options->width   ? options->width
               : options->quick ? QUICK_WIDTH
                                : ROOM_WIDTH;
  out->height = options->width   ? options->height
                : options->quick ? QUICK_HEIGHT
                                 : ROOM_HEIGHT;
  out->config.inputs.normal_space = HBIL_SPACE_WORLD;
  out->config.model.far_field = HBIL_FAR_FRAME;
  out->radius = 1.0f;
  out->frame = calloc(frames, sizeof *out->frame);
  if (!out->frame)
    return image_no_memory(error, out->name);
  out->frames = frames;
  for (unsigned i = 0; i < frames; i++)
    if (load_scene_frame(kind, out, i, error) != 0)
      return -1;
  return 0;
}

/* --- the pixels where errors are measured --- */

/* Every n-th block of 4x4 pixels in both directions is used, so that at most
 * `most` pixels are compared. */
static uint32_t block_step(const bench_content *content, size_t most) {
  uint32_t step = 1;
  while (bench_pixels(content) / 16 / step / step > most)
    step++;
  return step;
}

/* All pixels of a rectangle. */
static int choose_window(const uint32_t window[4], bench_content *out,
                         image_error *error) {
  const uint32_t x = window[0], y = window[1], width = window[2];
  const uint32_t height = window[3];
  if (x >= out->width || width > out->width - x || y >= out->height ||
      height > out->height - y)
    return image_fail(error,
                      "--window %" PRIu32 "x%" PRIu32 "+%" PRIu32 "+%" PRIu32
                      ": it must lie in the picture's %" PRIu32 " x %" PRIu32
                      " pixels",
                      width, height, x, y, out->width, out->height);
  memcpy(out->window, window, sizeof out->window);
  for (uint32_t row = 0; row < height; row++)
    memset(out->compared + (size_t)(y + row) * out->width + x, 1, width);
  out->compared_count = (size_t)width * height;
  return 0;
}

/* One pixel of each used block.  Its position goes through all sixteen along
 * every row and column of blocks, so that each layer is measured alike. */
static int choose_compared(const bench_options *options, bench_content *out,
                           image_error *error) {
  const size_t standard = options->quick ? QUICK_COMPARED : COMPARED;
  const uint32_t step =
      4 * block_step(out, options->pixels ? options->pixels : standard);
  out->compared = calloc(bench_pixels(out), 1);
  if (!out->compared)
    return image_no_memory(error, out->name);
  if (options->window[2])
    return choose_window(options->window, out, error);
  for (uint32_t by = 0; step * by < out->height; by++)
    for (uint32_t bx = 0; step * bx < out->width; bx++) {
      const uint32_t position = (5 * bx + 7 * by) % 16;
      const uint32_t x = step * bx + position % 4;
      const uint32_t y = step * by + position / 4;
      if (x >= out->width || y >= out->height)
        continue;
      out->compared[(size_t)y * out->width + x] = 1;
      out->compared_count++;
    }
  return 0;
}

/* --- all content --- */

static int load(const bench_options *options, scene_kind kind, unsigned frames,
                int measure_last, bench_content *out, image_error *error) {
  memset(out, 0, sizeof *out);
  hbil_config_init(&out->config);
  /* The direct light of renderers holds what lamps in the picture send. */
  out->config.model.gather_emission = CL_FALSE;
  out->config.execution.profiling = CL_TRUE;
  int failed = options->frame_count
                   ? bench_content_load_dumps(options, out, error)
                   : load_scene(options, kind, frames, out, error);
  out->config.width = out->width;
  out->config.height = out->height;
  out->measured = measure_last ? out->frames - 1 : 0;
  if (!failed)
    failed = choose_compared(options, out, error);
  if (failed)
    bench_content_free(out);
  return failed;
}

int bench_content_load(const bench_options *options, unsigned frames,
                       int measure_last, bench_content *out,
                       image_error *error) {
  return load(options, SCENE_ROOM, frames, measure_last, out, error);
}

int bench_content_load_scene(const bench_options *options, scene_kind kind,
                             unsigned frames, bench_content *out,
                             image_error *error) {
  bench_options own = *options;
  own.frame_count = 0;
  return load(&own, kind, frames, 0, out, error);
}
