/* The library on the content: one plan for each configuration, first for its
 * errors, then for its times. */
#define _POSIX_C_SOURCE 200809L
#include "bench/bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

struct bench_lab {
  const device *device;
  const bench_content *content;
  hbil_context *context;
  cl_mem input[BENCH_FRAMES][BENCH_INPUTS];
  cl_mem output[LAYER_COUNT];
  float *ao, *light; /* the reference */
  float *found;      /* three planes: what is being looked at */
};

typedef struct input_place {
  size_t format, image; /* offsets in hbil_config and hbil_frame */
} input_place;

#define PLACE(field)                                                           \
  { offsetof(hbil_config, field), offsetof(hbil_frame, field) }

static const input_place places[BENCH_INPUTS] = {
    [BENCH_DEPTH] = PLACE(depth),       [BENCH_NORMAL] = PLACE(normal),
    [BENCH_ALBEDO] = PLACE(albedo),     [BENCH_DIRECT] = PLACE(direct),
    [BENCH_EMISSION] = PLACE(emission),
};

static hbil_format *format_at(hbil_config *config, size_t offset) {
  return (hbil_format *)((char *)config + offset);
}

static hbil_image *image_at(hbil_frame *frame, size_t offset) {
  return (hbil_image *)((char *)frame + offset);
}

static int library_failed(const bench_lab *lab, hbil_status status,
                          image_error *error) {
  const char *message = lab->context ? hbil_context_message(lab->context) : "";
  return image_fail(error, "device %s: %s", lab->device->name,
                    *message ? message : hbil_status_string(status));
}

/* --- opening --- */

static int upload(bench_lab *lab, image_error *error) {
  const bench_content *content = lab->content;
  const size_t plane = bench_pixels(content) * sizeof(float);
  for (unsigned f = 0; f < content->frames; f++)
    for (int i = 0; i < BENCH_INPUTS; i++)
      if (content->frame[f].plane[i] &&
          bench_buffer(
              lab->device, plane * bench_input_channels((bench_input)i),
              content->frame[f].plane[i], &lab->input[f][i], error) != 0)
        return -1;
  for (int l = 0; l < LAYER_COUNT; l++)
    if (bench_buffer(lab->device, plane * strlen(layer_table[l].components),
                     NULL, &lab->output[l], error) != 0)
      return -1;
  return 0;
}

static int allocate(bench_lab *lab, image_error *error) {
  const size_t plane = bench_pixels(lab->content) * sizeof(float);
  lab->ao = malloc(plane);
  lab->light = malloc(3 * plane);
  lab->found = malloc(3 * plane);
  return lab->ao && lab->light && lab->found
             ? 0
             : image_no_memory(error, lab->content->name);
}

int bench_lab_open(const device *d, const bench_content *content,
                   bench_lab **out, image_error *error) {
  bench_lab *lab = calloc(1, sizeof *lab);
  *out = lab;
  if (!lab)
    return image_no_memory(error, content->name);
  lab->device = d;
  lab->content = content;
  const hbil_status status =
      hbil_context_create(d->context, d->id, &lab->context);
  int failed = status == HBIL_SUCCESS ? 0 : library_failed(lab, status, error);
  if (failed || allocate(lab, error) != 0 || upload(lab, error) != 0) {
    bench_lab_close(lab);
    *out = NULL;
    return -1;
  }
  return 0;
}

void bench_lab_close(bench_lab *lab) {
  if (!lab)
    return;
  for (int f = 0; f < BENCH_FRAMES; f++)
    for (int i = 0; i < BENCH_INPUTS; i++)
      if (lab->input[f][i])
        clReleaseMemObject(lab->input[f][i]);
  for (int l = 0; l < LAYER_COUNT; l++)
    if (lab->output[l])
      clReleaseMemObject(lab->output[l]);
  hbil_context_destroy(lab->context);
  free(lab->ao);
  free(lab->light);
  free(lab->found);
  free(lab);
}

/* --- plans and frames --- */

static int make_plan(bench_lab *lab, const bench_configuration *c,
                     size_t *memory, hbil_plan **out, image_error *error) {
  const hbil_format planes_of_floats = {HBIL_FLOAT32, 1};
  hbil_config config = lab->content->config;
  bench_configure(c, &config);
  for (int i = 0; i < BENCH_INPUTS; i++)
    if (lab->input[0][i])
      *format_at(&config, places[i].format) = planes_of_floats;
  for (int l = 0; l < LAYER_COUNT; l++)
    *format_at(&config, layer_table[l].format) = planes_of_floats;
  hbil_status status = hbil_plan_memory(lab->context, &config, memory);
  if (status == HBIL_SUCCESS)
    status = hbil_plan_create(lab->context, &config, out);
  return status == HBIL_SUCCESS ? 0 : library_failed(lab, status, error);
}

static int enqueue(bench_lab *lab, hbil_plan *plan, unsigned index,
                   image_error *error) {
  const bench_content *content = lab->content;
  hbil_frame frame;
  hbil_frame_init(&frame);
  frame.camera = content->frame[index].camera;
  memcpy(frame.environment, content->environment, sizeof frame.environment);
  for (int i = 0; i < BENCH_INPUTS; i++)
    image_at(&frame, places[i].image)->buffer = lab->input[index][i];
  for (int l = 0; l < LAYER_COUNT; l++)
    image_at(&frame, layer_table[l].image)->buffer = lab->output[l];
  const hbil_status status =
      hbil_enqueue_frame(plan, lab->device->queue, &frame, 0, NULL, NULL);
  return status == HBIL_SUCCESS ? 0 : library_failed(lab, status, error);
}

static int read_layer(bench_lab *lab, layer l, float *out, image_error *error) {
  const size_t bytes = bench_pixels(lab->content) *
                       strlen(layer_table[l].components) * sizeof(float);
  const cl_int status =
      clEnqueueReadBuffer(lab->device->queue, lab->output[l], CL_TRUE, 0, bytes,
                          out, 0, NULL, NULL);
  return status == CL_SUCCESS
             ? 0
             : bench_cl_failed(lab->device, status, "reading a buffer", error);
}

/* --- errors --- */

int bench_lab_refer(bench_lab *lab, const bench_configuration *c,
                    image_error *error) {
  hbil_plan *plan;
  size_t memory;
  if (make_plan(lab, c, &memory, &plan, error) != 0)
    return -1;
  const int failed = enqueue(lab, plan, 0, error) != 0 ||
                     read_layer(lab, LAYER_AO, lab->ao, error) != 0 ||
                     read_layer(lab, LAYER_NEAR, lab->light, error) != 0;
  clFinish(lab->device->queue);
  hbil_plan_destroy(plan);
  return failed ? -1 : 0;
}

const float *bench_lab_ao(const bench_lab *lab) {
  return lab->ao;
}

const float *bench_lab_light(const bench_lab *lab) {
  return lab->light;
}

/* The plan's first frame: a single bounce, like the reference. */
static int sampling_error(bench_lab *lab, hbil_plan *plan, bench_row *out,
                          image_error *error) {
  if (enqueue(lab, plan, 0, error) != 0 ||
      read_layer(lab, LAYER_AO, lab->found, error) != 0)
    return -1;
  out->ao_error = bench_ao_error(lab->content, lab->found, lab->ao);
  if (read_layer(lab, LAYER_NEAR, lab->found, error) != 0)
    return -1;
  out->light_error = bench_light_error(lab->content, lab->found, lab->light);
  return 0;
}

/* Goes on from there: more bounces of the same frame. */
static int model_error(bench_lab *lab, hbil_plan *plan, bench_row *out,
                       image_error *error) {
  out->model_error = NAN;
  if (!lab->content->truth)
    return 0;
  for (int i = 1; i < BENCH_TRUTH_BOUNCES; i++)
    if (enqueue(lab, plan, 0, error) != 0)
      return -1;
  if (read_layer(lab, LAYER_INDIRECT, lab->found, error) != 0)
    return -1;
  out->model_error = bench_model_error(lab->content, lab->found);
  return 0;
}

/* --- times --- */

typedef struct samples {
  double pass[HBIL_PASS_COUNT][BENCH_MAX_RUNS];
  double total[BENCH_MAX_RUNS], host[BENCH_MAX_RUNS];
} samples;

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static int time_frame(bench_lab *lab, hbil_plan *plan, unsigned index,
                      samples *s, unsigned run, image_error *error) {
  double milliseconds[HBIL_PASS_COUNT];
  const double before = now();
  if (enqueue(lab, plan, index, error) != 0)
    return -1;
  s->host[run] = now() - before;
  const hbil_status status = hbil_plan_timings(plan, milliseconds);
  if (status != HBIL_SUCCESS)
    return library_failed(lab, status, error);
  s->total[run] = 0.0;
  for (int p = 0; p < HBIL_PASS_COUNT; p++) {
    s->pass[p][run] = milliseconds[p];
    s->total[run] += milliseconds[p];
  }
  return 0;
}

/* Back and forth between the frames, so that there is something to carry and
 * there are holes to fill. */
static int time_frames(bench_lab *lab, hbil_plan *plan, samples *s,
                       unsigned runs, image_error *error) {
  for (unsigned i = 0; i < BENCH_WARM_UP + runs; i++)
    if (time_frame(lab, plan, (i + 1) % lab->content->frames, s,
                   i < BENCH_WARM_UP ? 0 : i - BENCH_WARM_UP, error) != 0)
      return -1;
  return 0;
}

static int times(bench_lab *lab, hbil_plan *plan, unsigned runs, bench_row *out,
                 image_error *error) {
  samples *s = calloc(1, sizeof *s);
  if (!s)
    return image_no_memory(error, "times");
  const int failed = time_frames(lab, plan, s, runs, error);
  if (!failed) {
    for (int p = 0; p < HBIL_PASS_COUNT; p++)
      out->pass[p] = bench_spread_of(s->pass[p], runs);
    out->total = bench_spread_of(s->total, runs);
    out->host = bench_spread_of(s->host, runs);
  }
  free(s);
  return failed;
}

int bench_lab_measure(bench_lab *lab, const bench_configuration *c,
                      unsigned runs, bench_row *out, image_error *error) {
  hbil_plan *plan;
  memset(out, 0, sizeof *out);
  out->configuration = *c;
  bench_label(c, out->label, sizeof out->label);
  if (make_plan(lab, c, &out->memory, &plan, error) != 0)
    return -1;
  const int failed = sampling_error(lab, plan, out, error) != 0 ||
                     model_error(lab, plan, out, error) != 0 ||
                     times(lab, plan, runs, out, error) != 0;
  clFinish(lab->device->queue);
  hbil_plan_destroy(plan);
  return failed ? -1 : 0;
}
