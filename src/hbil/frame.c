/* The order of the passes. */
#include "checks.h"
#include "config.h"
#include "passes.h"
#include "planes.h"

/* The planes that each pass reads or writes. */
enum {
  READ_BY_REPROJECT = PLANE_BIT(PLANE_DEPTH) | PLANE_BIT(PLANE_MOTION),
  SURFACE = PLANE_BIT(PLANE_DEPTH) | PLANE_BIT(PLANE_ALBEDO) |
            PLANE_BIT(PLANE_F0) | PLANE_BIT(PLANE_DIRECT) |
            PLANE_BIT(PLANE_EMISSION),
  OUTPUTS = PLANE_BIT(PLANE_NEAR) | PLANE_BIT(PLANE_FAR) | PLANE_BIT(PLANE_AO) |
            PLANE_BIT(PLANE_BENT) | PLANE_BIT(PLANE_CONE) |
            PLANE_BIT(PLANE_INDIRECT) | PLANE_BIT(PLANE_BEAUTY) |
            PLANE_BIT(PLANE_ERROR)
};

static const struct {
  pass_function *enqueue;
  unsigned planes;
} passes[HBIL_PASS_COUNT] = {
    [HBIL_PASS_REPROJECT] = {enqueue_reproject, READ_BY_REPROJECT},
    [HBIL_PASS_PUSH_PULL] = {enqueue_push_pull, 0},
    [HBIL_PASS_SPLIT] = {enqueue_split, SURFACE | PLANE_BIT(PLANE_NORMAL)},
    [HBIL_PASS_GATHER] = {enqueue_gather, 0},
    [HBIL_PASS_RECOMPOSE] = {enqueue_recompose, 0},
    [HBIL_PASS_TEMPORAL] = {enqueue_temporal, PLANE_BIT(PLANE_MOTION)},
    [HBIL_PASS_COMPOSITE] = {enqueue_composite, SURFACE | OUTPUTS},
};

/* Drops the events of the last frame, when a frame's first pass begins. */
static void forget_timings(hbil_plan *plan) {
  for (int i = 0; i < plan->launches; ++i)
    clReleaseEvent(plan->events[i]);
  plan->launches = 0;
  plan->events_error = CL_SUCCESS;
}

/* Gives the caller the last command's event, or one that follows the wait list
 * if nothing had to be enqueued. */
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

/* Enqueues the passes first..last as one chain of commands. */
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
  unsigned planes = 0;
  for (int i = (int)first; i <= (int)last; ++i)
    planes |= passes[i].planes;
  commands chain = {.plan = plan,
                    .queue = queue,
                    .wait_count = wait_count,
                    .wait_list = wait_list};
  hbil_frame frame;
  hbil_status status = check_queue(plan, queue, &chain.in_order);
  if (status == HBIL_SUCCESS)
    status = frame_take(plan->context, given, &frame);
  if (status == HBIL_SUCCESS)
    status = check_frame(plan, &frame, planes);
  chain.events = event || !chain.in_order || plan->config.execution.profiling;
  for (int i = (int)first; i <= (int)last && status == HBIL_SUCCESS; ++i) {
    chain.pass = (hbil_pass)i;
    if (i == HBIL_PASS_REPROJECT)
      forget_timings(plan);
    plan->left_out[i] = plan->may_leave_out[i] = false;
    status = passes[i].enqueue(&chain, &frame);
    if (status != HBIL_SUCCESS)
      plan->has_last = false; /* buffers may hold parts of a failed frame */
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
