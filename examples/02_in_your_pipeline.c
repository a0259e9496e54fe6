/*
 * hbil inside an existing renderer.  This renderer has an out-of-order queue,
 * orders its commands by events only, and stores interleaved planes with padded
 * rows, partly in half floats.
 *
 * The scene is a floor between a red and a green wall, both lit evenly.  There
 * are two frames: light of the first one bounces again in the second one.
 */
#include <hbil/hbil.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
  WIDTH = 250,
  HEIGHT = 141,
  FRAMES = 2,
  /* The renderer has a header before each image, and aligns rows; bytes. */
  HEADER = 512,
  GEOMETRY_ROW = 4096, /* RGBA fp32: normal, depth */
  ALBEDO_ROW = 1024,   /* RGBA8 */
  LIGHT_ROW = 2048     /* RGBA fp16 */
};

typedef struct renderer {
  cl_device_id device;
  cl_context context;
  cl_command_queue queue;
  cl_mem geometry, albedo, direct, result;
  /* Memory for uploads and downloads, which the queue uses until it is done. */
  unsigned char host_geometry[HEADER + GEOMETRY_ROW * HEIGHT];
  unsigned char host_albedo[HEADER + ALBEDO_ROW * HEIGHT];
  unsigned char host_direct[HEADER + LIGHT_ROW * HEIGHT];
  unsigned char host_result[FRAMES][HEADER + LIGHT_ROW * HEIGHT];
} renderer;

static void fail(const char *what, const char *why) {
  fprintf(stderr, "02_in_your_pipeline: %s: %s\n", what, why);
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

static float from_half(const unsigned char *bytes) {
  unsigned short h;
  memcpy(&h, bytes, sizeof h);
  int exponent = h >> 10 & 31, fraction = h & 1023;
  float sign = h & 0x8000 ? -1.0f : 1.0f;
  if (exponent == 31)
    return fraction != 0 ? NAN : sign * INFINITY;
  if (exponent == 0)
    return sign * ldexpf((float)fraction, -24);
  return sign * ldexpf((float)(fraction + 1024), exponent - 25);
}

/* ------------------------------------------------------------------------ */
/* The renderer                                                              */

static hbil_camera camera(void) {
  return (hbil_camera){
      .fx = 160.0,
      .fy = 160.0,
      .cx = WIDTH / 2.0,
      .cy = HEIGHT / 2.0,
      .world_from_view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
}

static void draw_pixel(renderer *r, int x, int y) {
  hbil_camera c = camera();
  float rx = (float)((x + 0.5 - c.cx) / c.fx);
  float ry = (float)((y + 0.5 - c.cy) / c.fy);
  float floor_z = ry > 0.0f ? 1.0f / ry : INFINITY;
  float wall_z = 1.2f / fabsf(rx); /* walls at x = -1.2 and 1.2 */
  float z = fminf(4.0f, fminf(floor_z, wall_z));
  float geometry[4] = {0.0f, 0.0f, 0.0f, z};
  unsigned char albedo[4] = {200, 200, 200, 255};
  if (z == wall_z) {
    geometry[0] = rx < 0.0f ? 1.0f : -1.0f;
    albedo[0] = rx < 0.0f ? 200 : 20;
    albedo[1] = rx < 0.0f ? 20 : 200;
    albedo[2] = 20;
  } else if (z == floor_z) {
    geometry[1] = -1.0f;
  } else {
    geometry[2] = -1.0f;
  }
  const unsigned short one = 0x3c00, light[4] = {one, one, one, 0};
  memcpy(r->host_geometry + HEADER + y * GEOMETRY_ROW + x * 16, geometry, 16);
  memcpy(r->host_albedo + HEADER + y * ALBEDO_ROW + x * 4, albedo, 4);
  memcpy(r->host_direct + HEADER + y * LIGHT_ROW + x * 8, light, 8);
}

static cl_mem make_buffer(const renderer *r, size_t bytes) {
  cl_int error;
  cl_mem m = clCreateBuffer(r->context, CL_MEM_READ_WRITE, bytes, NULL, &error);
  check_cl(error, "clCreateBuffer");
  return m;
}

static renderer *renderer_create(void) {
  renderer *r = calloc(1, sizeof *r);
  if (r == NULL)
    fail("renderer", "out of memory");
  cl_platform_id platforms[16];
  cl_uint count = 0;
  clGetPlatformIDs(16, platforms, &count);
  for (cl_uint i = 0; i < count && i < 16 && r->device == NULL; ++i)
    clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, 1, &r->device, NULL);
  if (r->device == NULL)
    fail("OpenCL", "no device");
  cl_int error;
  r->context = clCreateContext(NULL, 1, &r->device, NULL, NULL, &error);
  check_cl(error, "clCreateContext");
  /* Devices without out-of-order queues run the commands in order, which is
   * correct as well. */
  cl_command_queue_properties can = 0;
  clGetDeviceInfo(r->device, CL_DEVICE_QUEUE_PROPERTIES, sizeof can, &can,
                  NULL);
  r->queue = clCreateCommandQueue(r->context, r->device,
                                  can & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE,
                                  &error);
  check_cl(error, "clCreateCommandQueue");
  r->geometry = make_buffer(r, sizeof r->host_geometry);
  r->albedo = make_buffer(r, sizeof r->host_albedo);
  r->direct = make_buffer(r, sizeof r->host_direct);
  r->result = make_buffer(r, sizeof r->host_result[0]);
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x)
      draw_pixel(r, x, y);
  return r;
}

static void renderer_destroy(renderer *r) {
  clReleaseMemObject(r->geometry);
  clReleaseMemObject(r->albedo);
  clReleaseMemObject(r->direct);
  clReleaseMemObject(r->result);
  clReleaseCommandQueue(r->queue);
  clReleaseContext(r->context);
  free(r);
}

/* Uploads a frame after the event `after`.  Returns the events of the three
 * uploads in `done`. */
static void upload(renderer *r, cl_event after, cl_event done[3]) {
  check_cl(clEnqueueWriteBuffer(r->queue, r->geometry, CL_FALSE, 0,
                                sizeof r->host_geometry, r->host_geometry, 1,
                                &after, &done[0]),
           "clEnqueueWriteBuffer");
  check_cl(clEnqueueWriteBuffer(r->queue, r->albedo, CL_FALSE, 0,
                                sizeof r->host_albedo, r->host_albedo, 1,
                                &after, &done[1]),
           "clEnqueueWriteBuffer");
  check_cl(clEnqueueWriteBuffer(r->queue, r->direct, CL_FALSE, 0,
                                sizeof r->host_direct, r->host_direct, 1,
                                &after, &done[2]),
           "clEnqueueWriteBuffer");
}

/* ------------------------------------------------------------------------ */
/* hbil                                                                      */

static hbil_plan *plan_create(hbil_context *hbil) {
  hbil_config config;
  hbil_config_init(&config);
  config.width = WIDTH;
  config.height = HEIGHT;
  config.inputs.depth = (hbil_plane_format){HBIL_FLOAT32, 16};
  config.inputs.normal = (hbil_plane_format){HBIL_FLOAT32, 16};
  config.inputs.albedo = (hbil_plane_format){HBIL_UNORM8, 4};
  config.inputs.direct = (hbil_plane_format){HBIL_FLOAT16, 8};
  config.inputs.direct_scale = 3.14159265f; /* `direct` holds irradiance / pi */
  config.outputs.near_irradiance = (hbil_plane_format){HBIL_FLOAT16, 8};
  config.outputs.ao = (hbil_plane_format){HBIL_FLOAT16, 8};
  hbil_memory bytes;
  check(hbil_plan_memory(hbil, &config, &bytes), hbil);
  printf("hbil takes %.1f MiB of device memory, %.1f of them only during a "
         "frame\n",
         (double)(bytes.persistent + bytes.scratch) / 1048576.0,
         (double)bytes.scratch / 1048576.0);
  hbil_plan *plan = NULL;
  check(hbil_plan_create(hbil, &config, &plan), hbil);
  return plan;
}

static hbil_frame frame_of(const renderer *r, cl_uint index) {
  hbil_frame f;
  hbil_frame_init(&f);
  f.camera = camera();
  f.frame_index = index;
  /* Depth is the fourth component of the pixels with the normal. */
  f.normal = (hbil_plane){r->geometry, HEADER, GEOMETRY_ROW, 0};
  f.depth = (hbil_plane){r->geometry, HEADER + 12, GEOMETRY_ROW, 0};
  f.albedo = (hbil_plane){r->albedo, HEADER, ALBEDO_ROW, 0};
  f.direct = (hbil_plane){r->direct, HEADER, LIGHT_ROW, 0};
  /* The result is RGBA fp16, with E_near as RGB and AO as alpha. */
  f.near_irradiance = (hbil_plane){r->result, HEADER, LIGHT_ROW, 0};
  f.ao = (hbil_plane){r->result, HEADER + 6, LIGHT_ROW, 0};
  return f;
}

static void release(cl_event *events, int count) {
  for (int i = 0; i < count; ++i)
    clReleaseEvent(events[i]);
}

/* Enqueues all frames after the event `gate`.  Returns the event of the last
 * download. */
static cl_event enqueue_all(renderer *r, hbil_context *hbil, hbil_plan *plan,
                            cl_event gate) {
  cl_event last = gate;
  clRetainEvent(last);
  for (cl_uint i = 0; i < FRAMES; ++i) {
    cl_event uploads[3], lit, read;
    /* The buffers are free again when the last result has been read. */
    upload(r, last, uploads);
    hbil_frame frame = frame_of(r, i);
    check(hbil_enqueue_frame(plan, r->queue, &frame, 3, uploads, &lit), hbil);
    check_cl(clEnqueueReadBuffer(r->queue, r->result, CL_FALSE, 0,
                                 sizeof r->host_result[i], r->host_result[i], 1,
                                 &lit, &read),
             "clEnqueueReadBuffer");
    release(uploads, 3);
    release(&lit, 1);
    release(&last, 1);
    last = read;
  }
  return last;
}

/* Computes means over the floor next to the red wall.  Returns 0 if a value is
 * negative or not finite. */
static int measure(const unsigned char *result, float mean[4]) {
  int count = 0, sane = 1;
  memset(mean, 0, 4 * sizeof *mean);
  for (int y = HEIGHT * 3 / 4; y < HEIGHT * 7 / 8; ++y)
    for (int x = WIDTH / 5; x < WIDTH * 2 / 5; ++x, ++count)
      for (int c = 0; c < 4; ++c) {
        float v = from_half(result + HEADER + y * LIGHT_ROW + x * 8 + 2 * c);
        sane = sane && isfinite(v) && v >= 0.0f;
        mean[c] += v;
      }
  for (int c = 0; c < 4; ++c)
    mean[c] /= (float)count;
  return sane;
}

int main(void) {
  renderer *r = renderer_create();
  hbil_context *hbil = NULL;
  check(hbil_context_create(r->context, r->device, &hbil), hbil);
  hbil_plan *plan = plan_create(hbil);

  /* No command runs before the gate opens, and no call waits for it.  So both
   * frames are enqueued before their inputs have arrived. */
  cl_int error;
  cl_event gate = clCreateUserEvent(r->context, &error);
  check_cl(error, "clCreateUserEvent");
  cl_event last = enqueue_all(r, hbil, plan, gate);
  check_cl(clFlush(r->queue), "clFlush");
  check_cl(clSetUserEventStatus(gate, CL_COMPLETE), "clSetUserEventStatus");
  check_cl(clWaitForEvents(1, &last), "clWaitForEvents");
  release(&gate, 1);
  release(&last, 1);

  float mean[FRAMES][4];
  for (int i = 0; i < FRAMES; ++i) {
    if (!measure(r->host_result[i], mean[i]))
      fail("result", "not finite, or below 0");
    printf("frame %d: floor by the red wall: near light %.3f %.3f %.3f, "
           "visibility %.3f\n",
           i, mean[i][0], mean[i][1], mean[i][2], mean[i][3]);
  }
  hbil_plan_destroy(plan);
  hbil_context_destroy(hbil);
  renderer_destroy(r);
  if (!(mean[0][0] > 1.05f * mean[0][1]))
    fail("result", "the red wall does not colour the floor");
  if (!(mean[1][0] > 1.05f * mean[0][0]))
    fail("result", "the second frame adds no second bounce");
  if (!(mean[0][3] > 0.1f && mean[0][3] < 0.99f))
    fail("result", "the floor is not partly shaded");
  return 0;
}
