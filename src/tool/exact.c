/* Sequences of frames through the exact integral. */
#include "tool/exact.h"

#include "dump/frame_camera.h"
#include "image/camera_json.h"
#include "image/error.h"
#include "image/image.h"
#include "tool/layers.h"
#include "tool/report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Where the exact integral has the tool's inputs and layers. */
static const int input_planes[INPUTS] = {EXACT_DEPTH,    EXACT_NORMAL,
                                         EXACT_ALBEDO,   EXACT_DIRECT,
                                         EXACT_EMISSION, EXACT_MOTION};
static const int layer_planes[LAYER_COUNT] = {
    [LAYER_NEAR_IRRADIANCE] = EXACT_NEAR_IRRADIANCE,
    [LAYER_FAR_IRRADIANCE] = EXACT_FAR_IRRADIANCE,
    [LAYER_INDIRECT] = EXACT_INDIRECT,
    [LAYER_AO] = EXACT_AO,
    [LAYER_BENT_NORMAL] = EXACT_BENT_NORMAL,
    [LAYER_CONE_COSINE] = EXACT_CONE_COSINE,
    [LAYER_BEAUTY] = EXACT_BEAUTY,
    [LAYER_UNKNOWN] = EXACT_UNKNOWN,
};

struct exact_sequence {
  hbil_config config;
  unsigned layers;
  size_t channels[INPUTS]; /* 0: this input is not used */
  exact_state state;
  float *no_motion; /* zeros: the motion of a frame that is repeated */
  exact_work work;
  unsigned done; /* runs, of all frames */
  progress progress;
};

/* ------------------------------------------------------------------------ */
/* Settings                                                                  */

static int check_positive(const char *option, float value, image_error *error) {
  if (value > 0.0f)
    return 0;
  return image_fail(error, "%s %g: a positive number or inf is needed", option,
                    (double)value);
}

int exact_sequence_check(const hbil_config *c, image_error *error) {
  const float low = c->model.facing_fade[0], high = c->model.facing_fade[1];
  if (check_positive("--radius", c->model.radius, error) != 0 ||
      check_positive("--ao-radius", c->model.ao_radius, error) != 0 ||
      check_positive("--thickness", c->model.thickness, error) != 0 ||
      check_positive("--relative-thickness", c->model.relative_thickness,
                     error) != 0 ||
      check_positive("--disocclusion-threshold",
                     c->history.disocclusion_threshold, error) != 0)
    return -1;
  if (low >= -1.0f && low <= high && high <= 1.0f)
    return 0;
  return image_fail(error,
                    "--facing-fade %g,%g: two cosines, the smaller one first, "
                    "are needed",
                    (double)low, (double)high);
}

static int fail(exact_status status, image_error *error) {
  return image_fail(error, "the exact integral: %s", exact_status_text(status));
}

int exact_sequence_open(const hbil_config *config, const channel_map *map,
                        unsigned layers, const exact_work *work,
                        exact_sequence **out, image_error *error) {
  const size_t pixels = (size_t)config->width * config->height;
  *out = NULL;
  exact_sequence *e = calloc(1, sizeof *e);
  if (!e)
    return image_no_memory(error, "the exact integral");
  e->config = *config;
  e->layers = layers;
  e->work = *work;
  e->no_motion = calloc(pixels, sizeof *e->no_motion);
  const exact_status status =
      e->no_motion ? exact_state_create(&e->state, (int)config->width,
                                        (int)config->height)
                   : EXACT_OUT_OF_MEMORY;
  if (status != EXACT_SUCCESS) {
    exact_sequence_close(e);
    return fail(status, error);
  }
  formats_choose(&e->config, map, layers, 0);
  for (int i = 0; i < INPUTS; i++)
    e->channels[i] = formats_channels(&e->config, map, i);
  *out = e;
  return 0;
}

void exact_sequence_close(exact_sequence *e) {
  if (!e)
    return;
  progress_clear();
  exact_state_free(&e->state);
  free(e->no_motion);
  free(e);
}

void exact_sequence_expect(exact_sequence *e, unsigned frames, unsigned runs) {
  e->work.frames = frames;
  e->work.runs = runs;
}

/* ------------------------------------------------------------------------ */
/* A frame                                                                   */

static void fill_frame(const exact_sequence *e, const gbuffer *g,
                       const camera_file *camera, const far_light *far,
                       exact_frame *frame) {
  memset(frame, 0, sizeof *frame);
  frame->config = &e->config;
  camera_file_to_hbil(camera, &frame->camera);
  memcpy(frame->environment, far->environment, sizeof frame->environment);
  frame->sky_share = far->sky_share;
  for (int i = 0; i < INPUTS; i++)
    for (size_t c = 0; c < e->channels[i]; c++)
      frame->input[(size_t)input_planes[i] + c] =
          gbuffer_plane(g, input_table[i].role, c);
}

/* A frame that is repeated does not move against itself. */
static void stop_motion(const exact_sequence *e, exact_frame *frame) {
  for (size_t c = 0; c < e->channels[INPUTS - 1]; c++)
    frame->input[EXACT_MOTION + c] = e->no_motion;
}

/* Prints, before the first frame, how long all of them will take. */
static void announce(exact_sequence *e, const exact_frame *frame) {
  const exact_work *w = &e->work;
  const size_t pixels = (size_t)e->config.width * e->config.height;
  const int slices = (int)e->config.sampling.slices, cpus = exact_cpu_count();
  char text[32];
  if (w->quiet)
    return;
  const double expected =
      w->runs * exact_predict_seconds(frame, slices, pixels);
  progress_duration(expected, text, sizeof text);
  progress_line_begin();
  fprintf(stderr,
          "hbil: exact integral of %u frame%s, %u run%s of %d slices on %d "
          "CPU%s: expected to take %s\n",
          w->frames, w->frames == 1 ? "" : "s", w->runs,
          w->runs == 1 ? "" : "s", slices, cpus, cpus == 1 ? "" : "s", text);
  progress_line_end();
  progress_start(&e->progress, "exact integral", expected, 0);
}

static void show(void *user, int done, int count) {
  exact_sequence *e = user;
  if (!e->work.quiet)
    progress_show(&e->progress, ((double)e->done + (double)done / count) /
                                    (double)e->work.runs);
}

static void copy_layers(const exact_sequence *e, image *result, image *hidden) {
  const size_t pixels = (size_t)e->config.width * e->config.height;
  for (int l = 0; l < LAYER_COUNT; l++)
    for (size_t c = 0; e->layers >> l & 1 && layer_table[l].components[c];
         c++) {
      const double *from =
          exact_at(&e->state.out, layer_planes[l] + (int)c, 0, 0);
      float *to = layers_plane_of(result, hidden, (layer)l, c);
      for (size_t i = 0; i < pixels; i++)
        to[i] = (float)from[i];
    }
}

int exact_sequence_run(exact_sequence *e, const gbuffer *g,
                       const camera_file *camera, const far_light *far,
                       unsigned repeat, image *result, image *hidden,
                       image_error *error) {
  const exact_dense how = {
      .slices = (int)e->config.sampling.slices, .progress = show, .user = e};
  exact_status status = EXACT_SUCCESS;
  exact_frame frame;
  fill_frame(e, g, camera, far, &frame);
  if (e->done == 0)
    announce(e, &frame);
  for (unsigned run = 0; run < repeat && status == EXACT_SUCCESS;
       run++, e->done++) {
    if (run == 1)
      stop_motion(e, &frame);
    status = exact_run_frame_dense(&e->state, &frame, &how);
  }
  progress_clear();
  if (status != EXACT_SUCCESS)
    return fail(status, error);
  copy_layers(e, result, hidden);
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Light on its way from one process to another                              */

static size_t values_size(const exact_planes *planes) {
  return sizeof *planes->values * (size_t)planes->count *
         (size_t)planes->width * (size_t)planes->height;
}

/* The history, then the bounces of its light. */
size_t exact_sequence_light_size(const exact_sequence *e) {
  const exact_planes *history = &e->state.history;
  return e->config.history.reprojection == HBIL_REPROJECTION_NONE
             ? 0
             : values_size(history) + sizeof e->state.bounces;
}

void exact_sequence_take_light(const exact_sequence *e, void *bytes) {
  const exact_planes *history = &e->state.history;
  const size_t size = values_size(history);
  memcpy(bytes, history->values, size);
  memcpy((unsigned char *)bytes + size, &e->state.bounces,
         sizeof e->state.bounces);
}

void exact_sequence_give_light(exact_sequence *e, const camera_file *camera,
                               const void *bytes) {
  const size_t size = values_size(&e->state.history);
  memcpy(e->state.history.values, bytes, size);
  memcpy(&e->state.bounces, (const unsigned char *)bytes + size,
         sizeof e->state.bounces);
  camera_file_to_hbil(camera, &e->state.camera);
  e->state.has_history = true;
}
