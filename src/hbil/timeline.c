/* See timeline.h. */
#include "timeline.h"

/* --- the order of calls --- */

/* Makes an event that follows all earlier commands, in line->tail. */
static hbil_status make_tail(const commands *chain, timeline *line) {
  if (line->tail)
    return HBIL_SUCCESS;
  const cl_int error =
      clEnqueueMarkerWithWaitList(line->queue, 0, NULL, &line->tail);
  if (error == CL_SUCCESS)
    return HBIL_SUCCESS;
  line->tail = NULL;
  return fail_cl(chain->context, error, "clEnqueueMarkerWithWaitList");
}

/* Takes the queue for a timeline, and lets the first command wait for its
 * earlier commands where the queue doesn't. */
static hbil_status join(commands *chain, int which) {
  timeline *line = chain->line[which];
  const bool same = line->queue == chain->queue;
  if (same && line->in_order)
    return HBIL_SUCCESS;
  if (!same) {
    const cl_int error = clRetainCommandQueue(chain->queue);
    if (error != CL_SUCCESS)
      return fail_cl(chain->context, error, "clRetainCommandQueue");
    chain->retained[which] = true;
  }
  if (!line->queue)
    return HBIL_SUCCESS;
  const hbil_status status = make_tail(chain, line);
  if (status != HBIL_SUCCESS)
    return status;
  /* commands that nobody flushes need not ever begin, and the other queue would
   * wait for them */
  const cl_int error = same ? CL_SUCCESS : clFlush(line->queue);
  if (error != CL_SUCCESS)
    return fail_cl(chain->context, error, "clFlush");
  chain->before[chain->befores++] = line->tail;
  return HBIL_SUCCESS;
}

hbil_status begin_commands(commands *chain, cl_uint wait_count,
                           const cl_event *wait_list) {
  hbil_status status = HBIL_SUCCESS;
  chain->wait_count = wait_count;
  chain->wait_list = wait_list;
  for (int i = 0; i < LINES && status == HBIL_SUCCESS; ++i)
    if (chain->line[i])
      status = join(chain, i);
  if (status != HBIL_SUCCESS || !chain->befores)
    return status;
  /* The tails and the caller's list can't become one list, which has any
   * length, without allocating memory. */
  if (wait_count) {
    const cl_int error = clEnqueueMarkerWithWaitList(chain->queue, wait_count,
                                                     wait_list, &chain->marker);
    if (error != CL_SUCCESS) {
      chain->marker = NULL;
      return fail_cl(chain->context, error, "clEnqueueMarkerWithWaitList");
    }
    chain->before[chain->befores++] = chain->marker;
  }
  chain->wait_count = chain->befores;
  chain->wait_list = chain->before;
  return HBIL_SUCCESS;
}

/* Makes the chain's commands a timeline's last ones. */
static void leave(commands *chain, int which) {
  timeline *line = chain->line[which];
  if (chain->retained[which] && line->queue)
    clReleaseCommandQueue(line->queue);
  if (line->tail)
    clReleaseEvent(line->tail);
  line->queue = chain->queue;
  line->in_order = chain->in_order;
  /* A tail that can't be retained is made anew when it is needed. */
  line->tail = chain->last && clRetainEvent(chain->last) == CL_SUCCESS
                   ? chain->last
                   : NULL;
}

void end_commands(commands *chain) {
  if (chain->marker)
    clReleaseEvent(chain->marker);
  /* An in-order queue needs no event until another queue comes. */
  if (chain->in_order && chain->last) {
    clReleaseEvent(chain->last);
    chain->last = NULL;
  }
  for (int i = 0; i < LINES; ++i) {
    if (!chain->line[i])
      continue;
    if (chain->enqueued)
      leave(chain, i);
    else if (chain->retained[i])
      clReleaseCommandQueue(chain->queue);
  }
  if (chain->last)
    clReleaseEvent(chain->last);
  chain->last = NULL;
}

void timeline_end(timeline *line) {
  if (line->tail)
    clReleaseEvent(line->tail);
  if (line->queue)
    clReleaseCommandQueue(line->queue);
}

/* --- commands --- */

/* Notes a command that has been enqueued with `event`. */
static void follow(commands *chain, cl_event event) {
  chain->enqueued = true;
  if (chain->last)
    clReleaseEvent(chain->last);
  chain->last = event;
  chain->wait_count = 0;
  chain->wait_list = NULL;
  if (!chain->in_order) {
    chain->wait_count = 1;
    chain->wait_list = &chain->last;
  }
}

/* follow() for a command whose time somebody may ask for. */
static void follow_timed(commands *chain, cl_event event) {
  command_times *times = chain->times;
  follow(chain, event);
  if (!event || !times || times->count == MOST_TIMED)
    return;
  /* the command runs all the same: timings alone are lost */
  const cl_int error = clRetainEvent(event);
  if (error != CL_SUCCESS) {
    times->error = error;
    warn(chain->context,
         "clRetainEvent: %s (%d); hbil_plan_timings() will fail for this frame",
         cl_error_name(error), (int)error);
    return;
  }
  times->events[times->count] = event;
  times->owner[times->count++] = chain->owner;
}

void forget_times(command_times *times) {
  for (int i = 0; i < times->count; ++i)
    clReleaseEvent(times->events[i]);
  times->count = 0;
  times->error = CL_SUCCESS;
}

/* Later commands wait for what the chain waits for. */
static hbil_status enqueue_marker(commands *chain) {
  cl_event event = NULL;
  const cl_int error = clEnqueueMarkerWithWaitList(
      chain->queue, chain->wait_count, chain->wait_list,
      chain->events ? &event : NULL);
  if (error != CL_SUCCESS)
    return fail_cl(chain->context, error, "clEnqueueMarkerWithWaitList");
  follow(chain, event);
  return HBIL_SUCCESS;
}

hbil_status finish_commands(commands *chain, cl_event *event) {
  if (!chain->enqueued && (event || chain->wait_count)) {
    const hbil_status status = enqueue_marker(chain);
    if (status != HBIL_SUCCESS)
      return status;
  }
  if (!event)
    return HBIL_SUCCESS;
  *event = chain->last;
  /* Only other queues than in-order ones need it later.  If it can't be
   * retained, they wait for everything that is in the queue. */
  if (chain->in_order || clRetainEvent(chain->last) != CL_SUCCESS)
    chain->last = NULL;
  return HBIL_SUCCESS;
}

static size_t groups_up(size_t n, size_t group) {
  return (n + group - 1) / group * group;
}

static hbil_status fail_kernel(const commands *chain, cl_int error,
                               const char *call, int kernel) {
  return fail_cl(chain->context, error, "%s(%s)", call,
                 chain->kernels->table->kernels[kernel].name);
}

/* Sets the arguments of a kernel. */
static hbil_status set_arguments(const commands *chain, int kernel,
                                 const argument *args, cl_uint count) {
  /* every device of OpenCL 1.2 has room for so many bytes of arguments */
  static const unsigned char zeros[1024];
  for (cl_uint i = 0; i < count; ++i) {
    const bool is_zero = chain->trial && !args[i].is_memory;
    const cl_int error =
        is_zero && args[i].size > sizeof zeros
            ? CL_INVALID_ARG_SIZE
            : clSetKernelArg(chain->kernels->kernels[kernel], i, args[i].size,
                             is_zero ? zeros : args[i].value);
    if (error != CL_SUCCESS)
      return fail_kernel(chain, error, "clSetKernelArg", kernel);
  }
  return HBIL_SUCCESS;
}

hbil_status launch_kernel(commands *chain, int kernel, const argument *args,
                          cl_uint count, size_t x, size_t y, size_t z) {
  hbil_context *context = chain->context;
  const size_t *group = context->group;
  const size_t local[3] = {group[0], group[1], 1};
  const size_t global[3] = {groups_up(x, group[0]), groups_up(y, group[1]), z};
  cl_event event = NULL;
  if (chain->trial) {
    if (chain->trial->launched[kernel])
      return HBIL_SUCCESS;
    chain->trial->launched[kernel] = true;
  }
  const hbil_status status = set_arguments(chain, kernel, args, count);
  if (status != HBIL_SUCCESS)
    return status;
  const cl_int error = clEnqueueNDRangeKernel(
      chain->queue, chain->kernels->kernels[kernel], 3, NULL, global, local,
      chain->wait_count, chain->wait_list, chain->events ? &event : NULL);
  if (error != CL_SUCCESS)
    return fail_kernel(chain, error, "clEnqueueNDRangeKernel", kernel);
  follow_timed(chain, event);
  return HBIL_SUCCESS;
}

hbil_status fill_memory(commands *chain, cl_mem memory, cl_uint word,
                        size_t offset, size_t bytes) {
  cl_event event = NULL;
  if (chain->trial)
    return HBIL_SUCCESS;
  const cl_int error = clEnqueueFillBuffer(
      chain->queue, memory, &word, sizeof word, offset, bytes,
      chain->wait_count, chain->wait_list, chain->events ? &event : NULL);
  if (error != CL_SUCCESS)
    return fail_cl(chain->context, error, "clEnqueueFillBuffer");
  follow_timed(chain, event);
  return HBIL_SUCCESS;
}

hbil_status read_memory(const commands *chain, cl_mem memory, size_t bytes,
                        void *out) {
  const cl_int error =
      clEnqueueReadBuffer(chain->queue, memory, CL_TRUE, 0, bytes, out,
                          chain->wait_count, chain->wait_list, NULL);
  return error == CL_SUCCESS
             ? HBIL_SUCCESS
             : fail_cl(chain->context, error, "clEnqueueReadBuffer");
}

/* --- first commands --- */

hbil_status run_first_commands(hbil_context *context, first_commands *enqueue,
                               void *object) {
  cl_int error = CL_SUCCESS;
  cl_command_queue queue =
      clCreateCommandQueue(context->context, context->device, 0, &error);
  if (!queue)
    return fail_cl(context, error, "clCreateCommandQueue");
  const hbil_status status = enqueue(object, queue);
  error = clFinish(queue);
  clReleaseCommandQueue(queue);
  return status == HBIL_SUCCESS && error != CL_SUCCESS
             ? fail_cl(context, error, "clFinish")
             : status;
}
