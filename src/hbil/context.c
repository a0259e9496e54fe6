/* A device, its limits, and the message of the last failure. */
#include "context.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *cl_error_name(cl_int error) {
#define NAME(e)                                                                \
  case e:                                                                      \
    return #e
  switch (error) {
    NAME(CL_SUCCESS);
    NAME(CL_DEVICE_NOT_FOUND);
    NAME(CL_DEVICE_NOT_AVAILABLE);
    NAME(CL_COMPILER_NOT_AVAILABLE);
    NAME(CL_MEM_OBJECT_ALLOCATION_FAILURE);
    NAME(CL_OUT_OF_RESOURCES);
    NAME(CL_OUT_OF_HOST_MEMORY);
    NAME(CL_PROFILING_INFO_NOT_AVAILABLE);
    NAME(CL_MEM_COPY_OVERLAP);
    NAME(CL_BUILD_PROGRAM_FAILURE);
    NAME(CL_MISALIGNED_SUB_BUFFER_OFFSET);
    NAME(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST);
    NAME(CL_COMPILE_PROGRAM_FAILURE);
    NAME(CL_LINKER_NOT_AVAILABLE);
    NAME(CL_INVALID_VALUE);
    NAME(CL_INVALID_DEVICE);
    NAME(CL_INVALID_CONTEXT);
    NAME(CL_INVALID_QUEUE_PROPERTIES);
    NAME(CL_INVALID_COMMAND_QUEUE);
    NAME(CL_INVALID_MEM_OBJECT);
    NAME(CL_INVALID_BINARY);
    NAME(CL_INVALID_BUILD_OPTIONS);
    NAME(CL_INVALID_PROGRAM);
    NAME(CL_INVALID_PROGRAM_EXECUTABLE);
    NAME(CL_INVALID_KERNEL_NAME);
    NAME(CL_INVALID_KERNEL_DEFINITION);
    NAME(CL_INVALID_KERNEL);
    NAME(CL_INVALID_ARG_INDEX);
    NAME(CL_INVALID_ARG_VALUE);
    NAME(CL_INVALID_ARG_SIZE);
    NAME(CL_INVALID_KERNEL_ARGS);
    NAME(CL_INVALID_WORK_DIMENSION);
    NAME(CL_INVALID_WORK_GROUP_SIZE);
    NAME(CL_INVALID_WORK_ITEM_SIZE);
    NAME(CL_INVALID_GLOBAL_OFFSET);
    NAME(CL_INVALID_EVENT_WAIT_LIST);
    NAME(CL_INVALID_EVENT);
    NAME(CL_INVALID_OPERATION);
    NAME(CL_INVALID_BUFFER_SIZE);
    NAME(CL_INVALID_GLOBAL_WORK_SIZE);
  }
#undef NAME
  return "an unnamed OpenCL error";
}

hbil_status fail(hbil_context *context, hbil_status status, const char *format,
                 ...) {
  va_list args;
  va_start(args, format);
  const int length = vsnprintf(NULL, 0, format, args);
  va_end(args);
  char *message = length < 0 ? NULL : malloc((size_t)length + 1);
  if (message) {
    va_start(args, format);
    vsnprintf(message, (size_t)length + 1, format, args);
    va_end(args);
  }
  /* Freed after formatting: the old message may be among the arguments. */
  free(context->message);
  context->message = message;
  return status;
}

hbil_status status_of(cl_int error) {
  switch (error) {
  case CL_SUCCESS:
    return HBIL_SUCCESS;
  case CL_OUT_OF_HOST_MEMORY:
    return HBIL_OUT_OF_HOST_MEMORY;
  case CL_MEM_OBJECT_ALLOCATION_FAILURE:
  case CL_OUT_OF_RESOURCES:
  case CL_INVALID_BUFFER_SIZE:
    return HBIL_OUT_OF_DEVICE_MEMORY;
  }
  return HBIL_OPENCL_ERROR;
}

hbil_status fail_cl(hbil_context *context, cl_int error, const char *call) {
  return fail(context, status_of(error), "%s: %s (%d)", call,
              cl_error_name(error), (int)error);
}

/* "OpenCL 1.2 ..." -> 102; 0 if it does not read like that. */
static cl_int read_version(cl_device_id device, int *version) {
  char text[256] = "";
  int major = 0, minor = 0;
  const cl_int error =
      clGetDeviceInfo(device, CL_DEVICE_VERSION, sizeof text - 1, text, NULL);
  *version = sscanf(text, "OpenCL %d.%d", &major, &minor) == 2
                 ? major * 100 + minor
                 : 0;
  return error;
}

/*
 * The width of the kernels' explicit vectors.  On a CPU it is the width of the
 * registers, in floats.  On other devices each work-item has one pixel, because
 * their hardware makes vectors of neighbouring work-items by itself.
 */
static cl_int read_width(cl_device_id device, cl_device_type type,
                         cl_uint *width) {
  cl_uint native = 1;
  cl_int error = CL_SUCCESS;
  if (type & CL_DEVICE_TYPE_CPU)
    error = clGetDeviceInfo(device, CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT,
                            sizeof native, &native, NULL);
  *width = native >= 16 ? 16 : native >= 8 ? 8 : native >= 4 ? 4 : 1;
  return error;
}

static hbil_status read_limits(hbil_context *context) {
  const cl_device_id device = context->device;
  cl_device_type type = 0;
  cl_bool compiler = CL_FALSE;
  cl_device_fp_config fp = 0;
  int version = 0;
  cl_int error =
      clGetDeviceInfo(device, CL_DEVICE_TYPE, sizeof type, &type, NULL);
  if (error == CL_SUCCESS)
    error = clGetDeviceInfo(device, CL_DEVICE_COMPILER_AVAILABLE,
                            sizeof compiler, &compiler, NULL);
  if (error == CL_SUCCESS)
    error = clGetDeviceInfo(device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof fp, &fp,
                            NULL);
  if (error == CL_SUCCESS)
    error = read_version(device, &version);
  if (error == CL_SUCCESS)
    error = read_width(device, type, &context->vector_width);
  if (error != CL_SUCCESS)
    return status_of(error);
  context->exact_divide = (fp & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  /* A row of work-items, whose loads are contiguous.  CPUs: one row a group,
   * which measured best. */
  const bool cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
  context->group[0] = cpu ? 16 : 32;
  context->group[1] = cpu ? 1 : 4;
  return compiler && version >= 102 ? HBIL_SUCCESS : HBIL_UNSUPPORTED_DEVICE;
}

static hbil_status retain(hbil_context *context) {
  cl_int error = clRetainContext(context->context);
  if (error != CL_SUCCESS)
    return status_of(error);
  error = clRetainDevice(context->device);
  if (error != CL_SUCCESS)
    clReleaseContext(context->context);
  return status_of(error);
}

hbil_status hbil_context_create(cl_context context, cl_device_id device,
                                hbil_context **out) {
  if (out)
    *out = NULL;
  if (!context || !device || !out)
    return HBIL_INVALID_ARGUMENT;
  hbil_context *created = calloc(1, sizeof *created);
  if (!created)
    return HBIL_OUT_OF_HOST_MEMORY;
  created->context = context;
  created->device = device;
  hbil_status status = read_limits(created);
  if (status == HBIL_SUCCESS)
    status = retain(created);
  if (status == HBIL_SUCCESS)
    *out = created;
  else
    free(created);
  return status;
}

void hbil_context_destroy(hbil_context *context) {
  if (!context)
    return;
  clReleaseDevice(context->device);
  clReleaseContext(context->context);
  free(context->message);
  free(context);
}

const char *hbil_context_message(const hbil_context *context) {
  return context && context->message ? context->message : "";
}
