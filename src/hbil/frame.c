/* Enqueues the passes of a frame, after checks of what the caller hands in. */
#include <math.h>
#include <string.h>

#include "cache.h"
#include "cache_config.h"
#include "camera.h"
#include "checks.h"
#include "config.h"
#include "hbil/hbil_stages.h"
#include "passes.h"

/* --- checks --- */

static hbil_status check_far_field(const hbil_plan *plan,
                                   const hbil_frame *frame) {
  const hbil_status status = check_environment(
      plan->context, HBIL_INVALID_FRAME, plan->config.model.far_field,
      (const float(*)[3])frame->environment);
  if (status != HBIL_SUCCESS)
    return status;
  if (plan->config.model.far_field == HBIL_FAR_FRAME &&
      !(frame->sky_share >= 0.0f && frame->sky_share <= 1.0f))
    return fail(plan->context, HBIL_INVALID_FRAME,
                "sky_share: %g; must be in 0 .. 1", (double)frame->sky_share);
  return HBIL_SUCCESS;
}

/* What can be checked of static_frame. */
static hbil_status check_still(const hbil_plan *plan, const hbil_frame *frame) {
  const hbil_status status = check_flag(plan->context, HBIL_INVALID_FRAME,
                                        "static_frame", frame->static_frame);
  if (status != HBIL_SUCCESS || !frame->static_frame || !plan->has_last)
    return status;
  if (memcmp(&frame->camera, &plan->last_camera, sizeof frame->camera))
    return fail(
        plan->context, HBIL_INVALID_FRAME,
        "static_frame: CL_TRUE, but camera is not that of the frame before");
  if (light_exposure(frame->exposure) != plan->last_exposure)
    return fail(plan->context, HBIL_INVALID_FRAME,
                "static_frame: CL_TRUE, but exposure is %g, that of the frame "
                "before was %g",
                (double)light_exposure(frame->exposure),
                (double)plan->last_exposure);
  if (frame->frame_index != plan->last_index)
    return fail(plan->context, HBIL_INVALID_FRAME,
                "static_frame: CL_TRUE, but frame_index is %u, that of the "
                "frame before was "
                "%u; one pattern is needed",
                (unsigned)frame->frame_index, (unsigned)plan->last_index);
  return HBIL_SUCCESS;
}

static hbil_status check_cache(const hbil_plan *plan, const hbil_frame *frame) {
  const hbil_cache_method method = plan->config.model.cache_method;
  if (!frame->cache)
    return HBIL_SUCCESS;
  if (method == HBIL_CACHE_METHOD_NONE)
    return fail(plan->context, HBIL_INVALID_FRAME,
                "cache: given, but the plan was made without "
                "model.cache_method (hbil_config_use_cache())");
  /* every cache has what rays need */
  if (method != HBIL_CACHE_METHOD_RAYS && method != frame->cache->config.method)
    return fail(plan->context, HBIL_INVALID_FRAME,
                "cache: its method is %s; the plan's model.cache_method is %s",
                cache_method_name(frame->cache->config.method),
                cache_method_name(method));
  if (frame->cache->context != plan->context)
    return fail(plan->context, HBIL_INVALID_FRAME,
                "cache: not of the plan's context");
  return HBIL_SUCCESS;
}

/* The frame and those of its planes. */
static hbil_status check_frame(hbil_plan *plan, const hbil_frame *frame,
                               unsigned planes) {
  const plane_rules rules = {plan->context, &plan->config, &plan->layout.staged,
                             "plan", plan->lent};
  hbil_status status = camera_check(plan->context, &frame->camera);
  if (status == HBIL_SUCCESS)
    status = check_cache(plan, frame);
  if (status == HBIL_SUCCESS)
    status = check_exposure(plan->context, HBIL_INVALID_FRAME, frame->exposure);
  if (status == HBIL_SUCCESS)
    status = check_still(plan, frame);
  if (status == HBIL_SUCCESS)
    status = check_far_field(plan, frame);
  return status == HBIL_SUCCESS ? check_planes(&rules, frame, planes) : status;
}

/* What is wrong with the arguments of `function`, before OpenCL is asked. */
static hbil_status check_arguments(hbil_plan *plan, const char *function,
                                   cl_command_queue queue,
                                   const hbil_frame *frame, cl_uint wait_count,
                                   const cl_event *wait_list) {
  if (!plan || !queue || !frame)
    return fail_null(plan ? plan->context : NULL, function,
                     !plan    ? "plan"
                     : !queue ? "queue"
                              : "frame");
  return check_wait_list(plan->context, function, wait_count, wait_list);
}

/* The light that this frame hands on falls by what the cache learns from now on
 * (fall.h). */
static void remember_cache(hbil_plan *plan, const hbil_cache *cache) {
  plan->last_cache = cache;
  plan->last_cache_changes = cache ? cache->changes : 0;
}

typedef struct pass_range {
  hbil_pass first, last;
} pass_range;

/* Enqueues passes as one chain of commands, for the public `function`. */
static hbil_status enqueue(const char *function, hbil_plan *plan,
                           cl_command_queue queue, const hbil_frame *given,
                           cl_uint wait_count, const cl_event *wait_list,
                           cl_event *event, pass_range range) {
  hbil_frame frame;
  hbil_status status =
      check_arguments(plan, function, queue, given, wait_count, wait_list);
  if (status != HBIL_SUCCESS)
    return status;
  commands chain = commands_of_plan(plan, queue);
  status = check_queue(plan->context, queue, plan->config.execution.profiling,
                       &chain.in_order);
  if (status == HBIL_SUCCESS)
    status = frame_take(plan->context, given, &frame);
  if (status == HBIL_SUCCESS)
    status = check_frame(plan, &frame,
                         planes_of_passes(plan, range.first, range.last));
  if (status != HBIL_SUCCESS)
    return status;
  chain.events = event || !chain.in_order || chain.times;
  chain.line[1] = frame.cache ? &frame.cache->line : NULL;
  hbil_plan *const followed = plan->followed; /* until its line is not needed */
  plan_retain(followed);
  chain.line[2] = followed ? &followed->line : NULL;
  if (range.first == HBIL_PASS_REPROJECT)
    forget_times(&plan->times);
  status = begin_commands(&chain, wait_count, wait_list);
  if (status == HBIL_SUCCESS)
    status = enqueue_passes(plan, &chain, &frame, range.first, range.last);
  if (status != HBIL_SUCCESS)
    plan->has_last = false; /* buffers may hold parts of a failed frame */
  else if (range.last == HBIL_PASS_COMPOSITE) {
    remember_frame(plan, &frame);
    remember_cache(plan, frame.cache);
  }
  if (status == HBIL_SUCCESS)
    status = finish_commands(&chain, event);
  end_commands(&chain);
  plan_release(followed);
  return status;
}

hbil_status hbil_enqueue_frame(hbil_plan *plan, cl_command_queue queue,
                               const hbil_frame *frame, cl_uint wait_count,
                               const cl_event *wait_list, cl_event *event) {
  const pass_range all = {HBIL_PASS_REPROJECT, HBIL_PASS_COMPOSITE};
  return enqueue(__func__, plan, queue, frame, wait_count, wait_list, event,
                 all);
}

hbil_status hbil_enqueue_passes(hbil_plan *plan, cl_command_queue queue,
                                const hbil_frame *frame, hbil_pass first,
                                hbil_pass last, cl_uint wait_count,
                                const cl_event *wait_list, cl_event *event) {
  const pass_range range = {first, last};
  if (plan && ((unsigned)first > (unsigned)last ||
               (unsigned)last > HBIL_PASS_COMPOSITE))
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "first, last: %d, %d; must be passes from HBIL_PASS_REPROJECT, "
                "%d, to HBIL_PASS_COMPOSITE, %d, in this order",
                (int)first, (int)last, (int)HBIL_PASS_REPROJECT,
                (int)HBIL_PASS_COMPOSITE);
  return enqueue(__func__, plan, queue, frame, wait_count, wait_list, event,
                 range);
}
