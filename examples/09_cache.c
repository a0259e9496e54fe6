/*
 * A renderer's loop with a radiance cache.  A camera turns in a closed room; a
 * lamp lights the red wall behind it.  The frame that looks away from that wall
 * shows nothing that is lit.  What earlier frames have shown is in the cache,
 * so when the camera looks there again, the room has the red wall's light.
 *
 * The same frames are lit without a cache, too, to compare.  A path tracer gets
 * 0.209 red and 0.047 green for the last frame: floor and ceiling near the
 * camera have not been seen by any frame, and their light is a guess.
 */
#include <hbil/hbil.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 160, HEIGHT = 120, PIXELS = WIDTH * HEIGHT };
enum { TURN = 8, FRAMES = TURN + 1 }; /* the last frame looks as the first */

/* The renderer's only pass: a G-buffer by ray casting.  The room is 6 m wide
 * and long and 3 m high; y is up. */
static const char *source =
    "kernel void draw(float16 m, global float *depth, global float4 *normal,\n"
    "                 global float4 *albedo, global float4 *direct) {\n"
    "  float2 at = (float2)(get_global_id(0), get_global_id(1)) + 0.5f;\n"
    "  float2 size = (float2)(get_global_size(0), get_global_size(1));\n"
    "  int i = get_global_id(1) * get_global_size(0) + get_global_id(0);\n"
    "  at = (2 * at - size) / size.x; /* 90 degrees wide */\n"
    "  float3 eye = m.s37b, ray = m.s048 * at.x - m.s159 * at.y - m.s26a;\n"
    "  float3 room = select((float3)(-3, 0, -3), (float3)(3), ray > 0);\n"
    "  float3 s = fabs((room - eye) / ray), n = 0;\n"
    "  float z = min(s.x, min(s.y, s.z));\n"
    "  if (z == s.x) n.x = -sign(ray.x);\n"
    "  else if (z == s.y) n.y = -sign(ray.y);\n"
    "  else n.z = -sign(ray.z);\n"
    "  float3 p = eye + z * ray, to = p - (float3)(0, 1.5f, 0);\n"
    "  float3 beam = normalize(to);\n"
    "  float lit = max(beam.z - 0.6f, 0.0f) * max(-dot(beam, n), 0.0f);\n"
    "  depth[i] = z, normal[i] = (float4)(n, 0);\n"
    "  albedo[i] = n.z < 0 ? (float4)(0.7f, 0.1f, 0.1f, 1) : (float4)(0.7f);\n"
    "  direct[i] = 100 * lit / dot(to, to);\n"
    "}\n";

static void check(int good, const char *what) {
  if (!good) {
    fprintf(stderr, "09_cache: %s\n", what);
    exit(1);
  }
}

static hbil_context *hbil;

static void check_hbil(hbil_status status) {
  check(status == HBIL_SUCCESS, hbil_context_message(hbil));
}

/* The camera of a frame: it walks in a small circle and turns to the right,
 * from -z on.  In OpenGL's convention, row by row. */
static void look(int frame, double camera_to_world[16]) {
  const double turned = 2.0 * 3.14159265358979 * (frame % TURN) / TURN;
  const double c = cos(turned), s = sin(turned);
  const double m[16] = {c, 0, -s, 0.5 * s,  0, 1, 0, 1.5,
                        s, 0, c,  -0.5 * c, 0, 0, 0, 1};
  memcpy(camera_to_world, m, sizeof m);
}

static void draw(cl_command_queue queue, cl_kernel kernel, const double m[16],
                 const hbil_frame *frame) {
  cl_float to_world[16];
  for (int i = 0; i < 16; ++i)
    to_world[i] = (cl_float)m[i];
  const cl_mem planes[] = {frame->depth.buffer, frame->normal.buffer,
                           frame->albedo.buffer, frame->direct.buffer};
  const size_t size[2] = {WIDTH, HEIGHT};
  cl_int error = clSetKernelArg(kernel, 0, sizeof to_world, to_world);
  for (cl_uint i = 0; i < 4; ++i)
    error |= clSetKernelArg(kernel, 1 + i, sizeof(cl_mem), &planes[i]);
  error |= clEnqueueNDRangeKernel(queue, kernel, 2, 0, size, 0, 0, 0, 0);
  check(error == CL_SUCCESS, "draw");
}

/* Lights the frame.  mean: of its indirect light, red and green. */
static void light_frame(hbil_plan *plan, cl_command_queue queue,
                        const hbil_frame *frame, double mean[2]) {
  static float pixels[PIXELS][4];
  check_hbil(hbil_enqueue_frame(plan, queue, frame, 0, NULL, NULL));
  check(clEnqueueReadBuffer(queue, frame->indirect.buffer, CL_TRUE, 0,
                            sizeof pixels, pixels, 0, 0, 0) == CL_SUCCESS,
        "the result could not be read");
  mean[0] = mean[1] = 0.0;
  for (int i = 0; i < PIXELS; ++i)
    for (int c = 0; c < 2; ++c)
      mean[c] += (double)pixels[i][c] / PIXELS;
}

/* What the planes are; the same for frames and for views. */
static void describe(hbil_config *config) {
  const hbil_plane_format rgba = {HBIL_FLOAT32, 4};
  hbil_config_init(config);
  config->width = WIDTH, config->height = HEIGHT;
  config->inputs.depth = (hbil_plane_format){HBIL_FLOAT32, 1};
  config->inputs.normal = config->inputs.albedo = config->inputs.direct = rgba;
  config->inputs.normal_space = HBIL_SPACE_WORLD;
  config->outputs.indirect = rgba;
  config->model.far_field = HBIL_FAR_FRAME;
}

/* The same pixels as a view for the cache. */
static hbil_view view_of(const hbil_frame *frame) {
  hbil_view view;
  hbil_view_init(&view);
  view.width = WIDTH, view.height = HEIGHT;
  view.camera = frame->camera;
  view.depth = frame->depth;
  view.normal = frame->normal;
  view.albedo = frame->albedo;
  view.direct = frame->direct;
  return view;
}

int main(void) {
  cl_platform_id platform = NULL;
  cl_device_id device = NULL;
  clGetPlatformIDs(1, &platform, NULL);
  clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &device, NULL);
  check(device != NULL, "no OpenCL device on the first platform");
  cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
  cl_command_queue queue = clCreateCommandQueue(context, device, 0, NULL);
  cl_program program = clCreateProgramWithSource(context, 1, &source, 0, NULL);
  clBuildProgram(program, 1, &device, "", NULL, NULL);
  cl_kernel kernel = clCreateKernel(program, "draw", NULL);
  check(kernel != NULL, "the renderer's kernel was not built");
  check_hbil(hbil_context_create(context, device, &hbil));

  /* Once: a cache, whose coarse level is 12.8 m wide and holds the room; */
  hbil_cache *cache = NULL;
  hbil_cache_config known;
  hbil_cache_config_init(&known);
  hbil_config config;
  describe(&config);
  known.voxel_size = 0.1;
  known.inputs = config.inputs;
  check_hbil(hbil_cache_create(hbil, &known, &cache));
  /* a plan for frames without it, and one for frames with it. */
  hbil_plan *with = NULL, *without = NULL;
  check_hbil(hbil_plan_create(hbil, &config, &without));
  hbil_model_set(&config.model, HBIL_MODEL_WORLD);
  config.model.radius = (float)(HBIL_CACHE_NEAR_VOXELS * known.voxel_size);
  check_hbil(hbil_plan_create(hbil, &config, &with));
  hbil_frame frame;
  hbil_frame_init(&frame);
  cl_mem *const planes[] = {&frame.depth.buffer, &frame.normal.buffer,
                            &frame.albedo.buffer, &frame.direct.buffer,
                            &frame.indirect.buffer};
  for (int i = 0; i < 5; ++i)
    *planes[i] = clCreateBuffer(context, 0, 16 * PIXELS, NULL, NULL);

  /* Every frame: draw it, show it to the cache, let light bounce there, light
   * it.  The queue is in order, and nothing waits but light_frame(). */
  hbil_cache_update bounces;
  hbil_cache_update_init(&bounces);
  bounces.far_field = config.model.far_field;
  double light[2], dark[2];
  for (cl_uint i = 0; i < FRAMES; ++i) {
    double m[16];
    look((int)i, m);
    hbil_camera_from_opengl(&frame.camera, m, WIDTH / 2.0, WIDTH / 2.0,
                            WIDTH / 2.0, HEIGHT / 2.0);
    frame.frame_index = i;
    const double eye[3] = {m[3], m[7], m[11]};
    const hbil_view view = view_of(&frame);
    draw(queue, kernel, m, &frame);
    check_hbil(hbil_enqueue_cache_move(cache, queue, eye, 0, 0, 0));
    check_hbil(hbil_enqueue_cache_inject(cache, queue, &view, 1, 0, 0, 0));
    check_hbil(hbil_enqueue_cache_update(cache, queue, &bounces, 0, 0, 0));
    frame.cache = cache;
    light_frame(with, queue, &frame, light);
    frame.cache = NULL;
    light_frame(without, queue, &frame, dark);
    printf("frame %u: red %.3f, green %.3f; without a cache %.3f, %.3f\n",
           (unsigned)i, light[0], light[1], dark[0], dark[1]);
  }
  check(light[0] > dark[0] + 0.1 && light[0] > 2 * light[1],
        "the red wall does not light the last frame");

  hbil_plan_destroy(with);
  hbil_plan_destroy(without);
  hbil_cache_destroy(cache);
  hbil_context_destroy(hbil);
  for (int i = 0; i < 5; ++i)
    clReleaseMemObject(*planes[i]);
  clReleaseKernel(kernel);
  clReleaseProgram(program);
  clReleaseCommandQueue(queue);
  clReleaseContext(context);
  return 0;
}
