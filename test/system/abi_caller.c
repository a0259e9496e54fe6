/*
 * A program whose hbil_config and hbil_frame have the sizes it is told:
 *
 *   abi_caller [CONFIG_BYTES FRAME_BYTES]
 *
 * What lies behind them can't be touched: a library that reads or writes there
 * ends it.  Prints both sizes, what a plan needs and a sum of what a frame of
 * it has made; or, on standard error, why the library rejects them.
 */
/* MAP_ANONYMOUS */
#define _DEFAULT_SOURCE

#include <hbil/hbil.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { WIDTH = 40, HEIGHT = 30, PIXELS = WIDTH * HEIGHT };

static int fail(const char *why) {
  fprintf(stderr, "%s\n", why);
  return 1;
}

/* `bytes` that end where a page begins that is nobody's. */
static void *guarded(size_t bytes) {
  const size_t page = (size_t)sysconf(_SC_PAGESIZE);
  char *pages = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE,
                     MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages == MAP_FAILED || bytes > page ||
      mprotect(pages + page, page, PROT_NONE))
    exit(fail("no guarded page"));
  memset(pages, 0xaa, page);
  return pages + page - bytes;
}

/* Whether `bytes` at `given` begin with their number, and go on like `full`. */
static int begins_like(const void *given, size_t bytes, const void *full,
                       size_t known) {
  const size_t common = bytes < known ? bytes : known;
  return !memcmp(given, &bytes, sizeof bytes) &&
         !memcmp((const char *)given + sizeof bytes,
                 (const char *)full + sizeof bytes, common - sizeof bytes);
}

static cl_mem make_buffer(cl_context context, size_t floats, float value) {
  float *values = malloc(floats * sizeof *values);
  if (!values)
    exit(fail("no memory"));
  for (size_t i = 0; i < floats; ++i) /* a step across the middle */
    values[i] = i % WIDTH < WIDTH / 2 ? value : 2.0f * value;
  const cl_mem buffer =
      clCreateBuffer(context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR,
                     floats * sizeof *values, values, NULL);
  free(values);
  return buffer;
}

int main(int count, char **words) {
  const size_t config_bytes =
      count > 1 ? strtoul(words[1], NULL, 10) : sizeof(hbil_config);
  const size_t frame_bytes =
      count > 2 ? strtoul(words[2], NULL, 10) : sizeof(hbil_frame);
  hbil_config *config = guarded(config_bytes), full_config;
  hbil_frame *frame = guarded(frame_bytes), full_frame;
  hbil_config_init_sized(config, config_bytes);
  hbil_frame_init_sized(frame, frame_bytes);
  hbil_config_init(&full_config);
  hbil_frame_init(&full_frame);
  if (!begins_like(config, config_bytes, &full_config, sizeof full_config) ||
      !begins_like(frame, frame_bytes, &full_frame, sizeof full_frame))
    return fail("the init functions don't fill what they are given");

  cl_platform_id platforms[16];
  cl_device_id device = NULL;
  cl_uint found = 0;
  clGetPlatformIDs(16, platforms, &found);
  for (cl_uint i = 0; i < found && i < 16 && !device; ++i)
    clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, 1, &device, NULL);
  if (!device)
    return fail("no OpenCL device");
  const cl_context context =
      clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
  const cl_command_queue queue = clCreateCommandQueue(context, device, 0, NULL);

  config->width = WIDTH;
  config->height = HEIGHT;
  config->inputs.depth.component = HBIL_FLOAT32;
  config->inputs.normal.component = HBIL_FLOAT32;
  config->outputs.ao.component = HBIL_FLOAT32;
  frame->camera.fx = frame->camera.fy = WIDTH;
  frame->camera.cx = WIDTH / 2.0;
  frame->camera.cy = HEIGHT / 2.0;
  for (int i = 0; i < 4; ++i)
    frame->camera.world_from_view[5 * i] = 1.0;
  frame->depth.buffer = make_buffer(context, PIXELS, 1.0f);
  frame->normal.buffer = make_buffer(context, 3 * PIXELS, -1.0f);
  frame->ao.buffer = make_buffer(context, PIXELS, 0.0f);

  hbil_context *hbil = NULL;
  hbil_plan *plan = NULL;
  hbil_memory memory = {0, 0};
  hbil_status status = hbil_context_create(context, device, &hbil);
  if (status == HBIL_SUCCESS)
    status = hbil_sampling_set(&config->sampling, HBIL_QUALITY_FAST);
  if (status == HBIL_SUCCESS)
    status = hbil_plan_memory(hbil, config, &memory);
  const hbil_status made = hbil_plan_create(hbil, config, &plan);
  if (status != made)
    return fail("hbil_plan_memory() and hbil_plan_create() don't agree");
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_frame(plan, queue, frame, 0, NULL, NULL);
  if (status != HBIL_SUCCESS)
    return fail(hbil_context_message(hbil));
  float ao[PIXELS];
  double sum = 0.0;
  if (clEnqueueReadBuffer(queue, frame->ao.buffer, CL_TRUE, 0, sizeof ao, ao, 0,
                          NULL, NULL) != CL_SUCCESS)
    return fail("no result");
  for (int i = 0; i < PIXELS; ++i)
    sum += (double)ao[i];
  printf("%zu %zu\n%zu bytes, sum %.9g\n", config_bytes, frame_bytes,
         memory.persistent + memory.scratch, sum);
  hbil_plan_destroy(plan);
  hbil_context_destroy(hbil);
  return 0;
}
