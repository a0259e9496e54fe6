/*
 * A renderer's loop.  hbil gets what the renderer has anyway: the depth buffer,
 * projection and view matrices, packed normals, motion vectors, images; and its
 * result is an image for the next pass.  On devices without images the same
 * planes are buffers.
 *
 * This renderer has Vulkan's conventions: the first row is at y = -1 of clip
 * space, matrices are stored by columns, depth is reversed without a far plane.
 * Its picture is jittered; it shows a red wall and a ball that rolls by.
 */
#include <hbil/hbil.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 320, HEIGHT = 180, FRAMES = 6 };

/* The renderer's only pass: a G-buffer by ray casting.  Motion is the place on
 * the last picture minus that on this one, each with its own jitter. */
static const char *source =
    "#ifdef IMAGES\n"
    "#define PLANE write_only image2d_t\n"
    "#define PUT(plane, value) write_imagef(plane, at, value)\n"
    "#else\n"
    "#define PLANE global float4 *\n"
    "#define PUT(plane, value) plane[i] = value\n"
    "#endif\n"
    "#define TIMES(m, v) (m.s0123 * v.x + m.s4567 * v.y + m.s89ab * v.z)\n"
    "typedef struct { float16 projection, view; } camera;\n"
    "kernel void draw(camera now, camera last, float ball, float rolled,\n"
    "                 PLANE depth, global uint *normal, PLANE albedo,\n"
    "                 PLANE direct, PLANE motion) {\n"
    "  int2 at = (int2)(get_global_id(0), get_global_id(1));\n"
    "  int i = at.y * get_global_size(0) + at.x;\n"
    "  float2 size = (float2)(get_global_size(0), get_global_size(1));\n"
    "  float2 clip = (convert_float2(at) + 0.5f) / size * 2 - 1;\n"
    "  float3 eye = -now.view.scde, n = (float3)(0, 0, 1), moved = 0;\n"
    "  float3 ray = (float3)((clip + now.projection.s89) /\n"
    "                        now.projection.s05, -1), colour = 0.8f;\n"
    "  float wall = (-2 - eye.x) / ray.x, ground = -eye.y / ray.y;\n"
    "  float s = (-5 - eye.z) / ray.z; /* the back wall */\n"
    "  if (ground > 0 && ground < s) s = ground, n = (float3)(0, 1, 0);\n"
    "  if (wall > 0 && wall < s)\n"
    "    s = wall, n = (float3)(1, 0, 0), colour.yz = 0.05f;\n"
    "  float3 to = eye - (float3)(ball, 0.5f, -3);\n"
    "  float rr = dot(ray, ray), rt = dot(ray, to), tt = dot(to, to) - 0.25f;\n"
    "  float front = (-rt - sqrt(rt * rt - rr * tt)) / rr; /* NaN: missed */\n"
    "  if (front > 0 && front < s)\n"
    "    s = front, n = 2 * (to + s * ray), moved.x = rolled;\n"
    "  float3 p = eye + s * ray, lamp = (float3)(0, 3, -2) - p;\n"
    "  float3 seen = p - eye, before = p - moved + last.view.scde;\n"
    "  float4 here = TIMES(now.projection, seen) + now.projection.scdef;\n"
    "  float4 there = TIMES(last.projection, before) + last.projection.scdef;\n"
    "  float2 way = (there.xy / there.w - here.xy / here.w) * 0.5f * size;\n"
    "  uint3 q = convert_uint3_rte((n * 0.5f + 0.5f) * 1023);\n"
    "  normal[i] = q.x | q.y << 10 | q.z << 20;\n"
    "  PUT(depth, (float4)(here.z / here.w));\n"
    "  PUT(albedo, (float4)(colour, 1)); PUT(motion, (float4)(way, 0, 0));\n"
    "  PUT(direct, (float4)(2 * max(0.0f, dot(n, normalize(lamp)))));\n"
    "}\n";

static void check(int good, const char *what) {
  if (good)
    return;
  fprintf(stderr, "07_renderer_loop: %s\n", what);
  exit(1);
}

static void check_hbil(hbil_status status, const hbil_context *hbil) {
  check(status == HBIL_SUCCESS, hbil_context_message(hbil));
}

/* Four floats a pixel, in an image or in a buffer. */
static cl_mem make_plane(cl_context context, cl_bool image) {
  const cl_image_format format = {CL_RGBA, CL_FLOAT};
  const cl_image_desc desc = {.image_type = CL_MEM_OBJECT_IMAGE2D,
                              .image_width = WIDTH,
                              .image_height = HEIGHT};
  return image ? clCreateImage(context, 0, &format, &desc, NULL, NULL)
               : clCreateBuffer(context, 0, 16 * WIDTH * HEIGHT, NULL, NULL);
}

/* The matrices of a frame, column by column: projection, then view.  It looks
 * along -z; the depth is 0.1 / distance; the jitter is a quarter of a pixel. */
static void look(int frame, double m[32]) {
  const double x = 0.5 - 0.02 * frame, jitter = frame % 2 ? 0.5 : -0.5;
  const double right = jitter / WIDTH, up = -jitter / HEIGHT;
  const double matrices[32] = {
      1, 0, 0, 0, 0, -16.0 / 9, 0, 0, right, up, 0, -1, 0, 0,    0.1, 0,
      1, 0, 0, 0, 0, 1,         0, 0, 0,     0,  1, 0,  x, -1.2, -1,  1};
  memcpy(m, matrices, sizeof matrices);
}

static void draw(cl_command_queue queue, cl_kernel kernel, int frame,
                 cl_mem *const planes[5]) {
  const float rolled = 0.05f, ball = -0.6f + rolled * (float)frame;
  const size_t size[2] = {WIDTH, HEIGHT};
  cl_int error = clSetKernelArg(kernel, 2, sizeof ball, &ball);
  error |= clSetKernelArg(kernel, 3, sizeof rolled, &rolled);
  for (cl_uint i = 0; i < 5; ++i)
    error |= clSetKernelArg(kernel, 4 + i, sizeof(cl_mem), planes[i]);
  for (int back = 0; back < 2; ++back) { /* this frame, the last one */
    double m[32];
    float f[32];
    look(frame > back ? frame - back : 0, m);
    for (int i = 0; i < 32; ++i)
      f[i] = (float)m[i];
    error |= clSetKernelArg(kernel, (cl_uint)back, sizeof f, f);
  }
  error |= clEnqueueNDRangeKernel(queue, kernel, 2, 0, size, 0, 0, 0, 0);
  check(error == CL_SUCCESS, "draw");
}

/* Prints the light of a pixel on the floor beside the wall; returns its red. */
static float measure(cl_command_queue queue, cl_mem light, cl_bool image) {
  const size_t at[3] = {WIDTH * 3 / 10, HEIGHT * 7 / 8, 0}, one[3] = {1, 1, 1};
  float pixel[4];
  check((image ? clEnqueueReadImage(queue, light, CL_TRUE, at, one, 0, 0, pixel,
                                    0, NULL, NULL)
               : clEnqueueReadBuffer(queue, light, CL_TRUE,
                                     16 * (at[1] * WIDTH + at[0]), 16, pixel, 0,
                                     NULL, NULL)) == CL_SUCCESS,
        "the result could not be read");
  printf("floor by the red wall: indirect light %.4f red, %.4f green\n",
         pixel[0], pixel[1]);
  check(pixel[0] > 1.2f * pixel[1], "the red wall does not colour the floor");
  return pixel[0];
}

int main(void) {
  cl_platform_id platform = NULL;
  cl_device_id device = NULL;
  cl_bool images = CL_FALSE;
  clGetPlatformIDs(1, &platform, NULL);
  clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &device, NULL);
  check(device != NULL, "no OpenCL device on the first platform");
  clGetDeviceInfo(device, CL_DEVICE_IMAGE_SUPPORT, sizeof images, &images, 0);
  cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
  cl_command_queue queue = clCreateCommandQueue(context, device, 0, NULL);
  cl_program program = clCreateProgramWithSource(context, 1, &source, 0, NULL);
  clBuildProgram(program, 1, &device, images ? "-DIMAGES" : "", NULL, NULL);
  cl_kernel kernel = clCreateKernel(program, "draw", NULL);
  check(kernel != NULL, "the renderer's kernel was not built");

  /* Once: what the planes are. */
  const hbil_plane_format format = {images ? HBIL_IMAGE : HBIL_FLOAT32, 4};
  hbil_config config;
  hbil_config_init(&config);
  config.width = WIDTH;
  config.height = HEIGHT;
  config.inputs.depth = config.inputs.albedo = config.inputs.direct = format;
  config.inputs.motion = config.outputs.indirect = format;
  config.inputs.normal = (hbil_plane_format){HBIL_RGB10A2_UNORM, 4};
  config.inputs.depth_kind = HBIL_DEPTH_HARDWARE;
  config.inputs.normal_space = HBIL_SPACE_WORLD;
  config.history.reprojection = HBIL_REPROJECTION_MOTION;
  hbil_context *hbil = NULL;
  hbil_plan *plan = NULL;
  check_hbil(hbil_context_create(context, device, &hbil), NULL);
  check_hbil(hbil_plan_create(hbil, &config, &plan), hbil);
  hbil_frame frame;
  hbil_frame_init(&frame);
  cl_mem *const planes[6] = {&frame.depth.buffer,  &frame.normal.buffer,
                             &frame.albedo.buffer, &frame.direct.buffer,
                             &frame.motion.buffer, &frame.indirect.buffer};
  for (int i = 0; i < 6; ++i)
    *planes[i] = make_plane(context, images && i != 1);

  /* Every frame: draw it, light it.  The queue is in order, and nothing waits
   * but measure(), which a renderer doesn't have. */
  float light[FRAMES];
  for (cl_uint i = 0; i < FRAMES; ++i) {
    double m[32];
    look((int)i, m);
    draw(queue, kernel, (int)i, planes);
    check_hbil(hbil_camera_from_matrices(
                   &frame.camera, frame.hardware_depth, &config, m, m + 16,
                   HBIL_MATRIX_COLUMN_MAJOR | HBIL_MATRIX_REVERSED_DEPTH |
                       HBIL_MATRIX_Y_DOWN),
               NULL);
    check_hbil(hbil_enqueue_frame(plan, queue, &frame, 0, NULL, NULL), hbil);
    light[i] = measure(queue, frame.indirect.buffer, images);
  }
  check(light[FRAMES - 1] > 1.2f * light[0],
        "light does not bounce from frame to frame");

  hbil_plan_destroy(plan);
  hbil_context_destroy(hbil);
  for (int i = 0; i < 6; ++i)
    clReleaseMemObject(*planes[i]);
  clReleaseKernel(kernel);
  clReleaseProgram(program);
  clReleaseCommandQueue(queue);
  clReleaseContext(context);
  return 0;
}
