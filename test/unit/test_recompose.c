/*
 * Recompose matches the exact pass: the joint bilateral filter, and layers
 * that are only interleaved.
 */
#include "exact/settings.h"
#include "test/support/random.h"
#include "test/support/stages.h"

/* Random light in the layers of a real scene; the sky is open and dark, as
 * the gather leaves it.  What isn't gathered is NaN, so nobody may read it. */
static exact_planes plant_light(setup *s) {
  random_state r = {17};
  exact_planes light = checked_planes(
      (int)s->config.width, (int)s->config.height, HBIL_GATHERED_PLANES);
  for (int i = 0; i < light.width * light.height * light.count; ++i) {
    double value = random_unit(&r);
    int pixels = light.width * light.height, plane = i / pixels;
    light.values[i] =
        (double)(float)(plane == HBIL_LIGHT_WEIGHT ? 0.05 + 3.0 * value
                        : plane >= HBIL_LIGHT_BENT ? value - 0.5
                                                   : value);
    if (!(s->input[EXACT_DEPTH][i % pixels] > 0.0f))
      light.values[i] = plane == HBIL_LIGHT_AO;
    if (!exact_is_gathered(&s->config, i % pixels % light.width,
                           i % pixels / light.width))
      light.values[i] = (double)NAN;
  }
  stage_write(s, HBIL_STAGE_GATHERED, &light);
  return light;
}

/* The scene with the settings in `s`, which is freed. */
static void check_setup(setup *setup_of_scene) {
  setup s = *setup_of_scene;
  exact_planes split, light, got, want;
  const int width = (int)s.config.width, height = (int)s.config.height;
  setup_start(&s);
  setup_run(&s, enqueue_split);
  light = plant_light(&s);
  split = stage_read(&s, HBIL_STAGE_SPLIT);
  want = checked_planes(width, height, HBIL_LIGHT_PLANES);
  exact_recompose(&s.job, &split, &light, &want);
  setup_run(&s, enqueue_recompose);
  got = stage_read(&s, HBIL_STAGE_RESOLVED);
  /* measured: 2.7e-6 and 1.2e-6 */
  check_at_most("AO, E_near", largest_error(&got, &want, 0, HBIL_LIGHT_BENT),
                1e-5);
  check_at_most("bent", relative_rmse(&got, &want, HBIL_LIGHT_BENT, 3), 1e-5);
  exact_planes_free(&split);
  exact_planes_free(&light);
  exact_planes_free(&got);
  exact_planes_free(&want);
  setup_free(&s);
}

static void check_recompose(scene_kind kind, int width, int height, bool raw,
                            cl_uint slices) {
  setup s;
  setup_scene(&s, kind, width, height, 0);
  s.config.sampling.unfiltered = raw;
  s.config.sampling.slices = slices;
  check_setup(&s);
}

static const int sizes[][2] = {{1, 1}, {3, 5}, {17, 31}, {160, 90}};

static void the_filter_matches(void **state) {
  (void)state;
  for (int i = 0; i < 8; ++i)
    check_recompose(i & 1 ? SCENE_SKY : SCENE_ROOM, sizes[i / 2][0],
                    sizes[i / 2][1], false, 2);
}

/* A single slice's AO and light are quotients of sums; bent normals are none.
 */
static void slices_are_weighed(void **state) {
  (void)state;
  for (int i = 0; i < 8; ++i)
    check_recompose(i & 1 ? SCENE_SKY : SCENE_ROOM, sizes[i / 2][0],
                    sizes[i / 2][1], false, 1);
}

static void the_raw_interleave_matches(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i)
    check_recompose(SCENE_SKY, sizes[i][0], sizes[i][1], true,
                    1 + (cl_uint)i % 2);
}

static void a_large_image_matches(void **state) {
  (void)state;
  check_recompose(SCENE_ROOM, 640, 360, false, 2);
}

static void left_out_pixels_are_filled_in(void **state) {
  (void)state;
  for (int i = 0; i < 16; ++i) {
    setup s;
    setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, sizes[i / 4][0],
                sizes[i / 4][1], 0);
    s.config.sampling.resolution = HBIL_RESOLUTION_HALF;
    s.config.sampling.slices = 1 + (cl_uint)i / 2 % 2;
    check_setup(&s);
  }
}

/* Depths at random, half of them sky: pixels without a neighbour on the same
 * surface, and without any neighbour. */
static void lonely_pixels_are_filled_in(void **state) {
  (void)state;
  for (cl_uint slices = 1; slices < 3; ++slices) {
    setup s;
    random_state r = {31};
    setup_scene(&s, SCENE_ROOM, 67, 41, 0);
    for (int p = 0; p < 67 * 41; ++p)
      s.input[EXACT_DEPTH][p] =
          random_unit(&r) < 0.5 ? 0.0f : 1.0f + 9.0f * (float)random_unit(&r);
    s.config.sampling.resolution = HBIL_RESOLUTION_HALF;
    s.config.sampling.slices = slices;
    check_setup(&s);
  }
}

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
  exact_planes_free(&light);
  exact_planes_free(&got);
  setup_free(&s);
}

static void even_light_stays_even(void **state) {
  (void)state;
  for (int half = 0; half < 2; ++half) {
    check_even_light(2, half);
    check_even_light(1, half);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_filter_matches),
      cmocka_unit_test(slices_are_weighed),
      cmocka_unit_test(the_raw_interleave_matches),
      cmocka_unit_test(a_large_image_matches),
      cmocka_unit_test(left_out_pixels_are_filled_in),
      cmocka_unit_test(lonely_pixels_are_filled_in),
      cmocka_unit_test(even_light_stays_even)};
  return RUN_WITH_DEVICE(tests);
}
