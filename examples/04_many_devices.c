/*
 * All devices of a machine at once.  Each device has a context, a plan and a
 * thread of its own.  It takes the next view from a list when it has finished
 * one, so fast devices compute more views than slow ones.
 *
 * These views are independent of each other.  Frames of a sequence share a
 * history, so give each device a whole shot instead.  If the machine has only
 * one device, the program splits it into two halves, if the device allows that.
 */
#include <hbil/hbil.h>

#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>

enum { WIDTH = 320, HEIGHT = 180, VIEWS = 12, DEVICES = 16 };

/* Devices round differently, which can move single samples over an edge.  This
 * changes the mean over a picture by 1e-6 or less. */
static const double same_mean = 1e-5;

typedef struct worker {
  cl_device_id device;
  cl_context context;
  cl_command_queue queue;
  hbil_context *hbil;
  hbil_plan *plan;
  hbil_frame frame;
  float depth[HEIGHT][WIDTH], normal[3][HEIGHT][WIDTH], ao[HEIGHT][WIDTH];
  pthread_t thread;
  int views; /* that this worker has computed */
} worker;

static worker workers[DEVICES];

/* Shared by the threads: the next view, and the results. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static int next_view;
static double visibility[VIEWS];

static int take_view(void) {
  pthread_mutex_lock(&lock);
  const int view = next_view++;
  pthread_mutex_unlock(&lock);
  return view;
}

/* Draws the corner of a room.  Its wall is farther away in each view. */
static void draw_view(worker *w, int view) {
  const hbil_camera *c = &w->frame.camera;
  const double wall_x = -1.0 - 0.25 * view;
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      const double rx = (x + 0.5 - c->cx) / c->fx;
      const double ry = (y + 0.5 - c->cy) / c->fy;
      const double floor_z = ry > 0.0 ? 1.0 / ry : INFINITY;
      const double wall_z = rx < 0.0 ? wall_x / rx : INFINITY;
      const double z = fmin(5.0, fmin(floor_z, wall_z));
      w->depth[y][x] = (float)z;
      w->normal[0][y][x] = z == wall_z ? 1.0f : 0.0f;
      w->normal[1][y][x] = z == floor_z && z != wall_z ? -1.0f : 0.0f;
      w->normal[2][y][x] = z != floor_z && z != wall_z ? -1.0f : 0.0f;
    }
}

/* Returns the mean visibility of a view, or NaN if the device fails. */
static double light_view(worker *w, int view) {
  draw_view(w, view);
  cl_int error =
      clEnqueueWriteBuffer(w->queue, w->frame.depth.buffer, CL_FALSE, 0,
                           sizeof w->depth, w->depth, 0, NULL, NULL);
  error |= clEnqueueWriteBuffer(w->queue, w->frame.normal.buffer, CL_FALSE, 0,
                                sizeof w->normal, w->normal, 0, NULL, NULL);
  if (hbil_enqueue_frame(w->plan, w->queue, &w->frame, 0, NULL, NULL) !=
      HBIL_SUCCESS) {
    fprintf(stderr, "04_many_devices: %s\n", hbil_context_message(w->hbil));
    clFinish(w->queue);
    return NAN;
  }
  error |= clEnqueueReadBuffer(w->queue, w->frame.ao.buffer, CL_TRUE, 0,
                               sizeof w->ao, w->ao, 0, NULL, NULL);
  if (error != CL_SUCCESS)
    return NAN;
  double sum = 0.0;
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    sum += w->ao[i / WIDTH][i % WIDTH];
  return sum / (WIDTH * HEIGHT);
}

static void *work(void *argument) {
  worker *w = argument;
  for (int view; (view = take_view()) < VIEWS; ++w->views)
    visibility[view] = light_view(w, view);
  return NULL;
}

static bool open_worker(worker *w, cl_device_id device) {
  *w = (worker){.device = device};
  hbil_frame_init(&w->frame);
  w->frame.camera = (hbil_camera){
      .fx = 200.0,
      .fy = 200.0,
      .cx = WIDTH / 2.0,
      .cy = HEIGHT / 2.0,
      .world_from_view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
  w->context = clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
  if (w->context == NULL)
    return false;
  w->queue = clCreateCommandQueue(w->context, device, 0, NULL);
  const cl_mem_flags in = CL_MEM_READ_ONLY, out = CL_MEM_WRITE_ONLY;
  w->frame.depth.buffer =
      clCreateBuffer(w->context, in, sizeof w->depth, NULL, NULL);
  w->frame.normal.buffer =
      clCreateBuffer(w->context, in, sizeof w->normal, NULL, NULL);
  w->frame.ao.buffer =
      clCreateBuffer(w->context, out, sizeof w->ao, NULL, NULL);

  hbil_config config;
  hbil_config_init(&config);
  config.width = WIDTH;
  config.height = HEIGHT;
  config.model.mode = HBIL_MODE_GTAO;
  config.history.reprojection = HBIL_REPROJECTION_NONE; /* no sequence */
  config.inputs.depth = config.inputs.normal = config.outputs.ao =
      (hbil_plane_format){HBIL_FLOAT32, 4};
  if (w->queue == NULL ||
      hbil_context_create(w->context, device, &w->hbil) != HBIL_SUCCESS)
    return false;
  if (hbil_plan_create(w->hbil, &config, &w->plan) == HBIL_SUCCESS)
    return true;
  fprintf(stderr, "04_many_devices: %s\n", hbil_context_message(w->hbil));
  return false;
}

/* Releases what open_worker() has created, which may be a part only. */
static void close_worker(worker *w) {
  hbil_plan_destroy(w->plan);
  hbil_context_destroy(w->hbil);
  const cl_mem buffers[] = {w->frame.depth.buffer, w->frame.normal.buffer,
                            w->frame.ao.buffer};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; ++i)
    if (buffers[i] != NULL)
      clReleaseMemObject(buffers[i]);
  if (w->queue != NULL)
    clReleaseCommandQueue(w->queue);
  if (w->context != NULL)
    clReleaseContext(w->context);
  clReleaseDevice(w->device); /* has an effect on halves of a device only */
}

static cl_uint find_devices(cl_device_id devices[DEVICES]) {
  cl_platform_id platforms[DEVICES];
  cl_uint platform_count = 0, count = 0;
  clGetPlatformIDs(DEVICES, platforms, &platform_count);
  for (cl_uint i = 0; i < platform_count && i < DEVICES; ++i) {
    cl_uint found = 0;
    if (count < DEVICES &&
        clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, DEVICES - count,
                       devices + count, &found) == CL_SUCCESS)
      count += found < DEVICES - count ? found : DEVICES - count;
  }
  if (count == 1) {
    cl_uint units = 0;
    clGetDeviceInfo(devices[0], CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units,
                    &units, NULL);
    const cl_device_partition_property halves[] = {
        CL_DEVICE_PARTITION_EQUALLY, (cl_device_partition_property)(units / 2),
        0};
    cl_device_id parts[2];
    if (units >= 2 &&
        clCreateSubDevices(devices[0], halves, 2, parts, NULL) == CL_SUCCESS) {
      devices[0] = parts[0];
      devices[1] = parts[1];
      count = 2;
    }
  }
  return count;
}

static void print_device(const char *what, cl_device_id device) {
  char name[128] = "?";
  clGetDeviceInfo(device, CL_DEVICE_NAME, sizeof name, name, NULL);
  printf("%s: %s\n", what, name);
}

/* Opens a worker for each device.  A device whose result of the first view
 * differs from that of the first device is left out.  Returns the number of
 * workers. */
static int open_workers(void) {
  cl_device_id devices[DEVICES];
  const cl_uint found = find_devices(devices);
  int count = 0;
  double first = NAN;
  for (cl_uint i = 0; i < found; ++i) {
    worker *w = &workers[count];
    const double mean = open_worker(w, devices[i]) ? light_view(w, 0) : NAN;
    if (count == 0)
      first = mean;
    if (fabs(mean - first) < same_mean) { /* false for NaN */
      ++count;
      print_device("works", devices[i]);
    } else {
      print_device("left out", devices[i]);
      close_worker(w);
    }
  }
  return count;
}

int main(void) {
  const int count = open_workers();
  if (count == 0) {
    fprintf(stderr, "04_many_devices: no OpenCL device that works\n");
    return 1;
  }
  for (int i = 0; i < count; ++i)
    if (pthread_create(&workers[i].thread, NULL, work, &workers[i]) != 0) {
      fprintf(stderr, "04_many_devices: no thread\n");
      return 1;
    }
  for (int i = 0; i < count; ++i)
    pthread_join(workers[i].thread, NULL);

  int done = 0, wrong = 0;
  for (int i = 0; i < count; ++i) {
    printf("device %d: %d views\n", i, workers[i].views);
    done += workers[i].views;
  }
  /* One device alone must compute the same.  NaN counts as wrong. */
  for (int view = 0; view < VIEWS; ++view) {
    const double alone = light_view(&workers[0], view);
    printf("view %2d: visibility %.4f\n", view, visibility[view]);
    wrong += !(fabs(visibility[view] - alone) < same_mean);
  }
  for (int i = 0; i < count; ++i)
    close_worker(&workers[i]);
  if (done != VIEWS || wrong != 0)
    fprintf(stderr, "04_many_devices: %d views, %d of them wrong\n", done,
            wrong);
  return done == VIEWS && wrong == 0 ? 0 : 1;
}
