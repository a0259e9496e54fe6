/* What is measured on: frames of the procedural room, or captured frames. */
#ifndef HBIL_BENCH_CONTENT_H
#define HBIL_BENCH_CONTENT_H

#include <math.h>

#include "bench/command.h"
#include "hbil/hbil.h"
#include "scene/scene.h"

typedef enum bench_input {
  BENCH_DEPTH = 0,
  BENCH_NORMAL,
  BENCH_ALBEDO,
  BENCH_DIRECT,
  BENCH_EMISSION,
  BENCH_MOTION,
  BENCH_INPUTS
} bench_input;

typedef struct bench_frame {
  hbil_camera camera;
  /* One float plane per channel, one after the other; NULL: no such input. */
  float *plane[BENCH_INPUTS];
} bench_frame;

typedef struct bench_content {
  char name[512];
  char note[256]; /* what had to be assumed, as a sentence; or empty */
  uint32_t width, height;
  bench_frame *frame;
  unsigned frames;
  unsigned measured;       /* the frame whose errors are measured */
  hbil_config config;      /* size, conventions and far field; defaults else */
  float environment[9][3]; /* of that far field */
  float sky_share;         /* as hbil_frame has it */
  float radius;            /* world units that suit HBAO */
  /* One byte a pixel: whether the sampling error is measured there.  Each of
   * the 16 interleaved layers has as many of these pixels. */
  unsigned char *compared;
  size_t compared_count;
  uint32_t window[4]; /* as in bench_options: these pixels are compared */
} bench_content;

/* frames: of the room, if that is what options ask for; captured frames are all
 * loaded.  Errors are measured in the first frame, or in the last one. */
int bench_content_load(const bench_options *options, unsigned frames,
                       int measure_last, bench_content *out,
                       image_error *error);
/* Frames of a procedural scene, whatever frames the options name. */
int bench_content_load_scene(const bench_options *options, scene_kind kind,
                             unsigned frames, bench_content *out,
                             image_error *error);
/* Frees the planes of the frames and nothing else, once they are on the
 * device. */
void bench_content_drop_planes(bench_content *content);
void bench_content_free(bench_content *content);

static inline size_t bench_input_channels(bench_input input) {
  return input == BENCH_DEPTH ? 1 : input == BENCH_MOTION ? 2 : 3;
}
static inline size_t bench_pixels(const bench_content *content) {
  return (size_t)content->width * content->height;
}
/* Whether a pixel of the measured frame shows a surface. */
static inline int bench_is_surface(const bench_content *content, size_t pixel) {
  const bench_frame *frame = &content->frame[content->measured];
  const float depth = frame->plane[BENCH_DEPTH][pixel];
  return isfinite(depth) && depth > 0.0f &&
         depth < content->config.inputs.sky_depth;
}

/* Copies the channels of an input into a frame's plane. */
int bench_content_copy(bench_content *content, bench_frame *frame,
                       bench_input input, const float *const *channels,
                       image_error *error);

/* --- content_dump.c --- */

/* Loads options->frames; the config gets their conventions.  What was loaded is
 * freed by the caller, also after a failure. */
int bench_content_load_dumps(const bench_options *options, bench_content *out,
                             image_error *error);

/* --- errors.c: how far results are off in the measured frame --- */

/* Mean of AO over the compared surfaces. */
double bench_ao_mean(const bench_content *content, const float *ao);
/* RMSE of AO, and of E_near (RGB) over the mean of `exact`, at the compared
 * surfaces; NAN where a value is not finite. */
double bench_ao_error(const bench_content *content, const float *ao,
                      const float *exact);
double bench_light_error(const bench_content *content, const float *light,
                         const float *exact);
/* RMSE of AO's error in the band of structures that an eye sees: the error
 * blurred by a Gaussian of 1.5 pixels, without what one of 8 pixels leaves of
 * it.  Both blurs are of the window's surfaces alone.  NAN without a window, or
 * where a value is not finite. */
double bench_ao_band(const bench_content *content, const float *ao,
                     const float *exact);

#endif
