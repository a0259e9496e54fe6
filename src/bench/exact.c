/* The exact screen-space integral of frame 0, model by model, at the pixels
 * where sampling errors are measured. */
#include "exact/exact.h"
#include "bench/bench.h"

#include <stdlib.h>
#include <string.h>

/* The integral of one model. */
typedef struct task {
  const bench_content *content;
  hbil_config config;
  exact_frame frame;
  int slices;
} task;

/* Progress over all of them. */
typedef struct watch {
  progress progress;
  int done, count; /* models */
} watch;

static void use_input(task *t, bench_input input, int first,
                      hbil_plane_format *format) {
  const float *plane = t->content->frame[0].plane[input];
  if (!plane)
    return;
  *format = (hbil_plane_format){HBIL_FLOAT32, 1};
  for (size_t c = 0; c < bench_input_channels(input); c++)
    t->frame.input[(size_t)first + c] = plane + c * bench_pixels(t->content);
}

static void fill_task(const bench_content *content, bench_model model,
                      int slices, task *t) {
  const bench_configuration any = {.slices = 1, .samples = 1, .model = model};
  memset(t, 0, sizeof *t);
  t->content = content;
  t->slices = slices;
  bench_configure(content, &any, &t->config);
  t->frame.config = &t->config;
  t->frame.camera = content->frame[0].camera;
  memcpy(t->frame.environment, bench_environment(content, t->config.far_field),
         sizeof t->frame.environment);
  use_input(t, BENCH_DEPTH, EXACT_DEPTH, &t->config.depth);
  use_input(t, BENCH_NORMAL, EXACT_NORMAL, &t->config.normal);
  use_input(t, BENCH_ALBEDO, EXACT_ALBEDO, &t->config.albedo);
  use_input(t, BENCH_DIRECT, EXACT_DIRECT, &t->config.direct);
  use_input(t, BENCH_EMISSION, EXACT_EMISSION, &t->config.emission);
  t->config.ao = (hbil_plane_format){HBIL_FLOAT32, 1};
  if (!bench_is_ao_alone(model))
    t->config.near_irradiance = (hbil_plane_format){HBIL_FLOAT32, 1};
}

static void show(void *user, int done, int count) {
  watch *w = user;
  progress_show(&w->progress, (w->done + (double)done / count) / w->count);
}

static int fail(exact_status status, image_error *error) {
  return image_fail(error, "the exact integral: %s", exact_status_text(status));
}

/* NULL: out of memory. */
static float *copy_planes(const exact_planes *from, int first, int count) {
  const size_t plane = (size_t)from->width * (size_t)from->height;
  const size_t values = plane * (size_t)count;
  const double *source = exact_at(from, first, 0, 0);
  float *to = malloc(values * sizeof *to);
  for (size_t i = 0; to && i < values; i++)
    to[i] = (float)source[i];
  return to;
}

/* What has been allocated in `out` stays there for bench_exact_free(). */
static int make_one(task *t, bench_model model, watch *w, bench_exact *out,
                    image_error *error) {
  const exact_dense how = {.slices = t->slices,
                           .mask = t->content->compared,
                           .progress = show,
                           .user = w};
  exact_state state;
  exact_status status = exact_state_create(&state, (int)t->content->width,
                                           (int)t->content->height);
  if (status == EXACT_SUCCESS)
    status = exact_run_frame_dense(&state, &t->frame, &how);
  if (status == EXACT_SUCCESS) {
    out->ao[model] = copy_planes(&state.out, EXACT_AO, 1);
    if (!bench_is_ao_alone(model))
      out->light[model] = copy_planes(&state.out, EXACT_NEAR_IRRADIANCE, 3);
    if (!out->ao[model] || (!bench_is_ao_alone(model) && !out->light[model]))
      status = EXACT_OUT_OF_MEMORY;
  }
  exact_state_free(&state);
  return status == EXACT_SUCCESS ? 0 : fail(status, error);
}

/* Prints how long it will take. */
static void announce(const bench_content *content, int slices,
                     const int used[BENCH_MODELS], watch *w) {
  const int cpus = exact_cpu_count();
  double expected = 0.0;
  char text[32];
  task t;
  for (int m = 0; m < BENCH_MODELS; m++)
    if (used[m]) {
      fill_task(content, (bench_model)m, slices, &t);
      expected +=
          exact_predict_seconds(&t.frame, slices, content->compared_count);
      w->count++;
    }
  progress_duration(expected, text, sizeof text);
  fprintf(stderr,
          "hbil: exact integral of %d models, %d slices in %zu pixels, on %d "
          "CPU%s: expected to take %s\n",
          w->count, slices, content->compared_count, cpus, cpus == 1 ? "" : "s",
          text);
  progress_start(&w->progress, "exact integral", expected, 0);
}

int bench_exact_make(const bench_content *content, int slices,
                     const bench_configuration *list, size_t count,
                     bench_exact *out, image_error *error) {
  int used[BENCH_MODELS] = {0}, failed = 0;
  watch w = {.done = 0};
  memset(out, 0, sizeof *out);
  out->slices = slices;
  for (size_t i = 0; i < count; i++)
    used[list[i].model] = 1;
  used[BENCH_PAPER] = 1; /* the baseline's */
  announce(content, slices, used, &w);
  for (int m = 0; m < BENCH_MODELS && !failed; m++)
    if (used[m]) {
      task t;
      fill_task(content, (bench_model)m, slices, &t);
      failed = make_one(&t, (bench_model)m, &w, out, error);
      w.done++;
    }
  progress_clear();
  return failed;
}

void bench_exact_free(bench_exact *exact) {
  for (int m = 0; m < BENCH_MODELS; m++) {
    free(exact->ao[m]);
    free(exact->light[m]);
  }
  memset(exact, 0, sizeof *exact);
}
