/*
 * A library for LD_PRELOAD that makes OpenCL calls of a program fail as the
 * environment says:
 *
 *   FAIL_BUFFER=STATUS   clCreateBuffer()
 *   FAIL_LAUNCH=STATUS   clEnqueueNDRangeKernel()
 *   FAIL_COMPILER=1      the device has no compiler
 */
#define _GNU_SOURCE
#include <CL/cl.h>
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

/* The next library's function; ISO C has no cast to it. */
static void next(const char *name, void *function) {
  void *found = dlsym(RTLD_NEXT, name);
  if (!found)
    abort();
  memcpy(function, &found, sizeof found);
}

CL_API_ENTRY cl_mem CL_API_CALL clCreateBuffer(cl_context context,
                                               cl_mem_flags flags, size_t size,
                                               void *host, cl_int *status) {
  const char *fail = getenv("FAIL_BUFFER");
  cl_mem (*call)(cl_context, cl_mem_flags, size_t, void *, cl_int *);
  next("clCreateBuffer", &call);
  if (!fail)
    return call(context, flags, size, host, status);
  if (status)
    *status = atoi(fail);
  return NULL;
}

CL_API_ENTRY cl_int CL_API_CALL clEnqueueNDRangeKernel(
    cl_command_queue queue, cl_kernel kernel, cl_uint dimensions,
    const size_t *offset, const size_t *global, const size_t *local,
    cl_uint count, const cl_event *list, cl_event *event) {
  const char *fail = getenv("FAIL_LAUNCH");
  cl_int (*call)(cl_command_queue, cl_kernel, cl_uint, const size_t *,
                 const size_t *, const size_t *, cl_uint, const cl_event *,
                 cl_event *);
  next("clEnqueueNDRangeKernel", &call);
  return fail ? atoi(fail)
              : call(queue, kernel, dimensions, offset, global, local, count,
                     list, event);
}

CL_API_ENTRY cl_int CL_API_CALL clGetDeviceInfo(cl_device_id device,
                                                cl_device_info what,
                                                size_t room, void *value,
                                                size_t *size) {
  cl_int (*call)(cl_device_id, cl_device_info, size_t, void *, size_t *);
  next("clGetDeviceInfo", &call);
  const cl_int status = call(device, what, room, value, size);
  if (getenv("FAIL_COMPILER") && what == CL_DEVICE_COMPILER_AVAILABLE &&
      value && room >= sizeof(cl_bool))
    memset(value, 0, sizeof(cl_bool));
  return status;
}
