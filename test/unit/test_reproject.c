/*
 * Reprojection gives the bits of the exact pass in every form of the kernels:
 * vectors of pixels, and single pixels.
 */
#include "test/support/random.h"
#include "test/support/stages.h"

static cl_uint tested; /* pixels of a work-item; set by the test that runs */

static int take_width(void **state) {
  tested = *(const cl_uint *)*state;
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Frames                                                                    */

static const int sizes[][2] = {{1, 1}, {3, 5}, {17, 31}, {64, 36}};
#define SIZES (sizeof(sizes) / sizeof(*sizes))

static void configure(setup *s, hbil_reprojection reprojection) {
  s->config.history.reprojection = reprojection;
  s->config.execution.vector_width = tested;
  s->config.sampling.slices = 1;
  s->config.sampling.steps_per_side = 2;
}

static void prepare(setup *s, scene_kind kind, const int size[2],
                    hbil_reprojection reprojection) {
  setup_scene(s, kind, size[0], size[1], 0);
  configure(s, reprojection);
}

/* Frame 0 done, another one uploaded. */
static void advance(setup *s, scene_kind kind, uint32_t next) {
  setup_start(s);
  setup_run(s, hbil_enqueue_frame);
  s->job.previous = s->frame.camera;
  setup_load_scene(s, kind, next);
  setup_upload(s);
}

static exact_planes expected(setup *s) {
  exact_planes history = stage_read(s, HBIL_STAGE_HISTORY);
  exact_planes want = checked_planes(history.width, history.height, 4);
  checked_reproject(&s->job, &history, &want);
  exact_planes_free(&history);
  return want;
}

static exact_planes reprojected(setup *s) {
  setup_run(s, enqueue_reproject);
  return stage_read(s, HBIL_STAGE_CARRIED);
}

/* Share of the pixels that carry something. */
static double carried_share(const exact_planes *carried) {
  double sum = 0.0;
  for (int y = 0; y < carried->height; ++y)
    for (int x = 0; x < carried->width; ++x)
      sum += fmax(*exact_at(carried, HBIL_CARRIED_WEIGHT, x, y), 0.0);
  return sum / (carried->width * carried->height);
}

static void assert_same_bits(const exact_planes *got,
                             const exact_planes *want) {
  size_t different = count_different(got, want);
  if (different)
    fail_msg("%dx%d: %zu values differ", want->width, want->height, different);
}

/* Compares several runs; on the large sizes at least `share` is carried. */
static void check(setup *s, double share, int runs) {
  exact_planes want = expected(s);
  for (int run = 0; run < runs; ++run) {
    exact_planes got = reprojected(s);
    assert_same_bits(&got, &want);
    exact_planes_free(&got);
  }
  if (want.width > 16)
    assert_true(carried_share(&want) >= share);
  exact_planes_free(&want);
  setup_free(s);
}

static void the_camera_matches_at_every_size(void **state) {
  (void)state;
  for (size_t i = 0; i < SIZES; ++i) {
    setup s;
    prepare(&s, SCENE_ROOM, sizes[i], HBIL_REPROJECTION_CAMERA);
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

static void the_camera_matches_on_large_images(void **state) {
  const int large[2] = {640, 360};
  setup s;
  (void)state;
  prepare(&s, SCENE_ROOM, large, HBIL_REPROJECTION_CAMERA);
  advance(&s, SCENE_ROOM, 2);
  check(&s, 0.3, 1);
}

/* The camera rolls by a quarter, so that rows become columns, and the pixels of
 * a vector lie in as many rows. */
static void a_camera_that_rolls_matches(void **state) {
  const int size[2] = {200, 200};
  setup s;
  (void)state;
  prepare(&s, SCENE_ROOM, size, HBIL_REPROJECTION_CAMERA);
  s.config.history.disocclusion_threshold = INFINITY;
  advance(&s, SCENE_ROOM, 0);
  double *m = s.frame.camera.world_from_view;
  for (int row = 0; row < 3; ++row) {
    const double x = m[4 * row];
    m[4 * row] = m[4 * row + 1];
    m[4 * row + 1] = -x;
  }
  s.job.camera = s.frame.camera;
  check(&s, 0.9, 1);
}

static void the_camera_gives_the_same_bits_every_time(void **state) {
  setup s;
  (void)state;
  prepare(&s, SCENE_SKY, sizes[3], HBIL_REPROJECTION_CAMERA);
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
            i & 1 ? HBIL_REPROJECTION_MOTION : HBIL_REPROJECTION_CAMERA);
    s.config.history.disocclusion_threshold = i & 2 ? INFINITY : 0.01f;
    s.config.inputs.depth_kind = i & 2 ? HBIL_DEPTH_PLANAR : HBIL_DEPTH_RAY;
    s.config.inputs.motion_scale[0] = -0.75f;
    s.config.inputs.sky_depth = 1e3f;
    advance(&s, SCENE_ROOM, 1);
    check(&s, 0.0, 1);
  }
}

/* A step towards a wall, which halves its distance: each old pixel covers four,
 * and none of them is a crack. */
static void surfaces_that_come_nearer_have_no_cracks(void **state) {
  setup s;
  (void)state;
  setup_init(&s, 64, 36);
  configure(&s, HBIL_REPROJECTION_CAMERA);
  setup_plane(&s, (const double[]){0.0, 0.0, -1.0}); /* at depth 3 */
  setup_start(&s);
  setup_run(&s, hbil_enqueue_frame);
  s.job.previous = s.frame.camera;
  double *m = s.frame.camera.world_from_view;
  for (int row = 0; row < 3; ++row)
    m[4 * row + 3] += 1.5 * m[4 * row + 2];
  s.job.camera = s.frame.camera;
  setup_fill(&s, EXACT_DEPTH, 1.5f);
  setup_upload(&s);
  check(&s, 1.0, 1);
}

/* Random motion vectors, not-a-numbers and infinities among them. */
static void wild_motion_is_followed_or_dropped(void **state) {
  setup s;
  random_state r = {5};
  const float odd[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 0.0f};
  int pixels = sizes[3][0] * sizes[3][1];
  (void)state;
  prepare(&s, SCENE_ROOM, sizes[3], HBIL_REPROJECTION_MOTION);
  s.config.history.disocclusion_threshold = 0.5f;
  advance(&s, SCENE_ROOM, 0);
  for (int i = 0; i < pixels; ++i)
    for (int c = 0; c < 2; ++c)
      s.input[EXACT_MOTION + c][i] =
          i % 13 == 0 ? odd[(i / 13 + c) % 6]
                      : (float)(80.0 * random_unit(&r) - 40.0);
  setup_upload(&s);
  check(&s, 0.05, 1);
}

/* Nothing has moved: all surfaces get exactly their own light. */
static void check_copy(hbil_reprojection reprojection, scene_kind kind) {
  setup s;
  exact_planes got, history;
  prepare(&s, kind, sizes[3], reprojection);
  advance(&s, kind, 0);
  for (int c = 0; c < 2; ++c)
    setup_fill(&s, EXACT_MOTION + c, 0.0f);
  setup_upload(&s);
  history = stage_read(&s, HBIL_STAGE_HISTORY);
  got = reprojected(&s);
  for (int y = 0; y < got.height; ++y)
    for (int x = 0; x < got.width; ++x) {
      bool sky = !(*exact_at(&history, HBIL_HISTORY_W, x, y) > 0.0);
      assert_true(*exact_at(&got, HBIL_CARRIED_WEIGHT, x, y) ==
                  (sky ? -1.0 : 1.0));
      for (int c = 0; c < 3; ++c)
        assert_true(
            *exact_at(&got, c, x, y) ==
            (sky ? 0.0 : *exact_at(&history, HBIL_HISTORY_RED + c, x, y)));
    }
  exact_planes_free(&got);
  exact_planes_free(&history);
  setup_free(&s);
}

static void a_still_camera_copies(void **state) {
  (void)state;
  check_copy(HBIL_REPROJECTION_CAMERA, SCENE_ROOM);
  check_copy(HBIL_REPROJECTION_CAMERA, SCENE_SKY);
  check_copy(HBIL_REPROJECTION_MOTION, SCENE_ROOM);
}

static cl_uint vectors_of_8 = 8, vectors_of_16 = 16, single_pixels = 1;

#define TEST(test, width)                                                      \
  { #test ": " #width, test, take_width, NULL, &(width) }
#define MOTION(test) TEST(test, vectors_of_8), TEST(test, single_pixels)
#define CAMERA(test) MOTION(test), TEST(test, vectors_of_16)

int main(void) {
  const struct CMUnitTest tests[] = {
      CAMERA(the_camera_matches_at_every_size),
      MOTION(motion_matches_at_every_size),
      CAMERA(the_camera_matches_on_large_images),
      CAMERA(a_camera_that_rolls_matches),
      CAMERA(the_camera_gives_the_same_bits_every_time),
      MOTION(motion_gives_the_same_bits_every_time),
      CAMERA(other_settings_match),
      CAMERA(surfaces_that_come_nearer_have_no_cracks),
      MOTION(wild_motion_is_followed_or_dropped),
      CAMERA(a_still_camera_copies)};
  return RUN_WITH_DEVICE(tests);
}
