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
  int halves; /* images other than depth are half floats */
  cl_mem input[BENCH_FRAMES][BENCH_INPUTS];
  cl_mem motion[BENCH_FRAMES]; /* while it is measured */
  cl_mem output[LAYER_COUNT];
  float *found; /* three planes: what is being looked at */
};

/* A plan and what it writes. */
typedef struct trial {
  bench_lab *lab;
  hbil_plan *plan;
  int still;      /* every frame is frame 0 and said to be still */
  int first_only; /* every frame is frame 0 */
  size_t memory;
  unsigned layers;
  hbil_far_field far;
  int follows; /* motion vectors */
} trial;

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

static hbil_plane_format *format_at(hbil_config *config, size_t offset) {
  return (hbil_plane_format *)((char *)config + offset);
}

static hbil_plane *image_at(hbil_frame *frame, size_t offset) {
  return (hbil_plane *)((char *)frame + offset);
}

static int library_failed(const bench_lab *lab, hbil_status status,
                          image_error *error) {
  const char *message = lab->context ? hbil_context_message(lab->context) : "";
  return image_fail(error, "device %s: %s", lab->device->name,
                    *message ? message : hbil_status_string(status));
}

/* --- opening --- */

/* Puts a buffer of halves in the place of one of `rows` rows of floats. */
static int make_halves(bench_lab *lab, cl_kernel kernel, size_t rows,
                       cl_mem *buffer, image_error *error) {
  const device *d = lab->device;
  const cl_uint count = lab->content->width;
  const size_t global[2] = {rows, 1}, local[2] = {1, 1};
  bench_spread unused;
  cl_mem halves = NULL;
  if (bench_buffer(d, rows * count * sizeof(cl_half), NULL, &halves, error) !=
      0)
    return -1;
  clSetKernelArg(kernel, 0, sizeof *buffer, buffer);
  clSetKernelArg(kernel, 1, sizeof halves, &halves);
  clSetKernelArg(kernel, 2, sizeof count, &count);
  const int failed =
      bench_time_kernel(d, kernel, global, local, 1, &unused, error);
  clReleaseMemObject(*buffer);
  *buffer = halves;
  return failed;
}

/* to_halves: NULL where they stay floats. */
static int upload_input(bench_lab *lab, unsigned f, bench_input input,
                        cl_kernel to_halves, image_error *error) {
  const float *plane = lab->content->frame[f].plane[input];
  const size_t channels = bench_input_channels(input);
  cl_mem *buffer = &lab->input[f][input];
  if (!plane)
    return 0;
  if (bench_buffer(lab->device,
                   bench_pixels(lab->content) * channels * sizeof *plane, plane,
                   buffer, error) != 0)
    return -1;
  return to_halves && input != BENCH_DEPTH
             ? make_halves(lab, to_halves, lab->content->height * channels,
                           buffer, error)
             : 0;
}

static int upload(bench_lab *lab, image_error *error) {
  const bench_content *content = lab->content;
  const size_t plane = bench_pixels(content) *
                       (lab->halves ? sizeof(cl_half) : sizeof(cl_float));
  cl_kernel to_halves = NULL;
  int failed = lab->halves
                   ? bench_kernel(lab->device, "halves", "", &to_halves, error)
                   : 0;
  for (unsigned f = 0; f < content->frames; f++)
    for (int i = 0; i < BENCH_INPUTS && !failed; i++)
      failed = upload_input(lab, f, (bench_input)i, to_halves, error);
  for (int l = 0; l < LAYER_COUNT && !failed; l++)
    failed =
        bench_buffer(lab->device, plane * strlen(layer_table[l].components),
                     NULL, &lab->output[l], error);
  if (to_halves)
    clReleaseKernel(to_halves);
  return failed;
}

static int allocate(bench_lab *lab, image_error *error) {
  lab->found = malloc(3 * bench_pixels(lab->content) * sizeof(float));
  return lab->found ? 0 : image_no_memory(error, lab->content->name);
}

static int open_lab(const device *d, const bench_content *content, int halves,
                    bench_lab **out, image_error *error) {
  bench_lab *lab = calloc(1, sizeof *lab);
  *out = lab;
  if (!lab)
    return image_no_memory(error, content->name);
  lab->device = d;
  lab->content = content;
  lab->halves = halves;
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

int bench_lab_open(const device *d, const bench_content *content,
                   bench_lab **out, image_error *error) {
  return open_lab(d, content, 0, out, error);
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
  free(lab->found);
  free(lab);
}

/* --- plans and frames --- */

static unsigned layers_of(const hbil_config *config) {
  return config->mode == HBIL_MODE_HBIL
             ? layers_of_mode(HBIL_MODE_HBIL)
             : 1u << LAYER_AO; /* all that those modes are for */
}

static void set_formats(const bench_lab *lab, hbil_config *config) {
  const hbil_plane_format planes_of_floats = {HBIL_FLOAT32, 1};
  const hbil_plane_format planes = {lab->halves ? HBIL_FLOAT16 : HBIL_FLOAT32,
                                    1};
  const unsigned layers = layers_of(config);
  if (config->reprojection == HBIL_REPROJECTION_MOTION)
    config->motion = planes_of_floats;
  for (int i = 0; i < BENCH_INPUTS; i++)
    if (lab->input[0][i])
      *format_at(config, places[i].format) =
          i == BENCH_DEPTH ? planes_of_floats : planes;
  for (int l = 0; l < LAYER_COUNT; l++)
    if (layers >> l & 1)
      *format_at(config, layer_table[l].format) = planes;
}

static int make_plan(bench_lab *lab, const hbil_config *settings, trial *out,
                     image_error *error) {
  hbil_config config = *settings;
  out->lab = lab;
  out->plan = NULL;
  out->far = config.far_field;
  out->follows = config.reprojection == HBIL_REPROJECTION_MOTION;
  out->layers = layers_of(&config);
  set_formats(lab, &config);
  hbil_status status = hbil_plan_memory(lab->context, &config, &out->memory);
  if (status == HBIL_SUCCESS)
    status = hbil_plan_create(lab->context, &config, &out->plan);
  return status == HBIL_SUCCESS ? 0 : library_failed(lab, status, error);
}

/* Its commands may still be running. */
static void free_trial(trial *t) {
  if (t->plan)
    clFinish(t->lab->device->queue);
  hbil_plan_destroy(t->plan);
}

static int enqueue(const trial *t, unsigned index, image_error *error) {
  bench_lab *lab = t->lab;
  const bench_content *content = lab->content;
  hbil_frame frame;
  hbil_frame_init(&frame);
  frame.static_frame = t->still ? CL_TRUE : CL_FALSE;
  frame.camera = content->frame[index].camera;
  memcpy(frame.environment, bench_environment(content, t->far),
         sizeof frame.environment);
  if (t->follows)
    frame.motion.buffer = lab->motion[index];
  for (int i = 0; i < BENCH_INPUTS; i++)
    image_at(&frame, places[i].image)->buffer = lab->input[index][i];
  for (int l = 0; l < LAYER_COUNT; l++)
    if (t->layers >> l & 1)
      image_at(&frame, layer_table[l].image)->buffer = lab->output[l];
  const hbil_status status =
      hbil_enqueue_frame(t->plan, lab->device->queue, &frame, 0, NULL, NULL);
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

/* The plan's first frame: a single bounce, like the reference. */
static int sampling_error(bench_lab *lab, const trial *t,
                          const bench_exact *exact, bench_row *out,
                          image_error *error) {
  const bench_model model = out->configuration.model;
  out->light_error = out->light_95 = NAN;
  if (enqueue(t, 0, error) != 0 ||
      read_layer(lab, LAYER_AO, lab->found, error) != 0)
    return -1;
  out->ao_error = bench_ao_error(lab->content, lab->found, exact->ao[model]);
  if (bench_ao_95(lab->content, lab->found, exact->ao[model], &out->ao_95,
                  error) != 0)
    return -1;
  if (!exact->light[model])
    return 0;
  if (read_layer(lab, LAYER_NEAR, lab->found, error) != 0)
    return -1;
  out->light_error =
      bench_light_error(lab->content, lab->found, exact->light[model]);
  return bench_light_95(lab->content, lab->found, exact->light[model],
                        &out->light_95, error);
}

/* What the last frame was given: as much as the plan has, or less. */
static int samples_taken(const bench_lab *lab, const trial *t, bench_row *out,
                         image_error *error) {
  hbil_statistics skipped;
  const hbil_status status =
      hbil_plan_statistics(t->plan, lab->device->queue, &skipped);
  out->slices = skipped.slices;
  out->samples = skipped.steps_per_side;
  return status == HBIL_SUCCESS ? 0 : library_failed(lab, status, error);
}

/* Goes on from there: more bounces of the same frame. */
static int model_error(bench_lab *lab, const trial *t, bench_row *out,
                       image_error *error) {
  out->model_error = NAN;
  if (!lab->content->truth || !(t->layers >> LAYER_INDIRECT & 1))
    return 0;
  for (int i = 1; i < BENCH_TRUTH_BOUNCES; i++)
    if (enqueue(t, 0, error) != 0)
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

static int time_frame(const trial *t, unsigned index, samples *s, unsigned run,
                      image_error *error) {
  double milliseconds[HBIL_PASS_COUNT];
  const double before = now();
  if (enqueue(t, index, error) != 0)
    return -1;
  s->host[run] = now() - before;
  const hbil_status status = hbil_plan_timings(t->plan, milliseconds);
  if (status != HBIL_SUCCESS)
    return library_failed(t->lab, status, error);
  s->total[run] = 0.0;
  for (int p = 0; p < HBIL_PASS_COUNT; p++) {
    s->pass[p][run] = milliseconds[p];
    s->total[run] += milliseconds[p];
  }
  return 0;
}

static unsigned next_frame(const trial *t, unsigned run) {
  return t->still || t->first_only ? 0 : (run + 1) % t->lab->content->frames;
}

/*
 * Back and forth between the frames, so that there is something to carry and
 * there are holes to fill.  Of several plans, every one in turn: what slows the
 * machine down then slows them all.
 */
static int time_frames(const trial *trials, size_t count, samples *s,
                       unsigned runs, image_error *error) {
  for (unsigned i = 0; i < BENCH_WARM_UP + runs; i++)
    for (size_t k = 0; k < count; k++)
      if (time_frame(&trials[k], next_frame(&trials[k], i), &s[k],
                     i < BENCH_WARM_UP ? 0 : i - BENCH_WARM_UP, error) != 0)
        return -1;
  return 0;
}

int bench_lab_errors(bench_lab *lab, const bench_exact *exact,
                     const bench_configuration *c, bench_row *out,
                     image_error *error) {
  hbil_config config;
  trial t = {.plan = NULL};
  memset(out, 0, sizeof *out);
  out->configuration = *c;
  out->over_endless = out->ao_loss = out->light_loss = NAN;
  bench_label(c, out->label, sizeof out->label);
  bench_configure(lab->content, c, &config);
  const int failed = make_plan(lab, &config, &t, error) != 0 ||
                     sampling_error(lab, &t, exact, out, error) != 0 ||
                     samples_taken(lab, &t, out, error) != 0 ||
                     model_error(lab, &t, out, error) != 0;
  out->memory = t.memory;
  free_trial(&t);
  return failed ? -1 : 0;
}

/* --- storage --- */

/* AO and then E_near of a plan's first frame. */
static int first_frame(bench_lab *lab, const hbil_config *config, float *out,
                       image_error *error) {
  trial t = {.plan = NULL};
  const int failed =
      make_plan(lab, config, &t, error) != 0 || enqueue(&t, 0, error) != 0 ||
      read_layer(lab, LAYER_AO, out, error) != 0 ||
      read_layer(lab, LAYER_NEAR, out + bench_pixels(lab->content), error) != 0;
  free_trial(&t);
  return failed ? -1 : 0;
}

int bench_lab_loss(bench_lab *lab, const bench_configuration *c, bench_row *row,
                   image_error *error) {
  const size_t pixels = bench_pixels(lab->content);
  hbil_config config;
  float *own = malloc(8 * pixels * sizeof *own);
  if (!own)
    return image_no_memory(error, "layers");
  float *exact = own + 4 * pixels;
  bench_configure(lab->content, c, &config);
  int failed = first_frame(lab, &config, own, error);
  config.storage = HBIL_STORAGE_FLOAT32;
  if (!failed)
    failed = first_frame(lab, &config, exact, error);
  if (!failed) {
    row->ao_loss = bench_ao_error(lab->content, own, exact);
    row->light_loss =
        bench_light_error(lab->content, own + pixels, exact + pixels);
  }
  free(own);
  return failed;
}

/* --- pairs --- */

/* A pass of two plans in turns. */
static int time_pair(bench_lab *lab, const hbil_config configs[2],
                     unsigned runs, samples s[2], image_error *error) {
  trial trials[2] = {{.plan = NULL}, {.plan = NULL}};
  const int failed = make_plan(lab, &configs[0], &trials[0], error) != 0 ||
                     make_plan(lab, &configs[1], &trials[1], error) != 0 ||
                     time_frames(trials, 2, s, runs, error) != 0;
  free_trial(&trials[0]);
  free_trial(&trials[1]);
  return failed ? -1 : 0;
}

static double ratio(double a, double b) {
  return a / b;
}

static double difference(double a, double b) {
  return a - b;
}

/* The median, over the turns, of what two times are to each other. */
static int compare_pair(bench_lab *lab, const hbil_config configs[2],
                        hbil_pass pass, double (*how)(double, double),
                        unsigned runs, double *out, image_error *error) {
  double values[BENCH_MAX_RUNS];
  samples *s = calloc(2, sizeof *s);
  if (!s)
    return image_no_memory(error, "times");
  const int failed = time_pair(lab, configs, runs, s, error);
  if (!failed) {
    for (unsigned i = 0; i < runs; i++)
      values[i] = how(s[0].pass[pass][i], s[1].pass[pass][i]);
    *out = bench_spread_of(values, runs).median;
  }
  free(s);
  return failed;
}

int bench_lab_thickness(bench_lab *lab, const bench_configuration *c,
                        unsigned runs, bench_row *row, image_error *error) {
  bench_configuration endless = *c;
  hbil_config configs[2];
  endless.model = BENCH_PAPER;
  bench_configure(lab->content, c, &configs[0]);
  bench_configure(lab->content, &endless, &configs[1]);
  return compare_pair(lab, configs, HBIL_PASS_GATHER, ratio, runs,
                      &row->over_endless, error);
}

int bench_lab_estimate(bench_lab *lab, const bench_configuration *c,
                       unsigned runs, double *out, image_error *error) {
  hbil_config configs[2];
  bench_configure(lab->content, c, &configs[0]);
  configs[1] = configs[0];
  configs[1].back_facing_fallback = HBIL_FALLBACK_BLACK;
  configs[1].far_field = HBIL_FAR_NONE;
  return compare_pair(lab, configs, HBIL_PASS_SPLIT, difference, runs, out,
                      error);
}

/* --- motion vectors --- */

static int upload_motion(bench_lab *lab, image_error *error) {
  const bench_content *content = lab->content;
  const size_t bytes = 2 * bench_pixels(content) * sizeof(float);
  for (unsigned f = 0; f < content->frames; f++)
    if (bench_buffer(lab->device, bytes, content->frame[f].motion,
                     &lab->motion[f], error) != 0)
      return -1;
  return 0;
}

static void drop_motion(bench_lab *lab) {
  for (int f = 0; f < BENCH_FRAMES; f++) {
    if (lab->motion[f])
      clReleaseMemObject(lab->motion[f]);
    lab->motion[f] = NULL;
  }
}

/* From the first frame to the last each time, since that is where the vectors
 * lead from.  A dump has one frame: what they find there is at most a frame too
 * new. */
static int time_motion(const trial *t, samples *s, unsigned runs,
                       image_error *error) {
  const unsigned last = t->lab->content->frames - 1;
  for (unsigned i = 0; i < BENCH_WARM_UP + runs; i++) {
    hbil_plan_reset(t->plan);
    if (enqueue(t, 0, error) != 0 ||
        time_frame(t, last, s, i < BENCH_WARM_UP ? 0 : i - BENCH_WARM_UP,
                   error) != 0)
      return -1;
  }
  return 0;
}

int bench_lab_motion(bench_lab *lab, const bench_configuration *c,
                     unsigned runs, bench_spread *out, image_error *error) {
  hbil_config config;
  trial t = {.plan = NULL};
  *out = (bench_spread){NAN, NAN, NAN};
  if (!lab->content->frame[0].motion)
    return 0;
  bench_configure(lab->content, c, &config);
  config.reprojection = HBIL_REPROJECTION_MOTION;
  samples *s = calloc(1, sizeof *s);
  const int failed = !s ? image_no_memory(error, "times")
                        : upload_motion(lab, error) != 0 ||
                              make_plan(lab, &config, &t, error) != 0 ||
                              time_motion(&t, s, runs, error) != 0;
  if (!failed)
    *out = bench_spread_of(s->pass[HBIL_PASS_REPROJECT], runs);
  free_trial(&t);
  drop_motion(lab);
  free(s);
  return failed ? -1 : 0;
}

/* --- any number in turns --- */

/* The median, over the turns, of a time over that of the first. */
static double median_ratio(const double *of, const double *to, unsigned runs) {
  double values[BENCH_MAX_RUNS];
  for (unsigned i = 0; i < runs; i++)
    values[i] = of[i] / to[i];
  return bench_spread_of(values, runs).median;
}

static double mean_of(const double *values, unsigned count) {
  double sum = 0.0;
  for (unsigned i = 0; i < count; i++)
    sum += values[i];
  return sum / count;
}

static void sum_up(samples *s, size_t count, unsigned runs, bench_timing *out) {
  for (size_t k = 0; k < count; k++) {
    out[k].total_ratio = median_ratio(s[k].total, s[0].total, runs);
    out[k].mean = mean_of(s[k].total, runs);
    for (int p = 0; p < HBIL_PASS_COUNT; p++)
      out[k].pass_ratio[p] = median_ratio(s[k].pass[p], s[0].pass[p], runs);
  }
  /* only now: this sorts them */
  for (size_t k = 0; k < count; k++) {
    out[k].total = bench_spread_of(s[k].total, runs);
    for (int p = 0; p < HBIL_PASS_COUNT; p++)
      out[k].pass[p] = bench_spread_of(s[k].pass[p], runs);
    out[k].host = bench_spread_of(s[k].host, runs);
  }
}

/* With kernels of its own, or those that all others have. */
static int make_turns_plan(const bench_turn *turn, trial *out,
                           image_error *error) {
  static const char name[] = "HBIL_KERNEL_DIR";
  const char *set = turn->kernels ? getenv(name) : NULL;
  char *before = set ? strdup(set) : NULL;
  if (set && !before)
    return image_no_memory(error, name);
  if (turn->kernels)
    setenv(name, turn->kernels, 1);
  const int failed = make_plan(turn->lab, &turn->config, out, error);
  if (before)
    setenv(name, before, 1);
  else if (turn->kernels)
    unsetenv(name);
  free(before);
  return failed;
}

static int make_turn(const bench_turn *turn, trial *out, image_error *error) {
  if (make_turns_plan(turn, out, error) != 0)
    return -1;
  out->still = turn->still;
  out->first_only = turn->first_only;
  for (unsigned i = 0; i < turn->settled; i++)
    if (enqueue(out, 0, error) != 0)
      return -1;
  return 0;
}

static int count_skipped(const trial *t, hbil_statistics *out,
                         image_error *error) {
  const hbil_status status =
      hbil_plan_statistics(t->plan, t->lab->device->queue, out);
  return status == HBIL_SUCCESS ? 0 : library_failed(t->lab, status, error);
}

static int follows(const bench_turn *turn) {
  return turn->config.reprojection == HBIL_REPROJECTION_MOTION;
}

int bench_lab_turns(const bench_turn *list, size_t count, unsigned runs,
                    bench_timing *out, image_error *error) {
  trial trials[BENCH_MAX_TURNS] = {{.plan = NULL}};
  samples *s = calloc(count, sizeof *s);
  int failed = s ? 0 : image_no_memory(error, "times");
  for (size_t k = 0; k < count && !failed; k++)
    if (follows(&list[k]) && !list[k].lab->motion[0])
      failed = upload_motion(list[k].lab, error);
  for (size_t k = 0; k < count && !failed; k++)
    failed = make_turn(&list[k], &trials[k], error);
  if (!failed)
    failed = time_frames(trials, count, s, runs, error);
  if (!failed)
    sum_up(s, count, runs, out);
  for (size_t k = 0; k < count && !failed; k++)
    failed = count_skipped(&trials[k], &out[k].skipped, error);
  for (size_t k = 0; k < count; k++) {
    free_trial(&trials[k]);
    drop_motion(list[k].lab);
  }
  free(s);
  return failed ? -1 : 0;
}

static bench_spread later(bench_spread s, double more) {
  return (bench_spread){s.median + more, s.low + more, s.high + more};
}

/* Adaptive sampling chooses for the light of each frame, and that whose error
 * is known is the first.  So it is what was chosen there that is timed, and to
 * that is added what choosing takes: the gather of that frame, over and over,
 * with choosing and without. */
static int add_choosing(bench_lab *lab, const bench_configuration *c,
                        const bench_configuration *chosen, unsigned runs,
                        bench_row *out, image_error *error) {
  bench_turn turns[2] = {{.lab = lab, .first_only = 1},
                         {.lab = lab, .first_only = 1}};
  bench_timing timing[2];
  bench_configure(lab->content, c, &turns[0].config);
  bench_configure(lab->content, chosen, &turns[1].config);
  for (int i = 0; i < 2; i++)
    turns[i].config.reprojection = HBIL_REPROJECTION_NONE;
  if (bench_lab_turns(turns, 2, runs, timing, error) != 0)
    return -1;
  bench_spread *const gather = &out->pass[HBIL_PASS_GATHER];
  const double start = gather->median / out->gather_over_start;
  const double whole = out->total.median / out->total_over_start;
  const double more =
      gather->median * (1.0 / timing[1].pass_ratio[HBIL_PASS_GATHER] - 1.0);
  out->choosing = more;
  *gather = later(*gather, more);
  out->total = later(out->total, more);
  out->gather_over_start += more / start;
  out->total_over_start += more / whole;
  return 0;
}

int bench_lab_times(bench_lab *lab, const bench_configuration *c, unsigned runs,
                    bench_row *out, image_error *error) {
  const bench_configuration first = bench_first();
  bench_configuration taken = *c;
  bench_turn turns[2] = {{.lab = lab}, {.lab = lab}};
  bench_timing timing[2];
  bench_configure(lab->content, &first, &turns[0].config);
  taken.most_ao = taken.most_light = 0.0f;
  taken.slices = out->slices;
  taken.samples = out->samples;
  bench_configure(lab->content, &taken, &turns[1].config);
  if (bench_lab_turns(turns, 2, runs, timing, error) != 0)
    return -1;
  memcpy(out->pass, timing[1].pass, sizeof out->pass);
  out->total = timing[1].total;
  out->host = timing[1].host;
  out->gather_over_start = timing[1].pass_ratio[HBIL_PASS_GATHER];
  out->total_over_start = timing[1].total_ratio;
  return bench_is_adaptive(c) ? add_choosing(lab, c, &taken, runs, out, error)
                              : 0;
}

/* --- images of half floats --- */

int bench_lab_halves(bench_lab *lab, const bench_configuration *c,
                     unsigned runs, bench_timing out[2], image_error *error) {
  bench_lab *halves = NULL;
  if (open_lab(lab->device, lab->content, 1, &halves, error) != 0)
    return -1;
  bench_turn turns[2] = {{.lab = lab}, {.lab = halves}};
  bench_configure(lab->content, c, &turns[0].config);
  turns[1].config = turns[0].config;
  const int failed = bench_lab_turns(turns, 2, runs, out, error);
  bench_lab_close(halves);
  return failed;
}

/* --- the first frames of a plan --- */

int bench_lab_start(bench_lab *lab, const hbil_config *config, bench_start *out,
                    image_error *error) {
  trial t = {.plan = NULL};
  double before = now();
  int failed = make_plan(lab, config, &t, error);
  out->plan = now() - before;
  for (unsigned i = 0; i < BENCH_START_FRAMES && !failed; i++) {
    before = now();
    failed = enqueue(&t, i % lab->content->frames, error);
    const cl_int status = clFinish(lab->device->queue);
    out->frame[i] = now() - before;
    if (!failed && status != CL_SUCCESS)
      failed = bench_cl_failed(lab->device, status, "running a frame", error);
  }
  free_trial(&t);
  return failed;
}

/* --- memory --- */

/* Bytes of a plane of floats. */
static size_t plane_bytes(uint32_t width, uint32_t height) {
  return (size_t)width * height * sizeof(float);
}

/* Four values in every level of the push/pull chain, halved down to a pixel. */
static size_t chain_bytes(uint32_t width, uint32_t height, size_t values) {
  size_t bytes = values * plane_bytes(width, height);
  while (width > 1 || height > 1) {
    width = (width + 1) / 2;
    height = (height + 1) / 2;
    bytes += values * plane_bytes(width, height);
  }
  return bytes;
}

static void count_planes(const hbil_plan *plan, const hbil_config *config,
                         bench_planes *out) {
  memset(out, 0, sizeof *out);
  for (int stage = 0; stage < BENCH_STAGES; stage++) {
    hbil_buffer buffer;
    if (hbil_plan_buffer(plan, (hbil_stage)stage, &buffer) == HBIL_SUCCESS)
      out->values[stage] = buffer.values;
  }
  if (out->values[HBIL_STAGE_HISTORY] &&
      config->reprojection == HBIL_REPROJECTION_SCATTER)
    out->scatter = 2;
}

int bench_lab_planes(bench_lab *lab, const hbil_config *config,
                     bench_planes *out, image_error *error) {
  trial t = {.plan = NULL};
  const int failed = make_plan(lab, config, &t, error);
  if (!failed)
    count_planes(t.plan, config, out);
  free_trial(&t);
  return failed;
}

static size_t image_planes(const bench_lab *lab, const hbil_config *config) {
  const unsigned layers = layers_of(config);
  size_t planes = 0;
  for (int i = 0; i < BENCH_INPUTS; i++)
    if (lab->input[0][i])
      planes += lab->content->frames * bench_input_channels((bench_input)i);
  for (int l = 0; l < LAYER_COUNT; l++)
    if (layers >> l & 1)
      planes += strlen(layer_table[l].components);
  return planes;
}

int bench_lab_memory(bench_lab *lab, const hbil_config *settings,
                     const bench_planes *planes, bench_memory *out,
                     image_error *error) {
  hbil_config config = *settings;
  const size_t plane = plane_bytes(config.width, config.height);
  set_formats(lab, &config);
  out->images = image_planes(lab, &config) * plane;
  out->planes = planes->scatter * plane;
  for (int stage = 0; stage < BENCH_STAGES; stage++)
    out->planes +=
        stage == HBIL_STAGE_CARRIED
            ? chain_bytes(config.width, config.height, planes->values[stage])
            : planes->values[stage] * plane;
  const hbil_status status =
      hbil_plan_memory(lab->context, &config, &out->plan);
  return status == HBIL_SUCCESS ? 0 : library_failed(lab, status, error);
}
