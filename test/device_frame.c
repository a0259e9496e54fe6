/*
 * One fixed pair of frames through every pass, on whatever device there is: for
 * test_devices.sh, which runs it under other implementations of OpenCL.
 *
 *   device_frame OUT          writes the outputs
 *   device_frame OUT WITH     and holds them against those of another device
 *
 * The width is 1 everywhere: the form that all devices can run.
 */
#include "support.h"

#include <stdio.h>

enum { WIDTH = 29, HEIGHT = 18 };

/* RMSE of an output over its mean that another device's roundings may make: the
 * requirement. */
#define LIMIT 1e-4

static void write_planes(const char *path, const ref_planes *planes) {
  const size_t count =
      (size_t)planes->count * (size_t)(planes->width * planes->height);
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(planes->values, sizeof(double), count, file), count);
  assert_int_equal(fclose(file), 0);
}

static ref_planes read_planes(const char *path) {
  ref_planes planes = ref_planes_new(WIDTH, HEIGHT, REF_OUTPUT_PLANES);
  const size_t count = (size_t)REF_OUTPUT_PLANES * WIDTH * HEIGHT;
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fread(planes.values, sizeof(double), count, file), count);
  fclose(file);
  return planes;
}

static void compare(const ref_planes *got, const char *path) {
  ref_planes want = read_planes(path);
  for (image_id id = IMAGE_FIRST_OUTPUT; id < IMAGE_COUNT; ++id)
    check_at_most(
        image_name(id),
        relative_rmse(got, &want, image_first(id), image_channels(id)), LIMIT);
  ref_planes_free(&want);
}

static void name_device(void) {
  char name[256] = "";
  clGetDeviceInfo(test_gpu.device, CL_DEVICE_NAME, sizeof name - 1, name, NULL);
  printf("%s\n", name);
  fflush(stdout);
}

static const char *const *arguments;

static void frames(void **state) {
  setup s;
  ref_planes out;
  (void)state;
  name_device();
  setup_every_pass(&s, HBIL_REPROJECTION_SCATTER, 1, WIDTH, HEIGHT);
  s.config.storage = HBIL_STORAGE_FLOAT32; /* no dither that may round over */
  setup_start(&s);
  setup_run(&s, hbil_enqueue_frame);
  setup_load_scene(&s, SCENE_ROOM, 1);
  setup_upload(&s);
  setup_run(&s, hbil_enqueue_frame);
  out = outputs_read(&s);
  write_planes(arguments[1], &out);
  if (arguments[2])
    compare(&out, arguments[2]);
  ref_planes_free(&out);
  setup_free(&s);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(frames)};
  if (argc < 2 || argc > 3) {
    fprintf(stderr, "usage: device_frame OUT [WITH]\n");
    return 2;
  }
  arguments = (const char *const *)argv;
  return RUN_WITH_GPU(tests);
}
