/* The library on the content. */
#define _POSIX_C_SOURCE 200809L
#include "bench/fixture.h"

#include <stdlib.h>
#include <string.h>

struct bench_fixture {
  const bench_device *device;
  const bench_content *content;
  hbil_context *context;
  size_t plane;                  /* bytes */
  cl_mem (*input)[BENCH_INPUTS]; /* of every frame */
  cl_mem output[BENCH_OUTPUTS];
};

/* Where the library's structs have a plane and its format. */
typedef struct plane_fields {
  size_t format, plane; /* offsets in hbil_config and hbil_frame */
  size_t channels;
} plane_fields;

#define FIELDS(group, field, channels)                                         \
  { offsetof(hbil_config, group.field), offsetof(hbil_frame, field), channels }

static const plane_fields inputs[BENCH_INPUTS] = {
    [BENCH_DEPTH] = FIELDS(inputs, depth, 1),
    [BENCH_NORMAL] = FIELDS(inputs, normal, 3),
    [BENCH_ALBEDO] = FIELDS(inputs, albedo, 3),
    [BENCH_DIRECT] = FIELDS(inputs, direct, 3),
    [BENCH_EMISSION] = FIELDS(inputs, emission, 3),
    [BENCH_MOTION] = FIELDS(inputs, motion, 2)};

static const plane_fields outputs[BENCH_OUTPUTS] = {
    [BENCH_AO] = FIELDS(outputs, ao, 1),
    [BENCH_NEAR] = FIELDS(outputs, near_irradiance, 3),
    [BENCH_INDIRECT] = FIELDS(outputs, indirect, 3),
    [BENCH_FAR] = FIELDS(outputs, far_irradiance, 3),
    [BENCH_BENT_NORMAL] = FIELDS(outputs, bent_normal, 3),
    [BENCH_CONE_COSINE] = FIELDS(outputs, cone_cosine, 1),
    [BENCH_BEAUTY] = FIELDS(outputs, beauty, 3),
    [BENCH_ERROR_ESTIMATE] = FIELDS(outputs, error_estimate, 2)};

static hbil_plane_format *format_at(hbil_config *config, size_t offset) {
  return (hbil_plane_format *)((char *)config + offset);
}

static hbil_plane *plane_at(hbil_frame *frame, size_t offset) {
  return (hbil_plane *)((char *)frame + offset);
}

static int library_failed(const bench_fixture *f, hbil_status status,
                          image_error *error) {
  const char *message = f->context ? hbil_context_message(f->context) : "";
  return image_fail(error, "device %s: %s", f->device->name,
                    *message ? message : hbil_status_string(status));
}

/* --- planes on the device --- */

static int upload(bench_fixture *f, image_error *error) {
  const bench_content *content = f->content;
  int failed = 0;
  for (unsigned n = 0; n < content->frames; n++)
    for (int i = 0; i < BENCH_INPUTS && !failed; i++)
      if (content->frame[n].plane[i])
        failed = bench_buffer_new(f->device, inputs[i].channels * f->plane,
                                  content->frame[n].plane[i], &f->input[n][i],
                                  error);
  for (int o = 0; o < BENCH_OUTPUTS && !failed; o++)
    failed = bench_buffer_new(f->device, outputs[o].channels * f->plane, NULL,
                              &f->output[o], error);
  return failed;
}

int bench_fixture_open(const bench_device *d, const bench_content *content,
                       bench_fixture **out, image_error *error) {
  bench_fixture *f = calloc(1, sizeof *f);
  *out = NULL;
  if (!f)
    return image_no_memory(error, content->name);
  f->device = d;
  f->content = content;
  f->plane = bench_pixels(content) * sizeof(cl_float);
  f->input = calloc(content->frames, sizeof *f->input);
  const hbil_status status =
      hbil_context_create(d->context, d->id, &f->context);
  const int failed = !f->input ? image_no_memory(error, content->name)
                     : status != HBIL_SUCCESS ? library_failed(f, status, error)
                                              : upload(f, error);
  if (failed)
    bench_fixture_close(f);
  else
    *out = f;
  return failed;
}

void bench_fixture_close(bench_fixture *f) {
  if (!f)
    return;
  for (unsigned n = 0; f->input && n < f->content->frames; n++)
    for (int i = 0; i < BENCH_INPUTS; i++)
      if (f->input[n][i])
        clReleaseMemObject(f->input[n][i]);
  for (int o = 0; o < BENCH_OUTPUTS; o++)
    if (f->output[o])
      clReleaseMemObject(f->output[o]);
  hbil_context_destroy(f->context);
  free(f->input);
  free(f);
}

hbil_context *bench_fixture_context(const bench_fixture *f) {
  return f->context;
}

/* --- one plan --- */

/* Whether plans of this configuration read or write a plane. */
static int reads(const bench_trial *t, int input) {
  return t->fixture->input[0][input] &&
         (input != BENCH_MOTION ||
          t->config.history.reprojection == HBIL_REPROJECTION_MOTION);
}

/* A configuration that asks for none of the outputs, but for the estimate of
 * errors perhaps, gets all others of its model. */
static int writes(const bench_trial *t, int output) {
  hbil_config config = t->config;
  int asked = 0;
  for (int o = 0; o < BENCH_OUTPUTS; o++)
    if (o != BENCH_ERROR_ESTIMATE)
      asked |= format_at(&config, outputs[o].format)->component != HBIL_NONE;
  if (asked || output == BENCH_ERROR_ESTIMATE)
    return format_at(&config, outputs[output].format)->component != HBIL_NONE;
  return output == BENCH_AO || config.model.mode == HBIL_MODE_HBIL;
}

static void set_formats(bench_trial *t) {
  const hbil_plane_format floats = {HBIL_FLOAT32, 4};
  int written[BENCH_OUTPUTS];
  for (int o = 0; o < BENCH_OUTPUTS; o++)
    written[o] = writes(t, o);
  for (int i = 0; i < BENCH_INPUTS; i++)
    if (reads(t, i) && !format_at(&t->config, inputs[i].format)->component)
      *format_at(&t->config, inputs[i].format) = floats;
  for (int o = 0; o < BENCH_OUTPUTS; o++)
    if (written[o])
      *format_at(&t->config, outputs[o].format) = floats;
}

static hbil_status make_plan(bench_trial *t) {
  hbil_context *context = t->fixture->context;
  hbil_memory memory = {0, 0};
  const hbil_status status = hbil_plan_memory(context, &t->config, &memory);
  t->memory = memory.persistent + memory.scratch;
  return status == HBIL_SUCCESS
             ? hbil_plan_create(context, &t->config, &t->plan)
             : status;
}

/* The library reads the environment when it makes a plan; whatever the user
 * has set there is restored. */
static hbil_status make_plan_from(bench_trial *t, const char *kernels) {
  static const char name[] = "HBIL_KERNEL_DIR";
  const char *set = getenv(name);
  char *before = set ? strdup(set) : NULL;
  if ((set && !before) || setenv(name, kernels, 1) != 0) {
    free(before);
    return HBIL_OUT_OF_HOST_MEMORY;
  }
  const hbil_status status = make_plan(t);
  if (before)
    setenv(name, before, 1);
  else
    unsetenv(name);
  free(before);
  return status;
}

int bench_trial_open(bench_fixture *f, const hbil_config *config,
                     const char *kernels, bench_trial *out,
                     image_error *error) {
  *out = (bench_trial){.fixture = f, .config = *config};
  set_formats(out);
  const hbil_status status =
      kernels ? make_plan_from(out, kernels) : make_plan(out);
  return status == HBIL_SUCCESS ? 0 : library_failed(f, status, error);
}

void bench_trial_close(bench_trial *t) {
  if (t->plan)
    clFinish(t->fixture->device->queue);
  hbil_plan_destroy(t->plan);
  t->plan = NULL;
}

int bench_trial_run(const bench_trial *t, unsigned frame, unsigned frame_index,
                    int is_static, image_error *error) {
  const bench_fixture *f = t->fixture;
  hbil_frame h;
  hbil_frame_init(&h);
  h.camera = f->content->frame[frame].camera;
  h.frame_index = frame_index;
  h.static_frame = is_static ? CL_TRUE : CL_FALSE;
  memcpy(h.hardware_depth, t->hardware_depth, sizeof h.hardware_depth);
  memcpy(h.environment, f->content->environment, sizeof h.environment);
  h.sky_share = f->content->sky_share;
  h.cache = t->cache;
  for (int i = 0; i < BENCH_INPUTS; i++)
    if (reads(t, i))
      plane_at(&h, inputs[i].plane)->buffer =
          t->replaced[i] ? t->replaced[i] : f->input[frame][i];
  for (int o = 0; o < BENCH_OUTPUTS; o++)
    if (writes(t, o))
      plane_at(&h, outputs[o].plane)->buffer = f->output[o];
  const hbil_status status =
      hbil_enqueue_frame(t->plan, f->device->queue, &h, 0, NULL, NULL);
  return status == HBIL_SUCCESS ? 0 : library_failed(f, status, error);
}

void bench_trial_view(const bench_trial *t, unsigned frame, hbil_view *out) {
  const bench_fixture *f = t->fixture;
  hbil_plane *const planes[BENCH_INPUTS] = {[BENCH_DEPTH] = &out->depth,
                                            [BENCH_NORMAL] = &out->normal,
                                            [BENCH_ALBEDO] = &out->albedo,
                                            [BENCH_DIRECT] = &out->direct,
                                            [BENCH_EMISSION] = &out->emission};
  hbil_view_init(out);
  out->width = f->content->width;
  out->height = f->content->height;
  out->projection = t->config.inputs.projection;
  out->camera = f->content->frame[frame].camera;
  for (int i = 0; i < BENCH_INPUTS; i++)
    if (planes[i])
      planes[i]->buffer = f->input[frame][i];
}

int bench_trial_read(const bench_trial *t, bench_output output, float *out,
                     image_error *error) {
  const bench_fixture *f = t->fixture;
  const cl_int status = clEnqueueReadBuffer(
      f->device->queue, f->output[output], CL_TRUE, 0,
      outputs[output].channels * f->plane, out, 0, NULL, NULL);
  return status == CL_SUCCESS ? 0
                              : bench_opencl_failed(f->device, status,
                                                    "reading a buffer", error);
}

int bench_trial_passes(const bench_trial *t,
                       double milliseconds[HBIL_PASS_COUNT], double *total,
                       image_error *error) {
  const hbil_status status = hbil_plan_timings(t->plan, milliseconds);
  if (status != HBIL_SUCCESS)
    return library_failed(t->fixture, status, error);
  *total = 0.0;
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    *total += milliseconds[p];
  return 0;
}

/* --- plans in turns --- */

/* The times of every run of one plan. */
typedef struct run_times {
  double pass[HBIL_PASS_COUNT][BENCH_MAX_RUNS];
  double total[BENCH_MAX_RUNS], host[BENCH_MAX_RUNS];
} run_times;

static unsigned frame_of(const bench_turn *turn, unsigned run) {
  return turn->play == BENCH_PLAY_STATIC
             ? 0
             : (run + 1) % turn->fixture->content->frames;
}

/* Runs of the warm-up are stored in slot 0, and overwritten. */
static int time_run(const bench_turn *turn, const bench_trial *t, unsigned run,
                    run_times *out, image_error *error) {
  const unsigned slot = run < BENCH_WARM_UP ? 0 : run - BENCH_WARM_UP;
  double pass[HBIL_PASS_COUNT];
  const double before = bench_clock();
  if (bench_trial_run(t, frame_of(turn, run), 0,
                      turn->play == BENCH_PLAY_STATIC, error) != 0)
    return -1;
  out->host[slot] = bench_clock() - before;
  if (bench_trial_passes(t, pass, &out->total[slot], error) != 0)
    return -1;
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    out->pass[p][slot] = pass[p];
  return 0;
}

static int open_turn(const bench_turn *turn, bench_trial *out,
                     image_error *error) {
  if (bench_trial_open(turn->fixture, &turn->config, turn->kernels, out,
                       error) != 0)
    return -1;
  for (unsigned i = 0; i < turn->settle; i++)
    if (bench_trial_run(out, 0, 0, turn->play == BENCH_PLAY_STATIC, error) != 0)
      return -1;
  return 0;
}

/* Ratios are taken before the medians, which sort the times. */
static void sum_up(run_times *times, size_t count, unsigned runs,
                   bench_timing *out) {
  for (size_t k = 0; k < count; k++) {
    out[k].total_ratio =
        bench_median_ratio(times[k].total, times[0].total, runs);
    for (int p = 0; p < HBIL_PASS_COUNT; p++)
      out[k].pass_ratio[p] =
          bench_median_ratio(times[k].pass[p], times[0].pass[p], runs);
  }
  for (size_t k = 0; k < count; k++) {
    out[k].mean = 0.0;
    for (unsigned i = 0; i < runs; i++)
      out[k].mean += times[k].total[i] / runs;
    out[k].total = bench_spread_of(times[k].total, runs);
    out[k].host = bench_spread_of(times[k].host, runs);
    for (int p = 0; p < HBIL_PASS_COUNT; p++)
      out[k].pass[p] = bench_spread_of(times[k].pass[p], runs);
  }
}

static int get_statistics(const bench_trial *t, bench_timing *out,
                          image_error *error) {
  const bench_fixture *f = t->fixture;
  const hbil_status status =
      hbil_plan_statistics(t->plan, f->device->queue, &out->statistics);
  out->memory = t->memory;
  return status == HBIL_SUCCESS ? 0 : library_failed(f, status, error);
}

int bench_time_turns(const bench_turn *list, size_t count, unsigned runs,
                     bench_timing *out, image_error *error) {
  bench_trial trials[BENCH_MAX_TURNS] = {{.plan = NULL}};
  run_times *times = calloc(count, sizeof *times);
  int failed = times ? 0 : image_no_memory(error, "times");
  for (size_t k = 0; k < count && !failed; k++)
    failed = open_turn(&list[k], &trials[k], error);
  for (unsigned i = 0; i < BENCH_WARM_UP + runs && !failed; i++)
    for (size_t k = 0; k < count && !failed; k++)
      failed = time_run(&list[k], &trials[k], i, &times[k], error);
  if (!failed)
    sum_up(times, count, runs, out);
  for (size_t k = 0; k < count && !failed; k++)
    failed = get_statistics(&trials[k], &out[k], error);
  for (size_t k = 0; k < count; k++)
    bench_trial_close(&trials[k]);
  free(times);
  return failed;
}
