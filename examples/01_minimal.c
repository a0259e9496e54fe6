/* The smallest program: it computes the ambient occlusion of one frame, a floor
 * in front of a wall.  In your program the frame comes from your renderer. */
#include <hbil/hbil.h>
#include <math.h>
#include <stdio.h>

enum { WIDTH = 320, HEIGHT = 180, PIXELS = WIDTH * HEIGHT };

static float depth[PIXELS], ao[PIXELS];
static float normal[3][PIXELS]; /* all x, then all y, then all z */

/* Draws a floor at y = 1 and a wall at z = 5, in view space: x right, y down, z
 * forward. */
static void draw(const hbil_camera *c) {
  for (int i = 0; i < PIXELS; ++i) {
    double y = (i / WIDTH + 0.5 - c->cy) / c->fy; /* of the ray with z = 1 */
    int is_floor = y > 1.0 / 5.0;
    depth[i] = is_floor ? (float)(1.0 / y) : 5.0f;
    normal[1][i] = is_floor ? -1.0f : 0.0f;
    normal[2][i] = is_floor ? 0.0f : -1.0f;
  }
}

static int fail(const char *what, const char *why) {
  fprintf(stderr, "01_minimal: %s: %s\n", what, why);
  return 1;
}

int main(void) {
  /* Your program has a device, a context, a queue, and buffers with a frame. */
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
  frame.camera.fx = frame.camera.fy = 200.0;
  frame.camera.cx = WIDTH / 2.0;
  frame.camera.cy = HEIGHT / 2.0;
  for (int i = 0; i < 4; ++i)
    frame.camera.world_from_view[5 * i] = 1.0;
  draw(&frame.camera);
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
  const hbil_plane_format floats = {HBIL_FLOAT32, 4};
  config.inputs.depth = config.inputs.normal = config.outputs.ao = floats;
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
  clEnqueueReadBuffer(queue, frame.ao.buffer, CL_TRUE, 0, sizeof ao, ao, 0,
                      NULL, NULL);
  double mean = 0.0;
  for (int i = 0; i < PIXELS; ++i)
    mean += ao[i] / PIXELS;
  printf("mean ambient visibility: %.4f\n", mean);

  hbil_plan_destroy(plan);
  hbil_context_destroy(hbil);
  clReleaseMemObject(frame.ao.buffer);
  clReleaseMemObject(frame.normal.buffer);
  clReleaseMemObject(frame.depth.buffer);
  clReleaseCommandQueue(queue);
  clReleaseContext(context);
  return mean > 0.7 && mean < 0.9 ? 0 : fail("mean", "not that of the frame");
}
