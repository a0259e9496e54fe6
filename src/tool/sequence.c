/* Runs the frames of a sequence through the library. */
#include "tool/sequence.h"

#include "hbil/hbil_stages.h"
#include "image/error.h"
#include "image/image.h"
#include "tool/device_plane.h"
#include "tool/layers.h"
#include "tool/refusal.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

struct sequence {
  const device *device;
  hbil_context *context;
  hbil_plan *plan;
  hbil_config config;
  hbil_memory memory; /* of the plan */
  size_t plane;       /* bytes of one channel */
  unsigned layers, halves;
  size_t channels[INPUTS]; /* 0: this input is not used */
  device_plane input[INPUTS];
  device_plane output[LAYER_COUNT];
  job_cache *cache; /* NULL: none */
  uint64_t last;  /* hash of the previous frame's inputs and camera; 0: none */
  unsigned still; /* static runs in a row so far */
};

static hbil_plane *plane_at(hbil_frame *frame, size_t offset) {
  return (hbil_plane *)((char *)frame + offset);
}

/* path: the frame, or NULL. */
static int library_failed(const sequence *s, const char *path,
                          hbil_status status, image_error *error) {
  return refusal(s->device, path, status, s->context, error);
}

static int opencl_failed(const sequence *s, cl_int status, const char *doing,
                         image_error *error) {
  return refusal_of_opencl(s->device, NULL, status, doing, error);
}

static int open_plan(sequence *s, image_error *error) {
  hbil_status status = hbil_plan_memory(s->context, &s->config, &s->memory);
  if (status == HBIL_SUCCESS)
    status = hbil_plan_create(s->context, &s->config, &s->plan);
  return status == HBIL_SUCCESS ? 0 : library_failed(s, NULL, status, error);
}

int sequence_open(const device *d, hbil_context *context,
                  const hbil_config *config, const channel_map *map,
                  unsigned layers, unsigned halves, sequence **out,
                  image_error *error) {
  sequence *s = calloc(1, sizeof *s);
  *out = NULL;
  if (!s)
    return image_no_memory(error, "sequence");
  s->device = d;
  s->context = context;
  s->config = *config;
  s->layers = layers;
  s->halves = halves;
  s->plane = (size_t)config->width * config->height * sizeof(float);
  formats_choose(&s->config, map, layers, halves);
  for (int i = 0; i < INPUTS; i++)
    s->channels[i] = formats_channels(&s->config, map, i);
  if (open_plan(s, error) != 0) {
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
    device_plane_close(&s->input[i]);
  for (int l = 0; l < LAYER_COUNT; l++)
    device_plane_close(&s->output[l]);
  hbil_plan_destroy(s->plan);
  free(s);
}

void sequence_set_cache(sequence *s, job_cache *cache) {
  s->cache = cache;
}

size_t sequence_memory(const sequence *s) {
  return s->memory.persistent + s->memory.scratch;
}

/* The planes stay as they are until the end of the frame. */
static int upload(sequence *s, const gbuffer *g, image_error *error) {
  for (int i = 0; i < INPUTS; i++) {
    host_channels from = {.count = s->channels[i], .bytes = s->plane};
    if (!from.count)
      continue;
    for (size_t c = 0; c < from.count; c++)
      from.channel[c] = gbuffer_plane(g, input_table[i].role, c);
    const cl_int status = device_plane_write(s->device, &from, &s->input[i]);
    if (status != CL_SUCCESS)
      return opencl_failed(s, status, "writing a buffer", error);
  }
  return 0;
}

static host_channels channels_of(const sequence *s, const image *result,
                                 const image *hidden, layer l) {
  host_channels out = {.count = strlen(layer_table[l].components),
                       .bytes = s->plane};
  const int halves = s->halves >> l & 1;
  if (halves)
    out.bytes = s->plane / sizeof(float) * sizeof(uint16_t);
  for (size_t c = 0; c < out.count; c++)
    out.channel[c] = halves ? (void *)layers_halves(result, l, c)
                            : (void *)layers_plane_of(result, hidden, l, c);
  return out;
}

static int open_outputs(sequence *s, const image *result, const image *hidden,
                        image_error *error) {
  for (int l = 0; l < LAYER_COUNT; l++) {
    if (!(s->layers >> l & 1))
      continue;
    const host_channels to = channels_of(s, result, hidden, (layer)l);
    const cl_int status = device_plane_open(s->device, &to, &s->output[l]);
    if (status != CL_SUCCESS)
      return opencl_failed(s, status, "making a buffer", error);
  }
  return 0;
}

static void end_planes(sequence *s) {
  for (int i = 0; i < INPUTS; i++)
    device_plane_end(s->device, &s->input[i]);
  for (int l = 0; l < LAYER_COUNT; l++)
    device_plane_end(s->device, &s->output[l]);
}

static void set_plane(hbil_frame *frame, size_t offset, const device_plane *p) {
  hbil_plane *plane = plane_at(frame, offset);
  plane->buffer = p->buffer;
  plane->plane_pitch = p->pitch;
}

static void fill_frame(const sequence *s, const channel_map *map,
                       const far_light *far, hbil_frame *frame) {
  hbil_frame_init(frame);
  frame->camera = map->camera;
  channel_map_hardware_depth(map, frame->hardware_depth);
  memcpy(frame->environment, far->environment, sizeof frame->environment);
  frame->sky_share = far->sky_share;
  frame->cache = s->cache ? job_cache_of(s->cache) : NULL;
  for (int i = 0; i < INPUTS; i++)
    set_plane(frame, input_table[i].image, &s->input[i]);
  for (int l = 0; l < LAYER_COUNT; l++)
    set_plane(frame, layer_table[l].image, &s->output[l]);
}

/* When a frame is repeated, nothing has moved since the previous run. */
static int clear_motion(sequence *s, image_error *error) {
  const float zero = 0.0f;
  for (int i = 0; i < INPUTS; i++)
    for (size_t c = 0; input_table[i].role == ROLE_MOTION && c < s->channels[i];
         c++) {
      const cl_int status = clEnqueueFillBuffer(
          s->device->queue, s->input[i].buffer, &zero, sizeof zero,
          c * s->input[i].pitch, s->plane, 0, NULL, NULL);
      if (status != CL_SUCCESS)
        return opencl_failed(s, status, "clearing a buffer", error);
    }
  return 0;
}

/* From some number of static runs on, their light depends on how many there
 * were.  A resumed job doesn't know that of frames before it, so such numbers
 * are reached within one frame alone. */
static void count_static_runs(sequence *s, hbil_frame *frame, unsigned repeat) {
  if (s->still + repeat > HBIL_EXACT_STATIC_FRAMES)
    frame->static_frame = CL_FALSE;
  s->still = frame->static_frame ? s->still + repeat : repeat - 1;
}

static int run_passes(sequence *s, const char *path, hbil_frame *frame,
                      unsigned repeat, image_error *error) {
  count_static_runs(s, frame, repeat);
  for (unsigned run = 0; run < repeat; run++) {
    if (run == 1 && clear_motion(s, error) != 0)
      return -1;
    if (run == 1)
      frame->static_frame = CL_TRUE;
    const hbil_status status =
        hbil_enqueue_frame(s->plan, s->device->queue, frame, 0, NULL, NULL);
    if (status != HBIL_SUCCESS)
      return library_failed(s, path, status, error);
  }
  return 0;
}

static int download(sequence *s, const image *result, const image *hidden,
                    image_error *error) {
  for (int l = 0; l < LAYER_COUNT; l++) {
    if (!(s->layers >> l & 1))
      continue;
    const host_channels to = channels_of(s, result, hidden, (layer)l);
    const cl_int status = device_plane_read(s->device, &to, &s->output[l]);
    if (status != CL_SUCCESS)
      return opencl_failed(s, status, "reading a buffer", error);
  }
  return 0;
}

uint64_t sequence_hash(const sequence *s, const gbuffer *g) {
  uint64_t hash = 0;
  for (int i = 0; s->config.execution.skip && i < INPUTS; i++)
    for (size_t c = 0; c < s->channels[i]; c++)
      hash = XXH3_64bits_withSeed(gbuffer_plane(g, input_table[i].role, c),
                                  s->plane, hash);
  return hash;
}

/* Whether inputs and camera are those of the previous frame.  Motion vectors
 * may be the same in both frames and still lead elsewhere. */
static cl_bool is_same(sequence *s, uint64_t hash, const hbil_frame *frame) {
  if (s->config.execution.skip == 0 ||
      s->config.history.reprojection == HBIL_REPROJECTION_MOTION)
    return CL_FALSE;
  hash = XXH3_64bits_withSeed(&frame->camera, sizeof frame->camera, hash);
  hash =
      XXH3_64bits_withSeed(frame->environment, sizeof frame->environment, hash);
  hash = XXH3_64bits_withSeed(&frame->sky_share, sizeof frame->sky_share, hash);
  hash = XXH3_64bits_withSeed(frame->hardware_depth,
                              sizeof frame->hardware_depth, hash);
  const cl_bool same = hash == s->last;
  s->last = hash;
  return same;
}

int sequence_run(sequence *s, const gbuffer *g, uint64_t hash,
                 const far_light *far, unsigned repeat, image *result,
                 image *hidden, timing_row *row, image_error *error) {
  hbil_frame frame;
  int failed =
      upload(s, g, error) != 0 || open_outputs(s, result, hidden, error) != 0;
  if (!failed) {
    fill_frame(s, &g->map, far, &frame);
    frame.static_frame = is_same(s, hash, &frame);
    failed = (s->cache && job_cache_see_frame(s->cache, row->frame, g, s->input,
                                              error) != 0) ||
             run_passes(s, row->frame, &frame, repeat, error) != 0 ||
             download(s, result, hidden, error) != 0;
  }
  clFinish(s->device->queue); /* until then it uses the planes */
  end_planes(s);
  if (failed)
    return -1;
  const cl_command_queue queue = s->device->queue;
  hbil_status status = hbil_plan_sanitized(s->plan, queue, &row->sanitized);
  if (status == HBIL_SUCCESS && s->config.execution.profiling)
    status = hbil_plan_timings(s->plan, row->milliseconds);
  if (status == HBIL_SUCCESS && s->config.execution.profiling)
    status = hbil_plan_statistics(s->plan, queue, &row->statistics);
  return status == HBIL_SUCCESS ? 0
                                : library_failed(s, row->frame, status, error);
}

/* ------------------------------------------------------------------------ */
/* History                                                                   */

static const hbil_stage history_stages[] = {
    HBIL_STAGE_HISTORY, HBIL_STAGE_SLICES, HBIL_STAGE_AO_SLICES,
    HBIL_STAGE_PROBE_HISTORY};
enum { HISTORIES = sizeof history_stages / sizeof *history_stages };

/* Where a history lies in its buffer, in bytes, without the padding around its
 * planes, which was never written.  No buffer: the plan has no such history. */
typedef struct history {
  cl_mem buffer;
  size_t from[3], size[3], row, plane, bytes;
} history;

static history history_of(const sequence *s, hbil_stage stage) {
  hbil_buffer b;
  if (hbil_plan_buffer(s->plan, stage, &b) != HBIL_SUCCESS)
    return (history){.buffer = NULL};
  const int whole = stage != HBIL_STAGE_HISTORY;
  const size_t row = (whole ? b.row_pitch : s->config.width) * sizeof(float);
  const size_t rows = whole ? b.plane_pitch / b.row_pitch : s->config.height;
  return (history){.buffer = b.buffer,
                   .from = {b.origin * sizeof(float), 0, 0},
                   .size = {row, rows, b.values},
                   .row = b.row_pitch * sizeof(float),
                   .plane = b.plane_pitch * sizeof(float),
                   .bytes = row * rows * b.values};
}

/* The histories, one after the other, then hbil_last_frame. */
size_t sequence_history_size(const sequence *s) {
  size_t all = 0;
  for (int i = 0; i < HISTORIES; i++)
    all += history_of(s, history_stages[i]).bytes;
  return all ? all + sizeof(hbil_last_frame) : 0;
}

static cl_int copy_planes(sequence *s, const history *c, void *bytes,
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

static int copy_histories(sequence *s, unsigned char **bytes, int to_plan,
                          image_error *error) {
  for (int i = 0; i < HISTORIES; i++) {
    const history h = history_of(s, history_stages[i]);
    const cl_int status = copy_planes(s, &h, *bytes, to_plan);
    if (status != CL_SUCCESS)
      return opencl_failed(s, status, "copying the history", error);
    *bytes += h.bytes;
  }
  return 0;
}

int sequence_history_save(sequence *s, void *bytes, image_error *error) {
  hbil_last_frame last;
  unsigned char *next = bytes;
  if (copy_histories(s, &next, 0, error) != 0)
    return -1;
  const hbil_status status = hbil_plan_last_frame(s->plan, &last);
  memcpy(next, &last, sizeof last);
  return status == HBIL_SUCCESS ? 0 : library_failed(s, NULL, status, error);
}

int sequence_history_restore(sequence *s, void *bytes, image_error *error) {
  hbil_last_frame last;
  unsigned char *next = bytes;
  if (copy_histories(s, &next, 1, error) != 0)
    return -1;
  memcpy(&last, next, sizeof last);
  const hbil_status status = hbil_plan_adopt_history(s->plan, &last);
  return status == HBIL_SUCCESS ? 0 : library_failed(s, NULL, status, error);
}
