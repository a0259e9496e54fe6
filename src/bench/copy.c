/* The bandwidth yardstick: a copy of planes, and what passes are to it. */
#include "bench/bench.h"

enum { PLANES = 8, GROUP = 64 };

int bench_is_cpu(const device *d) {
  cl_device_type type = 0;
  clGetDeviceInfo(d->id, CL_DEVICE_TYPE, sizeof type, &type, NULL);
  return (type & CL_DEVICE_TYPE_CPU) != 0;
}

static int run_copy(const device *d, cl_kernel kernel, const cl_mem buffers[2],
                    size_t vectors, unsigned runs, bench_copy *out,
                    image_error *error) {
  const size_t global[2] = {vectors, 1}, local[2] = {GROUP, 1};
  for (cl_uint i = 0; i < 2; i++) {
    const cl_int status =
        clSetKernelArg(kernel, i, sizeof *buffers, &buffers[i]);
    if (status != CL_SUCCESS)
      return bench_cl_failed(d, status, "setting an argument", error);
  }
  return bench_time_kernel(d, kernel, global, local, runs, &out->milliseconds,
                           error);
}

int bench_measure_copy(const device *d, size_t pixels, unsigned runs,
                       bench_copy *out, image_error *error) {
  const size_t width = bench_is_cpu(d) ? 16 : 4, step = width * GROUP;
  const size_t floats = (PLANES * pixels + step - 1) / step * step;
  const size_t bytes = floats * sizeof(float);
  const float one = 1.0f;
  cl_kernel kernel = NULL;
  cl_mem buffers[2] = {NULL, NULL};
  int failed = bench_kernel(d, "copy", width == 16 ? "-DWIDTH=16" : "-DWIDTH=4",
                            &kernel, error);
  for (int i = 0; i < 2 && !failed; i++) {
    failed = bench_buffer(d, bytes, NULL, &buffers[i], error);
    /* pages that nothing was written to are not memory yet */
    if (!failed)
      clEnqueueFillBuffer(d->queue, buffers[i], &one, sizeof one, 0, bytes, 0,
                          NULL, NULL);
  }
  out->planes = PLANES;
  out->bytes = 2 * bytes;
  if (!failed)
    failed =
        run_copy(d, kernel, buffers, floats / width, runs, out, error) != 0;
  for (int i = 0; i < 2; i++)
    if (buffers[i])
      clReleaseMemObject(buffers[i]);
  if (kernel)
    clReleaseKernel(kernel);
  return failed ? -1 : 0;
}

double bench_copy_time(const bench_copy *copy, double bytes) {
  return copy->milliseconds.median * bytes / (double)copy->bytes;
}

/* Channels of those inputs that a frame has. */
static double input_planes(const bench_content *content, unsigned inputs) {
  double planes = 0.0;
  for (int i = 0; i < BENCH_INPUTS; i++)
    if (inputs >> i & 1 && content->frame[0].plane[i])
      planes += (double)bench_input_channels((bench_input)i);
  return planes;
}

/*
 * Planes read and written, each once.  Split: its inputs and carried light
 * (RGB) in, inverse depth, normal and radiance out.  Push/pull: every level
 * (4/3 of the finest) of RGB and weight in and out.  Composite: inputs and
 * seven resolved planes in, seventeen outputs and four of history out.
 */
double bench_pass_bytes(const bench_content *content, hbil_pass pass) {
  const unsigned light = 1u << BENCH_ALBEDO | 1u << BENCH_DIRECT;
  const unsigned surface = 1u << BENCH_DEPTH | light;
  const unsigned emission = 1u << BENCH_EMISSION;
  double planes = 0.0;
  if (pass == HBIL_PASS_SPLIT)
    planes = 3.0 + 7.0 +
             input_planes(content,
                          surface | 1u << BENCH_NORMAL |
                              (content->config.gather_emission ? emission : 0));
  else if (pass == HBIL_PASS_PUSH_PULL)
    planes = 2.0 * 4.0 * 4.0 / 3.0;
  else if (pass == HBIL_PASS_COMPOSITE)
    planes = 7.0 + 17.0 + 4.0 + input_planes(content, surface | emission);
  return planes * (double)bench_pixels(content) * sizeof(float);
}

/* Depth, two of motion and four of history in, four of carried light out. */
double bench_motion_bytes(const bench_content *content) {
  return (1.0 + 2.0 + 4.0 + 4.0) * (double)bench_pixels(content) *
         sizeof(float);
}
