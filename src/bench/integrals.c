/* The exact integral of the measured frame.  This is the one file of the bench
 * that uses the double-precision integrals of the CPU. */
#include "bench/integrals.h"

#include <stdlib.h>
#include <string.h>

#include "exact/exact.h"
#include "tool/report.h"

/* 64 slices differ from 1024 by .001 of AO. */
enum { SLICES = 128, QUICK_SLICES = 64 };

static void use_input(const bench_content *content, bench_input input,
                      int first, hbil_plane_format *format,
                      exact_frame *frame) {
  const float *plane = content->frame[content->measured].plane[input];
  if (!plane)
    return;
  *format = (hbil_plane_format){HBIL_FLOAT32, 4};
  for (size_t c = 0; c < bench_input_channels(input); c++)
    frame->input[(size_t)first + c] = plane + c * bench_pixels(content);
}

static void fill_frame(const bench_content *content, int has_light,
                       hbil_config *config, exact_frame *frame) {
  memset(frame, 0, sizeof *frame);
  frame->config = config;
  frame->camera = content->frame[content->measured].camera;
  memcpy(frame->environment, content->environment, sizeof frame->environment);
  frame->sky_share = content->sky_share;
  use_input(content, BENCH_DEPTH, EXACT_DEPTH, &config->inputs.depth, frame);
  use_input(content, BENCH_NORMAL, EXACT_NORMAL, &config->inputs.normal, frame);
  use_input(content, BENCH_ALBEDO, EXACT_ALBEDO, &config->inputs.albedo, frame);
  use_input(content, BENCH_DIRECT, EXACT_DIRECT, &config->inputs.direct, frame);
  use_input(content, BENCH_EMISSION, EXACT_EMISSION, &config->inputs.emission,
            frame);
  config->outputs.ao = (hbil_plane_format){HBIL_FLOAT32, 4};
  if (has_light)
    config->outputs.near_irradiance = config->outputs.ao;
}

/* NULL when out of memory. */
static float *copy_planes(const exact_planes *from, int first, size_t count) {
  const size_t values = count * (size_t)from->width * (size_t)from->height;
  const double *source = exact_at(from, first, 0, 0);
  float *to = malloc(values * sizeof *to);
  for (size_t i = 0; to && i < values; i++)
    to[i] = (float)source[i];
  return to;
}

int bench_integral_make(const bench_content *content, const hbil_config *config,
                        int slices, float **ao, float **light,
                        image_error *error) {
  const exact_dense how = {.slices = slices, .mask = content->compared};
  hbil_config own = *config;
  exact_frame frame;
  exact_state state;
  fill_frame(content, light != NULL, &own, &frame);
  exact_status status =
      exact_state_create(&state, (int)content->width, (int)content->height);
  if (status == EXACT_SUCCESS)
    status = exact_run_frame_dense(&state, &frame, &how);
  if (status == EXACT_SUCCESS) {
    *ao = copy_planes(&state.out, EXACT_AO, 1);
    if (light)
      *light = copy_planes(&state.out, EXACT_NEAR_IRRADIANCE, 3);
    if (!*ao || (light && !*light))
      status = EXACT_OUT_OF_MEMORY;
  }
  exact_state_free(&state);
  return status == EXACT_SUCCESS ? 0
                                 : image_fail(error, "the exact integral: %s",
                                              exact_status_text(status));
}

int bench_integral_slices(const bench_options *options) {
  return options->quick ? QUICK_SLICES : SLICES;
}

static int make_one(const bench_content *content, bench_model model,
                    bench_integrals *out, image_error *error) {
  const bench_setting any = {.model = model, .slices = 1, .steps = 1};
  hbil_config config;
  bench_setting_apply(&any, content, &config);
  return bench_integral_make(
      content, &config, out->slices, &out->ao[model],
      bench_model_is_ao(model) ? NULL : &out->light[model], error);
}

int bench_integrals_make(const bench_options *options,
                         const bench_content *content,
                         const bench_setting *list, size_t count,
                         bench_integrals *out, image_error *error) {
  int used[BENCH_MODELS] = {0}, failed = 0;
  memset(out, 0, sizeof *out);
  out->slices = bench_integral_slices(options);
  for (size_t i = 0; i < count; i++)
    used[list[i].model] = 1;
  for (size_t m = 0; m < BENCH_MODELS && !failed; m++) {
    progress_count("exact integral of each model", m, BENCH_MODELS);
    if (used[m])
      failed = make_one(content, (bench_model)m, out, error);
  }
  progress_count("exact integral of each model", BENCH_MODELS, BENCH_MODELS);
  return failed;
}

void bench_integrals_free(bench_integrals *integrals) {
  for (int m = 0; m < BENCH_MODELS; m++) {
    free(integrals->ao[m]);
    free(integrals->light[m]);
  }
  memset(integrals, 0, sizeof *integrals);
}
