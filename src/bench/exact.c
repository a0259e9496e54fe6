/* What sampling errors are measured against: the exact screen-space integral of
 * frame 0, model by model, where pixels are compared. */
/* first: bench.h has a type that is a parameter in the headers of this one */
#include "tool/exact.h"
#include "bench/bench.h"

#include <stdlib.h>
#include <string.h>

/* One model's. */
typedef struct task {
  const bench_content *content;
  hbil_config config;
  ref_job job;
  int slices;
} task;

/* All of them, for whoever watches. */
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
    t->job.input[(size_t)first + c] = plane + c * bench_pixels(t->content);
}

static void fill_task(const bench_content *content, bench_model model,
                      int slices, task *t) {
  const bench_configuration any = {.slices = 1, .samples = 1, .model = model};
  memset(t, 0, sizeof *t);
  t->content = content;
  t->slices = slices;
  bench_configure(content, &any, &t->config);
  t->job.config = &t->config;
  t->job.camera = content->frame[0].camera;
  memcpy(t->job.environment, bench_environment(content, t->config.far_field),
         sizeof t->job.environment);
  use_input(t, BENCH_DEPTH, REF_DEPTH, &t->config.depth);
  use_input(t, BENCH_NORMAL, REF_NORMAL, &t->config.normal);
  use_input(t, BENCH_ALBEDO, REF_ALBEDO, &t->config.albedo);
  use_input(t, BENCH_DIRECT, REF_DIRECT, &t->config.direct);
  use_input(t, BENCH_EMISSION, REF_EMISSION, &t->config.emission);
  t->config.ao = (hbil_plane_format){HBIL_FLOAT32, 1};
  if (!bench_is_ao_alone(model))
    t->config.near_irradiance = (hbil_plane_format){HBIL_FLOAT32, 1};
}

static void show(void *user, int done, int count) {
  watch *w = user;
  progress_show(&w->progress, (w->done + (double)done / count) / w->count);
}

static float *copy_planes(const ref_planes *from, int first, int count) {
  const size_t plane = (size_t)from->width * (size_t)from->height;
  const size_t values = plane * (size_t)count;
  const double *source = ref_at(from, first, 0, 0);
  float *to = malloc(values * sizeof *to);
  for (size_t i = 0; to && i < values; i++)
    to[i] = (float)source[i];
  return to;
}

static int make_one(task *t, bench_model model, watch *w, bench_exact *out,
                    image_error *error) {
  const ref_dense how = {.slices = t->slices,
                         .threads = exact_threads(),
                         .wanted = t->content->compared,
                         .progress = show,
                         .user = w};
  ref_state state;
  ref_state_init(&state, (int)t->content->width, (int)t->content->height);
  ref_frame_dense(&state, &t->job, &how);
  out->ao[model] = copy_planes(&state.out, REF_AO, 1);
  int failed = !out->ao[model];
  if (!failed && !bench_is_ao_alone(model)) {
    out->light[model] = copy_planes(&state.out, REF_NEAR, 3);
    failed = !out->light[model];
  }
  ref_state_free(&state);
  return failed ? image_no_memory(error, "the exact integral") : 0;
}

/* Says how long it will take. */
static void announce(const bench_content *content, int slices,
                     const int used[BENCH_MODELS], watch *w) {
  double expected = 0.0;
  char text[32];
  task t;
  for (int m = 0; m < BENCH_MODELS; m++)
    if (used[m]) {
      fill_task(content, (bench_model)m, slices, &t);
      expected += exact_probe(&t.job, slices, content->compared_count);
      w->count++;
    }
  progress_duration(expected, text, sizeof text);
  fprintf(stderr,
          "hbil: exact integral of %d models, %d slices in %zu pixels, on %d "
          "CPU%s: about %s\n",
          w->count, slices, content->compared_count, exact_threads(),
          exact_threads() == 1 ? "" : "s", text);
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
