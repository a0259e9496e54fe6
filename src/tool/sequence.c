/* Frames through the library: planes to cl_mem, passes, cl_mem to planes. */
#include "tool/resume.h"
#include "tool/tool.h"

#include <stdlib.h>
#include <string.h>

struct sequence {
  const device *device;
  hbil_context *context;
  hbil_plan *plan;
  hbil_config config;
  size_t memory;
  size_t plane; /* bytes of one channel */
  unsigned layers;
  size_t channels[INPUTS]; /* 0: this input is not used */
  cl_mem input[INPUTS];
  cl_mem output[LAYER_COUNT];
  uint64_t last;         /* of the last frame's inputs and camera; 0: none */
  unsigned choose_every; /* runs, with config.max_error */
  cl_uint index;         /* of the next run */
};

static hbil_plane *image_at(hbil_frame *frame, size_t offset) {
  return (hbil_plane *)((char *)frame + offset);
}

static int library_failed(const sequence *s, hbil_status status,
                          image_error *error) {
  const char *message = s->context ? hbil_context_message(s->context) : "";
  return image_fail(error, "device %s: %s", s->device->name,
                    *message ? message : hbil_status_string(status));
}

static int opencl_failed(const sequence *s, cl_int status, const char *doing,
                         image_error *error) {
  return image_fail(error, "device %s: OpenCL error %d while %s",
                    s->device->name, (int)status, doing);
}

static int make_buffer(sequence *s, cl_mem_flags flags, size_t channels,
                       cl_mem *out, image_error *error) {
  cl_int status;
  *out = clCreateBuffer(s->device->context, flags, channels * s->plane, NULL,
                        &status);
  return status == CL_SUCCESS
             ? 0
             : opencl_failed(s, status, "making a buffer", error);
}

static int make_buffers(sequence *s, image_error *error) {
  for (int i = 0; i < INPUTS; i++)
    if (s->channels[i] && make_buffer(s, CL_MEM_READ_ONLY, s->channels[i],
                                      &s->input[i], error) != 0)
      return -1;
  for (int l = 0; l < LAYER_COUNT; l++)
    if (s->layers >> l & 1 &&
        make_buffer(s, CL_MEM_WRITE_ONLY, strlen(layer_table[l].components),
                    &s->output[l], error) != 0)
      return -1;
  return 0;
}

static int open_plan(sequence *s, image_error *error) {
  hbil_status status =
      hbil_context_create(s->device->context, s->device->id, &s->context);
  if (status == HBIL_SUCCESS)
    status = hbil_plan_memory(s->context, &s->config, &s->memory);
  if (status == HBIL_SUCCESS)
    status = hbil_plan_create(s->context, &s->config, &s->plan);
  return status == HBIL_SUCCESS ? 0 : library_failed(s, status, error);
}

int sequence_open(const device *d, const hbil_config *config,
                  unsigned choose_every, const channel_map *map,
                  unsigned layers, sequence **out, image_error *error) {
  sequence *s = calloc(1, sizeof *s);
  *out = NULL;
  if (!s)
    return image_no_memory(error, "sequence");
  s->device = d;
  s->config = *config;
  s->layers = layers;
  s->choose_every = choose_every;
  s->plane = (size_t)config->width * config->height * sizeof(float);
  formats_choose(&s->config, map, layers);
  for (int i = 0; i < INPUTS; i++)
    s->channels[i] = formats_channels(&s->config, map, i);
  if (open_plan(s, error) != 0 || make_buffers(s, error) != 0) {
    sequence_close(s);
    return -1;
  }
  *out = s;
  return 0;
}

void sequence_close(sequence *s) {
  if (!s)
    return;
  for (int i = 0; i < INPUTS; i++)
    if (s->input[i])
      clReleaseMemObject(s->input[i]);
  for (int l = 0; l < LAYER_COUNT; l++)
    if (s->output[l])
      clReleaseMemObject(s->output[l]);
  hbil_plan_destroy(s->plan);
  hbil_context_destroy(s->context);
  free(s);
}

size_t sequence_memory(const sequence *s) {
  return s->memory;
}

/* The planes stay valid until the blocking reads at the end of the frame. */
static int upload(sequence *s, const gbuffer *g, image_error *error) {
  for (int i = 0; i < INPUTS; i++)
    for (size_t c = 0; c < s->channels[i]; c++) {
      const cl_int status = clEnqueueWriteBuffer(
          s->device->queue, s->input[i], CL_FALSE, c * s->plane, s->plane,
          gbuffer_plane(g, input_table[i].role, c), 0, NULL, NULL);
      if (status != CL_SUCCESS)
        return opencl_failed(s, status, "writing a buffer", error);
    }
  return 0;
}

static void fill_frame(const sequence *s, const camera_file *camera,
                       float environment[9][3], hbil_frame *frame) {
  hbil_frame_init(frame);
  gbuffer_hbil_camera(camera, &frame->camera);
  memcpy(frame->environment, environment, sizeof frame->environment);
  for (int i = 0; i < INPUTS; i++)
    image_at(frame, input_table[i].image)->buffer = s->input[i];
  for (int l = 0; l < LAYER_COUNT; l++)
    image_at(frame, layer_table[l].image)->buffer = s->output[l];
}

/* A frame that is repeated doesn't move against itself. */
static int stop_motion(sequence *s, image_error *error) {
  const float zero = 0.0f;
  for (int i = 0; i < INPUTS; i++) {
    if (input_table[i].role != ROLE_MOTION || !s->channels[i])
      continue;
    const cl_int status =
        clEnqueueFillBuffer(s->device->queue, s->input[i], &zero, sizeof zero,
                            0, s->channels[i] * s->plane, 0, NULL, NULL);
    if (status != CL_SUCCESS)
      return opencl_failed(s, status, "clearing a buffer", error);
  }
  return 0;
}

static int run_passes(sequence *s, hbil_frame *frame, unsigned repeat,
                      image_error *error) {
  for (unsigned run = 0; run < repeat; run++) {
    if (run == 1 && stop_motion(s, error) != 0)
      return -1;
    if (run == 1)
      frame->static_frame = CL_TRUE;
    /* a pattern that turns is for the filter over frames */
    frame->frame_index = s->config.max_history_frames ? s->index : 0;
    frame->keep_choice = s->index++ % s->choose_every != 0;
    const hbil_status status =
        hbil_enqueue_frame(s->plan, s->device->queue, frame, 0, NULL, NULL);
    if (status != HBIL_SUCCESS)
      return library_failed(s, status, error);
  }
  return 0;
}

static int download(sequence *s, image *result, image_error *error) {
  for (int l = 0; l < LAYER_COUNT; l++)
    for (size_t c = 0; s->output[l] && layer_table[l].components[c]; c++) {
      const cl_int status = clEnqueueReadBuffer(
          s->device->queue, s->output[l], CL_TRUE, c * s->plane, s->plane,
          layers_plane(result, (layer)l, c), 0, NULL, NULL);
      if (status != CL_SUCCESS)
        return opencl_failed(s, status, "reading a buffer", error);
    }
  return 0;
}

uint64_t sequence_hash(const sequence *s, const gbuffer *g) {
  uint64_t hash = RESUME_HASH;
  for (int i = 0; s->config.skip && i < INPUTS; i++)
    for (size_t c = 0; c < s->channels[i]; c++)
      hash =
          resume_hash(hash, gbuffer_plane(g, input_table[i].role, c), s->plane);
  return hash;
}

/* Whether the frame is the last one again: inputs and camera.  Motion vectors
 * that are followed may be the same in both and still lead elsewhere. */
static cl_bool is_same(sequence *s, uint64_t hash, const hbil_frame *frame) {
  if (s->config.skip == 0 || s->config.reprojection == HBIL_REPROJECTION_MOTION)
    return CL_FALSE;
  hash = resume_hash(hash, &frame->camera, sizeof frame->camera);
  hash = resume_hash(hash, frame->environment, sizeof frame->environment);
  const cl_bool same = hash == s->last;
  s->last = hash;
  return same;
}

int sequence_run(sequence *s, const gbuffer *g, uint64_t hash,
                 const camera_file *camera, float environment[9][3],
                 unsigned repeat, image *result, timing_row *row,
                 image_error *error) {
  hbil_frame frame;
  fill_frame(s, camera, environment, &frame);
  frame.static_frame = is_same(s, hash, &frame);
  int failed = upload(s, g, error) != 0 ||
               run_passes(s, &frame, repeat, error) != 0 ||
               download(s, result, error) != 0;
  if (failed) {
    clFinish(s->device->queue); /* the planes may still be read from */
    return -1;
  }
  if (s->config.profiling) {
    const cl_command_queue queue = s->device->queue;
    hbil_status status = hbil_plan_timings(s->plan, row->milliseconds);
    if (status == HBIL_SUCCESS)
      status = hbil_plan_statistics(s->plan, queue, &row->skipped);
    if (status == HBIL_SUCCESS)
      status = hbil_plan_sanitized(s->plan, queue, &row->repaired);
    if (status != HBIL_SUCCESS)
      return library_failed(s, status, error);
  }
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Light on its way from one process to another                              */

/* What a plan carries from frame to frame. */
static const hbil_stage carried_stages[] = {
    HBIL_STAGE_HISTORY, HBIL_STAGE_TEMPORAL_HISTORY, HBIL_STAGE_CHOICE};
enum { CARRIED = sizeof carried_stages / sizeof *carried_stages };

/* Where it lies, in bytes, without the room around its planes, which holds
 * whatever was in that memory before.  No buffer: there is no such thing. */
typedef struct carried {
  cl_mem buffer;
  size_t from[3], size[3], row, plane, bytes;
} carried;

static carried carried_of(const sequence *s, hbil_stage stage) {
  const int choice = stage == HBIL_STAGE_CHOICE; /* words, no planes */
  hbil_buffer b;
  if ((choice && s->choose_every == 1) ||
      hbil_plan_buffer(s->plan, stage, &b) != HBIL_SUCCESS)
    return (carried){.buffer = NULL};
  const size_t row = (choice ? 1 : s->config.width) * sizeof(float);
  const size_t rows = choice ? 1 : s->config.height;
  return (carried){.buffer = b.buffer,
                   .from = {b.origin * sizeof(float), 0, 0},
                   .size = {row, rows, b.values},
                   .row = b.row_pitch * sizeof(float),
                   .plane = b.plane_pitch * sizeof(float),
                   .bytes = row * rows * b.values};
}

/* The buffers, one after the other, and behind them the next run's index. */
size_t sequence_light_size(const sequence *s) {
  size_t all = 0;
  for (int i = 0; i < CARRIED; i++)
    all += carried_of(s, carried_stages[i]).bytes;
  return all ? all + sizeof s->index : 0;
}

/* Between the plan and `bytes`, one way or the other. */
static cl_int move_planes(sequence *s, const carried *c, void *bytes,
                          int to_plan) {
  const size_t packed[3] = {0, 0, 0};
  const cl_command_queue queue = s->device->queue;
  if (!c->buffer)
    return CL_SUCCESS;
  return to_plan ? clEnqueueWriteBufferRect(queue, c->buffer, CL_TRUE, c->from,
                                            packed, c->size, c->row, c->plane,
                                            0, 0, bytes, 0, NULL, NULL)
                 : clEnqueueReadBufferRect(queue, c->buffer, CL_TRUE, c->from,
                                           packed, c->size, c->row, c->plane, 0,
                                           0, bytes, 0, NULL, NULL);
}

static int move_light(sequence *s, unsigned char *bytes, int to_plan,
                      image_error *error) {
  for (int i = 0; i < CARRIED; i++) {
    const carried c = carried_of(s, carried_stages[i]);
    const cl_int status = move_planes(s, &c, bytes, to_plan);
    if (status != CL_SUCCESS)
      return opencl_failed(s, status, "moving carried light", error);
    bytes += c.bytes;
  }
  if (to_plan)
    memcpy(&s->index, bytes, sizeof s->index);
  else
    memcpy(bytes, &s->index, sizeof s->index);
  return 0;
}

int sequence_take_light(sequence *s, void *bytes, image_error *error) {
  return move_light(s, bytes, 0, error);
}

/* Composing any light makes the plan take the camera for that of its history,
 * whose planes are put right afterwards; so it does with what the temporal
 * filter keeps. */
static int compose_anything(sequence *s, const hbil_frame *frame,
                            image_error *error) {
  hbil_status status =
      hbil_enqueue_temporal(s->plan, s->device->queue, frame, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status =
        hbil_enqueue_composite(s->plan, s->device->queue, frame, 0, NULL, NULL);
  return status == HBIL_SUCCESS ? 0 : library_failed(s, status, error);
}

int sequence_give_light(sequence *s, const camera_file *camera,
                        float environment[9][3], void *bytes,
                        image_error *error) {
  hbil_frame frame;
  fill_frame(s, camera, environment, &frame);
  return compose_anything(s, &frame, error) != 0
             ? -1
             : move_light(s, bytes, 1, error);
}
