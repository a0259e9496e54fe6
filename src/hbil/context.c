/* A device, its limits, and the message of the last failure. */
#include "context.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "shared_programs.h"

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

/* --- messages --- */

/* The last failure on this thread without a context.  Nothing that is said
 * there is longer than this. */
static _Thread_local char thread_message[512];

/* A malloc'd string; NULL without memory. */
static char *formatted(const char *format, va_list args) {
  va_list copy;
  va_copy(copy, args);
  const int length = vsnprintf(NULL, 0, format, copy);
  va_end(copy);
  char *text = length < 0 ? NULL : malloc((size_t)length + 1);
  if (text)
    vsnprintf(text, (size_t)length + 1, format, args);
  return text;
}

/* Puts before a message which of several views it is about. */
static char *of_view(const hbil_context *context, char *message) {
  static const char format[] = "views[%u]: %s";
  if (!context->checked_view || !message)
    return message;
  const size_t size = strlen(message) + sizeof format + 10;
  char *whole = malloc(size);
  if (whole)
    snprintf(whole, size, format, (unsigned)context->checked_view - 1, message);
  free(message);
  return whole;
}

hbil_status fail(hbil_context *context, hbil_status status, const char *format,
                 ...) {
  va_list args;
  va_start(args, format);
  if (!context) {
    vsnprintf(thread_message, sizeof thread_message, format, args);
    va_end(args);
    return status;
  }
  char *message = of_view(context, formatted(format, args));
  va_end(args);
  /* Freed after formatting: the old message may be among the arguments. */
  free(context->message);
  context->message = message;
  if (context->callback)
    context->callback(HBIL_MESSAGE_ERROR,
                      message ? message : hbil_status_string(status),
                      context->user);
  return status;
}

hbil_status fail_null(hbil_context *context, const char *function,
                      const char *name) {
  return fail(context, HBIL_INVALID_ARGUMENT, "%s: %s must not be null",
              function, name);
}

void warn(hbil_context *context, const char *format, ...) {
  if (!context->callback)
    return;
  va_list args;
  va_start(args, format);
  char *message = formatted(format, args);
  va_end(args);
  if (message)
    context->callback(HBIL_MESSAGE_WARNING, message, context->user);
  free(message);
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

hbil_status fail_cl(hbil_context *context, cl_int error, const char *format,
                    ...) {
  char call[256]; /* names of a function, of a kernel and of arguments */
  va_list args;
  va_start(args, format);
  vsnprintf(call, sizeof call, format, args);
  va_end(args);
  return fail(context, status_of(error), "%s: %s (%d)", call,
              cl_error_name(error), (int)error);
}

/* --- the device --- */

enum { VERSION_TEXT = 256 };

/* Reads "OpenCL 1.2 ..."; *version is 102 for that, and 0 if the text does not
 * read so. */
static cl_int read_version(cl_device_id device, char text[VERSION_TEXT],
                           int *version) {
  int major = 0, minor = 0;
  const cl_int error =
      clGetDeviceInfo(device, CL_DEVICE_VERSION, VERSION_TEXT - 1, text, NULL);
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

/* Whether the device's list of extensions, of any length, has this one. */
static cl_int read_extension(cl_device_id device, const char *name, bool *has) {
  size_t size = 0;
  cl_int error = clGetDeviceInfo(device, CL_DEVICE_EXTENSIONS, 0, NULL, &size);
  if (error != CL_SUCCESS)
    return error;
  char *list = calloc(1, size + 1);
  error = list ? clGetDeviceInfo(device, CL_DEVICE_EXTENSIONS, size, list, NULL)
               : CL_OUT_OF_HOST_MEMORY;
  *has = error == CL_SUCCESS && strstr(list, name);
  free(list);
  return error;
}

static hbil_status read_limits(hbil_context *context) {
  const cl_device_id device = context->device;
  cl_device_type type = 0;
  cl_bool compiler = CL_FALSE;
  cl_device_fp_config fp = 0;
  char text[VERSION_TEXT] = "";
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
    error = clGetDeviceInfo(device, CL_DEVICE_MAX_COMPUTE_UNITS,
                            sizeof context->compute_units,
                            &context->compute_units, NULL);
  if (error == CL_SUCCESS)
    error = read_version(device, text, &version);
  if (error == CL_SUCCESS)
    error = read_width(device, type, &context->vector_width);
  if (error == CL_SUCCESS)
    error = read_extension(device, "cl_nv_compiler_options",
                           &context->takes_registers);
  if (error != CL_SUCCESS)
    return fail_cl(NULL, error, "hbil_context_create: clGetDeviceInfo");
  context->exact_divide = (fp & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  /* A row of work-items, whose loads are contiguous.  CPUs: one row a group,
   * which measured best. */
  context->is_cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
  context->group[0] = context->is_cpu ? 16 : 32;
  context->group[1] = context->is_cpu ? 1 : 4;
  if (compiler && version >= 102)
    return HBIL_SUCCESS;
  return fail(NULL, HBIL_UNSUPPORTED_DEVICE,
              "hbil_context_create: the device has \"%s\" and %s compiler; "
              "OpenCL 1.2 and a compiler are needed",
              text, compiler ? "a" : "no");
}

static hbil_status retain_device(const hbil_context *context) {
  cl_int error = clRetainContext(context->context);
  if (error != CL_SUCCESS)
    return fail_cl(NULL, error, "hbil_context_create: clRetainContext");
  error = clRetainDevice(context->device);
  if (error == CL_SUCCESS)
    return HBIL_SUCCESS;
  clReleaseContext(context->context);
  return fail_cl(NULL, error, "hbil_context_create: clRetainDevice");
}

/* --- public --- */

hbil_status hbil_context_create(cl_context context, cl_device_id device,
                                hbil_context **out) {
  if (out)
    *out = NULL;
  if (!context || !device || !out)
    return fail_null(NULL, __func__,
                     !context  ? "context"
                     : !device ? "device"
                               : "out");
  hbil_context *created = calloc(1, sizeof *created);
  if (!created)
    return fail(NULL, HBIL_OUT_OF_HOST_MEMORY,
                "hbil_context_create: no memory for a context");
  created->references = 1;
  created->context = context;
  created->device = device;
  hbil_status status = read_limits(created);
  if (status == HBIL_SUCCESS)
    status = retain_device(created);
  if (status == HBIL_SUCCESS)
    *out = created;
  else
    free(created);
  return status;
}

void context_retain(hbil_context *context) {
  context->references++;
}

void context_release(hbil_context *context) {
  if (!context || --context->references)
    return;
  forget_shared_programs(context);
  clReleaseDevice(context->device);
  clReleaseContext(context->context);
  free(context->programs.folder);
  free(context->message);
  free(context);
}

void hbil_context_destroy(hbil_context *context) {
  context_release(context);
}

hbil_status hbil_context_set_callback(hbil_context *context,
                                      hbil_message_callback callback,
                                      void *user) {
  if (!context)
    return fail_null(NULL, __func__, "context");
  context->callback = callback;
  context->user = user;
  return HBIL_SUCCESS;
}

const char *hbil_context_message(const hbil_context *context) {
  if (!context)
    return thread_message;
  return context->message ? context->message : "";
}
