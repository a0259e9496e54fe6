/*
 * What single passes do with inputs whose results are known, and that random
 * settings rarely draw (test_kernels).
 */
#include "exact/settings.h"
#include "test/support/random.h"
#include "test/support/stages.h"

static const cl_uint widths[] = {1, 8, 16};
enum { WIDTHS = 3 };

static void assert_same_bits(const exact_planes *got,
                             const exact_planes *want) {
  size_t different = count_different(got, want);
  if (different)
    fail_msg("%dx%d: %zu values differ", want->width, want->height, different);
}

/* ------------------------------------------------------------------------ */
/* reproject                                                                 */

static void configure(setup *s, hbil_reprojection reprojection, cl_uint width) {
  s->config.history.reprojection = reprojection;
  s->config.execution.vector_width = width;
  s->config.sampling.slices = 1;
  s->config.sampling.steps_per_side = 2;
}

static exact_planes reprojected(setup *s) {
  setup_run(s, enqueue_reproject);
  return stage_read(s, HBIL_STAGE_CARRIED);
}

/* A step towards a wall, which halves its distance: each old pixel covers four,
 * and none of them is a crack. */
TEST(surfaces_that_come_nearer_have_no_cracks) {
  for (int i = 0; i < WIDTHS; ++i) {
    setup s;
    setup_init(&s, 64, 36);
    configure(&s, HBIL_REPROJECTION_CAMERA, widths[i]);
    setup_plane(&s, (const double[]){0.0, 0.0, -1.0}); /* at depth 3 */
    setup_start(&s);
    setup_run(&s, hbil_enqueue_frame);
    double *m = s.frame.camera.world_from_view;
    for (int row = 0; row < 3; ++row)
      m[4 * row + 3] += 1.5 * m[4 * row + 2];
    setup_fill(&s, EXACT_DEPTH, 1.5f);
    setup_upload(&s);
    exact_planes got = reprojected(&s);
    for (int p = 0; p < 64 * 36; ++p)
      assert_true(*exact_at(&got, HBIL_CARRIED_WEIGHT, p % 64, p / 64) == 1.0);
    exact_planes_free(&got);
    setup_free(&s);
  }
}

/* Nothing has moved: all surfaces get exactly their own light. */
static void check_copy(hbil_reprojection reprojection, scene_kind kind,
                       cl_uint width) {
  setup s;
  setup_scene(&s, kind, 64, 36, 0);
  configure(&s, reprojection, width);
  for (int c = 0; c < 2; ++c)
    setup_fill(&s, EXACT_MOTION + c, 0.0f);
  setup_start(&s);
  setup_run(&s, hbil_enqueue_frame);
  exact_planes want = checked_planes(64, 36, HBIL_CARRIED_PLANES);
  exact_planes history = stage_read(&s, HBIL_STAGE_HISTORY);
  for (int y = 0; y < 36; ++y)
    for (int x = 0; x < 64; ++x) {
      const bool sky = !(*exact_at(&history, HBIL_HISTORY_W, x, y) > 0.0);
      *exact_at(&want, HBIL_CARRIED_WEIGHT, x, y) = sky ? -1.0 : 1.0;
      for (int c = 0; c < 3 && !sky; ++c)
        *exact_at(&want, c, x, y) =
            *exact_at(&history, HBIL_HISTORY_RED + c, x, y);
    }
  exact_planes got = reprojected(&s);
  assert_same_bits(&got, &want);
  planes_free(&got, &want, &history);
  setup_free(&s);
}

TEST(a_still_camera_copies) {
  for (int i = 0; i < WIDTHS; ++i) {
    check_copy(HBIL_REPROJECTION_CAMERA, SCENE_ROOM, widths[i]);
    check_copy(HBIL_REPROJECTION_CAMERA, SCENE_SKY, widths[i]);
    check_copy(HBIL_REPROJECTION_MOTION, SCENE_ROOM, widths[i]);
  }
}

/* ------------------------------------------------------------------------ */
/* push/pull                                                                 */

TEST(one_valid_pixel_fills_everything) {
  static const int sizes[][2] = {{1, 1}, {3, 5}, {1, 37}, {640, 360}};
  static const double colour[4] = {0.25, 3.0, 7.5, 1.0};
  for (int i = 0; i < 4; ++i) {
    setup s;
    setup_scene(&s, SCENE_ROOM, sizes[i][0], sizes[i][1], 0);
    configure(&s, HBIL_REPROJECTION_CAMERA, 0);
    setup_start(&s);
    setup_run(&s, hbil_enqueue_frame);
    setup_run(&s, enqueue_reproject);
    exact_planes light = checked_planes(sizes[i][0], sizes[i][1], 4);
    for (int c = 0; c < 4; ++c)
      *exact_at(&light, c, light.width / 3, light.height - 1) = colour[c];
    stage_write(&s, HBIL_STAGE_CARRIED, &light);
    setup_run(&s, enqueue_push_pull);
    exact_planes got = stage_read(&s, HBIL_STAGE_CARRIED);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < got.height; ++y)
        for (int x = 0; x < got.width; ++x)
          assert_true(fabs(*exact_at(&got, c, x, y) - colour[c]) <=
                      2e-6 * colour[c]);
    planes_free(&got, &light);
    setup_free(&s);
  }
}

/* ------------------------------------------------------------------------ */
/* split                                                                     */

/* Outside the pixels of a layer no inverse depth is above 0. */
static void check_padding(int width, int height) {
  setup s;
  hbil_buffer b;
  exact_planes got;
  float *w;
  size_t size, real = 0, positive = 0;
  setup_scene(&s, SCENE_ROOM, width, height, 0);
  setup_start(&s);
  setup_run(&s, enqueue_split);
  got = stage_read(&s, HBIL_STAGE_SPLIT);
  for (int i = 0; i < width * height; ++i)
    real += got.values[i] > 0.0;
  assert_success(&s, hbil_plan_buffer(s.plan, HBIL_STAGE_SPLIT, &b));
  w = (float *)(void *)buffer_bytes(s.device, b.buffer, &size);
  for (size_t i = 0; i < size / sizeof(float); ++i) {
    assert_true(isfinite(w[i]));
    positive += i % b.layer_pitch < b.plane_pitch && w[i] > 0.0f;
  }
  assert_int_equal(positive, real);
  free(w);
  exact_planes_free(&got);
  setup_free(&s);
}

TEST(padding_holds_nothing) {
  check_padding(1, 1);
  check_padding(3, 5);
  check_padding(17, 31);
  check_padding(64, 64);
}

/* ------------------------------------------------------------------------ */
/* recompose                                                                 */

/* Whether a pixel isn't gathered and has no gathered surface next to it. */
static bool is_alone(const setup *s, int x, int y) {
  if (exact_is_gathered(&s->config, x, y))
    return false;
  for (int j = y > 0 ? y - 1 : 0; j <= y + 1 && j < (int)s->config.height; ++j)
    for (int i = x > 0 ? x - 1 : 0; i <= x + 1 && i < (int)s->config.width; ++i)
      if (exact_is_gathered(&s->config, i, j) &&
          s->input[EXACT_DEPTH][j * (int)s->config.width + i] > 0.0f)
        return false;
  return true;
}

/* A mean of equal values is that value, whatever the weights. */
static void check_even_light(cl_uint slices, bool half) {
  setup s;
  random_state r = {23};
  exact_planes light, got;
  setup_scene(&s, SCENE_ROOM, 64, 37, 0);
  s.config.sampling.slices = slices;
  s.config.sampling.resolution =
      half ? HBIL_RESOLUTION_HALF : HBIL_RESOLUTION_FULL;
  setup_start(&s);
  setup_run(&s, enqueue_split);
  light = checked_planes(64, 37, HBIL_GATHERED_PLANES);
  for (int i = 0; i < 64 * 37 * HBIL_LIGHT_BENT; ++i)
    light.values[i] = 0.625;
  for (int i = 0; i < 64 * 37; ++i)
    *exact_at(&light, HBIL_LIGHT_WEIGHT, i % 64, i / 64) =
        (double)(0.05f + (float)random_unit(&r));
  stage_write(&s, HBIL_STAGE_GATHERED, &light);
  setup_run(&s, enqueue_recompose);
  got = stage_read(&s, HBIL_STAGE_RESOLVED);
  for (int y = 0; y < 37; ++y)
    for (int x = 0; x < 64; ++x)
      for (int p = 0; p < HBIL_LIGHT_PLANES && !is_alone(&s, x, y); ++p) {
        bool sky = !(s.input[EXACT_DEPTH][y * 64 + x] > 0.0f);
        double want = p >= HBIL_LIGHT_BENT ? 0.0 : 0.625;
        if (sky)
          want = p == HBIL_LIGHT_AO ? 1.0 : 0.0;
        /* derived: sums of 25 terms */
        assert_true(fabs(*exact_at(&got, p, x, y) - want) <= 2e-6);
      }
  planes_free(&light, &got);
  setup_free(&s);
}

TEST(even_light_stays_even) {
  for (int half = 0; half < 2; ++half) {
    check_even_light(2, half);
    check_even_light(1, half);
  }
}

/* ------------------------------------------------------------------------ */
/* composite                                                                 */

#define WIDTH 45
#define HEIGHT 31

static void prepare_room(setup *s, hbil_far_field far) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  setup_all_outputs(s);
  s->config.outputs.glossy = three_floats;
  s->config.model.far_field = far;
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
}

TEST(an_even_environment_sends_pi_ao_l) {
  const float colour[3] = {0.5f, 2.0f, 7.0f};
  for (int far = HBIL_FAR_CONSTANT; far <= HBIL_FAR_SH; ++far) {
    setup s;
    prepare_room(&s, (hbil_far_field)far);
    for (int c = 0; c < 3; ++c)
      s.frame.environment[0][c] =
          colour[c] * (far == HBIL_FAR_SH ? (float)sqrt(4.0 * PI) : 1.0f);
    exact_planes got = first_outputs(&s);
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      for (int c = 0; c < 3 && s.input[EXACT_DEPTH][i] > 0.0f; ++c) {
        const double ao = *exact_at(&got, EXACT_AO, i % WIDTH, i / WIDTH);
        const double light =
            *exact_at(&got, EXACT_FAR_IRRADIANCE + c, i % WIDTH, i / WIDTH);
        /* derived: a dozen roundings; 1 - t^2 has to give AO back */
        assert_true(fabs(light - PI * ao * (double)colour[c]) <=
                    1e-6 * PI * (double)colour[c]);
      }
    exact_planes_free(&got);
    setup_free(&s);
  }
}

/* Every third surface gets red near light that is no number, and green that a
 * rounding has left below 0. */
static bool is_spoiled(const setup *s, int i) {
  return i % 3 == 0 && s->input[EXACT_DEPTH][i] > 0.0f;
}

static void spoil_near_light(setup *s) {
  exact_planes light = stage_read(s, HBIL_STAGE_RESOLVED);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    if (is_spoiled(s, i)) {
      *exact_at(&light, HBIL_LIGHT_RED, i % WIDTH, i / WIDTH) = (double)NAN;
      *exact_at(&light, HBIL_LIGHT_RED + 1, i % WIDTH, i / WIDTH) = -1e-7;
    }
  stage_write(s, HBIL_STAGE_RESOLVED, &light);
  exact_planes_free(&light);
}

/* A fault in an earlier pass stays visible: black would hide it. */
TEST(near_light_that_is_no_number_stays_none) {
  static const int lit[] = {EXACT_NEAR_IRRADIANCE, EXACT_INDIRECT,
                            EXACT_BEAUTY};
  for (int half = 0; half < 2; ++half) {
    setup s;
    prepare_room(&s, HBIL_FAR_NONE);
    for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
      plane_format(&s.config, id)->component =
          half ? HBIL_FLOAT16 : HBIL_FLOAT32;
    setup_start(&s);
    setup_run(&s, hbil_enqueue_frame);
    spoil_near_light(&s);
    setup_run(&s, enqueue_composite);
    exact_planes out = outputs_read(&s);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
      const int x = i % WIDTH, y = i / WIDTH;
      for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c)
          assert_int_equal(isnan(*exact_at(&out, lit[k] + c, x, y)) != 0,
                           is_spoiled(&s, i) && c == 0);
      assert_true(!is_spoiled(&s, i) ||
                  *exact_at(&out, EXACT_NEAR_IRRADIANCE + 1, x, y) == 0.0);
    }
    exact_planes_free(&out);
    setup_free(&s);
  }
}
