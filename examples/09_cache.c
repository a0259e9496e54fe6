/*
 * A radiance cache in a renderer's loop.  A camera turns in a closed room,
 * where a lamp lights the red wall behind it.  The first frame looks away from
 * that wall and shows nothing that is lit.  The last one looks the same way; by
 * then the cache has seen the wall, and the room has its light.
 */
#include <hbil/hbil.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 160, HEIGHT = 120, PIXELS = WIDTH * HEIGHT, FRAMES = 9 };

/* The renderer: a room of 6 x 3 x 6 m, y up; 90 degrees of it, about -z. */
static const char *source =
    "kernel void draw(float c, float s, global float *depth, global float4 "
    "*n,\n"
    "                 global float4 *albedo, global float4 *direct) {\n"
    "  int x = get_global_id(0), y = get_global_id(1), i = 160 * y + x;\n"
    "  float u = (x + 0.5f) / 80 - 1, v = 0.75f - (y + 0.5f) / 80;\n"
    "  float3 ray = (float3)(c * u + s, v, s * u - c), wall = 3 * sign(ray);\n"
    "  float3 eye = (float3)(0.5f * s, 1.5f, -0.5f * c);\n"
    "  wall.y = v > 0 ? 3 : 0;\n"
    "  float3 t = (wall - eye) / ray;\n"
    "  float z = min(t.x, min(t.y, t.z));\n"
    "  float3 p = eye + z * ray - (float3)(0, 1.5f, 0);\n"
    "  float3 side = -sign(ray) * convert_float3(-(t == z));\n"
    "  float lit = max(normalize(p).z - 0.6f, 0.0f) / dot(p, p);\n"
    "  depth[i] = z, n[i] = (float4)(side, 0);\n"
    "  albedo[i] = side.z < 0 ? (float4)(0.7f, 0.1f, 0.1f, 1) : 0.7f;\n"
    "  direct[i] = 100 * lit * max(-dot(normalize(p), side), 0.0f);\n"
    "}\n";

static hbil_context *hbil;

static void check(int good) {
  if (!good)
    exit((fprintf(stderr, "09_cache: %s\n", hbil_context_message(hbil)), 1));
}

int main(void) {
  cl_platform_id platform = NULL;
  cl_device_id device = NULL;
  clGetPlatformIDs(1, &platform, NULL);
  clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &device, NULL);
  cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
  cl_command_queue queue = clCreateCommandQueue(context, device, 0, NULL);
  cl_program program = clCreateProgramWithSource(context, 1, &source, 0, NULL);
  clBuildProgram(program, 1, &device, "", NULL, NULL);
  cl_kernel draw = clCreateKernel(program, "draw", NULL);
  check(hbil_context_create(context, device, &hbil) == HBIL_SUCCESS);

  /* Once: a plan, and a cache for it whose coarse level is 12.8 m wide. */
  const hbil_plane_format rgba = {HBIL_FLOAT32, 16};
  hbil_config config;
  hbil_config_init(&config);
  config.width = WIDTH, config.height = HEIGHT;
  config.inputs.depth = (hbil_plane_format){HBIL_FLOAT32, 4};
  config.inputs.normal = config.inputs.albedo = config.inputs.direct = rgba;
  config.inputs.normal_space = HBIL_SPACE_WORLD;
  config.outputs.indirect = rgba;
  hbil_cache_config room;
  hbil_cache_config_init(&room);
  room.voxel_size = 0.1;
  hbil_config_use_cache(&config, &room);
  hbil_plan *plan = NULL;
  hbil_frame frame;
  hbil_frame_init(&frame);
  check(hbil_cache_create(hbil, &room, &frame.cache) == HBIL_SUCCESS);
  check(hbil_plan_create(hbil, &config, &plan) == HBIL_SUCCESS);
  cl_mem *const planes[] = {&frame.depth.buffer, &frame.normal.buffer,
                            &frame.albedo.buffer, &frame.direct.buffer,
                            &frame.indirect.buffer};
  for (int i = 0; i < 5; ++i)
    *planes[i] = clCreateBuffer(context, 0, 16 * PIXELS, NULL, NULL);

  static float light[PIXELS][4];
  double red[FRAMES] = {0};
  for (int i = 0; i < FRAMES; ++i) {
    const double turn = 6.28318530717959 * i / (FRAMES - 1);
    const double c = cos(turn), s = sin(turn);
    const double to_world[16] = {c, 0, -s, 0.5 * s,  0, 1, 0, 1.5,
                                 s, 0, c,  -0.5 * c, 0, 0, 0, 1};
    const cl_float turned[] = {(cl_float)c, (cl_float)s};
    const size_t size[] = {WIDTH, HEIGHT};
    for (cl_uint k = 0; k < 6; ++k)
      clSetKernelArg(draw, k, k < 2 ? sizeof *turned : sizeof(cl_mem),
                     k < 2 ? (const void *)&turned[k] : planes[k - 2]);
    clEnqueueNDRangeKernel(queue, draw, 2, 0, size, 0, 0, 0, 0);
    hbil_camera_from_opengl(&frame.camera, to_world, 80, 80, 80, 60);

    /* Show the frame to the cache, let light bounce there, light the frame. */
    hbil_view view;
    hbil_view_from_frame(&view, &config, &frame);
    check(!hbil_enqueue_cache_inject(frame.cache, queue, &view, 1, 0, 0, 0));
    check(!hbil_enqueue_cache_update(frame.cache, queue, NULL, 0, 0, 0));
    check(!hbil_enqueue_frame(plan, queue, &frame, 0, 0, 0));
    clEnqueueReadBuffer(queue, *planes[4], 1, 0, sizeof light, light, 0, 0, 0);
    for (int p = 0; p < PIXELS; ++p)
      red[i] += (double)light[p][0] / PIXELS;
    printf("frame %d: mean red light %.3f\n", i, red[i]);
  }
  hbil_plan_destroy(plan);
  hbil_cache_destroy(frame.cache);
  hbil_context_destroy(hbil);
  return red[FRAMES - 1] > red[0] + 0.1 ? 0 : 1;
}
