/*
 * A few frames through every pass, on whatever device there is: for
 * test_devices.sh, which runs it under other implementations of OpenCL.
 *
 *   device_frame PLAN OUT          writes the outputs
 *   device_frame PLAN OUT WITH     and holds them against another device's
 *
 * PLAN: camera or motion, two plans that share hardly a compiled kernel.  Each
 * lights two frames.  camera then lights two static ones.
 * The width is 1 everywhere: the form that all devices can run.
 */
#include "test/support/fixture.h"
#include "test/support/shim.h"

#include <stdio.h>
#include <unistd.h>

/* The picture of `motion` ends in the middle of a work-item's pixels, that of
 * `camera` at their end, since oclgrind reports reads of what nothing has set,
 * and pixels beyond the end are read and masked. */
enum { WIDTH_OF_MOTION = 13, WIDTH_OF_CAMERA = 16, HEIGHT = 10 };

/* RMSE of an output over its mean that another device's roundings may make: the
 * requirement. */
#define LIMIT 1e-4

static size_t values_of(const exact_planes *planes) {
  return (size_t)planes->count * (size_t)(planes->width * planes->height);
}

static FILE *open_file(const char *path, const char *mode) {
  FILE *file = fopen(path, mode);
  assert_non_null(file);
  return file;
}

static void compare(const exact_planes *got, FILE *with) {
  exact_planes want =
      checked_planes(got->width, got->height, EXACT_OUTPUT_PLANES);
  const size_t count = values_of(&want);
  assert_int_equal(fread(want.values, sizeof(double), count, with), count);
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    check_at_most(
        plane_name(id),
        relative_rmse(got, &want, plane_first(id), plane_channels(id)), LIMIT);
  exact_planes_free(&want);
}

/* Writes the outputs to one file, and holds them against the next in the
 * other. */
static void keep_outputs(setup *s, FILE *out, FILE *with) {
  exact_planes planes = outputs_read(s);
  const size_t count = values_of(&planes);
  assert_int_equal(fwrite(planes.values, sizeof(double), count, out), count);
  if (with)
    compare(&planes, with);
  exact_planes_free(&planes);
}

static bool under_oclgrind;

static void name_device(void) {
  char name[256] = "";
  clGetDeviceInfo(shared_device.id, CL_DEVICE_NAME, sizeof name - 1, name,
                  NULL);
  printf("%s\n", name);
  fflush(stdout);
  under_oclgrind = strstr(name, "Oclgrind") != NULL;
  shim_under_oclgrind(under_oclgrind);
}

/* Nothing that a rounding may tip over to another step: no dither, no sample
 * whose light is the last one's. */
static void configure(setup *s, bool motion) {
  setup_every_pass(s,
                   motion ? HBIL_REPROJECTION_MOTION : HBIL_REPROJECTION_CAMERA,
                   1, motion ? WIDTH_OF_MOTION : WIDTH_OF_CAMERA, HEIGHT);
  s->config.sampling.storage = HBIL_STORAGE_FLOAT32;
  if (!motion)
    return;
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
  s->frame.static_frame = CL_TRUE;
  for (int i = 0; i < 2; ++i)
    setup_run(s, hbil_enqueue_frame);
}

static const char *plan, *out_path, *with_path;

static void frames(void **state) {
  const bool motion = strcmp(plan, "motion") == 0;
  FILE *out = open_file(out_path, "wb");
  FILE *with = with_path ? open_file(with_path, "rb") : NULL;
  setup s;
  (void)state;
  name_device();
  configure(&s, motion);
  setup_start(&s);
  setup_run(&s, hbil_enqueue_frame);
  setup_load_scene(&s, SCENE_ROOM, 1);
  setup_upload(&s);
  setup_run(&s, hbil_enqueue_frame);
  keep_outputs(&s, out, with);
  if (!motion) {
    run_static_frames(&s);
    keep_outputs(&s, out, with);
  }
  setup_free(&s);
  assert_int_equal(fclose(out), 0);
  if (with)
    fclose(with);
}

/* In one of four runs glibc finds oclgrind 21.10's heap damaged when oclgrind
 * frees its LLVM context, and aborts.  AddressSanitizer, which then looks at
 * what the library and this program do, has nothing to say.  So the process
 * ends before. */
static int finish(int failures) {
  if (!under_oclgrind)
    return device_finish(failures);
  clFinish(shared_device.queue);
  hbil_context_destroy(shared_device.hbil);
  fflush(NULL);
  _exit(failures);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(frames)};
  if (argc < 3 || argc > 4) {
    fprintf(stderr, "usage: device_frame camera|motion OUT [WITH]\n");
    return 2;
  }
  plan = argv[1];
  out_path = argv[2];
  with_path = argv[3];
  shared_device = device_open();
  return finish(cmocka_run_group_tests(tests, NULL, NULL));
}
