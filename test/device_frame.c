/*
 * A fixed pair of frames through every pass, of two plans that have no kernel
 * in common, on whatever device there is: for test_devices.sh, which runs it
 * under other implementations of OpenCL.
 *
 *   device_frame OUT          writes the outputs, OUT.0 and OUT.1
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

/* Nothing that a rounding may tip over to another step: no dither, no sample
 * whose light is the last one's.  Width 1: see above. */
static void configure(setup *s, hbil_reprojection reprojection) {
  setup_every_pass(s, reprojection, 1, WIDTH, HEIGHT);
  s->config.storage = HBIL_STORAGE_FLOAT32;
  if (reprojection != HBIL_REPROJECTION_MOTION)
    return;
  s->config.refused = HBIL_REFUSED_BLACK;
  s->config.far_field = HBIL_FAR_SH;
  s->config.feedback = HBIL_FEEDBACK_RADIANCE;
  s->config.radius = 3.0f;
  s->config.extrapolate = CL_FALSE;
  s->config.depth_kind = HBIL_DEPTH_RAY;
  s->config.bent_space = HBIL_SPACE_WORLD;
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      s->frame.environment[i][c] = i ? 0.1f * (float)(i - c) : 2.0f;
}

static void check_frames(hbil_reprojection reprojection, int number) {
  char path[2][512];
  setup s;
  ref_planes out;
  for (int i = 0; i < 2 && arguments[1 + i]; ++i)
    snprintf(path[i], sizeof path[i], "%s.%d", arguments[1 + i], number);
  configure(&s, reprojection);
  setup_start(&s);
  setup_run(&s, hbil_enqueue_frame);
  setup_load_scene(&s, SCENE_ROOM, 1);
  setup_upload(&s);
  setup_run(&s, hbil_enqueue_frame);
  out = outputs_read(&s);
  write_planes(path[0], &out);
  if (arguments[2])
    compare(&out, path[1]);
  ref_planes_free(&out);
  setup_free(&s);
}

static void frames_from_scattered_light(void **state) {
  (void)state;
  name_device();
  check_frames(HBIL_REPROJECTION_SCATTER, 0);
}

static void frames_from_light_that_motion_brings(void **state) {
  (void)state;
  check_frames(HBIL_REPROJECTION_MOTION, 1);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(frames_from_scattered_light),
      cmocka_unit_test(frames_from_light_that_motion_brings)};
  if (argc < 2 || argc > 3) {
    fprintf(stderr, "usage: device_frame OUT [WITH]\n");
    return 2;
  }
  arguments = (const char *const *)argv;
  return RUN_WITH_GPU(tests);
}
