/*
 * The output `unknown`: the share of the hemisphere whose light is a guess.  It
 * matches the exact passes in vectors of every width, is what the far field and
 * the fallback fill in, and takes no memory where nobody asks for it.
 */
#include "test/support/stages.h"

#include <math.h>

#define WIDTH 77
#define HEIGHT 45

/* A room with both kinds of guesses: its open directions, and what furniture
 * that faces away blocks. */
static void prepare(setup *s, hbil_far_field far) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.model.far_field = far;
  s->config.outputs.unknown = one_float;
}

static exact_planes one_frame(setup *s) {
  setup_start(s);
  setup_run(s, hbil_enqueue_frame);
  return outputs_read(s);
}

/* ------------------------------------------------------------------------ */
/* Against the exact passes                                                  */

/* Frames of a room that continues outside the picture, or under a sky that
 * direct light contains in part. */
static void check_frames(hbil_far_field far, hbil_storage storage,
                         cl_uint slices, cl_uint width) {
  setup s;
  exact_state expected;
  prepare(&s, far);
  setup_all_outputs(&s);
  s.config.sampling.storage = storage;
  s.config.sampling.slices = slices;
  s.config.execution.vector_width = width;
  setup_start(&s);
  checked_state(&expected, WIDTH, HEIGHT);
  for (uint32_t i = 0; i < 2; ++i) {
    setup_load_scene(&s, i ? SCENE_SKY : SCENE_ROOM, i);
    for (int c = 0; c < 3; ++c)
      s.frame.environment[0][c] = (float)i * (0.6f + 0.2f * (float)c);
    setup_upload(&s);
    setup_run(&s, hbil_enqueue_frame);
    checked_run_frame(&expected, &s.job);
    exact_planes got = outputs_read(&s);
    assert_true(largest_value(&expected.out, EXACT_UNKNOWN, 1) > 0.1);
    /* measured: 2.2e-7; packed: 1.1e-3, of a share in steps of 1/255 that the
     * filter averages, and of normals in 16 bits that steer it */
    check_at_most("unknown",
                  relative_rmse(&got, &expected.out, EXACT_UNKNOWN, 1),
                  storage == HBIL_STORAGE_FLOAT32 ? 1e-5 : 3e-3);
    exact_planes_free(&got);
  }
  exact_state_free(&expected);
  setup_free(&s);
}

static void every_width_matches(void **state) {
  static const cl_uint widths[] = {1, 4, 8, 16};
  (void)state;
  for (size_t i = 0; i < sizeof widths / sizeof *widths; ++i) {
    check_frames(HBIL_FAR_FRAME, HBIL_STORAGE_FLOAT32, 2, widths[i]);
    check_frames(HBIL_FAR_NONE, HBIL_STORAGE_PACKED, 1, widths[i]);
  }
}

/* ------------------------------------------------------------------------ */
/* What it consists of                                                       */

/* The share that back-facing samples block is left alone where the far field is
 * known, and the open share comes on top where it is not. */
static void other_far_fields_leave_back_faces_alone(void **state) {
  exact_planes behind[HBIL_FAR_FRAME + 1];
  (void)state;
  for (hbil_far_field far = HBIL_FAR_NONE; far <= HBIL_FAR_FRAME; ++far) {
    setup s;
    prepare(&s, far);
    behind[far] = one_frame(&s);
    exact_planes resolved = stage_read(&s, HBIL_STAGE_RESOLVED);
    assert_true(largest_value(&behind[far], EXACT_UNKNOWN, 1) > 0.1);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
      const int x = i % WIDTH, y = i / WIDTH;
      const bool solid = s.input[EXACT_DEPTH][i] > 0.0f;
      const double open =
          far == HBIL_FAR_FRAME ? *exact_at(&resolved, HBIL_LIGHT_AO, x, y) : 0;
      const double want =
          open + *exact_at(&behind[HBIL_FAR_NONE], EXACT_UNKNOWN, x, y);
      /* derived: a rounding of the sum */
      assert_true(fabs(*exact_at(&behind[far], EXACT_UNKNOWN, x, y) -
                       (solid ? want : 0.0)) <= 1e-7);
    }
    exact_planes_free(&resolved);
    setup_free(&s);
  }
  for (hbil_far_field far = HBIL_FAR_NONE; far <= HBIL_FAR_FRAME; ++far)
    exact_planes_free(&behind[far]);
}

/* Light that nobody guesses: all samples count, or the fallback is another. */
static void without_a_guess_it_is_zero(void **state) {
  (void)state;
  for (int i = 0; i < 3; ++i) {
    setup s;
    prepare(&s, i == 2 ? HBIL_FAR_CONSTANT : HBIL_FAR_NONE);
    if (i == 1)
      s.config.model.back_facing_fallback = HBIL_FALLBACK_BLACK;
    else
      s.config.model.facing_fade[0] = s.config.model.facing_fade[1] = -1.0f;
    exact_planes out = one_frame(&s);
    assert_true(largest_value(&out, EXACT_UNKNOWN, 1) == 0.0);
    exact_planes_free(&out);
    setup_free(&s);
  }
}

/* The inside of the box [-2,3] x [-1,2] x [-1,4], all of it with radiance 1. */
static void white_box(setup *s, hbil_back_facing_fallback fallback) {
  const double low[3] = {-2, -1, -1}, high[3] = {3, 2, 4};
  setup_init(s, WIDTH, HEIGHT);
  setup_camera(s, 100.0);
  s->config.outputs.unknown = one_float;
  s->config.history.reprojection = HBIL_REPROJECTION_NONE;
  s->config.inputs.albedo.component = s->config.inputs.direct.component =
      HBIL_NONE;
  s->config.model.back_facing_fallback = fallback;
  s->config.model.far_field = HBIL_FAR_FRAME;
  s->config.model.facing_fade[1] = 0.9f; /* no face of a box faces away */
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    double ray[3], nearest = INFINITY;
    int face = 0;
    setup_ray(s, i % WIDTH, i / WIDTH, ray);
    for (int c = 0; c < 3; ++c) {
      const double t =
          ray[c] == 0.0 ? INFINITY : (ray[c] > 0.0 ? high : low)[c] / ray[c];
      face = t < nearest ? c : face;
      nearest = fmin(nearest, t);
    }
    s->input[EXACT_DEPTH][i] = (float)nearest;
    s->input[EXACT_NORMAL + face][i] = ray[face] > 0.0 ? -1.0f : 1.0f;
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_EMISSION + c][i] = 1.0f;
  }
}

/* A black fallback leaves of the light what the screen shows: E_near / pi is
 * the share of the hemisphere that it comes from.  In a closed box the rest is
 * a guess. */
static void in_a_closed_box_all_is_known_or_unknown(void **state) {
  setup guessing, black;
  double worst = 0.0, behind = 0.0;
  (void)state;
  white_box(&guessing, HBIL_FALLBACK_FRAME_MEAN);
  white_box(&black, HBIL_FALLBACK_BLACK);
  exact_planes guess = one_frame(&guessing), known = one_frame(&black);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    const int x = i % WIDTH, y = i / WIDTH;
    const double unknown = *exact_at(&guess, EXACT_UNKNOWN, x, y);
    const double shown = *exact_at(&known, EXACT_NEAR_IRRADIANCE, x, y) / PI;
    worst = fmax(worst, fabs(unknown + shown - 1.0));
    behind = fmax(behind, unknown - *exact_at(&guess, EXACT_AO, x, y));
  }
  assert_true(behind > 0.1); /* both parts are there */
  /* measured: 2.9e-7, as in the white furnace of test_estimate */
  check_at_most("known + unknown", worst, 1e-5);
  exact_planes_free(&guess);
  exact_planes_free(&known);
  setup_free(&guessing);
  setup_free(&black);
}

/* ------------------------------------------------------------------------ */
/* What it costs                                                             */

static cl_uint resolved_values(const hbil_config *config) {
  hbil_plan *plan;
  hbil_buffer resolved;
  assert_int_equal(hbil_plan_create(shared_device.hbil, config, &plan),
                   HBIL_SUCCESS);
  assert_int_equal(hbil_plan_buffer(plan, HBIL_STAGE_RESOLVED, &resolved),
                   HBIL_SUCCESS);
  hbil_plan_destroy(plan);
  return resolved.values;
}

/* A plane of its own is for the share behind back faces, and only if it can be
 * something else than 0. */
static void plans_without_it_store_nothing(void **state) {
  setup s;
  (void)state;
  prepare(&s, HBIL_FAR_FRAME);
  assert_int_equal(resolved_values(&s.config), HBIL_LIGHT_PLANES + 1);
  s.config.outputs.unknown.component = HBIL_NONE;
  const size_t without = setup_memory(&s);
  assert_int_equal(resolved_values(&s.config), HBIL_LIGHT_PLANES);
  s.config.outputs.unknown = one_float;
  assert_true(setup_memory(&s) > without);
  s.config.model.facing_fade[0] = s.config.model.facing_fade[1] = -1.0f;
  const size_t with = setup_memory(&s);
  assert_int_equal(resolved_values(&s.config), HBIL_LIGHT_PLANES);
  s.config.outputs.unknown.component = HBIL_NONE;
  assert_int_equal(setup_memory(&s), with);
  setup_free(&s);
}

/* Alone it is the same as with other outputs. */
static void it_can_be_had_alone(void **state) {
  (void)state;
  for (int i = 0; i < 2; ++i) {
    setup s, alone;
    prepare(&s, i ? HBIL_FAR_FRAME : HBIL_FAR_NONE);
    setup_all_outputs(&s);
    prepare(&alone, i ? HBIL_FAR_FRAME : HBIL_FAR_NONE);
    setup_no_outputs(&alone);
    alone.config.outputs.unknown = one_float;
    exact_planes want = one_frame(&s), got = one_frame(&alone);
    assert_true(largest_error(&got, &want, EXACT_UNKNOWN, 1) == 0.0);
    exact_planes_free(&want);
    exact_planes_free(&got);
    setup_free(&s);
    setup_free(&alone);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_width_matches),
      cmocka_unit_test(other_far_fields_leave_back_faces_alone),
      cmocka_unit_test(without_a_guess_it_is_zero),
      cmocka_unit_test(in_a_closed_box_all_is_known_or_unknown),
      cmocka_unit_test(plans_without_it_store_nothing),
      cmocka_unit_test(it_can_be_had_alone)};
  return RUN_WITH_DEVICE(tests);
}
