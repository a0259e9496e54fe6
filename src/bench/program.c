/* The bench's own kernels: building and timing them. */
#include "bench/bench.h"

#include <stdlib.h>
#include <string.h>

int bench_cl_failed(const device *d, cl_int status, const char *doing,
                    image_error *error) {
  return image_fail(error, "device %s: OpenCL error %d while %s", d->name,
                    (int)status, doing);
}

static const char *source_of(const char *name) {
  char file[64];
  snprintf(file, sizeof file, "%s.cl", name);
  for (const bench_source *s = bench_sources; s->name; s++)
    if (strcmp(s->name, file) == 0)
      return s->text;
  return "";
}

static int build(const device *d, cl_program program, const char *name,
                 const char *defines, image_error *error) {
  char log[512] = "";
  const cl_int status = clBuildProgram(program, 1, &d->id, defines, NULL, NULL);
  if (status == CL_SUCCESS)
    return 0;
  clGetProgramBuildInfo(program, d->id, CL_PROGRAM_BUILD_LOG, sizeof log, log,
                        NULL);
  log[sizeof log - 1] = '\0';
  return image_fail(error, "device %s: %s.cl cannot be built: %s", d->name,
                    name, log);
}

int bench_kernel(const device *d, const char *name, const char *defines,
                 cl_kernel *out, image_error *error) {
  const char *text = source_of(name);
  cl_int status;
  *out = NULL;
  cl_program program =
      clCreateProgramWithSource(d->context, 1, &text, NULL, &status);
  if (status != CL_SUCCESS)
    return bench_cl_failed(d, status, "making a program", error);
  int failed = build(d, program, name, defines, error);
  if (!failed) {
    *out = clCreateKernel(program, name, &status);
    if (status != CL_SUCCESS)
      failed = bench_cl_failed(d, status, "making a kernel", error);
  }
  clReleaseProgram(program); /* the kernel keeps it */
  return failed;
}

int bench_buffer(const device *d, size_t bytes, const void *content,
                 cl_mem *out, image_error *error) {
  cl_int status;
  *out = clCreateBuffer(d->context, CL_MEM_READ_WRITE, bytes, NULL, &status);
  if (status == CL_SUCCESS && content)
    status = clEnqueueWriteBuffer(d->queue, *out, CL_TRUE, 0, bytes, content, 0,
                                  NULL, NULL);
  return status == CL_SUCCESS
             ? 0
             : bench_cl_failed(d, status, "filling a buffer", error);
}

static int time_once(const device *d, cl_kernel kernel, const size_t *global,
                     const size_t *local, double *milliseconds,
                     image_error *error) {
  cl_ulong start = 0, end = 0;
  cl_event event;
  cl_int status = clEnqueueNDRangeKernel(d->queue, kernel, 2, NULL, global,
                                         local, 0, NULL, &event);
  if (status != CL_SUCCESS)
    return bench_cl_failed(d, status, "running a kernel", error);
  status = clWaitForEvents(1, &event);
  if (status == CL_SUCCESS)
    status = clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START,
                                     sizeof start, &start, NULL);
  if (status == CL_SUCCESS)
    status = clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END,
                                     sizeof end, &end, NULL);
  clReleaseEvent(event);
  *milliseconds = (double)(end - start) * 1e-6;
  return status == CL_SUCCESS
             ? 0
             : bench_cl_failed(d, status, "timing a kernel", error);
}

int bench_time_kernel(const device *d, cl_kernel kernel, const size_t global[2],
                      const size_t local[2], unsigned runs, bench_spread *out,
                      image_error *error) {
  double times[BENCH_MAX_RUNS], unused;
  for (unsigned i = 0; i < BENCH_WARM_UP + runs; i++)
    if (time_once(d, kernel, global, local,
                  i < BENCH_WARM_UP ? &unused : &times[i - BENCH_WARM_UP],
                  error) != 0)
      return -1;
  *out = bench_spread_of(times, runs);
  return 0;
}
