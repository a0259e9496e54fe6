/*
 * Light of the last frame in this one: the reference's very bits, in every form
 * that the kernels have.  Which one a plan takes depends on the device's
 * extensions, too: clGetDeviceInfo() of this program stands in front of
 * OpenCL's and can hide one.
 */
#define _GNU_SOURCE /* RTLD_NEXT */
#include "support.h"

#include <dlfcn.h>

/* ------------------------------------------------------------------------ */
/* The forms of the kernels                                                  */

typedef struct form {
  cl_uint vector_width;
  bool narrow; /* 64-bit atomics are hidden */
} form;

static form tested; /* by the test that is running */

#define WIDE_ATOMICS "cl_khr_int64_extended_atomics"

typedef CL_API_ENTRY cl_int CL_API_CALL get_device_info(cl_device_id,
                                                        cl_device_info, size_t,
                                                        void *, size_t *);
typedef CL_API_ENTRY cl_kernel CL_API_CALL create_kernel(cl_program,
                                                         const char *,
                                                         cl_int *);

/* An object pointer is no function pointer in C, but POSIX says it will do. */
typedef union next_function {
  void *object;
  get_device_info *device_info;
  create_kernel *kernel;
} next_function;

static next_function next(const char *name) {
  next_function found = {.object = dlsym(RTLD_NEXT, name)};
  assert_non_null(found.object);
  return found;
}

CL_API_ENTRY cl_int CL_API_CALL clGetDeviceInfo(cl_device_id device,
                                                cl_device_info what,
                                                size_t size, void *value,
                                                size_t *needed) {
  cl_int error =
      next("clGetDeviceInfo").device_info(device, what, size, value, needed);
  char *word = what == CL_DEVICE_EXTENSIONS && value && error == CL_SUCCESS
                   ? strstr(value, WIDE_ATOMICS)
                   : NULL;
  if (tested.narrow && word)
    memset(word, '-', strlen(WIDE_ATOMICS));
  return error;
}

static bool index_kernel_made;

CL_API_ENTRY cl_kernel CL_API_CALL clCreateKernel(cl_program program,
                                                  const char *name,
                                                  cl_int *error) {
  index_kernel_made |= !strcmp(name, "scatter_index");
  return next("clCreateKernel").kernel(program, name, error);
}

/* Before each test: the device is looked at anew. */
static int take_form(void **state) {
  tested = *(const form *)*state;
  hbil_context_destroy(test_gpu.hbil);
  return hbil_context_create(test_gpu.context, test_gpu.device,
                             &test_gpu.hbil) != HBIL_SUCCESS;
}

static bool has_wide_atomics(void) {
  char list[4096] = "";
  cl_int error = clGetDeviceInfo(test_gpu.device, CL_DEVICE_EXTENSIONS,
                                 sizeof(list) - 1, list, NULL);
  assert_int_equal(error, CL_SUCCESS);
  return strstr(list, WIDE_ATOMICS) != NULL;
}

/* ------------------------------------------------------------------------ */
/* Frames                                                                    */

static const int sizes[][2] = {{1, 1}, {3, 5}, {17, 31}, {64, 36}};
#define SIZES (sizeof(sizes) / sizeof(*sizes))

static void prepare(setup *s, scene_kind kind, const int size[2],
                    hbil_reprojection reprojection) {
  setup_scene(s, kind, size[0], size[1], 0);
  s->config.reprojection = reprojection;
  s->config.vector_width = tested.vector_width;
  s->config.slices = 1;
  s->config.samples = 2;
}

/* Frame 0 done, another one uploaded. */
static void advance(setup *s, scene_kind kind, uint32_t next) {
  setup_start(s);
  setup_run(s, hbil_enqueue_frame);
  s->job.previous = s->frame.camera;
  setup_load_scene(s, kind, next);
  setup_upload(s);
}

static ref_planes expected(setup *s) {
  ref_planes history = stage_read(s, HBIL_STAGE_HISTORY);
  ref_planes want = ref_planes_new(history.width, history.height, 4);
  ref_reproject(&s->job, &history, &want);
  ref_planes_free(&history);
  return want;
}

static ref_planes reprojected(setup *s) {
  setup_run(s, hbil_enqueue_reproject);
  return stage_read(s, HBIL_STAGE_CARRIED);
}

/* Share of the pixels that carry something. */
static double carried_share(const ref_planes *carried) {
  double sum = 0.0;
  for (int y = 0; y < carried->height; ++y)
    for (int x = 0; x < carried->width; ++x)
      sum += *ref_at(carried, HBIL_CARRIED_WEIGHT, x, y);
  return sum / (carried->width * carried->height);
}

static void assert_same_bits(const ref_planes *got, const ref_planes *want) {
  size_t different = count_different(got, want);
  if (different)
    fail_msg("%dx%d: %zu values differ", want->width, want->height, different);
}

/* Compares several runs; on the large sizes at least `share` is carried. */
static void check(setup *s, double share, int runs) {
  ref_planes want = expected(s);
  for (int run = 0; run < runs; ++run) {
    ref_planes got = reprojected(s);
    assert_same_bits(&got, &want);
    ref_planes_free(&got);
  }
  if (want.width > 16)
    assert_true(carried_share(&want) >= share);
  ref_planes_free(&want);
  setup_free(s);
}

static void scatter_matches_at_every_size(void **state) {
  (void)state;
  for (size_t i = 0; i < SIZES; ++i) {
    setup s;
    prepare(&s, SCENE_ROOM, sizes[i], HBIL_REPROJECTION_SCATTER);
    advance(&s, SCENE_ROOM, 1);
    check(&s, 0.3, 1);
  }
}

static void motion_matches_at_every_size(void **state) {
  (void)state;
  for (size_t i = 0; i < SIZES; ++i) {
    setup s;
    prepare(&s, SCENE_ROOM, sizes[i], HBIL_REPROJECTION_MOTION);
    advance(&s, SCENE_ROOM, 1);
    check(&s, 0.3, 1);
  }
}

static void scatter_matches_on_a_large_image(void **state) {
  const int size[2] = {640, 360};
  setup s;
  (void)state;
  prepare(&s, SCENE_ROOM, size, HBIL_REPROJECTION_SCATTER);
  advance(&s, SCENE_ROOM, 2);
  check(&s, 0.3, 1);
}

static void scatter_gives_the_same_bits_every_time(void **state) {
  setup s;
  (void)state;
  prepare(&s, SCENE_SKY, sizes[3], HBIL_REPROJECTION_SCATTER);
  advance(&s, SCENE_SKY, 3);
  check(&s, 0.1, 5);
}

static void motion_gives_the_same_bits_every_time(void **state) {
  setup s;
  (void)state;
  prepare(&s, SCENE_SKY, sizes[3], HBIL_REPROJECTION_MOTION);
  advance(&s, SCENE_SKY, 3);
  check(&s, 0.1, 5);
}

/* Ray distances, no test of depths, motion in other units. */
static void other_settings_match(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i) {
    setup s;
    prepare(&s, SCENE_ROOM, sizes[2],
            i & 1 ? HBIL_REPROJECTION_MOTION : HBIL_REPROJECTION_SCATTER);
    s.config.disocclusion = i & 2 ? INFINITY : 0.01f;
    s.config.depth_kind = i & 2 ? HBIL_DEPTH_PLANAR : HBIL_DEPTH_RAY;
    s.config.motion_scale[0] = -0.75f;
    s.config.background = 1e3f;
    advance(&s, SCENE_ROOM, 1);
    check(&s, 0.0, 1);
  }
}

/* Sources that fall on one pixel: ties in depth go to the smallest index. */
static void many_sources_on_one_pixel_are_settled_alike(void **state) {
  setup s;
  random_state r = {11};
  ref_planes history;
  (void)state;
  prepare(&s, SCENE_ROOM, sizes[3], HBIL_REPROJECTION_SCATTER);
  s.config.disocclusion = INFINITY;
  advance(&s, SCENE_ROOM, 1);
  setup_camera(&s, 150.0); /* the old image shrinks into the middle */
  s.job.camera = s.frame.camera;
  memcpy(s.frame.camera.world_from_view, s.job.previous.world_from_view,
         sizeof(s.job.previous.world_from_view));
  s.job.camera = s.frame.camera;
  history = stage_read(&s, HBIL_STAGE_HISTORY);
  for (int y = 0; y < history.height; ++y)
    for (int x = 0; x < history.width; ++x) {
      *ref_at(&history, HBIL_HISTORY_W, x, y) = 0.25;
      for (int c = 0; c < 3; ++c)
        *ref_at(&history, HBIL_HISTORY_RED + c, x, y) =
            (double)(float)random_unit(&r);
    }
  stage_write(&s, HBIL_STAGE_HISTORY, &history);
  ref_planes_free(&history);
  check(&s, 0.01, 2);
}

/* Motion vectors that lead anywhere, not-a-numbers and infinities too. */
static void wild_motion_is_followed_or_dropped(void **state) {
  setup s;
  random_state r = {5};
  const float odd[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 0.0f};
  int pixels = sizes[3][0] * sizes[3][1];
  (void)state;
  prepare(&s, SCENE_ROOM, sizes[3], HBIL_REPROJECTION_MOTION);
  s.config.disocclusion = 0.5f;
  advance(&s, SCENE_ROOM, 0);
  for (int i = 0; i < pixels; ++i)
    for (int c = 0; c < 2; ++c)
      s.input[REF_MOTION + c][i] = i % 13 == 0
                                       ? odd[(i / 13 + c) % 6]
                                       : (float)(80.0 * random_unit(&r) - 40.0);
  setup_upload(&s);
  check(&s, 0.05, 1);
}

/* Nothing has moved: everything that is no sky is carried as it is. */
static void check_copy(hbil_reprojection reprojection, scene_kind kind) {
  setup s;
  ref_planes got, history;
  prepare(&s, kind, sizes[3], reprojection);
  advance(&s, kind, 0);
  for (int c = 0; c < 2; ++c)
    setup_fill(&s, REF_MOTION + c, 0.0f);
  setup_upload(&s);
  history = stage_read(&s, HBIL_STAGE_HISTORY);
  got = reprojected(&s);
  for (int y = 0; y < got.height; ++y)
    for (int x = 0; x < got.width; ++x) {
      bool sky = !(*ref_at(&history, HBIL_HISTORY_W, x, y) > 0.0);
      assert_true(*ref_at(&got, HBIL_CARRIED_WEIGHT, x, y) == !sky);
      for (int c = 0; c < 3; ++c)
        assert_true(
            *ref_at(&got, c, x, y) ==
            (sky ? 0.0 : *ref_at(&history, HBIL_HISTORY_RED + c, x, y)));
    }
  ref_planes_free(&got);
  ref_planes_free(&history);
  setup_free(&s);
}

static void a_still_camera_copies(void **state) {
  (void)state;
  check_copy(HBIL_REPROJECTION_SCATTER, SCENE_ROOM);
  check_copy(HBIL_REPROJECTION_SCATTER, SCENE_SKY);
  check_copy(HBIL_REPROJECTION_MOTION, SCENE_ROOM);
}

static void wide_atomics_need_one_kernel_less(void **state) {
  setup s;
  (void)state;
  prepare(&s, SCENE_ROOM, sizes[1], HBIL_REPROJECTION_SCATTER);
  index_kernel_made = false;
  setup_start(&s);
  assert_true(index_kernel_made ==
              (tested.vector_width == 1 || !has_wide_atomics()));
  setup_free(&s);
}

static form wide_vectors = {8, false}, narrow_vectors = {8, true},
            single_pixels = {1, false};

#define TEST(test, form)                                                       \
  { #test ": " #form, test, take_form, NULL, &(form) }
#define SCATTER(test)                                                          \
  TEST(test, wide_vectors), TEST(test, narrow_vectors),                        \
      TEST(test, single_pixels)
#define MOTION(test) TEST(test, wide_vectors), TEST(test, single_pixels)

int main(void) {
  const struct CMUnitTest tests[] = {
      SCATTER(scatter_matches_at_every_size),
      MOTION(motion_matches_at_every_size),
      SCATTER(scatter_matches_on_a_large_image),
      SCATTER(scatter_gives_the_same_bits_every_time),
      MOTION(motion_gives_the_same_bits_every_time),
      SCATTER(other_settings_match),
      SCATTER(many_sources_on_one_pixel_are_settled_alike),
      MOTION(wild_motion_is_followed_or_dropped),
      SCATTER(a_still_camera_copies),
      SCATTER(wide_atomics_need_one_kernel_less)};
  return RUN_WITH_GPU(tests);
}
