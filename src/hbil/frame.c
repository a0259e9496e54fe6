/* The order of the passes. */
#include "cache.h"
#include "checks.h"
#include "config.h"
#include "import.h"
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
            PLANE_BIT(PLANE_ERROR) | PLANE_BIT(PLANE_UNKNOWN) |
            PLANE_BIT(PLANE_GLOSSY)
};

static const struct {
  pass_function *enqueue;
  unsigned planes;
} passes[HBIL_PASS_COUNT] = {
    [HBIL_PASS_REPROJECT] = {enqueue_reproject, READ_BY_REPROJECT},
    [HBIL_PASS_PUSH_PULL] = {enqueue_push_pull, 0},
    [HBIL_PASS_SPLIT] = {enqueue_split, SURFACE | PLANE_BIT(PLANE_NORMAL)},
    [HBIL_PASS_GATHER] = {enqueue_gather, SURFACE & ~PLANE_BIT(PLANE_DEPTH)},
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

typedef struct pass_range {
  hbil_pass first, last;
} pass_range;

/* Enqueues passes as one chain of commands, for the public `function`. */
static hbil_status enqueue(const char *function, hbil_plan *plan,
                           cl_command_queue queue, const hbil_frame *given,
                           cl_uint wait_count, const cl_event *wait_list,
                           cl_event *event, pass_range range) {
  unsigned planes = 0;
  for (int i = (int)range.first; i <= (int)range.last; ++i)
    planes |= passes[i].planes;
  hbil_frame frame, staged;
  hbil_status status =
      check_arguments(plan, function, queue, given, wait_count, wait_list);
  if (status != HBIL_SUCCESS)
    return status;
  commands chain = commands_of_plan(plan, queue);
  status = check_queue(plan, queue, &chain.in_order);
  if (status == HBIL_SUCCESS)
    status = frame_take(plan->context, given, &frame);
  if (status == HBIL_SUCCESS)
    status = check_frame(plan, &frame, planes);
  if (status != HBIL_SUCCESS)
    return status;
  chain.events = event || !chain.in_order || plan->config.execution.profiling;
  chain.line[1] = frame.cache ? &frame.cache->line : NULL;
  if (range.first == HBIL_PASS_REPROJECT)
    forget_timings(plan);
  staged = staged_frame(plan, &frame);
  status = begin_commands(&chain, wait_count, wait_list);
  if (status == HBIL_SUCCESS)
    status = enqueue_import(&chain, &frame, &staged, planes);
  for (int i = (int)range.first; i <= (int)range.last && status == HBIL_SUCCESS;
       ++i) {
    chain.pass = (hbil_pass)i;
    plan->left_out[i] = plan->may_leave_out[i] = false;
    status = passes[i].enqueue(&chain, &staged);
  }
  if (status == HBIL_SUCCESS)
    status = enqueue_export(&chain, &frame, planes);
  if (status != HBIL_SUCCESS)
    plan->has_last = false; /* buffers may hold parts of a failed frame */
  else if (range.last == HBIL_PASS_COMPOSITE)
    remember_frame(plan, &frame);
  if (status == HBIL_SUCCESS)
    status = finish_commands(&chain, event);
  end_commands(&chain);
  return status;
}

hbil_status hbil_enqueue_frame(hbil_plan *plan, cl_command_queue queue,
                               const hbil_frame *frame, cl_uint wait_count,
                               const cl_event *wait_list, cl_event *event) {
  const pass_range all = {HBIL_PASS_REPROJECT, HBIL_PASS_COMPOSITE};
  return enqueue(__func__, plan, queue, frame, wait_count, wait_list, event,
                 all);
}

#define PASS_FUNCTION(name, pass)                                              \
  hbil_status hbil_enqueue_##name(                                             \
      hbil_plan *plan, cl_command_queue queue, const hbil_frame *frame,        \
      cl_uint wait_count, const cl_event *wait_list, cl_event *event) {        \
    const pass_range one = {pass, pass};                                       \
    return enqueue(__func__, plan, queue, frame, wait_count, wait_list, event, \
                   one);                                                       \
  }

PASS_FUNCTION(reproject, HBIL_PASS_REPROJECT)
PASS_FUNCTION(push_pull, HBIL_PASS_PUSH_PULL)
PASS_FUNCTION(split, HBIL_PASS_SPLIT)
PASS_FUNCTION(gather, HBIL_PASS_GATHER)
PASS_FUNCTION(recompose, HBIL_PASS_RECOMPOSE)
PASS_FUNCTION(temporal, HBIL_PASS_TEMPORAL)
PASS_FUNCTION(composite, HBIL_PASS_COMPOSITE)
