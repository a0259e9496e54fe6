/*
 * The smallest program: it computes the ambient occlusion of one frame.
 *
 * The frame is the corner of a room, made of three planes.  In your program it
 * comes from your renderer.
 */
#include <hbil/hbil.h>

#include <math.h>
#include <stdio.h>

enum { WIDTH = 320, HEIGHT = 180 };

static float depth[HEIGHT][WIDTH];
static float normal[3][HEIGHT]
                   [WIDTH]; /* planar: first all x, then all y, then all z */
static float ao[HEIGHT][WIDTH];

/* Draws a floor at y = 1, a left wall at x = -2 and a back wall at z = 5, in
 * view space: x right, y down, z forward. */
static void draw_corner(const hbil_camera *c) {
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      double rx = (x + 0.5 - c->cx) / c->fx, ry = (y + 0.5 - c->cy) / c->fy;
      double floor_z = ry > 0.0 ? 1.0 / ry : INFINITY;
      double wall_z = rx < 0.0 ? -2.0 / rx : INFINITY;
      double z = fmin(5.0, fmin(floor_z, wall_z));
      depth[y][x] = (float)z;
      normal[0][y][x] = z == wall_z ? 1.0f : 0.0f;
      normal[1][y][x] = z == floor_z && z != wall_z ? -1.0f : 0.0f;
      normal[2][y][x] = z != floor_z && z != wall_z ? -1.0f : 0.0f;
    }
}

static int fail(const char *what, const char *why) {
  fprintf(stderr, "01_minimal: %s: %s\n", what, why);
  return 1;
}

int main(void) {
  /* Your program has these: a device, a context, a queue, and buffers with a
   * frame. */
  cl_platform_id platforms[16];
  cl_device_id device = NULL;
  cl_uint count = 0;
  clGetPlatformIDs(16, platforms, &count);
  for (cl_uint i = 0; i < count && i < 16 && device == NULL; ++i)
    clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, 1, &device, NULL);
  if (device == NULL)
    return fail("OpenCL", "no device");
  cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
  cl_command_queue queue = clCreateCommandQueue(context, device, 0, NULL);

  hbil_frame frame;
  hbil_frame_init(&frame);
  frame.camera = (hbil_camera){
      .fx = 200.0,
      .fy = 200.0,
      .cx = WIDTH / 2.0,
      .cy = HEIGHT / 2.0,
      .world_from_view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
  draw_corner(&frame.camera);
  const cl_mem_flags copy = CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR;
  frame.depth.buffer = clCreateBuffer(context, copy, sizeof depth, depth, NULL);
  frame.normal.buffer =
      clCreateBuffer(context, copy, sizeof normal, normal, NULL);
  frame.ao.buffer =
      clCreateBuffer(context, CL_MEM_WRITE_ONLY, sizeof ao, NULL, NULL);

  /* Once, create a plan for this size, these inputs and these outputs. */
  hbil_config config;
  hbil_config_init(&config);
  config.width = WIDTH;
  config.height = HEIGHT;
  config.inputs.depth = (hbil_plane_format){HBIL_FLOAT32, 1};
  config.inputs.normal = (hbil_plane_format){HBIL_FLOAT32, 1};
  config.outputs.ao = (hbil_plane_format){HBIL_FLOAT32, 1};
  hbil_context *hbil = NULL;
  hbil_plan *plan = NULL;
  hbil_status status = hbil_context_create(context, device, &hbil);
  if (status == HBIL_SUCCESS)
    status = hbil_plan_create(hbil, &config, &plan);

  /* For every frame, enqueue it. */
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_frame(plan, queue, &frame, 0, NULL, NULL);
  if (status != HBIL_SUCCESS)
    return fail(hbil_status_string(status), hbil_context_message(hbil));
  if (clEnqueueReadBuffer(queue, frame.ao.buffer, CL_TRUE, 0, sizeof ao, ao, 0,
                          NULL, NULL) != CL_SUCCESS)
    return fail("OpenCL", "the result could not be read");

  double sum = 0.0;
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    sum += ao[i / WIDTH][i % WIDTH];
  double mean = sum / (WIDTH * HEIGHT);
  printf("mean ambient visibility of the corner: %.4f\n", mean);

  hbil_plan_destroy(plan);
  hbil_context_destroy(hbil);
  clReleaseMemObject(frame.ao.buffer);
  clReleaseMemObject(frame.normal.buffer);
  clReleaseMemObject(frame.depth.buffer);
  clReleaseCommandQueue(queue);
  clReleaseContext(context);
  /* A corner is neither open (1) nor closed (0).  NaN fails as well. */
  return mean > 0.5 && mean < 0.99 ? 0 : fail("mean", "not that of a corner");
}
