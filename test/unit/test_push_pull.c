/*
 * Holes are filled from coarser levels; what is valid stays as it is, and so
 * does the sky, whose weight is below 0.
 */
#include "test/support/random.h"
#include "test/support/stages.h"

static const int sizes[][2] = {{1, 1},   {3, 5},  {17, 31},
                               {64, 36}, {1, 37}, {640, 360}};
#define SIZES (sizeof(sizes) / sizeof(*sizes))

static void prepare(setup *s, const int size[2]) {
  setup_scene(s, SCENE_ROOM, size[0], size[1], 0);
  s->config.sampling.slices = 1;
  s->config.sampling.steps_per_side = 1;
}

/* A plan that has a history, so that the pass runs. */
static void start(setup *s) {
  setup_start(s);
  setup_run(s, hbil_enqueue_frame);
  setup_run(s, enqueue_reproject);
}

/* Shares of the pixels: valid, and of the others those that are sky. */
static exact_planes random_light(const setup *s, double valid, double sky) {
  random_state r = {3};
  exact_planes p =
      checked_planes((int)s->config.width, (int)s->config.height, 4);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      bool is_valid = random_unit(&r) < valid;
      for (int c = 0; c < 3; ++c)
        *exact_at(&p, c, x, y) =
            is_valid ? (double)(float)(10.0 * random_unit(&r)) : 0.0;
      *exact_at(&p, HBIL_CARRIED_WEIGHT, x, y) = is_valid                ? 1.0
                                                 : random_unit(&r) < sky ? -1.0
                                                                         : 0.0;
    }
  return p;
}

static exact_planes filled(setup *s, const exact_planes *carried) {
  stage_write(s, HBIL_STAGE_CARRIED, carried);
  setup_run(s, enqueue_push_pull);
  return stage_read(s, HBIL_STAGE_CARRIED);
}

static void assert_valid_unchanged(const exact_planes *got,
                                   const exact_planes *before) {
  for (int y = 0; y < got->height; ++y)
    for (int x = 0; x < got->width; ++x)
      for (int p = 0;
           p < 4 && *exact_at(before, HBIL_CARRIED_WEIGHT, x, y) != 0.0; ++p)
        assert_true(*exact_at(got, p, x, y) == *exact_at(before, p, x, y));
}

/* Derived: averages of 4, at most 10 levels down and up in fp32. */
#define FLOAT_LIMIT 1e-6

/* limit: of errors, over the brightest channel. */
static void check_light(setup *s, const exact_planes *carried, double limit) {
  exact_planes got = filled(s, carried);
  exact_planes want = checked_planes(carried->width, carried->height, 4);
  memcpy(want.values, carried->values,
         sizeof(double) * 4 * (size_t)(want.width * want.height));
  checked_push_pull(&want);
  assert_valid_unchanged(&got, carried);
  check_at_most("light", largest_error(&got, &want, 0, 3),
                limit * largest_value(&want, 0, 3));
  check_at_most("weight", largest_error(&got, &want, 3, 1), 1e-6);
  exact_planes_free(&got);
  exact_planes_free(&want);
}

static void holes_are_filled_as_in_the_reference(void **state) {
  const double valid[] = {0.5, 0.02, 0.97}, sky[] = {0.0, 0.5, 0.9};
  (void)state;
  for (size_t i = 0; i < SIZES; ++i) {
    setup s;
    prepare(&s, sizes[i]);
    start(&s);
    for (int j = 0; j < 3; ++j) {
      exact_planes light = random_light(&s, valid[j], sky[j]);
      check_light(&s, &light, FLOAT_LIMIT);
      exact_planes_free(&light);
    }
    setup_free(&s);
  }
}

static void one_valid_pixel_fills_everything(void **state) {
  (void)state;
  for (size_t i = 0; i < SIZES; ++i) {
    setup s;
    exact_planes light, got;
    const double colour[4] = {0.25, 3.0, 7.5, 1.0};
    prepare(&s, sizes[i]);
    start(&s);
    light = random_light(&s, 0.0, 0.0);
    for (int c = 0; c < 4; ++c)
      *exact_at(&light, c, light.width / 3, light.height - 1) = colour[c];
    got = filled(&s, &light);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < got.height; ++y)
        for (int x = 0; x < got.width; ++x)
          assert_true(fabs(*exact_at(&got, c, x, y) - colour[c]) <=
                      2e-6 * colour[c]);
    exact_planes_free(&got);
    check_light(&s, &light, FLOAT_LIMIT);
    exact_planes_free(&light);
    setup_free(&s);
  }
}

/* Derived: up to 6 levels down and 6 up, each rounded once by up to half a
 * step. A step is at most 2^-7 of the brightest channel. */
#define PACKED_LIMIT (12.0 * 0x1p-8)

static void packed_holes_are_filled(void **state) {
  static const cl_uint widths[] = {1, 4, 8, 16};
  const double valid[] = {0.9, 0.05};
  (void)state;
  for (size_t i = 0; i < 8; ++i) {
    setup s;
    prepare(&s, sizes[3]);
    s.config.sampling.storage = HBIL_STORAGE_PACKED;
    s.config.execution.vector_width = widths[i / 2];
    start(&s);
    exact_planes light = random_light(&s, valid[i % 2], 0.2);
    stage_write(&s, HBIL_STAGE_CARRIED, &light);
    exact_planes_free(&light);
    light = stage_read(&s, HBIL_STAGE_CARRIED); /* as its words have it */
    check_light(&s, &light, PACKED_LIMIT);
    exact_planes_free(&light);
    setup_free(&s);
  }
}

static void nothing_valid_leaves_zeros(void **state) {
  (void)state;
  for (size_t i = 0; i < SIZES; ++i) {
    setup s;
    exact_planes light, got;
    prepare(&s, sizes[i]);
    start(&s);
    light = random_light(&s, 0.0, 0.0);
    got = filled(&s, &light);
    assert_int_equal(count_different(&got, &light), 0);
    exact_planes_free(&got);
    exact_planes_free(&light);
    setup_free(&s);
  }
}

static void all_valid_is_left_alone(void **state) {
  (void)state;
  for (size_t i = 0; i < SIZES; ++i) {
    setup s;
    exact_planes light, got;
    prepare(&s, sizes[i]);
    start(&s);
    light = random_light(&s, 1.0, 0.0);
    got = filled(&s, &light);
    assert_int_equal(count_different(&got, &light), 0);
    exact_planes_free(&got);
    exact_planes_free(&light);
    setup_free(&s);
  }
}

/* Neither filled nor mixed into what is. */
static void the_sky_is_left_alone(void **state) {
  (void)state;
  for (size_t i = 0; i < SIZES; ++i) {
    setup s;
    prepare(&s, sizes[i]);
    start(&s);
    exact_planes light = random_light(&s, 0.3, 1.0);
    exact_planes got = filled(&s, &light);
    assert_int_equal(count_different(&got, &light), 0);
    exact_planes_free(&got);
    exact_planes_free(&light);
    setup_free(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(holes_are_filled_as_in_the_reference),
      cmocka_unit_test(packed_holes_are_filled),
      cmocka_unit_test(one_valid_pixel_fills_everything),
      cmocka_unit_test(nothing_valid_leaves_zeros),
      cmocka_unit_test(all_valid_is_left_alone),
      cmocka_unit_test(the_sky_is_left_alone)};
  return RUN_WITH_DEVICE(tests);
}
