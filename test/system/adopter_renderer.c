#include "test/system/adopter_renderer.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- TAP --- */

static int checks, failed;

void check(bool good, const char *format, ...) {
  va_list arguments;
  ++checks;
  failed += !good;
  printf("%sok %d - ", good ? "" : "not ", checks);
  va_start(arguments, format);
  vprintf(format, arguments);
  va_end(arguments);
  putchar('\n');
  fflush(stdout);
}

void skip_check(const char *name, const char *reason) {
  check(true, "%s # SKIP %s", name, reason);
}

void need(bool good, const char *what) {
  if (good)
    return;
  printf("Bail out! %s\n", what);
  exit(1);
}

void succeed(hbil_status status, const char *what) {
  const char *message = hbil_context_message(self.hbil);
  if (status != HBIL_SUCCESS)
    printf("# %s: %s\n", what, message);
  need(status == HBIL_SUCCESS, what);
}

bool fails(hbil_status got, hbil_status want, const hbil_context *with,
           const char *word) {
  const char *message = hbil_context_message(with);
  const bool good = got == want && strstr(message, word) != NULL;
  printf("# %s%d: %s\n", good ? "" : "unexpected: ", (int)got, message);
  if (!good)
    printf("# expected: %d: ... %s ...\n", (int)want, word);
  return good;
}

int finish_checks(void) {
  printf("1..%d\n", checks);
  return failed != 0;
}

/* --- the renderer --- */

renderer self;
scene drawn;
picture shown;

cl_mem make_buffer(cl_mem_flags flags, size_t size, void *data) {
  if (data)
    flags |= CL_MEM_COPY_HOST_PTR;
  const cl_mem buffer = clCreateBuffer(self.context, flags, size, data, NULL);
  need(buffer != NULL, "clCreateBuffer");
  return buffer;
}

static cl_device_id find_device(void) {
  const char *wanted = getenv("ADOPTER_DEVICE");
  long left = wanted ? atol(wanted) : 0;
  cl_platform_id platforms[16];
  cl_uint count = 0;
  clGetPlatformIDs(16, platforms, &count);
  for (cl_uint i = 0; i < count && i < 16; ++i) {
    cl_device_id devices[16];
    cl_uint found = 0;
    clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, 16, devices, &found);
    if (left < (long)found)
      return devices[left];
    left -= (long)found;
  }
  return NULL;
}

static void name_device(void) {
  char name[256] = "";
  clGetDeviceInfo(self.device, CL_DEVICE_NAME, sizeof name - 1, name, NULL);
  printf("# hbil %s on %s\n", hbil_version(), name);
}

static void make_planes(void) {
  const cl_mem_flags flags = CL_MEM_READ_ONLY;
  const size_t words = PIXELS * sizeof(cl_uint);
  scene_draw(&drawn, &looks_down);
  self.depth = make_buffer(flags, sizeof(plane), drawn.depth);
  self.normal = make_buffer(flags, sizeof(plane), drawn.normal);
  self.albedo = make_buffer(flags, sizeof(plane), drawn.albedo);
  self.direct = make_buffer(flags, sizeof(plane), drawn.direct);
  self.normal_rgb10 = make_buffer(flags, words, drawn.normal_rgb10);
  self.albedo_rgb8 = make_buffer(flags, words, drawn.albedo_rgb8);
  self.direct_rgb9e5 = make_buffer(flags, words, drawn.direct_rgb9e5);
  self.target = make_buffer(CL_MEM_READ_WRITE, sizeof shown, &shown);
}

void open_renderer(void) {
  self.device = find_device();
  need(self.device != NULL, "no OpenCL device");
  name_device();
  self.context = clCreateContext(NULL, 1, &self.device, NULL, NULL, NULL);
  need(self.context != NULL, "clCreateContext");
  self.queue = clCreateCommandQueue(self.context, self.device, 0, NULL);
  need(self.queue != NULL, "clCreateCommandQueue");
  self.out_of_order = clCreateCommandQueue(
      self.context, self.device, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, NULL);
  succeed(hbil_context_create(self.context, self.device, &self.hbil),
          "hbil_context_create");
  make_planes();
}

void close_renderer(void) {
  const cl_mem buffers[] = {
      self.depth,        self.normal,      self.albedo,        self.direct,
      self.normal_rgb10, self.albedo_rgb8, self.direct_rgb9e5, self.target};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; ++i)
    clReleaseMemObject(buffers[i]);
  hbil_context_destroy(self.hbil);
  if (self.out_of_order)
    clReleaseCommandQueue(self.out_of_order);
  clReleaseCommandQueue(self.queue);
  clReleaseContext(self.context);
}

/* --- frames --- */

void look(lighting *l, const pose *from, const convention *with) {
  const hbil_status status = scene_camera(&l->frame, &l->config, from, with);
  if (status != HBIL_SUCCESS)
    printf("# %s\n", hbil_context_message(NULL));
  need(status == HBIL_SUCCESS, "hbil_camera_from_matrices");
}

static void use_usual_frame(lighting *l) {
  hbil_frame *f = &l->frame;
  hbil_frame_init(f);
  look(l, &looks_down, &opengl);
  f->depth.buffer = self.depth;
  f->normal.buffer = self.normal;
  f->albedo.buffer = self.albedo;
  f->direct.buffer = self.direct;
  f->near_irradiance.buffer = self.target;
  f->ao.buffer = self.target;
  f->ao.offset = 3 * sizeof(float);
  f->beauty.buffer = self.target;
  f->beauty.offset = offsetof(picture, beauty);
}

lighting usual(void) {
  const hbil_plane_format floats = {HBIL_FLOAT32, 16};
  lighting l;
  memset(&l, 0, sizeof l);
  hbil_config *c = &l.config;
  hbil_config_init(c);
  c->width = WIDTH;
  c->height = HEIGHT;
  c->inputs.depth = c->inputs.normal = floats;
  c->inputs.albedo = c->inputs.direct = floats;
  c->outputs.near_irradiance = c->outputs.ao = c->outputs.beauty = floats;
  c->inputs.depth_kind = HBIL_DEPTH_HARDWARE;
  c->inputs.normal_space = HBIL_SPACE_WORLD;
  c->model.far_field = HBIL_FAR_NONE; /* near light is all there is */
  succeed(hbil_sampling_set(&c->sampling, HBIL_QUALITY_FAST),
          "hbil_sampling_set");
  use_usual_frame(&l);
  return l;
}

void make_plan(lighting *l) {
  succeed(hbil_plan_create(self.hbil, &l->config, &l->plan),
          "hbil_plan_create");
}

void free_plan(lighting *l) {
  hbil_plan_destroy(l->plan);
  l->plan = NULL;
}

void enqueue(lighting *l) {
  succeed(hbil_enqueue_frame(l->plan, self.queue, &l->frame, 0, NULL, NULL),
          "hbil_enqueue_frame");
}

void read_picture(picture *out) {
  need(clEnqueueReadBuffer(self.queue, self.target, CL_TRUE, 0, sizeof *out,
                           out, 0, NULL, NULL) == CL_SUCCESS,
       "clEnqueueReadBuffer");
}

void run_frames(lighting *l, int count) {
  for (int i = 0; i < count; ++i)
    enqueue(l);
  read_picture(&shown);
  succeed(hbil_plan_statistics(l->plan, self.queue, &l->statistics),
          "hbil_plan_statistics");
  succeed(hbil_plan_sanitized(l->plan, self.queue, &l->sanitized),
          "hbil_plan_sanitized");
}

void run_once(lighting *l, int count) {
  make_plan(l);
  run_frames(l, count);
  free_plan(l);
}

bool shows(const picture *want) {
  return memcmp(&shown, want, sizeof shown) == 0;
}

/* --- stages --- */

static size_t buffer_size(cl_mem buffer) {
  size_t size = 0;
  clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof size, &size, NULL);
  need(size > 0, "clGetMemObjectInfo");
  return size;
}

void read_stage(const lighting *l, hbil_stage stage, float out[PIXELS]) {
  hbil_buffer b;
  succeed(hbil_plan_buffer(l->plan, stage, &b), "hbil_plan_buffer");
  const size_t size = buffer_size(b.buffer);
  float *values = malloc(size);
  need(values != NULL, "malloc");
  need(clEnqueueReadBuffer(self.queue, b.buffer, CL_TRUE, 0, size, values, 0,
                           NULL, NULL) == CL_SUCCESS,
       "clEnqueueReadBuffer");
  for (size_t i = 0; i < PIXELS; ++i)
    out[i] = values[i / WIDTH * b.row_pitch + i % WIDTH + b.origin];
  free(values);
}

void copy_stage(const lighting *from, const lighting *to, hbil_stage stage) {
  hbil_buffer source, target;
  succeed(hbil_plan_buffer(from->plan, stage, &source), "hbil_plan_buffer");
  succeed(hbil_plan_buffer(to->plan, stage, &target), "hbil_plan_buffer");
  need(clEnqueueCopyBuffer(self.queue, source.buffer, target.buffer, 0, 0,
                           buffer_size(source.buffer), 0, NULL,
                           NULL) == CL_SUCCESS,
       "clEnqueueCopyBuffer");
}
