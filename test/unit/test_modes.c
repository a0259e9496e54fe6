/*
 * The modes GTAO and HBAO: their kernels match the exact passes with every
 * setting, and configurations that a mode has no use for are rejected.
 */
#include "test/support/stages.h"

/* ------------------------------------------------------------------------ */
/* Kernels against the exact passes                                          */

/* Relative RMSE.  Measured: AO 1.2e-7, bent 3.0e-7; with sectors, whose mean
 * direction is a quotient of differences, bent 1.2e-5. */
#define AO_LIMIT 1e-6
#define BENT_LIMIT 1e-5
#define SECTORS_BENT_LIMIT 5e-5

/* A rounding of fp32 can move an angle across the border of a sector.  Such a
 * pixel is off by a whole sector, which can be a large share of a half-slice
 * that is seen at a grazing angle.  These pixels are counted and then left out
 * of the comparison. */
static void forget_moved_sectors(exact_planes *got, const exact_planes *want) {
  int count = 0;
  for (int i = 0; i < got->width * got->height; ++i) {
    int x = i % got->width, y = i / got->width;
    if (fabs(*exact_at(got, HBIL_LIGHT_AO, x, y) -
             *exact_at(want, HBIL_LIGHT_AO, x, y)) < 1e-5)
      continue;
    ++count;
    for (int p = 0; p < got->count; ++p)
      *exact_at(got, p, x, y) = *exact_at(want, p, x, y);
  }
  check_at_most("pixels in which a sector moved", count,
                got->width * got->height / 1000.0);
}

static bool has_sectors(const hbil_config *c) {
  return !isinf(c->model.thickness) || !isinf(c->model.relative_thickness);
}

static void check_kernel(setup *s) {
  exact_planes got, want;
  setup_start(s);
  got = stage_gathered(s);
  want = expected_gathered(s);
  if (has_sectors(&s->config))
    forget_moved_sectors(&got, &want);
  check_at_most("AO", relative_rmse(&got, &want, HBIL_LIGHT_AO, 1), AO_LIMIT);
  if (s->config.model.mode != HBIL_MODE_HBAO)
    check_at_most("bent", relative_rmse(&got, &want, HBIL_LIGHT_BENT, 3),
                  has_sectors(&s->config) ? SECTORS_BENT_LIMIT : BENT_LIMIT);
  exact_planes_free(&got);
  exact_planes_free(&want);
  setup_free(s);
}

static void check_view(hbil_mode mode, hbil_falloff falloff, int i) {
  const float radii[] = {INFINITY, 2.0f, 0.5f};
  const double fov[] = {30.0, 60.0, 90.0, 120.0};
  const cl_uint widths[] = {1, 4, 8, 16};
  setup s;
  setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, 97, 54, 0);
  setup_load_view(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, fov[i % 4], 0);
  setup_mode(&s, mode);
  s.config.model.falloff = falloff;
  s.config.model.radius = radii[i % 3];
  s.config.execution.vector_width = widths[i / 3 % 4];
  /* a single slice is weighed: in either mode by two of the widths */
  const bool single = (mode == HBIL_MODE_GTAO) == (i / 3 & 1);
  s.config.sampling.slices = i % 3 ? 1 + (cl_uint)i % 3 : single ? 1 : 4;
  s.config.sampling.steps_per_side = i & 2 ? 8 : 21;
  s.config.sampling.sample_grid =
      i & 4 ? HBIL_GRID_SAME_LAYER : HBIL_GRID_FULL_RESOLUTION;
  s.frame.frame_index = (cl_uint)i;
  check_kernel(&s);
}

static void gtao_matches(void **state) {
  (void)state;
  for (int i = 0; i < 12; ++i)
    check_view(HBIL_MODE_GTAO, HBIL_FALLOFF_LINEAR, i);
}

static void hbao_matches_with_every_falloff(void **state) {
  (void)state;
  for (int i = 0; i < 12; ++i)
    check_view(HBIL_MODE_HBAO, (hbil_falloff)(i / 4), i);
  for (int i = 1; i < 12; i += 3) /* with a radius of 2 */
    check_view(HBIL_MODE_HBAO, (hbil_falloff)(i % 2), i);
}

static void finite_occluders_match(void **state) {
  const float thickness[][2] = {
      {INFINITY, 0.08f}, {0.1f, INFINITY}, {0.02f, 0.5f}};
  (void)state;
  for (int i = 0; i < 12; ++i) {
    setup s;
    setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, 97, 54, 0);
    setup_mode(&s, i & 2 ? HBIL_MODE_GTAO : HBIL_MODE_HBAO);
    s.config.model.thickness = thickness[i % 3][0];
    s.config.model.relative_thickness = thickness[i % 3][1];
    s.config.model.radius = i & 4 ? 1.0f : INFINITY;
    s.config.model.falloff = (hbil_falloff)(i / 4);
    s.config.execution.vector_width = i & 8 ? 1 : 8;
    check_kernel(&s);
  }
}

static void half_float_depth_matches(void **state) {
  (void)state;
  for (int i = 0; i < 2; ++i) {
    setup s;
    setup_scene(&s, SCENE_ROOM, 97, 54, 0);
    setup_mode(&s, i ? HBIL_MODE_HBAO : HBIL_MODE_GTAO);
    s.config.inputs.depth.component = HBIL_FLOAT16;
    check_kernel(&s);
  }
}

/* Every output that a mode has. */
static void set_outputs(setup *s, hbil_mode mode) {
  s->config.outputs.far_irradiance = s->config.outputs.indirect =
      s->config.outputs.beauty = three_floats;
  s->config.outputs.ao = s->config.outputs.cone_cosine = one_float;
  s->config.outputs.bent_normal = three_floats;
  setup_mode(s, mode);
}

/* Limits as in test_frame. */
static void check_frames(hbil_mode mode, hbil_far_field far_field,
                         hbil_feedback feedback) {
  setup s;
  exact_state expected;
  setup_scene(&s, SCENE_SKY, 97, 54, 0);
  checked_state(&expected, 97, 54);
  set_outputs(&s, mode);
  s.config.model.far_field = far_field;
  s.config.model.feedback = feedback;
  s.config.model.back_facing_fallback =
      HBIL_FALLBACK_FRAME_MEAN; /* has no effect without light */
  for (int i = 0; i < (far_field == HBIL_FAR_SH ? 9 : 1); ++i)
    for (int c = 0; c < 3; ++c)
      s.frame.environment[i][c] = i ? 0.1f * (float)(i % 3) : 1.0f + (float)c;
  setup_start(&s);
  for (int i = 0; i < 3; ++i) {
    setup_load_scene(&s, SCENE_SKY, (uint32_t)i);
    s.frame.frame_index = (cl_uint)i;
    setup_upload(&s);
    setup_run(&s, hbil_enqueue_frame);
    checked_run_frame(&expected, &s.job);
    check_frame_outputs(&s, &expected.out);
  }
  exact_state_free(&expected);
  setup_free(&s);
}

static void whole_frames_match(void **state) {
  (void)state;
  check_frames(HBIL_MODE_GTAO, HBIL_FAR_CONSTANT, HBIL_FEEDBACK_IRRADIANCE);
  check_frames(HBIL_MODE_GTAO, HBIL_FAR_SH, HBIL_FEEDBACK_RADIANCE);
  check_frames(HBIL_MODE_GTAO, HBIL_FAR_NONE, HBIL_FEEDBACK_IRRADIANCE);
  check_frames(HBIL_MODE_HBAO, HBIL_FAR_CONSTANT, HBIL_FEEDBACK_RADIANCE);
  check_frames(HBIL_MODE_HBAO, HBIL_FAR_NONE, HBIL_FEEDBACK_IRRADIANCE);
}

/* ------------------------------------------------------------------------ */
/* What modes reject                                                         */

static void assert_rejected(const hbil_config *config, const char *field) {
  hbil_plan *plan = NULL;
  assert_int_equal(hbil_plan_create(shared_device.hbil, config, &plan),
                   HBIL_INVALID_CONFIG);
  assert_null(plan);
  assert_non_null(strstr(hbil_context_message(shared_device.hbil), field));
}

static hbil_config ao_alone(hbil_mode mode) {
  hbil_config c;
  hbil_config_init(&c);
  c.width = c.height = 16;
  c.inputs.depth = c.outputs.ao = one_float;
  c.inputs.normal = three_floats;
  c.model.mode = mode;
  c.model.far_field = HBIL_FAR_NONE;
  return c;
}

static void outputs_without_meaning_are_rejected(void **state) {
  (void)state;
  for (hbil_mode mode = HBIL_MODE_GTAO; mode <= HBIL_MODE_HBAO; ++mode) {
    hbil_config c = ao_alone(mode);
    c.outputs.near_irradiance = three_floats;
    assert_rejected(&c, "near_irradiance");
    c = ao_alone(mode);
    c.outputs.unknown = one_float;
    assert_rejected(&c, "unknown");
    c = ao_alone(mode);
    c.model.far_field = HBIL_FAR_FRAME;
    assert_rejected(&c, "far_field");
  }
}

static void hbao_without_bent_cone_is_rejected(void **state) {
  hbil_config c = ao_alone(HBIL_MODE_HBAO);
  (void)state;
  c.outputs.bent_normal = three_floats;
  assert_rejected(&c, "bent_normal");
  c = ao_alone(HBIL_MODE_HBAO);
  c.outputs.cone_cosine = one_float;
  assert_rejected(&c, "cone_cosine");
  c = ao_alone(HBIL_MODE_HBAO);
  c.model.far_field = HBIL_FAR_SH;
  c.outputs.far_irradiance = three_floats;
  assert_rejected(&c, "far_field");
}

static void unknown_modes_and_falloffs_are_rejected(void **state) {
  hbil_config c = ao_alone((hbil_mode)3);
  (void)state;
  assert_rejected(&c, "mode");
  c = ao_alone(HBIL_MODE_HBAO);
  c.model.falloff = (hbil_falloff)3;
  assert_rejected(&c, "falloff");
}

static void everything_that_a_mode_has_is_accepted(void **state) {
  (void)state;
  for (int i = 0; i < 2; ++i) {
    setup s;
    setup_init(&s, 16, 16);
    set_outputs(&s, i ? HBIL_MODE_HBAO : HBIL_MODE_GTAO);
    s.config.model.far_field = i ? HBIL_FAR_CONSTANT : HBIL_FAR_SH;
    setup_start(&s); /* must succeed */
    setup_free(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(gtao_matches),
      cmocka_unit_test(hbao_matches_with_every_falloff),
      cmocka_unit_test(finite_occluders_match),
      cmocka_unit_test(half_float_depth_matches),
      cmocka_unit_test(whole_frames_match),
      cmocka_unit_test(outputs_without_meaning_are_rejected),
      cmocka_unit_test(hbao_without_bent_cone_is_rejected),
      cmocka_unit_test(unknown_modes_and_falloffs_are_rejected),
      cmocka_unit_test(everything_that_a_mode_has_is_accepted)};
  return RUN_WITH_DEVICE(tests);
}
