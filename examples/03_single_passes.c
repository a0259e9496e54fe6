/*
 * The passes of a frame, one by one, with one of them replaced.  A kernel of
 * this program reverses the 4x4 interleaving and filters the result, in place
 * of the pass recompose.
 *
 * Then the frame is computed again with the library's filter.  Both results
 * must agree on average.
 */
#include <hbil/hbil_stages.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum {
  WIDTH = 318,
  HEIGHT = 181
}; /* not multiples of 4, to show that any size works */

/*
 * The filter, with one work-item per pixel.  It averages those of the 4x4
 * pixels around the pixel that have a similar inverse depth.  Each direction of
 * the sampling pattern occurs once among 4x4 pixels.  Pitches are in floats,
 * and `values` is the number of planes; hbil_plan_buffer() returns both.
 */
static const char *const filter_source =
    "typedef struct { uint plane, layer, row, origin; } pitches;\n"
    "size_t at(pitches p, uint value, int x, int y) {\n"
    "  uint layer = 4 * (y & 3) + (x & 3);\n"
    "  return (size_t)value * p.plane + layer * p.layer +\n"
    "         (y >> 2) * p.row + (x >> 2) + p.origin;\n"
    "}\n"
    "kernel void filter(global const float *split, pitches s,\n"
    "                   global const float *gathered, pitches g,\n"
    "                   global float *resolved, pitches r,\n"
    "                   int values, int width, int height) {\n"
    "  int x = get_global_id(0), y = get_global_id(1);\n"
    "  float w0 = split[at(s, 0, x, y)], total = 0, mean[7];\n"
    "  for (int p = 0; p < 7; ++p)\n"
    "    mean[p] = 0;\n"
    "  for (int v = max(y - 2, 0); v < min(y + 2, height); ++v)\n"
    "    for (int u = max(x - 2, 0); u < min(x + 2, width); ++u) {\n"
    "      float w = split[at(s, 0, u, v)];\n"
    "      if (w <= 0 || fabs(w - w0) > 0.1f * w0)\n"
    "        continue;\n"
    "      total += 1;\n"
    "      for (int p = 0; p < values; ++p)\n"
    "        mean[p] += gathered[at(g, p, u, v)];\n"
    "    }\n"
    "  if (total == 0) { /* sky: AO 1, no light */\n"
    "    mean[0] = 1;\n"
    "    total = 1;\n"
    "  }\n"
    "  float3 bent = (float3)(mean[4], mean[5], mean[6]);\n"
    "  float size = length(bent);\n"
    "  for (int p = 0; p < values; ++p)\n"
    "    resolved[(size_t)p * r.plane + y * r.row + x + r.origin] =\n"
    "        p < 4 ? mean[p] / total : size > 0 ? mean[p] / size : 0;\n"
    "}\n";

typedef struct pitches {
  cl_uint plane, layer, row, origin;
} pitches;

static float depth[HEIGHT][WIDTH], normal[3][HEIGHT][WIDTH];
static float direct[3][HEIGHT][WIDTH];
static float ao[2][HEIGHT][WIDTH], light[2][3][HEIGHT][WIDTH];
static float bent[2][3][HEIGHT][WIDTH];

static void fail(const char *what, const char *why) {
  fprintf(stderr, "03_single_passes: %s: %s\n", what, why);
  exit(1);
}

static void check_cl(cl_int error, const char *what) {
  if (error != CL_SUCCESS)
    fail(what, "OpenCL call failed");
}

static void check(hbil_status status, const hbil_context *hbil) {
  if (status != HBIL_SUCCESS)
    fail(hbil_status_string(status), hbil_context_message(hbil));
}

/* Draws a floor and two walls under an open sky, lit evenly. */
static void draw_corner(const hbil_camera *c) {
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      double rx = (x + 0.5 - c->cx) / c->fx, ry = (y + 0.5 - c->cy) / c->fy;
      double floor_z = ry > 0.0 ? 1.0 / ry : INFINITY;
      double wall_z = rx < 0.0 ? -2.0 / rx : INFINITY;
      double z = fmin(5.0, fmin(floor_z, wall_z));
      if (z * ry < -1.5)
        continue; /* above the walls; depth 0 is sky */
      depth[y][x] = (float)z;
      normal[0][y][x] = z == wall_z ? 1.0f : 0.0f;
      normal[1][y][x] = z == floor_z && z != wall_z ? -1.0f : 0.0f;
      normal[2][y][x] = z != floor_z && z != wall_z ? -1.0f : 0.0f;
      for (int k = 0; k < 3; ++k)
        direct[k][y][x] = 1.0f;
    }
}

static cl_device_id first_device(void) {
  cl_platform_id platforms[16];
  cl_device_id device = NULL;
  cl_uint count = 0;
  clGetPlatformIDs(16, platforms, &count);
  for (cl_uint i = 0; i < count && i < 16 && device == NULL; ++i)
    clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, 1, &device, NULL);
  if (device == NULL)
    fail("OpenCL", "no device");
  return device;
}

static cl_mem buffer(cl_context context, size_t bytes, void *content) {
  cl_int error;
  cl_mem_flags copy = content != NULL ? CL_MEM_COPY_HOST_PTR : 0;
  cl_mem m =
      clCreateBuffer(context, CL_MEM_READ_WRITE | copy, bytes, content, &error);
  check_cl(error, "clCreateBuffer");
  return m;
}

static cl_kernel build_filter(cl_context context, cl_device_id device) {
  const char *source = filter_source;
  cl_int error;
  cl_program program =
      clCreateProgramWithSource(context, 1, &source, NULL, &error);
  check_cl(error, "clCreateProgramWithSource");
  check_cl(clBuildProgram(program, 1, &device, "", NULL, NULL),
           "clBuildProgram");
  cl_kernel kernel = clCreateKernel(program, "filter", &error);
  check_cl(error, "clCreateKernel");
  clReleaseProgram(program); /* the kernel retains it */
  return kernel;
}

/* Sets two arguments of the kernel: the buffer of a stage, and its pitches.
 * Returns the number of values. */
static cl_int set_stage(cl_kernel kernel, cl_uint argument,
                        const hbil_plan *plan, const hbil_context *hbil,
                        hbil_stage stage) {
  hbil_buffer b;
  check(hbil_plan_buffer(plan, stage, &b), hbil);
  pitches p = {(cl_uint)b.plane_pitch, (cl_uint)b.layer_pitch,
               (cl_uint)b.row_pitch, (cl_uint)b.origin};
  check_cl(clSetKernelArg(kernel, argument, sizeof b.buffer, &b.buffer),
           "clSetKernelArg");
  check_cl(clSetKernelArg(kernel, argument + 1, sizeof p, &p),
           "clSetKernelArg");
  return (cl_int)b.values;
}

/* Enqueues the passes in their order.  The in-order queue runs them one after
 * the other. */
static void enqueue_passes(hbil_plan *plan, const hbil_context *hbil,
                           cl_command_queue queue, const hbil_frame *frame,
                           cl_kernel filter) {
  cl_int sizes[3] = {0, WIDTH, HEIGHT};
  const size_t items[2] = {WIDTH, HEIGHT};
  check(hbil_enqueue_passes(plan, queue, frame, HBIL_PASS_REPROJECT,
                            HBIL_PASS_GATHER, 0, NULL, NULL),
        hbil);
  set_stage(filter, 0, plan, hbil, HBIL_STAGE_SPLIT);
  set_stage(filter, 2, plan, hbil, HBIL_STAGE_GATHERED);
  sizes[0] = set_stage(filter, 4, plan, hbil, HBIL_STAGE_RESOLVED);
  for (cl_uint i = 0; i < 3; ++i)
    check_cl(clSetKernelArg(filter, 6 + i, sizeof sizes[i], &sizes[i]),
             "clSetKernelArg");
  check_cl(clEnqueueNDRangeKernel(queue, filter, 2, NULL, items, NULL, 0, NULL,
                                  NULL),
           "clEnqueueNDRangeKernel");
  check(hbil_enqueue_passes(plan, queue, frame, HBIL_PASS_COMPOSITE,
                            HBIL_PASS_COMPOSITE, 0, NULL, NULL),
        hbil);
}

static void read_back(cl_command_queue queue, const hbil_frame *frame,
                      int result) {
  const cl_mem from[3] = {frame->ao.buffer, frame->near_irradiance.buffer,
                          frame->bent_normal.buffer};
  void *const to[3] = {ao[result], light[result], bent[result]};
  const size_t size[3] = {sizeof ao[0], sizeof light[0], sizeof bent[0]};
  for (int i = 0; i < 3; ++i)
    check_cl(clEnqueueReadBuffer(queue, from[i], CL_TRUE, 0, size[i], to[i], 0,
                                 NULL, NULL),
             "clEnqueueReadBuffer");
}

static double mean_of(const float *values, size_t count) {
  double sum = 0.0;
  for (size_t i = 0; i < count; ++i)
    sum += values[i];
  return sum / (double)count;
}

/* Mean cosine between the bent normals of the two results. */
static double alignment(void) {
  double sum = 0.0;
  size_t count = 0;
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      if (depth[y][x] == 0.0f)
        continue;
      for (int k = 0; k < 3; ++k)
        sum += (double)bent[0][k][y][x] * bent[1][k][y][x];
      ++count;
    }
  return sum / (double)count;
}

/* Compares the two results.  A NaN in a picture makes its mean NaN, which fails
 * as well. */
static int agree(void) {
  double a[2], e[2], cosine = alignment();
  for (int i = 0; i < 2; ++i) {
    a[i] = mean_of(&ao[i][0][0], sizeof ao[i] / sizeof(float));
    e[i] = mean_of(&light[i][0][0][0], sizeof light[i] / sizeof(float));
    printf("%s filter: mean visibility %.4f, mean near light %.4f\n",
           i == 0 ? "own " : "hbil", a[i], e[i]);
  }
  printf("mean cosine between their bent normals: %.4f\n", cosine);
  return fabs(a[0] - a[1]) < 0.01 && fabs(e[0] - e[1]) < 0.02 * e[1] &&
         cosine > 0.98 && a[0] > 0.5 && a[0] < 0.99 && e[0] > 0.01;
}

int main(void) {
  cl_int error;
  cl_device_id device = first_device();
  cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, &error);
  check_cl(error, "clCreateContext");
  cl_command_queue queue = clCreateCommandQueue(context, device, 0, &error);
  check_cl(error, "clCreateCommandQueue");

  hbil_frame frame;
  hbil_frame_init(&frame);
  frame.camera = (hbil_camera){
      .fx = 200.0,
      .fy = 200.0,
      .cx = WIDTH / 2.0,
      .cy = HEIGHT / 2.0,
      .world_from_view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
  draw_corner(&frame.camera);
  frame.depth.buffer = buffer(context, sizeof depth, depth);
  frame.normal.buffer = buffer(context, sizeof normal, normal);
  frame.direct.buffer = buffer(context, sizeof direct, direct);
  frame.ao.buffer = buffer(context, sizeof ao[0], NULL);
  frame.near_irradiance.buffer = buffer(context, sizeof light[0], NULL);
  frame.bent_normal.buffer = buffer(context, sizeof bent[0], NULL);

  hbil_config config;
  hbil_config_init(&config);
  config.sampling.storage =
      HBIL_STORAGE_FLOAT32; /* the filter below reads floats */
  config.width = WIDTH;
  config.height = HEIGHT;
  config.inputs.depth = config.inputs.normal = config.inputs.direct =
      config.outputs.ao = config.outputs.near_irradiance =
          config.outputs.bent_normal = (hbil_plane_format){HBIL_FLOAT32, 4};
  hbil_context *hbil = NULL;
  hbil_plan *plan = NULL;
  check(hbil_context_create(context, device, &hbil), hbil);
  check(hbil_plan_create(hbil, &config, &plan), hbil);

  cl_kernel filter = build_filter(context, device);
  enqueue_passes(plan, hbil, queue, &frame, filter);
  read_back(queue, &frame, 0);
  hbil_plan_reset(plan); /* else light of the first run would be carried over */
  check(hbil_enqueue_frame(plan, queue, &frame, 0, NULL, NULL), hbil);
  read_back(queue, &frame, 1);

  clReleaseKernel(filter);
  hbil_plan_destroy(plan);
  hbil_context_destroy(hbil);
  cl_mem buffers[] = {frame.depth.buffer,           frame.normal.buffer,
                      frame.direct.buffer,          frame.ao.buffer,
                      frame.near_irradiance.buffer, frame.bent_normal.buffer};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; ++i)
    clReleaseMemObject(buffers[i]);
  clReleaseCommandQueue(queue);
  clReleaseContext(context);
  if (!agree())
    fail("result", "the two filters disagree, or nothing was lit");
  return 0;
}
