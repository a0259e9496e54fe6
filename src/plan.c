/* A plan: the kernels and buffers of one configuration. */
#include "internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- build defines --- */

typedef struct text {
  char chars[MOST_DEFINES];
  size_t length;
} text;

static void add(text *t, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;
static void add(text *t, const char *format, ...) {
  va_list args;
  va_start(args, format);
  const int n = vsnprintf(t->chars + t->length, sizeof t->chars - t->length,
                          format, args);
  va_end(args);
  if (n > 0)
    t->length += (size_t)n;
  if (t->length >= sizeof t->chars)
    t->length = sizeof t->chars - 1;
}

/* Everything that changes machine code, as -D options. */
static void write_defines(const hbil_plan *plan, text *t) {
  static const char *const types[] = {"none", "f32", "f16", "u8"};
  const hbil_config *c = &plan->config;
  const bool refuses = config_refuses(c);
  add(t, "-DHBIL_WIDTH=%u", (unsigned)c->vector_width);
  for (int i = 0; i < PLANE_COUNT; ++i) {
    const hbil_plane_format *format = config_format(c, i);
    const char *name = plane_kinds[i].define;
    add(t, " -D%s_%s=%d", i < PLANE_FIRST_OUTPUT ? "HAS" : "OUT", name,
        format->component != HBIL_NONE);
    if (format->component != HBIL_NONE)
      add(t, " -D%s_TYPE=%s -D%s_STRIDE=%uu", name, types[format->component],
          name, (unsigned)format_stride(c, i));
  }
  add(t, " -DORTHOGRAPHIC=%d -DWHOLE_GROUPS=%d",
      c->projection == HBIL_PROJECTION_ORTHOGRAPHIC,
      c->width % (4 * c->vector_width) == 0);
  add(t, " -DDEPTH_IS_RAY=%d -DNORMAL_IS_WORLD=%d -DBENT_IS_WORLD=%d",
      c->depth_kind == HBIL_DEPTH_RAY, c->normal_space == HBIL_SPACE_WORLD,
      c->bent_normal_space == HBIL_SPACE_WORLD);
  add(t, " -DLIMITED=%d -DLEVELS=%d", !isinf(c->radius),
      (int)plan->layout.pattern.levels);
  add(t, " -DFACING_STEP=%d -DFACING_ALL=%d",
      c->facing_fade[0] >= c->facing_fade[1], !refuses);
  add(t, " -DFALLBACK_LAST_ACCEPTED=%d -DRAW=%d",
      refuses && c->back_facing_fallback == HBIL_FALLBACK_LAST_ACCEPTED,
      c->unfiltered != 0);
  add(t, " -DGATHER_EMISSION=%d -DFEEDBACK_RADIANCE=%d -DREPROJECT_MOTION=%d",
      c->gather_emission != 0, c->feedback == HBIL_FEEDBACK_RADIANCE,
      c->reprojection == HBIL_REPROJECTION_MOTION);
  add(t, " -DDISOCCLUSION=%d -DFAR=%d", !isinf(c->disocclusion_threshold),
      (int)plan->layout.far_field);
  add(t, " -DFINITE=%d",
      (isinf(c->relative_thickness) ? 0 : 1) | (isinf(c->thickness) ? 0 : 2));
  add(t, " -DEXTRAPOLATE=%d -DADAPTIVE=%d", c->extrapolate != 0,
      plan->layout.ladder.count > 0);
  add(t, " -DERROR_PLANE=%u -DWEIGHT_PLANE=%u -DLINE=%u",
      (unsigned)plan->layout.error_plane, (unsigned)plan->layout.weight_plane,
      (unsigned)plan->layout.line);
  add(t, " -DSTORAGE=%d", (int)c->storage);
  add(t, " -DFALLBACK_FRAME_MEAN=%d -DHBAO=%d", plan->layout.unknown,
      c->mode == HBIL_MODE_HBAO);
  static const struct {
    const char *name;
    cl_uint bit;
  } skips[] = {{"SKY", HBIL_SKIP_SKY},
               {"OPEN", HBIL_SKIP_OPEN},
               {"DARK", HBIL_SKIP_DARK},
               {"UNUSED", HBIL_SKIP_UNUSED},
               {"RADIUS", HBIL_SKIP_RADIUS}};
  for (size_t i = 0; i < sizeof skips / sizeof *skips; ++i)
    add(t, " -DSKIP_%s=%d", skips[i].name,
        (plan->layout.skip & skips[i].bit) != 0);
  add(t, " -DGATHER_RADIANCE=%d -DGATHER_BENT=%d -DHISTORY=%d",
      plan->layout.radiance, plan->layout.bent, plan->layout.history);
}

/* --- programs and kernels --- */

enum {
  PROGRAM_REPROJECT,
  PROGRAM_PUSH_PULL,
  PROGRAM_CLEAR,
  PROGRAM_SPLIT,
  PROGRAM_BOUNDS,
  PROGRAM_ESTIMATE,
  PROGRAM_PATTERN,
  PROGRAM_GATHER,
  PROGRAM_GATHER_FACTORS,
  PROGRAM_REGATHER,
  PROGRAM_JUDGE,
  PROGRAM_RECOMPOSE,
  PROGRAM_TEMPORAL,
  PROGRAM_COMPOSITE
};

static const program_kind programs[PROGRAM_COUNT] = {
    [PROGRAM_REPROJECT] = {"reproject", .images = true, .places = true},
    [PROGRAM_PUSH_PULL] = {"push_pull", .images = false},
    [PROGRAM_CLEAR] = {"clear", .images = false},
    [PROGRAM_SPLIT] = {"split", .images = true},
    [PROGRAM_BOUNDS] = {"bounds", .images = false},
    [PROGRAM_ESTIMATE] = {"estimate", .images = false},
    [PROGRAM_PATTERN] = {"pattern", .images = false},
    [PROGRAM_GATHER] = {"gather", .fast = true, .factors = true},
    [PROGRAM_GATHER_FACTORS] = {"gather", .fast = true, .factors = true,
                                .defines = " -DKEEP_FACTORS=1"},
    [PROGRAM_REGATHER] = {"regather", .fast = true, .factors = true},
    [PROGRAM_JUDGE] = {"judge", .guide = true},
    [PROGRAM_RECOMPOSE] = {"recompose", .fast = true, .guide = true},
    [PROGRAM_TEMPORAL] = {"temporal", .images = true, .places = true},
    [PROGRAM_COMPOSITE] = {"composite", .images = true},
};

static const struct {
  const char *name;
  int program;
} kernels[KERNEL_COUNT] = {
    [KERNEL_SCATTER_ROWS] = {"scatter_rows", PROGRAM_REPROJECT},
    [KERNEL_SCATTER_BANDS] = {"scatter_bands", PROGRAM_REPROJECT},
    [KERNEL_SCATTER_DEPTH] = {"scatter_depth", PROGRAM_REPROJECT},
    [KERNEL_SCATTER_INDEX] = {"scatter_index", PROGRAM_REPROJECT},
    [KERNEL_SCATTER_FETCH] = {"scatter_fetch", PROGRAM_REPROJECT},
    [KERNEL_FOLLOW_MOTION] = {"follow_motion", PROGRAM_REPROJECT},
    [KERNEL_FIND_HOLES] = {"find_holes", PROGRAM_PUSH_PULL},
    [KERNEL_PUSH] = {"push", PROGRAM_PUSH_PULL},
    [KERNEL_PULL] = {"pull", PROGRAM_PUSH_PULL},
    [KERNEL_CLEAR_LAYERS] = {"clear_layers", PROGRAM_CLEAR},
    [KERNEL_SPLIT] = {"split", PROGRAM_SPLIT},
    [KERNEL_RELIGHT] = {"relight", PROGRAM_SPLIT},
    [KERNEL_BOUND_CELLS] = {"bound_cells", PROGRAM_BOUNDS},
    [KERNEL_BOUND_QUADRANTS] = {"bound_quadrants", PROGRAM_BOUNDS},
    [KERNEL_ESTIMATE_PART] = {"estimate_part", PROGRAM_ESTIMATE},
    [KERNEL_ESTIMATE_SUM] = {"estimate_sum", PROGRAM_ESTIMATE},
    [KERNEL_PATTERN] = {"make_pattern", PROGRAM_PATTERN},
    [KERNEL_GATHER] = {"gather", PROGRAM_GATHER},
    [KERNEL_GATHER_FACTORS] = {"gather", PROGRAM_GATHER_FACTORS},
    [KERNEL_REGATHER] = {"regather", PROGRAM_REGATHER},
    [KERNEL_JUDGE_RULER] = {"judge_ruler", PROGRAM_JUDGE},
    [KERNEL_JUDGE_RUNG] = {"judge_rung", PROGRAM_JUDGE},
    [KERNEL_RECOMPOSE] = {"recompose", PROGRAM_RECOMPOSE},
    [KERNEL_TEMPORAL] = {"temporal", PROGRAM_TEMPORAL},
    [KERNEL_COMPOSITE] = {"composite", PROGRAM_COMPOSITE},
};

static bool program_needed(const hbil_plan *plan, int program) {
  if (program == PROGRAM_ESTIMATE)
    return plan->layout.estimate;
  if (program == PROGRAM_BOUNDS)
    return plan->layout.bytes[BUFFER_BOUNDS] > 0;
  if (program == PROGRAM_JUDGE)
    return plan->layout.ladder.count > 0;
  if (program == PROGRAM_GATHER_FACTORS || program == PROGRAM_REGATHER)
    return plan->layout.bytes[BUFFER_FACTORS] > 0;
  if (program == PROGRAM_TEMPORAL)
    return plan->config.max_history_frames > 0;
  return plan->layout.history ||
         (program != PROGRAM_REPROJECT && program != PROGRAM_PUSH_PULL);
}

static bool kernel_needed(const hbil_plan *plan, int kernel) {
  const bool motion = plan->config.reprojection == HBIL_REPROJECTION_MOTION;
  if (kernel == KERNEL_FOLLOW_MOTION)
    return plan->layout.history && motion;
  if (kernel == KERNEL_RELIGHT)
    return plan->layout.history && plan->layout.skip & HBIL_SKIP_STILL;
  if (kernel > KERNEL_SCATTER_FETCH)
    return program_needed(plan, kernels[kernel].program);
  if (!plan->layout.history || motion)
    return false;
  return layout_has_bands(&plan->config) ==
         (kernel == KERNEL_SCATTER_ROWS || kernel == KERNEL_SCATTER_BANDS);
}

static hbil_status build_kernels(hbil_plan *plan) {
  text defines = {.length = 0};
  write_defines(plan, &defines);
  for (int i = 0; i < PROGRAM_COUNT; ++i) {
    if (!program_needed(plan, i))
      continue;
    const hbil_status status = program_build(plan->context, &programs[i],
                                             defines.chars, &plan->programs[i]);
    if (status != HBIL_SUCCESS)
      return status;
  }
  for (int i = 0; i < KERNEL_COUNT; ++i) {
    cl_int error = CL_SUCCESS;
    if (!kernel_needed(plan, i))
      continue;
    plan->kernels[i] = clCreateKernel(plan->programs[kernels[i].program],
                                      kernels[i].name, &error);
    if (!plan->kernels[i])
      return fail_cl(plan->context, error, "clCreateKernel");
  }
  return HBIL_SUCCESS;
}

/* --- buffers --- */

/* The most bytes that the device has in one buffer. */
static hbil_status largest_buffer(hbil_context *context, cl_ulong *bytes) {
  const cl_int error =
      clGetDeviceInfo(context->device, CL_DEVICE_MAX_MEM_ALLOC_SIZE,
                      sizeof *bytes, bytes, NULL);
  return error == CL_SUCCESS ? HBIL_SUCCESS
                             : fail_cl(context, error, "clGetDeviceInfo");
}

static hbil_status allocate(hbil_plan *plan) {
  cl_ulong most = 0;
  cl_int error = CL_SUCCESS;
  const hbil_status status = largest_buffer(plan->context, &most);
  if (status != HBIL_SUCCESS)
    return status;
  for (int i = 0; i < BUFFER_COUNT; ++i) {
    const size_t bytes = plan->layout.bytes[i];
    if (bytes > most)
      return fail(plan->context, HBIL_OUT_OF_DEVICE_MEMORY,
                  "a buffer of %zu bytes is needed, the device allows %llu",
                  bytes, (unsigned long long)most);
    if (!bytes)
      continue;
    plan->buffers[i] = clCreateBuffer(plan->context->context, CL_MEM_READ_WRITE,
                                      bytes, NULL, &error);
    if (!plan->buffers[i])
      return fail_cl(plan->context, error, "clCreateBuffer");
  }
  return HBIL_SUCCESS;
}

/* "Nothing there" in all layers. */
static cl_int clear_layers(hbil_plan *plan, cl_command_queue queue) {
  const hbil_layer_args *layers = &plan->layout.split;
  const cl_kernel kernel = plan->kernels[KERNEL_CLEAR_LAYERS];
  const size_t *group = plan->context->group;
  const size_t rows = HBIL_LAYERS * ((size_t)layers->height + 2);
  const size_t global[2] = {(rows + group[0] - 1) / group[0] * group[0],
                            group[1]};
  cl_int error =
      clSetKernelArg(kernel, 0, sizeof(cl_mem), &plan->buffers[BUFFER_SPLIT]);
  if (error == CL_SUCCESS)
    error = clSetKernelArg(kernel, 1, sizeof *layers, layers);
  if (error == CL_SUCCESS)
    error = clEnqueueNDRangeKernel(queue, kernel, 2, NULL, global, group, 0,
                                   NULL, NULL);
  return error;
}

/* Padding left of, above and below the layers is written once, here: no kernel
 * touches it later.  Nor are counts of what a plan never looks at, nor what
 * rungs come to where the caller has put a pass in the gather's place.  The
 * waiting is done by clFinish on a queue of our own. */
static hbil_status fill_padding(hbil_plan *plan) {
  static const int buffers[] = {BUFFER_SPLIT, BUFFER_LIGHT, BUFFER_SANITIZED,
                                BUFFER_TRIED};
  const cl_float zero = 0.0f;
  cl_int error = CL_SUCCESS;
  cl_command_queue queue = clCreateCommandQueue(
      plan->context->context, plan->context->device, 0, &error);
  if (!queue)
    return fail_cl(plan->context, error, "clCreateCommandQueue");
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; ++i)
    if (plan->buffers[buffers[i]] && error == CL_SUCCESS)
      error = clEnqueueFillBuffer(
          queue, plan->buffers[buffers[i]], &zero, sizeof zero, 0,
          plan->layout.bytes[buffers[i]], 0, NULL, NULL);
  if (error == CL_SUCCESS)
    error = clear_layers(plan, queue);
  /* at once: should waiting fail below, the plan is gone before its commands */
  if (error == CL_SUCCESS)
    error = clEnqueueWriteBuffer(queue, plan->buffers[BUFFER_LADDER], CL_TRUE,
                                 0, plan->layout.bytes[BUFFER_LADDER],
                                 plan->layout.ladder.rung, 0, NULL, NULL);
  const cl_int finished = clFinish(queue);
  clReleaseCommandQueue(queue);
  if (error == CL_SUCCESS)
    error = finished;
  return error == CL_SUCCESS
             ? HBIL_SUCCESS
             : fail_cl(plan->context, error, "filling the layers");
}

/* --- public --- */

/* The caller's config, checked, with the width that is chosen for the device
 * where it has none; the sky begins where kernels can't compute any more; form
 * factors are one buffer. */
static hbil_status resolve_config(hbil_context *context,
                                  const hbil_config *given,
                                  hbil_config *resolved) {
  cl_ulong most = 0;
  hbil_status status = config_take(context, given, resolved);
  if (status == HBIL_SUCCESS)
    status = largest_buffer(context, &most);
  if (!resolved->vector_width)
    resolved->vector_width = context->vector_width;
  if (resolved->horizon_cache_bytes > most)
    resolved->horizon_cache_bytes = (size_t)most;
  resolved->sky_depth = fminf(resolved->sky_depth, HBIL_FARTHEST_DEPTH);
  return status;
}

hbil_status hbil_plan_memory(hbil_context *context, const hbil_config *config,
                             size_t *bytes) {
  layout sizes;
  hbil_config resolved;
  if (!context || !config || !bytes)
    return HBIL_INVALID_ARGUMENT;
  const hbil_status status = resolve_config(context, config, &resolved);
  if (status != HBIL_SUCCESS)
    return status;
  layout_compute(&resolved, &sizes);
  *bytes = 0;
  for (int i = 0; i < BUFFER_COUNT; ++i)
    *bytes += sizes.bytes[i];
  return HBIL_SUCCESS;
}

hbil_status hbil_plan_create(hbil_context *context, const hbil_config *config,
                             hbil_plan **out) {
  if (out)
    *out = NULL;
  hbil_config resolved;
  if (!context || !config || !out)
    return HBIL_INVALID_ARGUMENT;
  hbil_status status = resolve_config(context, config, &resolved);
  if (status != HBIL_SUCCESS)
    return status;
  hbil_plan *plan = calloc(1, sizeof *plan);
  if (!plan)
    return fail(context, HBIL_OUT_OF_HOST_MEMORY, "no memory for a plan");
  plan->context = context;
  plan->config = resolved;
  layout_compute(&plan->config, &plan->layout);
  if ((status = build_kernels(plan)) != HBIL_SUCCESS ||
      (status = allocate(plan)) != HBIL_SUCCESS ||
      (status = fill_padding(plan)) != HBIL_SUCCESS) {
    hbil_plan_destroy(plan);
    return status;
  }
  *out = plan;
  return HBIL_SUCCESS;
}

void hbil_plan_destroy(hbil_plan *plan) {
  if (!plan)
    return;
  for (int i = 0; i < plan->launches; ++i)
    clReleaseEvent(plan->events[i]);
  for (int i = 0; i < KERNEL_COUNT; ++i)
    if (plan->kernels[i])
      clReleaseKernel(plan->kernels[i]);
  for (int i = 0; i < PROGRAM_COUNT; ++i)
    if (plan->programs[i])
      clReleaseProgram(plan->programs[i]);
  for (int i = 0; i < BUFFER_COUNT; ++i)
    if (plan->buffers[i])
      clReleaseMemObject(plan->buffers[i]);
  free(plan);
}

void hbil_plan_reset(hbil_plan *plan) {
  if (plan)
    plan->has_history = plan->has_last = plan->has_kept = false;
}

hbil_status hbil_plan_buffer(const hbil_plan *plan, hbil_stage stage,
                             hbil_buffer *out) {
  static const int of_stage[] = {
      BUFFER_HISTORY,  BUFFER_CARRIED,  BUFFER_SPLIT, BUFFER_LIGHT,
      BUFFER_RESOLVED, BUFFER_TEMPORAL, BUFFER_TRIED};
  if (!plan || !out || (unsigned)stage > HBIL_STAGE_CHOICE)
    return HBIL_INVALID_ARGUMENT;
  const layout *l = &plan->layout;
  const int buffer =
      of_stage[stage] + (stage == HBIL_STAGE_TEMPORAL_HISTORY ? plan->kept : 0);
  memset(out, 0, sizeof *out);
  if (!plan->buffers[buffer])
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "stage %d: this plan has no such buffer (no %s)", (int)stage,
                stage == HBIL_STAGE_CHOICE             ? "max_error"
                : stage == HBIL_STAGE_TEMPORAL_HISTORY ? "temporal filter"
                                                       : "history");
  out->buffer = plan->buffers[buffer];
  if (stage == HBIL_STAGE_CHOICE) {
    out->plane_pitch = out->row_pitch = 1;
    out->values = HBIL_MOST_RUNGS * HBIL_TRIED;
    return HBIL_SUCCESS;
  }
  if (stage == HBIL_STAGE_SPLIT || stage == HBIL_STAGE_GATHERED) {
    const hbil_layer_args *layers =
        stage == HBIL_STAGE_SPLIT ? &l->split : &l->light;
    out->plane_pitch = layers->plane;
    out->row_pitch = layers->row;
    out->layer_pitch = layers->layer;
    out->origin = layers->origin;
    out->values = layers->layer / layers->plane;
    return HBIL_SUCCESS;
  }
  out->plane_pitch = l->planes.plane;
  out->row_pitch = l->planes.row;
  if (stage == HBIL_STAGE_RESOLVED) {
    out->values =
        (cl_uint)(l->bytes[buffer] / (out->plane_pitch * sizeof(cl_float)));
    return HBIL_SUCCESS;
  }
  if (stage != HBIL_STAGE_CARRIED)
    out->origin = hbil_history_origin(l->planes);
  out->values =
      (cl_uint)((l->bytes[buffer] / sizeof(cl_float) - 2 * out->origin) /
                out->plane_pitch);
  if (stage == HBIL_STAGE_CARRIED) /* coarser levels follow */
    out->values = HBIL_CARRIED_PLANES;
  return HBIL_SUCCESS;
}

/* Adds one command's time to its pass. */
static hbil_status add_time(hbil_plan *plan, int launch, double *milliseconds) {
  cl_ulong start = 0, end = 0;
  const cl_event event = plan->events[launch];
  cl_int error = clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START,
                                         sizeof start, &start, NULL);
  if (error == CL_SUCCESS)
    error = clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof end,
                                    &end, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clGetEventProfilingInfo");
  milliseconds[plan->event_pass[launch]] += (double)(end - start) * 1e-6;
  return HBIL_SUCCESS;
}

hbil_status hbil_plan_timings(hbil_plan *plan,
                              double milliseconds[HBIL_PASS_COUNT]) {
  if (!plan || !milliseconds)
    return HBIL_INVALID_ARGUMENT;
  memset(milliseconds, 0, HBIL_PASS_COUNT * sizeof *milliseconds);
  if (!plan->config.profiling)
    return fail(plan->context, HBIL_INVALID_CONFIG,
                "profiling: CL_FALSE; timings need CL_TRUE");
  if (plan->events_error != CL_SUCCESS)
    return fail_cl(plan->context, plan->events_error, "clRetainEvent");
  if (!plan->launches)
    return HBIL_SUCCESS;
  const cl_int error = clWaitForEvents((cl_uint)plan->launches, plan->events);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clWaitForEvents");
  hbil_status status = HBIL_SUCCESS;
  for (int i = 0; i < plan->launches && status == HBIL_SUCCESS; ++i)
    status = add_time(plan, i, milliseconds);
  return status;
}
