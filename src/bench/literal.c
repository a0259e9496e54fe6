/* The baseline: the paper as it reads, in one kernel. */
#include "bench/bench.h"

#include <stdlib.h>
#include <string.h>

enum { GROUP = 64 };

/* Same layout as in literal.cl. */
typedef struct literal_args {
  cl_int width, height;
  cl_float fx, fy, cx, cy;
  cl_float facing[2];
} literal_args;

/* What the kernel reads and writes. */
enum { DEPTHS, NORMALS, RADIANCES, RESULT, BUFFERS };

typedef struct planes {
  float *depth, *normal, *radiance; /* the latter two: four floats a pixel */
} planes;

static literal_args arguments(const bench_content *content) {
  const hbil_camera *camera = &content->frame[0].camera;
  const float *facing = content->config.facing_fade;
  /* smoothstep wants its edges apart */
  const float end =
      facing[1] > facing[0] + 1e-3f ? facing[1] : facing[0] + 1e-3f;
  return (literal_args){.width = (cl_int)content->width,
                        .height = (cl_int)content->height,
                        .fx = (float)camera->fx,
                        .fy = (float)camera->fy,
                        .cx = (float)camera->cx,
                        .cy = (float)camera->cy,
                        .facing = {facing[0], end}};
}

/* World to view: the inverse of a rotation is its transpose. */
static void turn_normal(const bench_content *content, size_t pixel,
                        float *out) {
  const size_t pixels = bench_pixels(content);
  const double *m = content->frame[0].camera.world_from_view;
  const float *n = content->frame[0].plane[BENCH_NORMAL] + pixel;
  for (int c = 0; c < 3; c++)
    out[c] = (float)(m[c] * (double)n[0] + m[4 + c] * (double)n[pixels] +
                     m[8 + c] * (double)n[2 * pixels]);
}

static void find_radiance(const bench_content *content, size_t pixel,
                          float *out) {
  const bench_frame *frame = &content->frame[0];
  const hbil_config *config = &content->config;
  for (int c = 0; c < 3; c++) {
    const size_t at = (size_t)c * bench_pixels(content) + pixel;
    const float *albedo = frame->plane[BENCH_ALBEDO];
    const float *direct = frame->plane[BENCH_DIRECT];
    const float *emission = frame->plane[BENCH_EMISSION];
    out[c] = 0.318309886f * (albedo ? albedo[at] : 1.0f) *
             (direct ? config->direct_scale * direct[at] : 0.0f);
    if (emission && config->gather_emission)
      out[c] += emission[at];
  }
}

static int make_planes(const bench_content *content, planes *out) {
  const size_t pixels = bench_pixels(content);
  out->depth = calloc(pixels, sizeof(float));
  out->normal = calloc(4 * pixels, sizeof(float));
  out->radiance = calloc(4 * pixels, sizeof(float));
  if (!out->depth || !out->normal || !out->radiance)
    return -1;
  for (size_t i = 0; i < pixels; i++) {
    if (!bench_is_surface(content, i))
      continue;
    out->depth[i] = content->frame[0].plane[BENCH_DEPTH][i];
    turn_normal(content, i, out->normal + 4 * i);
    find_radiance(content, i, out->radiance + 4 * i);
  }
  return 0;
}

static void free_planes(planes *p) {
  free(p->depth);
  free(p->normal);
  free(p->radiance);
}

static int make_buffers(const device *d, const bench_content *content,
                        cl_mem buffers[BUFFERS], image_error *error) {
  const size_t real = sizeof(float) * bench_pixels(content);
  planes p = {0};
  int failed;
  if (make_planes(content, &p) != 0)
    failed = image_no_memory(error, "the baseline");
  else
    failed =
        bench_buffer(d, real, p.depth, &buffers[DEPTHS], error) != 0 ||
        bench_buffer(d, 4 * real, p.normal, &buffers[NORMALS], error) != 0 ||
        bench_buffer(d, 4 * real, p.radiance, &buffers[RADIANCES], error) !=
            0 ||
        bench_buffer(d, 4 * real, NULL, &buffers[RESULT], error) != 0;
  free_planes(&p);
  return failed;
}

static int run_kernel(const device *d, const bench_content *content,
                      cl_kernel kernel, const cl_mem buffers[BUFFERS],
                      unsigned runs, bench_spread *out, image_error *error) {
  const literal_args args = arguments(content);
  const size_t local[2] = {GROUP, 1};
  const size_t global[2] = {(content->width + GROUP - 1) / GROUP * GROUP,
                            content->height};
  cl_int status = clSetKernelArg(kernel, 0, sizeof args, &args);
  for (cl_uint i = 0; i < BUFFERS && status == CL_SUCCESS; i++)
    status = clSetKernelArg(kernel, i + 1, sizeof *buffers, &buffers[i]);
  if (status != CL_SUCCESS)
    return bench_cl_failed(d, status, "setting an argument", error);
  return bench_time_kernel(d, kernel, global, local, runs, out, error);
}

/* Interleaved E_near and AO to the planes that errors are measured on. */
static void separate(const float *from, size_t pixels, float *to) {
  for (size_t i = 0; i < pixels; i++)
    for (size_t c = 0; c < 4; c++)
      to[c * pixels + i] = from[4 * i + c];
}

static int find_errors(const device *d, const bench_content *content,
                       cl_mem result, const float *ao, const float *light,
                       bench_literal *out, image_error *error) {
  const size_t pixels = bench_pixels(content);
  const size_t bytes = 4 * pixels * sizeof(float);
  float *both = malloc(2 * bytes);
  if (!both)
    return image_no_memory(error, "the baseline");
  const cl_int status = clEnqueueReadBuffer(d->queue, result, CL_TRUE, 0, bytes,
                                            both, 0, NULL, NULL);
  float *separated = both + 4 * pixels;
  if (status == CL_SUCCESS) {
    separate(both, pixels, separated);
    out->ao_error = bench_ao_error(content, separated + 3 * pixels, ao);
    out->light_error = bench_light_error(content, separated, light);
  }
  free(both);
  return status == CL_SUCCESS
             ? 0
             : bench_cl_failed(d, status, "reading a buffer", error);
}

int bench_measure_literal(const device *d, const bench_content *content,
                          unsigned runs, const float *ao, const float *light,
                          bench_literal *out, image_error *error) {
  const char *const builds[] = {"-DSLICES=2 -DSAMPLES=8 -DPARALLEL=0",
                                "-DSLICES=2 -DSAMPLES=8 -DPARALLEL=1"};
  cl_mem buffers[BUFFERS] = {NULL};
  cl_kernel kernel = NULL;
  const int failed =
      bench_kernel(d, "literal", builds[content->config.projection], &kernel,
                   error) != 0 ||
      make_buffers(d, content, buffers, error) != 0 ||
      run_kernel(d, content, kernel, buffers, runs, &out->milliseconds,
                 error) != 0 ||
      find_errors(d, content, buffers[RESULT], ao, light, out, error) != 0;
  for (int i = 0; i < BUFFERS; i++)
    if (buffers[i])
      clReleaseMemObject(buffers[i]);
  if (kernel)
    clReleaseKernel(kernel);
  return failed ? -1 : 0;
}
