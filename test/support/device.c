#include "test/support/device.h"

#include "test/support/compare.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

device_fixture shared_device;

void hard_error(const char *why) {
  fprintf(stderr, "test set-up: %s\n", why);
  exit(99);
}

static bool is_pocl(cl_platform_id platform) {
  char name[256] = "";
  clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof(name), name, NULL);
  return strstr(name, "Portable Computing Language") != NULL;
}

static cl_device_id find_device(void) {
  cl_platform_id platforms[16];
  cl_uint count = 0;
  cl_device_id found = NULL;
  if (clGetPlatformIDs(16, platforms, &count) != CL_SUCCESS || count == 0)
    hard_error("no OpenCL platform; install pocl-opencl-icd");
  for (cl_uint i = 0; i < count && i < 16; ++i) {
    cl_device_id device;
    if (clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, 1, &device, NULL) !=
        CL_SUCCESS)
      continue;
    if (is_pocl(platforms[i]))
      return device;
    found = found ? found : device;
  }
  if (!found)
    hard_error("no OpenCL device; install pocl-opencl-icd");
  return found;
}

void skip_unless_pocl(void) {
  cl_platform_id platform = NULL;
  clGetDeviceInfo(shared_device.id, CL_DEVICE_PLATFORM, sizeof platform,
                  &platform, NULL);
  if (!is_pocl(platform))
    skip();
}

device_fixture device_open(void) {
  device_fixture d;
  cl_int error;
  d.id = find_device();
  d.context = clCreateContext(NULL, 1, &d.id, NULL, NULL, &error);
  if (error != CL_SUCCESS)
    hard_error("clCreateContext failed");
  d.queue = clCreateCommandQueue(d.context, d.id, 0, &error);
  if (error != CL_SUCCESS)
    hard_error("clCreateCommandQueue failed");
  if (hbil_context_create(d.context, d.id, &d.hbil) != HBIL_SUCCESS)
    hard_error("hbil_context_create failed");
  return d;
}

void device_close(device_fixture *d) {
  /* a driver that still compiles when the process ends may crash */
  clFinish(d->queue);
  hbil_context_destroy(d->hbil);
  clReleaseCommandQueue(d->queue);
  clReleaseContext(d->context);
}

int device_finish(int failures) {
  device_close(&shared_device);
  return failures;
}

int run_with_device(void) {
  shared_device = device_open();
  return device_finish(tests_run());
}

cl_mem buffer_new(const device_fixture *d, size_t size, const void *bytes) {
  cl_int error;
  cl_mem buffer =
      clCreateBuffer(d->context, CL_MEM_READ_WRITE, size, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  if (bytes)
    buffer_write(d, buffer, 0, size, bytes);
  return buffer;
}

unsigned char *buffer_bytes(const device_fixture *d, cl_mem buffer,
                            size_t *size) {
  unsigned char *bytes;
  size_t all;
  assert_int_equal(
      clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof(all), &all, NULL),
      CL_SUCCESS);
  bytes = malloc(all);
  assert_non_null(bytes);
  assert_int_equal(clEnqueueReadBuffer(d->queue, buffer, CL_TRUE, 0, all, bytes,
                                       0, NULL, NULL),
                   CL_SUCCESS);
  if (size)
    *size = all;
  return bytes;
}

void buffer_write(const device_fixture *d, cl_mem buffer, size_t offset,
                  size_t size, const void *bytes) {
  assert_int_equal(clEnqueueWriteBuffer(d->queue, buffer, CL_TRUE, offset, size,
                                        bytes, 0, NULL, NULL),
                   CL_SUCCESS);
}
