/* OpenCL of the bench: one device, buffers, and kernels that are timed. */
#define _GNU_SOURCE /* strcasestr */
#include "bench/opencl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/command.h"

enum { MOST_PLATFORMS = 16, MOST_DEVICES = 64 };

int bench_opencl_failed(const bench_device *d, cl_int status, const char *doing,
                        image_error *error) {
  return image_fail(error, "device %s: OpenCL error %d while %s", d->name,
                    (int)status, doing);
}

/* --- the device --- */

static void get_text(cl_device_id id, cl_device_info what, char out[256]) {
  snprintf(out, 256, "?");
  clGetDeviceInfo(id, what, 255, out, NULL);
}

static cl_device_type type_of(cl_device_id id) {
  cl_device_type type = 0;
  clGetDeviceInfo(id, CL_DEVICE_TYPE, sizeof type, &type, NULL);
  return type;
}

/* In the order of `hbil devices`. */
static size_t list_devices(cl_device_id out[MOST_DEVICES]) {
  cl_platform_id platforms[MOST_PLATFORMS];
  cl_uint platform_count = 0;
  size_t count = 0;
  if (clGetPlatformIDs(MOST_PLATFORMS, platforms, &platform_count) !=
      CL_SUCCESS)
    return 0;
  for (cl_uint p = 0; p < platform_count && p < MOST_PLATFORMS; p++) {
    const cl_uint room = (cl_uint)(MOST_DEVICES - count);
    cl_uint found = 0;
    if (room && clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, room,
                               out + count, &found) == CL_SUCCESS)
      count += found < room ? found : room;
  }
  return count;
}

/* The device's place in the list; count if there is no such device. */
static size_t choose_device(const cl_device_id *list, size_t count,
                            const char *wanted) {
  if (!wanted) {
    for (size_t i = 0; i < count; i++)
      if (type_of(list[i]) & CL_DEVICE_TYPE_GPU)
        return i;
    return 0;
  }
  char *end;
  const unsigned long index = strtoul(wanted, &end, 10);
  if (end != wanted && !*end)
    return index < count ? index : count;
  for (size_t i = 0; i < count; i++) {
    char name[256];
    get_text(list[i], CL_DEVICE_NAME, name);
    if (*wanted && strcasestr(name, wanted))
      return i;
  }
  return count;
}

static void describe(bench_device *d) {
  cl_platform_id platform = NULL;
  get_text(d->id, CL_DEVICE_NAME, d->name);
  get_text(d->id, CL_DEVICE_VERSION, d->version);
  get_text(d->id, CL_DRIVER_VERSION, d->driver);
  snprintf(d->platform, sizeof d->platform, "?");
  clGetDeviceInfo(d->id, CL_DEVICE_PLATFORM, sizeof platform, &platform, NULL);
  clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof d->platform - 1,
                    d->platform, NULL);
  clGetDeviceInfo(d->id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof d->units,
                  &d->units, NULL);
  clGetDeviceInfo(d->id, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof d->memory,
                  &d->memory, NULL);
  d->is_cpu = (type_of(d->id) & CL_DEVICE_TYPE_CPU) != 0;
}

int bench_device_open(const char *wanted, bench_device *out,
                      image_error *error) {
  cl_device_id list[MOST_DEVICES];
  cl_int status;
  memset(out, 0, sizeof *out);
  const size_t count = list_devices(list);
  const size_t chosen = choose_device(list, count, wanted);
  if (count == 0)
    return image_fail(error, "no OpenCL device; a driver is needed, for "
                             "example Debian's pocl-opencl-icd");
  if (chosen == count)
    return image_fail(
        error, "--device %s: no such device; hbil devices lists them", wanted);
  out->id = list[chosen];
  describe(out);
  out->context = clCreateContext(NULL, 1, &out->id, NULL, NULL, &status);
  if (status == CL_SUCCESS)
    out->queue = clCreateCommandQueue(out->context, out->id,
                                      CL_QUEUE_PROFILING_ENABLE, &status);
  if (status == CL_SUCCESS)
    return 0;
  bench_opencl_failed(out, status, "opening it", error);
  bench_device_close(out);
  return -1;
}

void bench_device_close(bench_device *d) {
  if (d->queue)
    clReleaseCommandQueue(d->queue);
  if (d->context)
    clReleaseContext(d->context);
  memset(d, 0, sizeof *d);
}

/* --- buffers and kernels --- */

int bench_buffer_new(const bench_device *d, size_t bytes, const void *content,
                     cl_mem *out, image_error *error) {
  cl_int status;
  *out = clCreateBuffer(d->context, CL_MEM_READ_WRITE, bytes, NULL, &status);
  if (status == CL_SUCCESS && content)
    status = clEnqueueWriteBuffer(d->queue, *out, CL_TRUE, 0, bytes, content, 0,
                                  NULL, NULL);
  return status == CL_SUCCESS
             ? 0
             : bench_opencl_failed(d, status, "filling a buffer", error);
}

const char *bench_source_text(const char *name) {
  for (const bench_source *s = bench_sources; s->name; s++)
    if (strcmp(s->name, name) == 0)
      return s->text;
  return "";
}

static int build(const bench_device *d, cl_program program, const char *file,
                 const char *defines, image_error *error) {
  char log[512] = "";
  if (clBuildProgram(program, 1, &d->id, defines, NULL, NULL) == CL_SUCCESS)
    return 0;
  clGetProgramBuildInfo(program, d->id, CL_PROGRAM_BUILD_LOG, sizeof log - 1,
                        log, NULL);
  return image_fail(error, "device %s: %s cannot be built: %s", d->name, file,
                    log);
}

int bench_kernel_new(const bench_device *d, const char *name,
                     const char *defines, cl_kernel *out, image_error *error) {
  char file[64];
  cl_int status;
  snprintf(file, sizeof file, "%s.cl", name);
  const char *text = bench_source_text(file);
  *out = NULL;
  cl_program program =
      clCreateProgramWithSource(d->context, 1, &text, NULL, &status);
  if (status != CL_SUCCESS)
    return bench_opencl_failed(d, status, "making a program", error);
  int failed = build(d, program, file, defines, error);
  if (!failed) {
    *out = clCreateKernel(program, name, &status);
    if (status != CL_SUCCESS)
      failed = bench_opencl_failed(d, status, "making a kernel", error);
  }
  clReleaseProgram(program); /* the kernel holds a reference of its own */
  return failed;
}

static int time_once(const bench_device *d, cl_kernel kernel,
                     const size_t *global, const size_t *local,
                     double *milliseconds, image_error *error) {
  cl_ulong start = 0, end = 0;
  cl_event event;
  cl_int status = clEnqueueNDRangeKernel(d->queue, kernel, 2, NULL, global,
                                         local, 0, NULL, &event);
  if (status != CL_SUCCESS)
    return bench_opencl_failed(d, status, "running a kernel", error);
  status = clWaitForEvents(1, &event);
  if (status == CL_SUCCESS)
    status = clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START,
                                     sizeof start, &start, NULL);
  if (status == CL_SUCCESS)
    status = clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END,
                                     sizeof end, &end, NULL);
  clReleaseEvent(event);
  *milliseconds = 1e-6 * (double)(end - start);
  return status == CL_SUCCESS
             ? 0
             : bench_opencl_failed(d, status, "timing a kernel", error);
}

int bench_kernel_time(const bench_device *d, cl_kernel kernel,
                      const size_t global[2], const size_t local[2],
                      unsigned runs, bench_spread *out, image_error *error) {
  double times[BENCH_MAX_RUNS], warm_up;
  for (unsigned i = 0; i < BENCH_WARM_UP + runs; i++)
    if (time_once(d, kernel, global, local,
                  i < BENCH_WARM_UP ? &warm_up : &times[i - BENCH_WARM_UP],
                  error) != 0)
      return -1;
  *out = bench_spread_of(times, runs);
  return 0;
}
