/* The exact integral of the measured frame.  This is the one file of the bench
 * that uses the double-precision integrals of the CPU. */
#define _POSIX_C_SOURCE 200809L
#include "bench/integrals.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "test/reference.h"

/* 64 slices differ from 1024 by .001 of AO. */
enum { SLICES = 128, QUICK_SLICES = 64 };

static void use_input(const bench_content *content, bench_input input,
                      int first, hbil_plane_format *format, ref_job *job) {
  const float *plane = content->frame[content->measured].plane[input];
  if (!plane)
    return;
  *format = (hbil_plane_format){HBIL_FLOAT32, 1};
  for (size_t c = 0; c < bench_input_channels(input); c++)
    job->input[(size_t)first + c] = plane + c * bench_pixels(content);
}

static void fill_job(const bench_content *content, bench_model model,
                     hbil_config *config, ref_job *job) {
  const bench_setting any = {.model = model, .slices = 1, .steps = 1};
  memset(job, 0, sizeof *job);
  bench_setting_apply(&any, content, config);
  job->config = config;
  job->camera = content->frame[content->measured].camera;
  memcpy(job->environment, content->environment, sizeof job->environment);
  use_input(content, BENCH_DEPTH, REF_DEPTH, &config->depth, job);
  use_input(content, BENCH_NORMAL, REF_NORMAL, &config->normal, job);
  use_input(content, BENCH_ALBEDO, REF_ALBEDO, &config->albedo, job);
  use_input(content, BENCH_DIRECT, REF_DIRECT, &config->direct, job);
  use_input(content, BENCH_EMISSION, REF_EMISSION, &config->emission, job);
  config->ao = (hbil_plane_format){HBIL_FLOAT32, 1};
  if (!bench_model_is_ao(model))
    config->near_irradiance = config->ao;
}

/* NULL when out of memory. */
static float *copy_planes(const ref_planes *from, int first, size_t count) {
  const size_t values = count * (size_t)from->width * (size_t)from->height;
  const double *source = ref_at(from, first, 0, 0);
  float *to = malloc(values * sizeof *to);
  for (size_t i = 0; to && i < values; i++)
    to[i] = (float)source[i];
  return to;
}

static int make_one(const bench_content *content, bench_model model,
                    bench_integrals *out, image_error *error) {
  const long cpus = sysconf(_SC_NPROCESSORS_ONLN);
  const ref_dense how = {.slices = out->slices,
                         .threads = cpus < 1 ? 1 : (int)cpus,
                         .wanted = content->compared};
  hbil_config config;
  ref_job job;
  ref_state state;
  fill_job(content, model, &config, &job);
  ref_state_init(&state, (int)content->width, (int)content->height);
  ref_frame_dense(&state, &job, &how);
  out->ao[model] = copy_planes(&state.out, REF_AO, 1);
  int failed = out->ao[model] == NULL;
  if (!bench_model_is_ao(model)) {
    out->light[model] = copy_planes(&state.out, REF_NEAR, 3);
    failed = failed || out->light[model] == NULL;
  }
  ref_state_free(&state);
  return failed ? image_no_memory(error, "the exact integral") : 0;
}

int bench_integrals_make(const bench_options *options,
                         const bench_content *content,
                         const bench_setting *list, size_t count,
                         bench_integrals *out, image_error *error) {
  int used[BENCH_MODELS] = {0}, failed = 0;
  memset(out, 0, sizeof *out);
  out->slices = options->quick ? QUICK_SLICES : SLICES;
  for (size_t i = 0; i < count; i++)
    used[list[i].model] = 1;
  for (size_t m = 0; m < BENCH_MODELS && !failed; m++) {
    bench_progress("exact integral of each model", m, BENCH_MODELS);
    if (used[m])
      failed = make_one(content, (bench_model)m, out, error);
  }
  bench_progress("exact integral of each model", BENCH_MODELS, BENCH_MODELS);
  return failed;
}

void bench_integrals_free(bench_integrals *integrals) {
  for (int m = 0; m < BENCH_MODELS; m++) {
    free(integrals->ao[m]);
    free(integrals->light[m]);
  }
  memset(integrals, 0, sizeof *integrals);
}
