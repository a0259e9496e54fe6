/* See fault.h. */
#include "test/support/fault.h"

#include <ctype.h>

const cl_int faults[] = {CL_OUT_OF_RESOURCES, CL_OUT_OF_HOST_MEMORY,
                         CL_MEM_OBJECT_ALLOCATION_FAILURE,
                         CL_INVALID_OPERATION};
static const hbil_status statuses[] = {
    HBIL_OUT_OF_DEVICE_MEMORY, HBIL_OUT_OF_HOST_MEMORY,
    HBIL_OUT_OF_DEVICE_MEMORY, HBIL_OPENCL_ERROR};
static const char *const names[] = {
    "CL_OUT_OF_RESOURCES", "CL_OUT_OF_HOST_MEMORY",
    "CL_MEM_OBJECT_ALLOCATION_FAILURE", "CL_INVALID_OPERATION"};

/* The status that must follow from a failing call. A failed release can't be
 * repaired, so it is ignored. A missing event costs nothing but timings. A
 * build that fails for another reason than memory is a compiler error. */
static hbil_status follows(const char *call, hbil_status error) {
  if (!call || strncmp(call, "clRelease", 9) == 0 ||
      strcmp(call, "clRetainEvent") == 0)
    return HBIL_SUCCESS;
  return error == HBIL_OPENCL_ERROR && strcmp(call, "clBuildProgram") == 0
             ? HBIL_BUILD_FAILED
             : error;
}

void check_outcome_status(const outcome *o, int fault) {
  const hbil_status want = follows(o->failed, statuses[fault]);
  if (o->status != want)
    fail_msg("call %d, %s: \"%s\", expected \"%s\"", o->nth,
             o->failed ? o->failed : "none", hbil_status_string(o->status),
             hbil_status_string(want));
}

/* Calls whose messages name a kernel, as in "clCreateKernel(split): ...". */
static bool names_kernel(const char *call, const char *message) {
  static const char *const calls[] = {
      "clCreateProgramWithSource", "clBuildProgram", "clCreateKernel",
      "clSetKernelArg", "clEnqueueNDRangeKernel"};
  const size_t length = strlen(call);
  for (size_t i = 0; i < sizeof calls / sizeof *calls; ++i)
    if (!strcmp(call, calls[i]))
      return !strncmp(message, call, length) && message[length] == '(' &&
             isalpha((unsigned char)message[length + 1]);
  return true;
}

void check_outcome(const hbil_context *context, const outcome *o, int fault) {
  const char *message = hbil_context_message(context);
  check_outcome_status(o, fault);
  if (o->status != HBIL_SUCCESS && !strstr(message, names[fault]))
    fail_msg("call %d, %s: %s is not named in the message \"%s\"", o->nth,
             o->failed, names[fault], message);
  if (o->status != HBIL_SUCCESS && !names_kernel(o->failed, message))
    fail_msg("call %d, %s: no kernel is named in the message \"%s\"", o->nth,
             o->failed, message);
}

void check_held(const outcome *o, long want) {
  if (shim_references() != want)
    fail_msg("call %d, %s: %ld references are held, expected %ld", o->nth,
             o->failed ? o->failed : "none", shim_references(), want);
}

outcome attempted(int nth, hbil_status status) {
  const outcome o = {nth, shim_failed(), status};
  shim_fail(0, CL_SUCCESS);
  return o;
}
