/*
 * Frames through the exact screen-space integral: every pixel that a slice
 * crosses, hundreds of slices, double precision, on the CPU.  The same model
 * and the same files as through the library, for a thousand times as long.
 */
#define _POSIX_C_SOURCE 200809L
#include "tool/exact.h"

#include "dump/frame_camera.h"
#include "tool/formats.h"
#include "tool/layers.h"
#include "tool/progress.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Pixels that are looked at before a word is said about the time. */
enum { PROBED = 400 };

/* Where the reference has the tool's inputs and layers. */
static const int input_planes[INPUTS] = {REF_DEPTH,  REF_NORMAL,   REF_ALBEDO,
                                         REF_DIRECT, REF_EMISSION, REF_MOTION};
static const int layer_planes[LAYER_COUNT] = {
    [LAYER_NEAR_IRRADIANCE] = REF_NEAR, [LAYER_FAR_IRRADIANCE] = REF_FAR,
    [LAYER_INDIRECT] = REF_INDIRECT,    [LAYER_AO] = REF_AO,
    [LAYER_BENT_NORMAL] = REF_BENT,     [LAYER_CONE_COSINE] = REF_CONE,
    [LAYER_BEAUTY] = REF_RADIANCE,
};

struct exact_sequence {
  hbil_config config;
  unsigned layers;
  size_t channels[INPUTS]; /* 0: this input is not used */
  ref_state state;
  float *still; /* motion of a frame that is repeated: zero */
  exact_work work;
  unsigned done; /* runs, of all frames */
  progress progress;
};

int exact_threads(void) {
  const long cpus = sysconf(_SC_NPROCESSORS_ONLN);
  return cpus < 1 ? 1 : cpus > 1024 ? 1024 : (int)cpus;
}

/* ------------------------------------------------------------------------ */
/* How long it takes                                                         */

/* One pixel in each block of side x side, anywhere in it: regular rows could
 * all be one thread's. */
static size_t mark_some(unsigned char *wanted, int width, int height,
                        int side) {
  unsigned random = 1;
  size_t count = 0;
  for (int y = 0; y < height; y += side)
    for (int x = 0; x < width; x += side) {
      random = random * 1664525u + 1013904223u;
      const int i = x + (int)((random >> 8) % (unsigned)side);
      const int j = y + (int)((random >> 20) % (unsigned)side);
      if (i >= width || j >= height)
        continue;
      wanted[(size_t)j * (size_t)width + (size_t)i] = 1;
      count++;
    }
  return count;
}

/* Seconds for the marked pixels. */
static double time_some(ref_job *job, const ref_dense *how) {
  const int width = (int)job->config->width, height = (int)job->config->height;
  ref_planes split = ref_planes_new(width, height, HBIL_SPLIT_PLANES);
  ref_planes gathered = ref_planes_new(width, height, HBIL_GATHERED_PLANES);
  ref_split(job, NULL, &split);
  ref_estimate_frame(job, &split);
  const double before = progress_clock();
  ref_gather_dense(job, &split, how, &gathered);
  const double seconds = progress_clock() - before;
  ref_planes_free(&split);
  ref_planes_free(&gathered);
  return seconds;
}

double exact_probe(const ref_job *job, int slices, size_t wanted) {
  const int width = (int)job->config->width, height = (int)job->config->height;
  const size_t pixels = (size_t)width * (size_t)height;
  unsigned char *some = calloc(pixels, 1);
  if (!some)
    return 0.0; /* it only was for a word about the time */
  int side = 1;
  while ((size_t)(side + 1) * (size_t)(side + 1) * PROBED <= pixels)
    side++;
  const size_t count = mark_some(some, width, height, side);
  const ref_dense how = {
      .slices = slices, .threads = exact_threads(), .wanted = some};
  ref_job copy = *job;
  const double seconds = count ? time_some(&copy, &how) : 0.0;
  free(some);
  return count ? seconds * (double)wanted / (double)count : 0.0;
}

/* ------------------------------------------------------------------------ */
/* Settings                                                                  */

static int check_positive(const char *option, float value, image_error *error) {
  if (value > 0.0f)
    return 0;
  return image_fail(error, "%s %g: a positive number or inf is needed", option,
                    (double)value);
}

int exact_check(const hbil_config *c, image_error *error) {
  if (check_positive("--radius", c->radius, error) != 0 ||
      check_positive("--thickness", c->thickness, error) != 0 ||
      check_positive("--relative-thickness", c->relative_thickness, error) !=
          0 ||
      check_positive("--disocclusion-threshold", c->disocclusion_threshold,
                     error) != 0)
    return -1;
  if (c->facing_fade[0] >= -1.0f && c->facing_fade[0] <= c->facing_fade[1] &&
      c->facing_fade[1] <= 1.0f)
    return 0;
  return image_fail(
      error,
      "--facing-fade %g,%g: two cosines, the smaller one first, are "
      "needed",
      (double)c->facing_fade[0], (double)c->facing_fade[1]);
}

int exact_open(const hbil_config *config, const channel_map *map,
               unsigned layers, const exact_work *work, exact_sequence **out,
               image_error *error) {
  const size_t pixels = (size_t)config->width * config->height;
  *out = NULL;
  exact_sequence *e = calloc(1, sizeof *e);
  float *still = calloc(pixels, sizeof *still);
  if (!e || !still) {
    free(e);
    free(still);
    return image_no_memory(error, "the exact integral");
  }
  e->config = *config;
  e->layers = layers;
  e->still = still;
  e->work = *work;
  formats_choose(&e->config, map, layers);
  for (int i = 0; i < INPUTS; i++)
    e->channels[i] = formats_channels(&e->config, map, i);
  ref_state_init(&e->state, (int)config->width, (int)config->height);
  *out = e;
  return 0;
}

void exact_close(exact_sequence *e) {
  if (!e)
    return;
  progress_clear();
  ref_state_free(&e->state);
  free(e->still);
  free(e);
}

void exact_expect(exact_sequence *e, unsigned frames, unsigned runs) {
  e->work.frames = frames;
  e->work.runs = runs;
}

/* ------------------------------------------------------------------------ */
/* A frame                                                                   */

static void fill_job(const exact_sequence *e, const gbuffer *g,
                     const camera_file *camera, float environment[9][3],
                     ref_job *job) {
  memset(job, 0, sizeof *job);
  job->config = &e->config;
  camera_file_to_hbil(camera, &job->camera);
  memcpy(job->environment, environment, sizeof job->environment);
  for (int i = 0; i < INPUTS; i++)
    for (size_t c = 0; c < e->channels[i]; c++)
      job->input[(size_t)input_planes[i] + c] =
          gbuffer_plane(g, input_table[i].role, c);
}

/* A frame that is repeated doesn't move against itself. */
static void stop_motion(const exact_sequence *e, ref_job *job) {
  for (size_t c = 0; c < e->channels[INPUTS - 1]; c++)
    job->input[REF_MOTION + c] = e->still;
}

/* Before the first frame. */
static void announce(exact_sequence *e, const ref_job *job) {
  const exact_work *w = &e->work;
  const size_t pixels = (size_t)e->config.width * e->config.height;
  char text[32];
  if (w->quiet)
    return;
  const double expected =
      w->runs * exact_probe(job, (int)e->config.slices, pixels);
  progress_duration(expected, text, sizeof text);
  progress_line_begin();
  fprintf(stderr,
          "hbil: exact integral of %u frame%s, %u run%s of %u slices on %d "
          "CPU%s: about %s\n",
          w->frames, w->frames == 1 ? "" : "s", w->runs,
          w->runs == 1 ? "" : "s", (unsigned)e->config.slices, exact_threads(),
          exact_threads() == 1 ? "" : "s", text);
  progress_line_end();
  progress_start(&e->progress, "exact integral", expected, 0);
}

static void show(void *user, int done, int count) {
  exact_sequence *e = user;
  if (!e->work.quiet)
    progress_show(&e->progress, ((double)e->done + (double)done / count) /
                                    (double)e->work.runs);
}

static void take_layers(const exact_sequence *e, image *result) {
  const size_t pixels = (size_t)e->config.width * e->config.height;
  for (int l = 0; l < LAYER_COUNT; l++)
    for (size_t c = 0; e->layers >> l & 1 && layer_table[l].components[c];
         c++) {
      const double *from =
          ref_at(&e->state.out, layer_planes[l] + (int)c, 0, 0);
      float *to = layers_plane(result, (layer)l, c);
      for (size_t i = 0; i < pixels; i++)
        to[i] = (float)from[i];
    }
}

void exact_run(exact_sequence *e, const gbuffer *g, const camera_file *camera,
               float environment[9][3], unsigned repeat, image *result) {
  const ref_dense how = {.slices = (int)e->config.slices,
                         .threads = exact_threads(),
                         .progress = show,
                         .user = e};
  ref_job job;
  fill_job(e, g, camera, environment, &job);
  if (e->done == 0)
    announce(e, &job);
  for (unsigned run = 0; run < repeat; run++, e->done++) {
    if (run == 1)
      stop_motion(e, &job);
    ref_frame_dense(&e->state, &job, &how);
  }
  progress_clear();
  take_layers(e, result);
}

/* ------------------------------------------------------------------------ */
/* Light on its way from one process to another                              */

size_t exact_light_size(const exact_sequence *e) {
  const ref_planes *history = &e->state.history;
  return e->config.reprojection == HBIL_REPROJECTION_NONE
             ? 0
             : sizeof *history->values * (size_t)history->count *
                   (size_t)history->width * (size_t)history->height;
}

void exact_take_light(const exact_sequence *e, void *bytes) {
  memcpy(bytes, e->state.history.values, exact_light_size(e));
}

void exact_give_light(exact_sequence *e, const camera_file *camera,
                      const void *bytes) {
  memcpy(e->state.history.values, bytes, exact_light_size(e));
  camera_file_to_hbil(camera, &e->state.camera);
  e->state.has_history = true;
}
