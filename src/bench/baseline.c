/* The paper's method as one plain kernel. */
#include "bench/baseline.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GROUP = 64 };

/* The same layout as in baseline.cl. */
typedef struct baseline_args {
  cl_int width, height;
  cl_float fx, fy, cx, cy;
  cl_float facing_fade[2];
} baseline_args;

/* What the kernel reads and writes, in the order of its arguments. */
enum { DEPTHS, NORMALS, RADIANCES, RESULT, BUFFERS };
static const size_t floats_of[BUFFERS] = {1, 4, 4, 4};

static baseline_args arguments(const bench_content *content) {
  const hbil_camera *camera = &content->frame[content->measured].camera;
  return (baseline_args){.width = (cl_int)content->width,
                         .height = (cl_int)content->height,
                         .fx = (float)camera->fx,
                         .fy = (float)camera->fy,
                         .cx = (float)camera->cx,
                         .cy = (float)camera->cy,
                         .facing_fade = {-0.1f, 0.0f}};
}

static void view_normal(const bench_content *content, size_t pixel,
                        float *out) {
  const size_t pixels = bench_pixels(content);
  const bench_frame *frame = &content->frame[content->measured];
  const double *m = frame->camera.world_from_view;
  const float *n = frame->plane[BENCH_NORMAL] + pixel;
  const float *scale = content->config.inputs.normal_scale;
  const double v[3] = {(double)(n[0] * scale[0]),
                       (double)(n[pixels] * scale[1]),
                       (double)(n[2 * pixels] * scale[2])};
  for (size_t c = 0; c < 3; c++)
    if (content->config.inputs.normal_space == HBIL_SPACE_VIEW)
      out[c] = (float)v[c];
    else /* the inverse of a rotation is its transpose */
      out[c] = (float)(m[c] * v[0] + m[4 + c] * v[1] + m[8 + c] * v[2]);
}

static void radiance(const bench_content *content, size_t pixel, float *out) {
  const bench_frame *frame = &content->frame[content->measured];
  const float *albedo = frame->plane[BENCH_ALBEDO];
  const float *direct = frame->plane[BENCH_DIRECT];
  for (size_t c = 0; c < 3; c++) {
    const size_t at = c * bench_pixels(content) + pixel;
    out[c] = 0.318309886f * (albedo ? albedo[at] : 1.0f) *
             content->config.inputs.direct_scale * direct[at];
  }
}

static int make_buffers(const bench_device *d, const bench_content *content,
                        cl_mem buffers[BUFFERS], image_error *error) {
  const size_t pixels = bench_pixels(content);
  float *values[BUFFERS];
  int failed = 0;
  for (int b = 0; b < BUFFERS; b++)
    if (!(values[b] = calloc(floats_of[b] * pixels, sizeof *values[b])))
      failed = image_no_memory(error, "the baseline");
  for (size_t i = 0; i < pixels && !failed; i++)
    if (bench_is_surface(content, i)) {
      values[DEPTHS][i] =
          content->frame[content->measured].plane[BENCH_DEPTH][i];
      view_normal(content, i, values[NORMALS] + 4 * i);
      radiance(content, i, values[RADIANCES] + 4 * i);
    }
  for (int b = 0; b < BUFFERS; b++) {
    if (!failed)
      failed = bench_buffer_new(d, floats_of[b] * pixels * sizeof(float),
                                values[b], &buffers[b], error);
    free(values[b]);
  }
  return failed;
}

static int run_kernel(const bench_device *d, const bench_content *content,
                      cl_kernel kernel, const cl_mem buffers[BUFFERS],
                      unsigned runs, bench_spread *out, image_error *error) {
  const baseline_args args = arguments(content);
  const size_t local[2] = {GROUP, 1};
  const size_t global[2] = {(content->width + GROUP - 1) / GROUP * GROUP,
                            content->height};
  cl_int status = clSetKernelArg(kernel, 0, sizeof args, &args);
  for (cl_uint i = 0; i < BUFFERS && status == CL_SUCCESS; i++)
    status = clSetKernelArg(kernel, i + 1, sizeof *buffers, &buffers[i]);
  if (status != CL_SUCCESS)
    return bench_opencl_failed(d, status, "setting an argument", error);
  return bench_kernel_time(d, kernel, global, local, runs, out, error);
}

static int find_errors(const bench_device *d, const bench_content *content,
                       cl_mem result, const float *exact_ao,
                       const float *exact_light, bench_baseline *out,
                       image_error *error) {
  const size_t pixels = bench_pixels(content);
  float *mixed = malloc(8 * pixels * sizeof *mixed);
  if (!mixed)
    return image_no_memory(error, "the baseline");
  float *planes = mixed + 4 * pixels;
  const cl_int status =
      clEnqueueReadBuffer(d->queue, result, CL_TRUE, 0,
                          4 * pixels * sizeof *mixed, mixed, 0, NULL, NULL);
  for (size_t i = 0; i < 4 * pixels && status == CL_SUCCESS; i++)
    planes[i % 4 * pixels + i / 4] = mixed[i];
  if (status == CL_SUCCESS) {
    out->light_error = bench_light_error(content, planes, exact_light);
    out->ao_error = bench_ao_error(content, planes + 3 * pixels, exact_ao);
  }
  free(mixed);
  return status == CL_SUCCESS
             ? 0
             : bench_opencl_failed(d, status, "reading a buffer", error);
}

int bench_baseline_measure(const bench_device *d, const bench_content *content,
                           unsigned runs, const float *exact_ao,
                           const float *exact_light, bench_baseline *out,
                           image_error *error) {
  cl_mem buffers[BUFFERS] = {NULL};
  cl_kernel kernel = NULL;
  char defines[64];
  snprintf(defines, sizeof defines, "-DSLICES=%d -DSAMPLES=%d -DPARALLEL=%d",
           BENCH_BASELINE_SLICES, BENCH_BASELINE_STEPS,
           content->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC);
  const int failed =
      bench_kernel_new(d, "baseline", defines, &kernel, error) != 0 ||
      make_buffers(d, content, buffers, error) != 0 ||
      run_kernel(d, content, kernel, buffers, runs, &out->milliseconds,
                 error) != 0 ||
      find_errors(d, content, buffers[RESULT], exact_ao, exact_light, out,
                  error) != 0;
  for (int i = 0; i < BUFFERS; i++)
    if (buffers[i])
      clReleaseMemObject(buffers[i]);
  if (kernel)
    clReleaseKernel(kernel);
  return failed ? -1 : 0;
}
