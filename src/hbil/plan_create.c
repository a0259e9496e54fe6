/* Creates and destroys plans: their kernels and buffers. */
#include "plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "checks.h"
#include "config.h"
#include "defines.h"
#include "passes.h"
#include "searches.h"
#include "staging.h"

/* --- programs and kernels --- */

static const program_kind programs[] = {PLAN_PROGRAMS(LISTED_PROGRAM)};
static const kernel_kind kernels[] = {PLAN_KERNELS(LISTED_KERNEL)};
static const kernel_table table = {programs, kernels, PROGRAM_COUNT,
                                   KERNEL_COUNT};

static hbil_status build_kernels(hbil_plan *plan) {
  const hbil_config *c = &plan->config;
  const layout *l = &plan->layout;
  const hbil_cache_method method =
      l->probes ? c->model.cache_method : HBIL_CACHE_METHOD_NONE;
  const bool bounds = l->bytes[BUFFER_BOUNDS] > 0;
  const bool relights = l->history && l->skip & HBIL_SKIP_STATIC;
  const bool imports = l->staged.images & INPUT_PLANES;
  const bool exports = l->staged.images & ~INPUT_PLANES;
  const bool rebuilds_normals = l->staged.planes != l->staged.images;
  const bool needed_programs[] = {PLAN_PROGRAMS(PROGRAM_NEEDED)};
  const bool needed_kernels[] = {PLAN_KERNELS(KERNEL_NEEDED)};
  char defines[MOST_DEFINES];
  program_report_folder(plan->context);
  const hbil_status status =
      write_defines(plan->context, c, l, defines, sizeof defines);
  return status == HBIL_SUCCESS
             ? kernels_build(plan->context, &table, needed_programs,
                             needed_kernels, defines, &plan->kernels)
             : status;
}

/* --- buffers --- */

static hbil_status allocate(hbil_plan *plan) {
  const layout *l = &plan->layout;
  hbil_status status = HBIL_SUCCESS;
  for (int i = 0; i < BUFFER_COUNT && status == HBIL_SUCCESS; ++i)
    if (l->bytes[i])
      status =
          plan->lent.memory && layout_is_scratch(i)
              ? buffer_create_in(plan->context, &plan->lent, l->at[i],
                                 l->bytes[i], &plan->buffers[i])
              : buffer_create(plan->context, l->bytes[i], &plan->buffers[i]);
  return status;
}

/* --- the first commands --- */

/* Clears the padding of what frames hand on to each other. */
static hbil_status clear_slices(const hbil_plan *plan, commands *chain) {
  static const int buffers[] = {BUFFER_SLICES, BUFFER_SLICES_NEXT,
                                BUFFER_AO_SLICES, BUFFER_AO_SLICES_NEXT};
  hbil_status status = HBIL_SUCCESS;
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; ++i)
    if (plan->buffers[buffers[i]] && status == HBIL_SUCCESS)
      status = fill_memory(chain, plan->buffers[buffers[i]], 0, 0,
                           plan->layout.bytes[buffers[i]]);
  return status;
}

/* Writes what no kernel writes: counts of inputs that this plan never reads,
 * and the padding, which frames clear in scratch memory of the caller's. */
static hbil_status write_first(hbil_plan *plan, commands *chain) {
  hbil_status status = clear_counts(plan, chain, 0, HBIL_SANITIZED_WORDS);
  if (status == HBIL_SUCCESS)
    status = clear_slices(plan, chain);
  return status == HBIL_SUCCESS && !plan->lent.memory
             ? clear_padding(plan, chain)
             : status;
}

/* Frames whose passes launch every kernel that a plan has: the first one,
 * another one with light to carry over, and a static one. */
enum { TRIAL_FRAMES = 3, FIRST_STATIC = 2 };

/* Gives a trial frame an image of one pixel for each plane that is one, in the
 * format that OpenCL 1.2 demands; *image: NULL if there is none. */
static hbil_status make_image(const hbil_plan *plan, hbil_frame *frame,
                              cl_mem *image) {
  const cl_image_format format = {CL_RGBA, CL_FLOAT};
  const cl_image_desc pixel = {
      .image_type = CL_MEM_OBJECT_IMAGE2D, .image_width = 1, .image_height = 1};
  const unsigned images = plan->layout.staged.images;
  cl_int error = CL_SUCCESS;
  *image = NULL;
  if (!images)
    return HBIL_SUCCESS;
  *image = clCreateImage(plan->context->context, CL_MEM_READ_WRITE, &format,
                         &pixel, NULL, &error);
  if (!*image)
    return fail_cl(plan->context, error, "clCreateImage");
  const hbil_plane plane = {.buffer = *image};
  for (int i = 0; i < PLANE_COUNT; ++i)
    if (images & PLANE_BIT(i))
      memcpy((char *)frame + plane_kinds[i].plane_at, &plane, sizeof plane);
  return HBIL_SUCCESS;
}

/* Launches every kernel of the plan once, in the work-groups and with the
 * numbers of work-items of frames.  Nothing that frames read is changed. */
static hbil_status launch_every_kernel(hbil_plan *plan, commands *first) {
  const hbil_plan before = *plan;
  trial_launches trial = {.launched = {false}};
  commands chain = *first;
  hbil_frame frame;
  cl_mem image;
  hbil_frame_init(&frame);
  frame.camera.fx = frame.camera.fy = 1.0;
  for (int i = 0; i < 4; ++i)
    frame.camera.world_from_view[5 * i] = 1.0;
  hbil_status status = make_image(plan, &frame, &image);
  chain.trial = &trial;
  for (int i = 0; i < TRIAL_FRAMES && status == HBIL_SUCCESS; ++i) {
    frame.static_frame = i >= FIRST_STATIC;
    /* one by one, as callers may: push_pull looks for holes then */
    for (int pass = HBIL_PASS_REPROJECT;
         pass <= HBIL_PASS_COMPOSITE && status == HBIL_SUCCESS; ++pass)
      status = enqueue_passes(plan, &chain, &frame, (hbil_pass)pass,
                              (hbil_pass)pass);
    if (status == HBIL_SUCCESS)
      remember_frame(plan, &frame);
  }
  if (image)
    clReleaseMemObject(image); /* the commands retain it */
  *plan = before;
  return status;
}

/* Makes the plan ready for its first frame. */
static hbil_status prepare(void *object, cl_command_queue queue) {
  hbil_plan *plan = object;
  commands chain = commands_of_plan(plan, queue);
  chain.in_order = true;
  const hbil_status status = write_first(plan, &chain);
  return status == HBIL_SUCCESS ? launch_every_kernel(plan, &chain) : status;
}

/* --- public --- */

/* What a plan of the caller's config is: the config, checked and without
 * defaults, and the sizes.  If vector_width is 0, it is chosen for the device.
 * sky_depth is limited to HBIL_FARTHEST_DEPTH. */
static hbil_status lay_out(hbil_context *context, const hbil_config *given,
                           hbil_config *resolved, layout *sizes) {
  buffer_limits limits;
  staging staged;
  hbil_status status = config_take(context, given, resolved);
  if (status == HBIL_SUCCESS)
    status = stage_planes(context, resolved, &staged);
  if (status == HBIL_SUCCESS)
    status = memory_limits(context, &limits);
  if (status != HBIL_SUCCESS)
    return status;
  if (!resolved->execution.vector_width)
    resolved->execution.vector_width = context->vector_width;
  resolved->inputs.sky_depth =
      fminf(resolved->inputs.sky_depth, HBIL_FARTHEST_DEPTH);
  searches_settle(resolved);
  layout_compute(resolved, &staged, limits.alignment, sizes);
  if (resolved->model.ao_bounces && sizes->radiance)
    return fail(context, HBIL_INVALID_CONFIG,
                "model.ao_bounces: %d; must be HBIL_AO_BOUNCES_NONE where near "
                "light is computed, which has these bounces (HBIL_MODE_GTAO "
                "computes none)",
                (int)resolved->model.ao_bounces);
  for (int i = 0; i < BUFFER_COUNT; ++i)
    if (sizes->bytes[i] > limits.largest)
      return fail(context, HBIL_OUT_OF_DEVICE_MEMORY,
                  "width, height: %u x %u pixels need a buffer of %zu bytes, "
                  "the device allows %zu",
                  (unsigned)resolved->width, (unsigned)resolved->height,
                  sizes->bytes[i], limits.largest);
  return HBIL_SUCCESS;
}

hbil_status hbil_plan_memory(hbil_context *context, const hbil_config *config,
                             hbil_memory *out) {
  layout sizes;
  hbil_config resolved;
  if (!context || !config || !out)
    return fail_null(context, __func__,
                     !context  ? "context"
                     : !config ? "config"
                               : "out");
  const hbil_status status = lay_out(context, config, &resolved, &sizes);
  if (status == HBIL_SUCCESS)
    *out = sizes.memory;
  return status;
}

/* scratch: null, or the caller's */
static hbil_status create(hbil_context *context, const hbil_config *config,
                          cl_mem scratch, hbil_plan **out) {
  layout sizes;
  hbil_config resolved;
  memory_range lent = {NULL, 0, 0};
  hbil_status status = lay_out(context, config, &resolved, &sizes);
  if (status == HBIL_SUCCESS && scratch)
    status = check_lent(context, scratch, sizes.memory.scratch, &lent);
  if (status != HBIL_SUCCESS)
    return status;
  hbil_plan *plan = calloc(1, sizeof *plan);
  if (!plan)
    return fail(context, HBIL_OUT_OF_HOST_MEMORY, "no memory for a plan");
  plan->references = 1;
  plan->context = context;
  context_retain(context);
  plan->config = resolved;
  plan->layout = sizes;
  plan->lent = lent;
  if ((status = build_kernels(plan)) != HBIL_SUCCESS ||
      (status = build_ao_search(plan)) != HBIL_SUCCESS ||
      (status = allocate(plan)) != HBIL_SUCCESS ||
      (status = run_first_commands(context, prepare, plan)) != HBIL_SUCCESS) {
    hbil_plan_destroy(plan);
    return status;
  }
  kernels_share(context, &plan->kernels);
  kernels_share(context, &plan->ao.kernels);
  *out = plan;
  return HBIL_SUCCESS;
}

hbil_status hbil_plan_create(hbil_context *context, const hbil_config *config,
                             hbil_plan **out) {
  if (out)
    *out = NULL;
  if (!context || !config || !out)
    return fail_null(context, __func__,
                     !context  ? "context"
                     : !config ? "config"
                               : "out");
  return create(context, config, NULL, out);
}

hbil_status hbil_plan_create_in(hbil_context *context,
                                const hbil_config *config, cl_mem scratch,
                                hbil_plan **out) {
  if (out)
    *out = NULL;
  if (!context || !config || !scratch || !out)
    return fail_null(context, __func__,
                     !context   ? "context"
                     : !config  ? "config"
                     : !scratch ? "scratch"
                                : "out");
  return create(context, config, scratch, out);
}

void hbil_plan_destroy(hbil_plan *plan) {
  hbil_plan_reset(plan);
  plan_release(plan);
}
