/* The commands of one call: a chain, each waiting for the one before. */
#include "commands.h"

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
  if (chain->trial || !plan->config.execution.profiling ||
      plan->launches == MAX_LAUNCHES)
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

static size_t groups_up(size_t n, size_t group) {
  return (n + group - 1) / group * group;
}

/* Sets the arguments of a kernel.  In trial launches all values are 0: pictures
 * have no pixels, so no work-item has anything to do. */
static cl_int set_arguments(const commands *chain, cl_kernel kernel,
                            const argument *args, cl_uint count) {
  /* every device of OpenCL 1.2 has room for so many bytes of arguments */
  static const unsigned char zeros[1024];
  cl_int error = CL_SUCCESS;
  for (cl_uint i = 0; i < count && error == CL_SUCCESS; ++i)
    if (!chain->trial || args[i].is_memory)
      error = clSetKernelArg(kernel, i, args[i].size, args[i].value);
    else if (args[i].size > sizeof zeros)
      error = CL_INVALID_ARG_SIZE;
    else
      error = clSetKernelArg(kernel, i, args[i].size, zeros);
  return error;
}

/* Notes a trial launch; false if there was one like it. */
static bool is_first_launch(trial_launches *trial, int kernel, size_t top) {
  bool *launched = &trial->launched[kernel][top > 0];
  const bool first = !*launched;
  *launched = true;
  return first;
}

hbil_status launch_rows(commands *chain, int kernel, const argument *args,
                        cl_uint count, size_t top, size_t x, size_t y,
                        size_t z) {
  hbil_context *context = chain->plan->context;
  const cl_kernel launched = chain->plan->kernels[kernel];
  const size_t *group = context->group;
  const size_t local[3] = {group[0], group[1], 1};
  const size_t global[3] = {groups_up(x, group[0]), groups_up(y, group[1]), z};
  const size_t offset[3] = {0, top, 0};
  cl_event event = NULL;
  if (chain->trial && !is_first_launch(chain->trial, kernel, top))
    return HBIL_SUCCESS;
  cl_int error = set_arguments(chain, launched, args, count);
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clSetKernelArg");
  error = clEnqueueNDRangeKernel(chain->queue, launched, 3, offset, global,
                                 local, chain->wait_count, chain->wait_list,
                                 chain->events ? &event : NULL);
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clEnqueueNDRangeKernel");
  follow(chain, event);
  return HBIL_SUCCESS;
}

/* Fills `bytes` of a buffer from `offset` on with copies of a word. */
static hbil_status fill_part(commands *chain, int buffer, cl_uint word,
                             size_t offset, size_t bytes) {
  hbil_plan *plan = chain->plan;
  cl_event event = NULL;
  if (chain->trial)
    return HBIL_SUCCESS;
  const cl_int error = clEnqueueFillBuffer(
      chain->queue, plan->buffers[buffer], &word, sizeof word, offset, bytes,
      chain->wait_count, chain->wait_list, chain->events ? &event : NULL);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clEnqueueFillBuffer");
  follow(chain, event);
  return HBIL_SUCCESS;
}

hbil_status enqueue_fill(commands *chain, int buffer, cl_uint word) {
  return fill_part(chain, buffer, word, 0, chain->plan->layout.bytes[buffer]);
}

hbil_status set_flag(commands *chain, int flag, cl_uint value) {
  return fill_part(chain, BUFFER_FLAGS, value, (size_t)flag * sizeof value,
                   sizeof value);
}

hbil_status clear_counts(commands *chain, int first, int words) {
  return fill_part(chain, BUFFER_SANITIZED, 0, (size_t)first * sizeof(cl_uint),
                   (size_t)words * sizeof(cl_uint));
}
