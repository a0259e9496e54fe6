/*
 * A fixed pair of frames through every pass, on whatever device there is: for
 * test_devices.sh, which runs it under other implementations of OpenCL.
 *
 *   device_frame PLAN OUT          writes the outputs
 *   device_frame PLAN OUT WITH     and holds them against another device's
 *
 * PLAN: camera or motion, two plans that share hardly a compiled kernel; or
 * static, camera's with two static frames more, of which the first fills a
 * horizon cache of some rows, and the second uses it.
 * The width is 1 everywhere: the form that all devices can run.
 */
#include "test/support/fixture.h"
#include "test/support/shim.h"

#include <stdio.h>

/* The picture of `motion` ends in the middle of a work-item's pixels, that of
 * `camera` at their end, since oclgrind reports reads of what nothing has set,
 * and pixels beyond the end are read and masked. */
enum { WIDTH_OF_MOTION = 29, WIDTH_OF_CAMERA = 32, HEIGHT = 18 };

/* RMSE of an output over its mean that another device's roundings may make: the
 * requirement. */
#define LIMIT 1e-4

static void write_planes(const char *path, const exact_planes *planes) {
  const size_t count =
      (size_t)planes->count * (size_t)(planes->width * planes->height);
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(planes->values, sizeof(double), count, file), count);
  assert_int_equal(fclose(file), 0);
}

static exact_planes read_planes(const char *path, int width) {
  exact_planes planes = checked_planes(width, HEIGHT, EXACT_OUTPUT_PLANES);
  const size_t count = (size_t)(EXACT_OUTPUT_PLANES * width * HEIGHT);
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fread(planes.values, sizeof(double), count, file), count);
  fclose(file);
  return planes;
}

static void compare(const exact_planes *got, const char *path) {
  exact_planes want = read_planes(path, got->width);
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    check_at_most(
        plane_name(id),
        relative_rmse(got, &want, plane_first(id), plane_channels(id)), LIMIT);
  exact_planes_free(&want);
}

static void name_device(void) {
  char name[256] = "";
  clGetDeviceInfo(shared_device.id, CL_DEVICE_NAME, sizeof name - 1, name,
                  NULL);
  printf("%s\n", name);
  fflush(stdout);
  shim_under_oclgrind(strstr(name, "Oclgrind") != NULL);
}

/* Nothing that a rounding may tip over to another step: no dither, no sample
 * whose light is the last one's. */
static void configure(setup *s, bool motion) {
  if (motion)
    setup_every_pass(s, HBIL_REPROJECTION_MOTION, 1, WIDTH_OF_MOTION, HEIGHT);
  else
    setup_every_pass(s, HBIL_REPROJECTION_CAMERA, 1, WIDTH_OF_CAMERA, HEIGHT);
  s->config.sampling.storage = HBIL_STORAGE_FLOAT32;
  if (!motion)
    return;
  /* static frames of the other plan have a horizon cache */
  s->config.outputs.glossy = three_floats;
  s->config.model.back_facing_fallback = HBIL_FALLBACK_BLACK;
  s->config.model.far_field = HBIL_FAR_SH;
  s->config.model.feedback = HBIL_FEEDBACK_RADIANCE;
  s->config.model.radius = 3.0f;
  s->config.model.extrapolate = CL_FALSE;
  s->config.inputs.depth_kind = HBIL_DEPTH_RAY;
  s->config.outputs.bent_normal_space = HBIL_SPACE_WORLD;
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      s->frame.environment[i][c] = i ? 0.1f * (float)(i - c) : 2.0f;
}

static void run_static_frames(setup *s) {
  hbil_statistics skipped;
  s->frame.static_frame = CL_TRUE;
  for (int i = 0; i < 2; ++i)
    setup_run(s, hbil_enqueue_frame);
  assert_success(s, hbil_plan_statistics(s->plan, s->device->queue, &skipped));
  assert_in_range(skipped.from_cache.pixels, 1,
                  skipped.all.pixels - skipped.sky.pixels - 1);
}

static const char *plan, *out_path, *with_path;

static void frames(void **state) {
  setup s;
  exact_planes out;
  (void)state;
  name_device();
  configure(&s, strcmp(plan, "motion") == 0);
  if (strcmp(plan, "static") == 0)
    setup_cache_rows(&s, 3, 5);
  setup_start(&s);
  setup_run(&s, hbil_enqueue_frame);
  setup_load_scene(&s, SCENE_ROOM, 1);
  setup_upload(&s);
  setup_run(&s, hbil_enqueue_frame);
  if (strcmp(plan, "static") == 0)
    run_static_frames(&s);
  out = outputs_read(&s);
  write_planes(out_path, &out);
  if (with_path)
    compare(&out, with_path);
  exact_planes_free(&out);
  setup_free(&s);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(frames)};
  if (argc < 3 || argc > 4) {
    fprintf(stderr, "usage: device_frame camera|motion|static OUT [WITH]\n");
    return 2;
  }
  plan = argv[1];
  out_path = argv[2];
  with_path = argv[3];
  return RUN_WITH_DEVICE(tests);
}
