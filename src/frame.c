/* The order of the passes, their arguments and their events. */
#include "internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* --- checks, before anything is enqueued --- */

/* The images each pass reads or writes, as bits. */
#define BIT(image) (1u << (image))
enum {
  USES_REPROJECT = BIT(PLANE_DEPTH) | BIT(PLANE_MOTION),
  USES_SURFACE = BIT(PLANE_DEPTH) | BIT(PLANE_ALBEDO) | BIT(PLANE_F0) |
                 BIT(PLANE_DIRECT) | BIT(PLANE_EMISSION),
  USES_SPLIT = USES_SURFACE | BIT(PLANE_NORMAL),
  USES_OUTPUTS = BIT(PLANE_NEAR) | BIT(PLANE_FAR) | BIT(PLANE_AO) |
                 BIT(PLANE_BENT) | BIT(PLANE_CONE) | BIT(PLANE_INDIRECT) |
                 BIT(PLANE_BEAUTY) | BIT(PLANE_ERROR),
  USES_COMPOSITE = USES_SURFACE | USES_OUTPUTS,
  USES_FRAME = USES_REPROJECT | USES_SPLIT | USES_OUTPUTS
};

static size_t component_size(hbil_component component) {
  return component == HBIL_FLOAT32 ? 4 : component == HBIL_FLOAT16 ? 2 : 1;
}

/* Pitches of an image with the defaults filled in, in bytes. */
static void pitches(const hbil_plan *plan, int image, const hbil_plane *given,
                    size_t *row, size_t *plane) {
  const size_t size =
      component_size(config_format(&plan->config, image)->component);
  const size_t stride = format_stride(&plan->config, image);
  *row =
      given->row_pitch ? given->row_pitch : size * stride * plan->config.width;
  *plane = given->plane_pitch ? given->plane_pitch : *row * plan->config.height;
}

/* Bytes from the first component to the end of the last one. */
static size_t extent(const hbil_plan *plan, int image, size_t row,
                     size_t plane) {
  const size_t size =
      component_size(config_format(&plan->config, image)->component);
  const size_t stride = format_stride(&plan->config, image);
  const size_t channels = plane_kinds[image].channels;
  const size_t across = (plan->config.width - 1) * stride * size;
  const size_t deep =
      stride == 1 ? (channels - 1) * plane : (channels - 1) * size;
  return (plan->config.height - 1) * row + across + deep + size;
}

static hbil_status check_image(hbil_plan *plan, const hbil_frame *frame,
                               int image) {
  hbil_context *context = plan->context;
  const char *name = plane_kinds[image].name;
  const hbil_plane *given = frame_plane(frame, image);
  const hbil_plane_format *format = config_format(&plan->config, image);
  if (format->component == HBIL_NONE)
    return given->buffer
               ? fail(context, HBIL_INVALID_FRAME,
                      "%s.buffer: given, but the plan has no format for it",
                      name)
               : HBIL_SUCCESS;
  if (!given->buffer)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.buffer: missing, the plan has a format for it", name);
  const size_t size = component_size(format->component);
  const size_t stride = format_stride(&plan->config, image);
  if (given->offset % size || given->row_pitch % size ||
      given->plane_pitch % size)
    return fail(context, HBIL_INVALID_FRAME,
                "%s: offset, row_pitch and plane_pitch must be multiples of "
                "%zu bytes",
                name, size);
  size_t row, plane, bytes = 0;
  pitches(plan, image, given, &row, &plane);
  if (row < size * ((plan->config.width - 1) * stride + 1))
    return fail(context, HBIL_INVALID_FRAME,
                "%s.row_pitch: %zu bytes are less than a row of %u pixels",
                name, row, (unsigned)plan->config.width);
  const cl_int error = clGetMemObjectInfo(given->buffer, CL_MEM_SIZE,
                                          sizeof bytes, &bytes, NULL);
  if (error == CL_INVALID_MEM_OBJECT)
    return fail(context, HBIL_INVALID_FRAME, "%s.buffer: %s", name,
                cl_error_name(error));
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clGetMemObjectInfo");
  const size_t needed = extent(plan, image, row, plane);
  if (given->offset > bytes || needed > bytes - given->offset)
    return fail(context, HBIL_INVALID_FRAME,
                "%s: offset %zu + %zu bytes do not fit in its buffer of %zu",
                name, given->offset, needed, bytes);
  if ((given->offset + needed) / size > UINT32_MAX)
    return fail(context, HBIL_INVALID_FRAME,
                "%s: components beyond 2^32 cannot be addressed", name);
  return HBIL_SUCCESS;
}

static hbil_status check_environment(hbil_plan *plan, const hbil_frame *frame) {
  const bool sh = plan->config.far_field == HBIL_FAR_SH;
  const int count = plan->config.far_field == HBIL_FAR_NONE ? 0 : sh ? 9 : 1;
  for (int i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) {
      const float v = frame->environment[i][c];
      if (!isfinite(v) || (!sh && v < 0.0f))
        return fail(plan->context, HBIL_INVALID_FRAME,
                    "environment[%d][%d]: %g; must be %s", i, c, (double)v,
                    sh ? "finite" : "finite and not negative");
    }
  return HBIL_SUCCESS;
}

/* What can be seen of the caller's promise. */
static hbil_status check_still(hbil_plan *plan, const hbil_frame *frame) {
  if (!frame->static_frame || !plan->has_last)
    return HBIL_SUCCESS;
  if (memcmp(&frame->camera, &plan->last_camera, sizeof frame->camera))
    return fail(
        plan->context, HBIL_INVALID_FRAME,
        "static_frame: CL_TRUE, but camera is not that of the frame before");
  if (frame->frame_index != plan->last_index &&
      !plan->config.max_history_frames)
    return fail(plan->context, HBIL_INVALID_FRAME,
                "static_frame: CL_TRUE, but frame_index is %u, that of the "
                "frame before was "
                "%u; one pattern is needed",
                (unsigned)frame->frame_index, (unsigned)plan->last_index);
  return HBIL_SUCCESS;
}

static hbil_status check_frame(hbil_plan *plan, const hbil_frame *frame,
                               unsigned images) {
  hbil_status status = camera_check(plan->context, &frame->camera);
  if (status == HBIL_SUCCESS)
    status = check_still(plan, frame);
  if (status == HBIL_SUCCESS)
    status = check_environment(plan, frame);
  for (int i = 0; i < PLANE_COUNT && status == HBIL_SUCCESS; ++i)
    if (images & BIT(i))
      status = check_image(plan, frame, i);
  return status;
}

/* --- the chain of commands of one call --- */

typedef struct commands {
  hbil_plan *plan;
  cl_command_queue queue;
  cl_uint wait_count; /* what the next command waits for */
  const cl_event *wait_list;
  bool in_order;
  bool events;      /* every command makes an event */
  bool reprojected; /* by this call */
  hbil_pass pass;
  cl_event last; /* of the last command; owned */
} commands;

static hbil_status check_queue(hbil_plan *plan, cl_command_queue queue,
                               bool *in_order) {
  cl_context context = NULL;
  cl_device_id device = NULL;
  cl_command_queue_properties properties = 0;
  cl_int error = clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof context,
                                       &context, NULL);
  if (error == CL_SUCCESS)
    error = clGetCommandQueueInfo(queue, CL_QUEUE_DEVICE, sizeof device,
                                  &device, NULL);
  if (error == CL_SUCCESS)
    error = clGetCommandQueueInfo(queue, CL_QUEUE_PROPERTIES, sizeof properties,
                                  &properties, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clGetCommandQueueInfo");
  if (context != plan->context->context || device != plan->context->device)
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "queue: not of the plan's OpenCL context and device");
  if (plan->config.profiling && !(properties & CL_QUEUE_PROFILING_ENABLE))
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "queue: profiling needs CL_QUEUE_PROFILING_ENABLE");
  *in_order = !(properties & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
  return HBIL_SUCCESS;
}

/* Notes a command that has been enqueued with `event`. */
static void follow(commands *chain, cl_event event) {
  hbil_plan *plan = chain->plan;
  if (chain->last)
    clReleaseEvent(chain->last);
  chain->last = event;
  chain->wait_count = 0;
  chain->wait_list = NULL;
  if (!chain->in_order) {
    chain->wait_count = 1;
    chain->wait_list = &chain->last;
  }
  if (!plan->config.profiling || plan->launches == MAX_LAUNCHES)
    return;
  /* the command runs all the same: timings alone are lost */
  const cl_int error = clRetainEvent(event);
  if (error != CL_SUCCESS) {
    plan->events_error = error;
    return;
  }
  plan->events[plan->launches] = event;
  plan->event_pass[plan->launches++] = chain->pass;
}

typedef struct argument {
  size_t size;
  const void *value;
} argument;

#define ARG(x)                                                                 \
  { sizeof(x), &(x) }

static size_t groups_up(size_t n, size_t group) {
  return (n + group - 1) / group * group;
}

/* Work-items in x, y from `top` on, z; rounded up to whole groups, which
 * kernels ignore. */
static hbil_status launch_from(commands *chain, int kernel,
                               const argument *args, cl_uint count, size_t top,
                               size_t x, size_t y, size_t z) {
  hbil_context *context = chain->plan->context;
  const size_t *group = context->group;
  const size_t local[3] = {group[0], group[1], 1};
  const size_t global[3] = {groups_up(x, group[0]), groups_up(y, group[1]), z};
  const size_t offset[3] = {0, top, 0};
  cl_event event = NULL;
  for (cl_uint i = 0; i < count; ++i) {
    const cl_int error = clSetKernelArg(chain->plan->kernels[kernel], i,
                                        args[i].size, args[i].value);
    if (error != CL_SUCCESS)
      return fail_cl(context, error, "clSetKernelArg");
  }
  const cl_int error = clEnqueueNDRangeKernel(
      chain->queue, chain->plan->kernels[kernel], 3, offset, global, local,
      chain->wait_count, chain->wait_list, chain->events ? &event : NULL);
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clEnqueueNDRangeKernel");
  follow(chain, event);
  return HBIL_SUCCESS;
}

#define COUNT(args) ((cl_uint)(sizeof(args) / sizeof *(args)))
#define LAUNCH(chain, kernel, args, x, y, z)                                   \
  launch_from((chain), (kernel), (args), COUNT(args), 0, (x), (y), (z))

/* Vectors of pixels across the image. */
static size_t across(const hbil_plan *plan) {
  const size_t width = plan->config.vector_width;
  return (plan->config.width + width - 1) / width;
}

/* --- images as arguments --- */

/* Absent images are a null buffer. */
typedef struct bound_plane {
  cl_mem buffer;
  hbil_external_plane_args args;
} bound_plane;

static bound_plane bind(const hbil_plan *plan, const hbil_frame *frame,
                        int image) {
  bound_plane bound;
  memset(&bound, 0, sizeof bound);
  const hbil_plane_format *format = config_format(&plan->config, image);
  const hbil_plane *given = frame_plane(frame, image);
  if (format->component == HBIL_NONE)
    return bound;
  const size_t size = component_size(format->component);
  size_t row, plane;
  pitches(plan, image, given, &row, &plane);
  bound.buffer = given->buffer;
  bound.args.offset = (cl_uint)(given->offset / size);
  bound.args.row = (cl_uint)(row / size);
  /* interleaved channels are neighbours */
  bound.args.plane =
      format_stride(&plan->config, image) == 1 ? (cl_uint)(plane / size) : 1;
  return bound;
}

#define PLANE_ARGS(bound) ARG((bound).buffer), ARG((bound).args)

/* --- the passes --- */

/* Fills `bytes` of a buffer from `offset` on with copies of a word. */
static hbil_status fill_part(commands *chain, int buffer, cl_uint word,
                             size_t offset, size_t bytes) {
  hbil_plan *plan = chain->plan;
  cl_event event = NULL;
  const cl_int error = clEnqueueFillBuffer(
      chain->queue, plan->buffers[buffer], &word, sizeof word, offset, bytes,
      chain->wait_count, chain->wait_list, chain->events ? &event : NULL);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clEnqueueFillBuffer");
  follow(chain, event);
  return HBIL_SUCCESS;
}

static hbil_status fill(commands *chain, int buffer, cl_uint word) {
  return fill_part(chain, buffer, word, 0, chain->plan->layout.bytes[buffer]);
}

static hbil_status set_flag(commands *chain, int flag, cl_uint value) {
  return fill_part(chain, BUFFER_FLAGS, value, (size_t)flag * sizeof value,
                   sizeof value);
}

/* Counts of what can't be used as it is start anew: `words` from `first` on. */
static hbil_status clear_counts(commands *chain, int first, int words) {
  return fill_part(chain, BUFFER_SANITIZED, 0, (size_t)first * sizeof(cl_uint),
                   (size_t)words * sizeof(cl_uint));
}

/* --- still frames --- */

/* Whether this frame is the last one again but for its light. */
static bool is_still(const hbil_plan *plan, const hbil_frame *frame) {
  return frame->static_frame && plan->has_last &&
         plan->layout.skip & HBIL_SKIP_STILL;
}

/* Whether even its light is that of the last one: none is carried over. */
static bool is_same(const hbil_plan *plan, const hbil_frame *frame) {
  return is_still(plan, frame) && !plan->layout.history;
}

/* What the gather needs to know of that: with a filter over frames even one
 * that stands still is gathered anew, by another pattern. */
static bool may_rest(const hbil_plan *plan, const hbil_frame *frame) {
  return is_still(plan, frame) && !plan->config.max_history_frames;
}

static hbil_status leave_out(commands *chain) {
  chain->plan->left_out[chain->pass] = true;
  return HBIL_SUCCESS;
}

/* On CPUs bands of this frame by themselves; on GPUs who is nearest, of all
 * pixels of the last frame at once, then what that one sends. */
static hbil_status scatter(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  const hbil_runs_args *runs = &plan->layout.runs;
  const size_t x = across(plan), y = plan->config.height;
  const size_t bands = (y + (size_t)runs->band - 1) / (size_t)runs->band;
  const hbil_view_args from = camera_view(&plan->history_camera, &plan->config);
  const hbil_view_args to = camera_view(&frame->camera, &plan->config);
  const hbil_transform_args motion =
      camera_between(&plan->history_camera, &frame->camera);
  const bound_plane depth = bind(plan, frame, PLANE_DEPTH);
#define PROJECT                                                                \
  ARG(from), ARG(to), ARG(motion), ARG(plan->buffers[BUFFER_HISTORY]),         \
      ARG(plan->layout.planes)
#define FETCH                                                                  \
  ARG(to), ARG(plan->buffers[BUFFER_HISTORY]),                                 \
      ARG(plan->buffers[BUFFER_CARRIED]), ARG(plan->layout.planes),            \
      ARG(plan->buffers[BUFFER_NEAREST]), PLANE_ARGS(depth),                   \
      ARG(plan->config.sky_depth), ARG(plan->config.disocclusion_threshold),   \
      ARG(plan->buffers[BUFFER_FLAGS])
  const argument rows[] = {PROJECT, ARG(*runs),
                           ARG(plan->buffers[BUFFER_LANDING])};
  const argument band[] = {FETCH, ARG(from), ARG(motion), ARG(*runs),
                           ARG(plan->buffers[BUFFER_LANDING])};
  const argument pixels[] = {PROJECT, ARG(plan->buffers[BUFFER_NEAREST])};
  const argument fetch[] = {FETCH};
#undef PROJECT
#undef FETCH
  hbil_status status;
  if (layout_has_bands(&plan->config)) {
    status = LAUNCH(chain, KERNEL_SCATTER_ROWS, rows, (size_t)runs->row, y, 1);
    return status == HBIL_SUCCESS
               ? LAUNCH(chain, KERNEL_SCATTER_BANDS, band, 1, bands, 1)
               : status;
  }
  status = fill(chain, BUFFER_NEAREST, 0xffffffffu);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_SCATTER_DEPTH, pixels, x, y, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_SCATTER_INDEX, pixels, x, y, 1);
  return status == HBIL_SUCCESS
             ? LAUNCH(chain, KERNEL_SCATTER_FETCH, fetch, x, y, 1)
             : status;
}

static hbil_status follow_motion(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  const hbil_view_args view = camera_view(&frame->camera, &plan->config);
  const hbil_transform_args back =
      camera_between(&frame->camera, &plan->history_camera);
  const bound_plane depth = bind(plan, frame, PLANE_DEPTH);
  const bound_plane motion = bind(plan, frame, PLANE_MOTION);
  const argument args[] = {ARG(view),
                           ARG(back),
                           ARG(plan->buffers[BUFFER_HISTORY]),
                           ARG(plan->buffers[BUFFER_CARRIED]),
                           ARG(plan->layout.planes),
                           PLANE_ARGS(depth),
                           PLANE_ARGS(motion),
                           ARG(plan->config.motion_scale[0]),
                           ARG(plan->config.motion_scale[1]),
                           ARG(plan->config.sky_depth),
                           ARG(plan->config.disocclusion_threshold),
                           ARG(plan->buffers[BUFFER_FLAGS]),
                           ARG(plan->buffers[BUFFER_SANITIZED])};
  const hbil_status status = clear_counts(chain, HBIL_SANITIZED_MOTION, 1);
  return status == HBIL_SUCCESS ? LAUNCH(chain, KERNEL_FOLLOW_MOTION, args,
                                         across(plan), plan->config.height, 1)
                                : status;
}

/* A frame's first pass: timings start anew. */
static void forget_timings(hbil_plan *plan) {
  for (int i = 0; i < plan->launches; ++i)
    clReleaseEvent(plan->events[i]);
  plan->launches = 0;
  plan->events_error = CL_SUCCESS;
}

static hbil_status reproject(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  forget_timings(plan);
  if (!plan->has_history || is_still(plan, frame))
    return leave_out(chain);
  const hbil_status status = set_flag(chain, HBIL_FLAG_HOLES, 0);
  if (status != HBIL_SUCCESS)
    return status;
  chain->reprojected = true;
  return plan->config.reprojection == HBIL_REPROJECTION_MOTION
             ? follow_motion(chain, frame)
             : scatter(chain, frame);
}

/* Whether there is something to fill: reproject has said so, unless something
 * else may have been put in its place since. */
static hbil_status find_holes(commands *chain) {
  hbil_plan *plan = chain->plan;
  const argument args[] = {ARG(plan->buffers[BUFFER_CARRIED]),
                           ARG(plan->layout.chain[0]),
                           ARG(plan->buffers[BUFFER_FLAGS])};
  if (!(plan->layout.skip & HBIL_SKIP_HOLES))
    return set_flag(chain, HBIL_FLAG_HOLES, 1);
  plan->may_leave_out[HBIL_PASS_PUSH_PULL] = true;
  if (chain->reprojected)
    return HBIL_SUCCESS;
  const hbil_status status = set_flag(chain, HBIL_FLAG_HOLES, 0);
  return status == HBIL_SUCCESS ? LAUNCH(chain, KERNEL_FIND_HOLES, args,
                                         across(plan), plan->config.height, 1)
                                : status;
}

static hbil_status push_pull(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  const hbil_chain_args *levels = plan->layout.chain;
  const int last = plan->layout.chain_count - 1;
  const size_t width = plan->config.vector_width;
  if (!plan->has_history || is_still(plan, frame))
    return leave_out(chain);
  hbil_status status = find_holes(chain);
  /* finest to coarsest, and back */
  for (int step = 0; step < 2 * last && status == HBIL_SUCCESS; ++step) {
    const bool down = step < last;
    const int fine = down ? step : 2 * last - 1 - step;
    const hbil_chain_args *written = &levels[down ? fine + 1 : fine];
    const argument args[] = {ARG(plan->buffers[BUFFER_CARRIED]),
                             ARG(levels[fine]), ARG(levels[fine + 1]),
                             ARG(plan->buffers[BUFFER_FLAGS])};
    status = LAUNCH(chain, down ? KERNEL_PUSH : KERNEL_PULL, args,
                    ((size_t)written->width + width - 1) / width,
                    (size_t)written->height, 1);
  }
  return status;
}

/* What light comes from where the screen doesn't show: from the split planes.
 * The parts stand behind the sum in one buffer. */
static hbil_status estimate(commands *chain) {
  hbil_plan *plan = chain->plan;
  const argument part[] = {ARG(plan->layout.split),
                           ARG(plan->buffers[BUFFER_SPLIT]),
                           ARG(plan->buffers[BUFFER_ESTIMATE])};
  const argument sum[] = {ARG(plan->buffers[BUFFER_ESTIMATE])};
  const hbil_status status =
      LAUNCH(chain, KERNEL_ESTIMATE_PART, part, HBIL_ESTIMATE_PARTS, 1, 1);
  return status == HBIL_SUCCESS
             ? LAUNCH(chain, KERNEL_ESTIMATE_SUM, sum, HBIL_ESTIMATE_SIZE, 1, 1)
             : status;
}

/* What the gather may leave out. */
static hbil_status bound(commands *chain, cl_int still) {
  hbil_plan *plan = chain->plan;
  const hbil_bounds_args *b = &plan->layout.bounds;
  const cl_int width = (cl_int)plan->config.vector_width;
  const struct {
    const hbil_grid_args *fine, *coarse;
    cl_int across, down;
  } steps[] = {{&b->group, &b->cell, HBIL_CELL / width, HBIL_CELL * HBIL_SIDE},
               {&b->cell, &b->block, HBIL_BLOCK, HBIL_BLOCK},
               {&b->block, &b->whole, b->block.width, b->block.height}};
  hbil_status status = HBIL_SUCCESS;
  for (size_t i = 0; i < 3 && status == HBIL_SUCCESS; ++i) {
    const argument args[] = {ARG(*steps[i].fine),
                             ARG(*steps[i].coarse),
                             ARG(steps[i].across),
                             ARG(steps[i].down),
                             ARG(plan->buffers[BUFFER_BOUNDS]),
                             ARG(plan->buffers[BUFFER_FLAGS]),
                             ARG(still)};
    status =
        LAUNCH(chain, KERNEL_BOUND_CELLS, args, (size_t)steps[i].coarse->width,
               (size_t)steps[i].coarse->height, 1);
  }
  if (status != HBIL_SUCCESS || !plan->layout.quadrants)
    return status;
  const argument args[] = {ARG(*b), ARG(plan->buffers[BUFFER_BOUNDS]),
                           ARG(plan->buffers[BUFFER_FLAGS]), ARG(still)};
  return LAUNCH(chain, KERNEL_BOUND_QUADRANTS, args, (size_t)b->block.width,
                (size_t)b->block.height, 1);
}

/* What is made of the split planes. */
static hbil_status sum_up(commands *chain, cl_int still) {
  const hbil_status status =
      chain->plan->buffers[BUFFER_BOUNDS] ? bound(chain, still) : HBIL_SUCCESS;
  return status == HBIL_SUCCESS && chain->plan->layout.estimate
             ? estimate(chain)
             : status;
}

/* Nothing but light is new. */
static hbil_status relight(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  const hbil_view_args view = camera_view(&frame->camera, &plan->config);
  const cl_int has_history = plan->has_history;
  const bound_plane depth = bind(plan, frame, PLANE_DEPTH);
  const bound_plane albedo = bind(plan, frame, PLANE_ALBEDO);
  const bound_plane f0 = bind(plan, frame, PLANE_F0);
  const bound_plane direct = bind(plan, frame, PLANE_DIRECT);
  const bound_plane emission = bind(plan, frame, PLANE_EMISSION);
  const argument args[] = {ARG(view),
                           ARG(plan->buffers[BUFFER_SPLIT]),
                           ARG(plan->layout.split),
                           ARG(plan->buffers[BUFFER_HISTORY]),
                           ARG(plan->layout.planes),
                           ARG(has_history),
                           ARG(plan->config.sky_depth),
                           ARG(plan->config.direct_scale),
                           PLANE_ARGS(depth),
                           PLANE_ARGS(albedo),
                           PLANE_ARGS(f0),
                           PLANE_ARGS(direct),
                           PLANE_ARGS(emission),
                           ARG(plan->buffers[BUFFER_FLAGS]),
                           ARG(plan->layout.bounds.group),
                           ARG(plan->buffers[BUFFER_BOUNDS])};
  hbil_status status = set_flag(chain, HBIL_FLAG_CHANGED, 0);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_RELIGHT, args, (across(plan) + 3) / 4,
                    plan->config.height, 1);
  return status == HBIL_SUCCESS ? sum_up(chain, CL_TRUE) : status;
}

static hbil_status split(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  if (is_same(plan, frame))
    return leave_out(chain);
  if (is_still(plan, frame))
    return relight(chain, frame);
  plan->has_factors = false; /* those are of other shapes */
  const hbil_view_args view = camera_view(&frame->camera, &plan->config);
  const hbil_transform_args to_view = camera_from_world(&frame->camera);
  const cl_int has_history = plan->has_history;
  const bound_plane depth = bind(plan, frame, PLANE_DEPTH);
  const bound_plane normal = bind(plan, frame, PLANE_NORMAL);
  const bound_plane albedo = bind(plan, frame, PLANE_ALBEDO);
  const bound_plane f0 = bind(plan, frame, PLANE_F0);
  const bound_plane direct = bind(plan, frame, PLANE_DIRECT);
  const bound_plane emission = bind(plan, frame, PLANE_EMISSION);
  const argument args[] = {ARG(view),
                           ARG(to_view),
                           ARG(plan->buffers[BUFFER_SPLIT]),
                           ARG(plan->layout.split),
                           ARG(plan->buffers[BUFFER_CARRIED]),
                           ARG(plan->layout.planes),
                           ARG(has_history),
                           ARG(plan->config.sky_depth),
                           ARG(plan->config.direct_scale),
                           PLANE_ARGS(depth),
                           PLANE_ARGS(normal),
                           PLANE_ARGS(albedo),
                           PLANE_ARGS(f0),
                           PLANE_ARGS(direct),
                           PLANE_ARGS(emission),
                           ARG(plan->buffers[BUFFER_USES]),
                           ARG(plan->buffers[BUFFER_SANITIZED]),
                           ARG(plan->layout.bounds.group),
                           ARG(plan->buffers[BUFFER_BOUNDS])};
  hbil_status status = clear_counts(chain, HBIL_SANITIZED_DEPTH,
                                    HBIL_SANITIZED_LATE - HBIL_SANITIZED_DEPTH);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_SPLIT, args, (across(plan) + 3) / 4,
                    plan->config.height, 1);
  return status == HBIL_SUCCESS ? sum_up(chain, CL_FALSE) : status;
}

/* Fractions of a turn and of a step that frame `index` adds: multiples of the
 * fraction of sqrt(7) (the paper's demo) and of the inverse plastic number,
 * neither of which repeats soon. */
static hbil_pattern_args pattern_of(const hbil_plan *plan,
                                    const hbil_frame *frame,
                                    const hbil_view_args *view) {
  hbil_pattern_args pattern = plan->layout.pattern;
  const float to_x = (float)view->width / view->fx;
  const float to_y = (float)view->height / view->fy;
  pattern.reach = to_x > to_y ? to_x : to_y;
  pattern.turn = (float)fmod(frame->frame_index * 0.6457513, 1.0);
  pattern.shift = (float)fmod(frame->frame_index * 0.7548777, 1.0);
  return pattern;
}

/* A rung's part of the table of steps. */
static hbil_status make_steps(commands *chain, const hbil_view_args *view,
                              const hbil_pattern_args *pattern,
                              const hbil_rung *rung) {
  hbil_plan *plan = chain->plan;
  hbil_pattern_args own = *pattern;
  own.slices = rung->slices;
  own.samples = rung->samples;
  const argument args[] = {{sizeof *view, view},
                           ARG(own),
                           ARG(plan->layout.split),
                           ARG(plan->buffers[BUFFER_STEPS]),
                           ARG(rung->steps)};
  return LAUNCH(chain, KERNEL_PATTERN, args, (size_t)own.levels * HBIL_LAYERS,
                (size_t)own.slices * 2, 1);
}

/* The table of steps, unless it is there already. */
static hbil_status make_pattern(commands *chain, const hbil_view_args *view,
                                const hbil_pattern_args *pattern) {
  hbil_plan *plan = chain->plan;
  const ladder *l = &plan->layout.ladder;
  if (plan->has_steps && !memcmp(view, &plan->steps_view, sizeof *view) &&
      !memcmp(pattern, &plan->steps_pattern, sizeof *pattern))
    return HBIL_SUCCESS;
  hbil_status status = make_steps(chain, view, pattern, &l->rung[0]);
  for (int i = 1; i < l->count && status == HBIL_SUCCESS; ++i)
    status = make_steps(chain, view, pattern, &l->rung[i]);
  if (l->count && status == HBIL_SUCCESS)
    status = make_steps(chain, view, pattern, &l->rung[LADDER_RULER]);
  plan->has_steps = status == HBIL_SUCCESS;
  plan->steps_view = *view;
  plan->steps_pattern = *pattern;
  return status;
}

/* W of HBAO falls by this much per world unit. */
static float falloff_slope(const hbil_config *config) {
  if (isinf(config->radius) || config->falloff == HBIL_FALLOFF_NONE)
    return 0.0f;
  return (config->falloff == HBIL_FALLOFF_SOFT ? 1.0f / 3.0f : 1.0f) /
         config->radius;
}

/* Length of the ray to the corner that is farthest from the axis; orthographic,
 * of the way there in the picture's plane. */
static float longest_ray(const hbil_view_args *v, bool orthographic) {
  const double x = fmax(fabs((double)v->cx), fabs(v->width - (double)v->cx));
  const double y = fmax(fabs((double)v->cy), fabs(v->height - (double)v->cy));
  const double rx = x / (double)v->fx, ry = y / (double)v->fy;
  return (float)sqrt((orthographic ? 0.0 : 1.0) + rx * rx + ry * ry);
}

/* Looks around from so many spans of a row, from the rows of a layer between
 * `top` and `bottom`; keeps what it finds as form factors, or not. */
static hbil_status look_around(commands *chain, const hbil_gather_args *args,
                               cl_int still, size_t spans, size_t top,
                               size_t bottom, bool keep) {
  hbil_plan *plan = chain->plan;
  const argument all[] = {{sizeof *args, args},
                          ARG(plan->buffers[BUFFER_SPLIT]),
                          ARG(plan->buffers[BUFFER_STEPS]),
                          ARG(plan->buffers[BUFFER_LIGHT]),
                          ARG(plan->buffers[BUFFER_BOUNDS]),
                          ARG(plan->buffers[BUFFER_USES]),
                          ARG(plan->buffers[BUFFER_SPAN_STATES]),
                          ARG(plan->buffers[BUFFER_FLAGS]),
                          ARG(still),
                          ARG(plan->buffers[BUFFER_LADDER]),
                          ARG(plan->buffers[BUFFER_TRIED]),
                          ARG(plan->layout.factors),
                          ARG(plan->buffers[BUFFER_FACTORS])};
  const cl_uint of_factors = 2;
  if (top == bottom)
    return HBIL_SUCCESS;
  return launch_from(chain, keep ? KERNEL_GATHER_FACTORS : KERNEL_GATHER, all,
                     COUNT(all) - (keep ? 0 : of_factors), top, spans,
                     bottom - top, HBIL_LAYERS);
}

/* Gathers light by the form factors that are there. */
static hbil_status regather(commands *chain, const hbil_gather_args *args) {
  hbil_plan *plan = chain->plan;
  const argument all[] = {{sizeof *args, args},
                          ARG(plan->buffers[BUFFER_SPLIT]),
                          ARG(plan->buffers[BUFFER_LIGHT]),
                          ARG(plan->buffers[BUFFER_SPAN_STATES]),
                          ARG(plan->buffers[BUFFER_FLAGS]),
                          ARG(plan->layout.factors),
                          ARG(plan->buffers[BUFFER_FACTORS])};
  return LAUNCH(chain, KERNEL_REGATHER, all, plan->layout.spans,
                plan->layout.factors.rows, HBIL_LAYERS);
}

/* All pixels.  The first still frame keeps form factors, of as many rows as
 * there is memory for: it is the first that knows what comes after it may be
 * still, too.  It does so whether or not its light has changed, so that they
 * are there, whatever becomes of the light.  Later ones use them. */
static hbil_status gather_all(commands *chain, const hbil_gather_args *args,
                              cl_int still) {
  hbil_plan *plan = chain->plan;
  const layout *l = &plan->layout;
  const size_t kept = still ? l->factors.rows : 0;
  const bool has_factors = kept && plan->has_factors;
  hbil_status status =
      has_factors ? regather(chain, args)
                  : look_around(chain, args, CL_FALSE, l->spans, 0, kept, true);
  if (status == HBIL_SUCCESS)
    status = look_around(chain, args, still, l->spans, kept,
                         (size_t)l->split.height, false);
  plan->by_factors = has_factors;
  /* a frame that fails has no still ones after it */
  plan->has_factors = kept > 0;
  plan->may_leave_out[HBIL_PASS_GATHER] = still && (has_factors || !kept);
  return status;
}

/* Looks around from the tiles that are measured, with a rung, and says how far
 * it is off from the ruler, or what the ruler is. */
static hbil_status measure(commands *chain, const hbil_gather_args *args,
                           cl_int still, int rung) {
  hbil_plan *plan = chain->plan;
  const layout *l = &plan->layout;
  const size_t span = plan->config.vector_width == 1 ? 1 : HBIL_SPAN;
  const hbil_judge_args judge_args = {l->split, l->light, l->tiles, rung,
                                      l->ladder.limit[rung]};
  const argument judge[] = {ARG(judge_args),
                            ARG(args->view),
                            ARG(plan->buffers[BUFFER_SPLIT]),
                            ARG(plan->buffers[BUFFER_LIGHT]),
                            ARG(plan->buffers[BUFFER_RULER]),
                            ARG(plan->buffers[BUFFER_TRIED]),
                            ARG(plan->buffers[BUFFER_FLAGS]),
                            ARG(still)};
  hbil_gather_args measuring = *args;
  measuring.measures = rung;
  measuring.dark = isinf(plan->config.max_error[1]);
  const hbil_status status =
      look_around(chain, &measuring, still, (size_t)l->tiles * HBIL_SPAN / span,
                  0, 1, false);
  if (status != HBIL_SUCCESS)
    return status;
  const int kernel =
      rung == LADDER_RULER ? KERNEL_JUDGE_RULER : KERNEL_JUDGE_RUNG;
  return LAUNCH(chain, kernel, judge, (size_t)l->tiles, 1, 1);
}

/* Adaptive sampling: the last rung is what is left where no other will do. */
static hbil_status choose_rung(commands *chain, const hbil_gather_args *args,
                               cl_int still) {
  hbil_status status = measure(chain, args, still, LADDER_RULER);
  for (int i = 0;
       i + 1 < chain->plan->layout.ladder.count && status == HBIL_SUCCESS; ++i)
    status = measure(chain, args, still, i);
  return status;
}

static hbil_status gather(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  const hbil_view_args view = camera_view(&frame->camera, &plan->config);
  const hbil_pattern_args pattern = pattern_of(plan, frame, &view);
  const cl_int still = may_rest(plan, frame);
  if (still && !plan->layout.history)
    return leave_out(chain);
  hbil_status status = make_pattern(chain, &view, &pattern);
  if (status != HBIL_SUCCESS)
    return status;
  hbil_gather_args gather_args;
  memset(&gather_args, 0, sizeof gather_args);
  gather_args.view = view;
  gather_args.split = plan->layout.split;
  gather_args.light = plan->layout.light;
  gather_args.radius = plan->config.radius;
  gather_args.reach = pattern.reach;
  /* Four roundings of the format lie between two depths and their difference:
   * of z0, z1 and of their inverses; half has 2^-11 each for the depths.  The
   * same for the three components of a normal and what is made of them; a
   * packed one is off by sqrt(18)/4 steps of 2^-14 at most, 6.5e-5. */
  const bool half_depth = plan->config.depth.component == HBIL_FLOAT16;
  const bool half_normal = plan->config.normal.component == HBIL_FLOAT16;
  const bool packed = plan->config.storage != HBIL_STORAGE_FLOAT32;
  const float roundings = half_depth ? 0x1p-10f : 0x1p-22f;
  const bool orthographic =
      plan->config.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  /* away from the eye; -z is negative */
  gather_args.keep = orthographic ? 1.0f + roundings : 1.0f - roundings;
  gather_args.flat = half_normal ? 0x1p-10f : packed ? 0x1p-13f : 0x1p-21f;
  /* finite, since the gather is built without infinities */
  gather_args.thickness = fminf(plan->config.thickness, 1e30f);
  gather_args.relative_thickness =
      fminf(plan->config.relative_thickness, 1e30f);
  if (orthographic)
    gather_args.thickness =
        fminf(gather_args.thickness,
              gather_args.relative_thickness * (float)view.width * view.inv_fx);
  gather_args.falloff = falloff_slope(&plan->config);
  gather_args.longest = longest_ray(&view, orthographic);
  gather_args.bounds = plan->layout.bounds;
  gather_args.spans = (cl_uint)plan->layout.spans;
  gather_args.slices = pattern.slices;
  gather_args.samples = pattern.samples;
  gather_args.facing[0] = plan->config.facing_fade[0];
  gather_args.facing[1] =
      1.0f /
      fmaxf(plan->config.facing_fade[1] - plan->config.facing_fade[0], FLT_MIN);
  gather_args.rungs = plan->layout.ladder.count;
  gather_args.tiles = plan->layout.tiles;
  gather_args.measures = -1;
  plan->kept_choice = frame->keep_choice && plan->has_last;
  if (plan->layout.ladder.count && !plan->kept_choice)
    status = choose_rung(chain, &gather_args, still);
  return status == HBIL_SUCCESS ? gather_all(chain, &gather_args, still)
                                : status;
}

static hbil_status recompose(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  const cl_int still = may_rest(plan, frame);
  plan->kept_anew = false; /* what a frame has kept that was broken off */
  if (still && !plan->layout.history)
    return leave_out(chain);
  plan->may_leave_out[HBIL_PASS_RECOMPOSE] = still;
  const hbil_view_args view = camera_view(&frame->camera, &plan->config);
  const argument args[] = {ARG(view),
                           ARG(plan->layout.split),
                           ARG(plan->layout.light),
                           ARG(plan->buffers[BUFFER_SPLIT]),
                           ARG(plan->buffers[BUFFER_LIGHT]),
                           ARG(plan->buffers[BUFFER_ESTIMATE]),
                           ARG(plan->buffers[BUFFER_RESOLVED]),
                           ARG(plan->layout.planes),
                           ARG(plan->buffers[BUFFER_FLAGS]),
                           ARG(still),
                           ARG(plan->buffers[BUFFER_LADDER]),
                           ARG(plan->layout.ladder.count),
                           ARG(plan->buffers[BUFFER_TRIED])};
  const size_t rows =
      plan->config.vector_width == 1 ? 1 : (size_t)HBIL_RECOMPOSE_ROWS;
  return LAUNCH(chain, KERNEL_RECOMPOSE, args, plan->layout.spans,
                (plan->config.height + rows - 1) / rows, 1);
}

/* Writes beside what is kept of the frame before; composite makes it what is
 * kept, so that a frame which fails is none. */
static hbil_status temporal(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  if (!plan->config.max_history_frames)
    return HBIL_SUCCESS;
  const hbil_camera *last =
      plan->has_kept ? &plan->kept_camera : &frame->camera;
  const hbil_view_args view = camera_view(&frame->camera, &plan->config);
  const hbil_view_args before = camera_view(last, &plan->config);
  const hbil_transform_args back = camera_between(&frame->camera, last);
  const bound_plane motion = bind(plan, frame, PLANE_MOTION);
  /* a mean over one frame is that frame */
  const cl_int has_before =
      plan->has_kept && plan->config.max_history_frames > 1;
  const cl_float most = (cl_float)plan->config.max_history_frames;
  const argument args[] = {ARG(view),
                           ARG(before),
                           ARG(back),
                           ARG(plan->layout.split),
                           ARG(plan->buffers[BUFFER_SPLIT]),
                           ARG(plan->buffers[BUFFER_RESOLVED]),
                           ARG(plan->buffers[BUFFER_TEMPORAL + plan->kept]),
                           ARG(plan->buffers[BUFFER_TEMPORAL + !plan->kept]),
                           ARG(plan->layout.planes),
                           ARG(has_before),
                           ARG(plan->config.disocclusion_threshold),
                           ARG(most),
                           PLANE_ARGS(motion),
                           ARG(plan->config.motion_scale[0]),
                           ARG(plan->config.motion_scale[1]),
                           ARG(plan->buffers[BUFFER_SANITIZED])};
  hbil_status status = plan->layout.history
                           ? HBIL_SUCCESS
                           : clear_counts(chain, HBIL_SANITIZED_MOTION, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_TEMPORAL, args, (across(plan) + 3) / 4,
                    plan->config.height, 1);
  plan->kept_anew = status == HBIL_SUCCESS;
  return status;
}

/* The frame is the plan's last one. */
static void remember(hbil_plan *plan, const hbil_frame *frame) {
  plan->has_last = true;
  plan->last_camera = frame->camera;
  plan->last_index = frame->frame_index;
  if (plan->layout.history) {
    plan->has_history = true;
    plan->history_camera = frame->camera;
  }
  if (plan->kept_anew) {
    plan->kept_anew = false;
    plan->kept = !plan->kept;
    plan->has_kept = true;
    plan->kept_camera = frame->camera;
  }
}

static hbil_status composite(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  const hbil_view_args view = camera_view(&frame->camera, &plan->config);
  const hbil_transform_args world = camera_to_world(&frame->camera);
  const hbil_environment_args environment =
      far_field_args(&plan->config, frame->environment);
  bound_plane image[PLANE_COUNT];
  for (int i = 0; i < PLANE_COUNT; ++i)
    image[i] = bind(plan, frame, i);
  const argument args[] = {ARG(view),
                           ARG(world),
                           ARG(plan->buffers[BUFFER_RESOLVED]),
                           ARG(plan->buffers[BUFFER_ESTIMATE]),
                           ARG(plan->buffers[BUFFER_HISTORY]),
                           ARG(plan->layout.planes),
                           ARG(environment),
                           ARG(plan->config.sky_depth),
                           ARG(plan->config.direct_scale),
                           PLANE_ARGS(image[PLANE_DEPTH]),
                           PLANE_ARGS(image[PLANE_ALBEDO]),
                           PLANE_ARGS(image[PLANE_F0]),
                           PLANE_ARGS(image[PLANE_DIRECT]),
                           PLANE_ARGS(image[PLANE_EMISSION]),
                           PLANE_ARGS(image[PLANE_NEAR]),
                           PLANE_ARGS(image[PLANE_FAR]),
                           PLANE_ARGS(image[PLANE_AO]),
                           PLANE_ARGS(image[PLANE_BENT]),
                           PLANE_ARGS(image[PLANE_CONE]),
                           PLANE_ARGS(image[PLANE_INDIRECT]),
                           PLANE_ARGS(image[PLANE_BEAUTY]),
                           PLANE_ARGS(image[PLANE_ERROR]),
                           ARG(plan->buffers[BUFFER_SANITIZED])};
  const cl_uint line = plan->layout.line;
  hbil_status status =
      plan->layout.counts_late
          ? clear_counts(chain, HBIL_SANITIZED_LATE, HBIL_SURFACE_INPUTS)
          : HBIL_SUCCESS;
  if (status == HBIL_SUCCESS)
    status =
        LAUNCH(chain, KERNEL_COMPOSITE, args,
               (plan->config.width + line - 1) / line, plan->config.height, 1);
  if (status == HBIL_SUCCESS)
    remember(plan, frame);
  return status;
}

typedef hbil_status pass_function(commands *chain, const hbil_frame *frame);

static const struct {
  pass_function *enqueue;
  unsigned images;
} passes[HBIL_PASS_COUNT] = {
    [HBIL_PASS_REPROJECT] = {reproject, USES_REPROJECT},
    [HBIL_PASS_PUSH_PULL] = {push_pull, 0},
    [HBIL_PASS_SPLIT] = {split, USES_SPLIT},
    [HBIL_PASS_GATHER] = {gather, 0},
    [HBIL_PASS_RECOMPOSE] = {recompose, 0},
    [HBIL_PASS_TEMPORAL] = {temporal, BIT(PLANE_MOTION)},
    [HBIL_PASS_COMPOSITE] = {composite, USES_COMPOSITE},
};

/* Gives the caller the last command's event, or one that follows the wait list
 * where nothing had to be enqueued. */
static hbil_status finish(commands *chain, cl_event *event) {
  if (event && chain->last) {
    *event = chain->last;
    chain->last = NULL;
  } else if (event) {
    const cl_int error = clEnqueueMarkerWithWaitList(
        chain->queue, chain->wait_count, chain->wait_list, event);
    if (error != CL_SUCCESS)
      return fail_cl(chain->plan->context, error,
                     "clEnqueueMarkerWithWaitList");
  }
  return HBIL_SUCCESS;
}

/* Passes first..last as one chain of commands. */
static hbil_status enqueue(hbil_plan *plan, cl_command_queue queue,
                           const hbil_frame *given, cl_uint wait_count,
                           const cl_event *wait_list, cl_event *event,
                           hbil_pass first, hbil_pass last) {
  if (!plan)
    return HBIL_INVALID_ARGUMENT;
  if (!queue || !given || !wait_count != !wait_list)
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "queue and frame must not be null, wait_list must fit "
                "wait_count");
  unsigned images = 0;
  for (int i = (int)first; i <= (int)last; ++i)
    images |= passes[i].images;
  commands chain = {.plan = plan,
                    .queue = queue,
                    .wait_count = wait_count,
                    .wait_list = wait_list};
  hbil_frame frame;
  hbil_status status = check_queue(plan, queue, &chain.in_order);
  if (status == HBIL_SUCCESS)
    status = frame_take(plan->context, given, &frame);
  if (status == HBIL_SUCCESS)
    status = check_frame(plan, &frame, images);
  chain.events = event || !chain.in_order || plan->config.profiling;
  for (int i = (int)first; i <= (int)last && status == HBIL_SUCCESS; ++i) {
    chain.pass = (hbil_pass)i;
    plan->left_out[i] = plan->may_leave_out[i] = false;
    status = passes[i].enqueue(&chain, &frame);
    if (status != HBIL_SUCCESS)
      plan->has_last = false; /* buffers may hold parts of this frame */
  }
  if (status == HBIL_SUCCESS)
    status = finish(&chain, event);
  if (chain.last)
    clReleaseEvent(chain.last);
  return status;
}

hbil_status hbil_enqueue_frame(hbil_plan *plan, cl_command_queue queue,
                               const hbil_frame *frame, cl_uint wait_count,
                               const cl_event *wait_list, cl_event *event) {
  return enqueue(plan, queue, frame, wait_count, wait_list, event,
                 HBIL_PASS_REPROJECT, HBIL_PASS_COMPOSITE);
}

#define PASS_FUNCTION(name, pass)                                              \
  hbil_status hbil_enqueue_##name(                                             \
      hbil_plan *plan, cl_command_queue queue, const hbil_frame *frame,        \
      cl_uint wait_count, const cl_event *wait_list, cl_event *event) {        \
    return enqueue(plan, queue, frame, wait_count, wait_list, event, pass,     \
                   pass);                                                      \
  }

PASS_FUNCTION(reproject, HBIL_PASS_REPROJECT)
PASS_FUNCTION(push_pull, HBIL_PASS_PUSH_PULL)
PASS_FUNCTION(split, HBIL_PASS_SPLIT)
PASS_FUNCTION(gather, HBIL_PASS_GATHER)
PASS_FUNCTION(recompose, HBIL_PASS_RECOMPOSE)
PASS_FUNCTION(temporal, HBIL_PASS_TEMPORAL)
PASS_FUNCTION(composite, HBIL_PASS_COMPOSITE)
