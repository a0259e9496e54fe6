/*
 * Composite matches the exact pass: far light, every output in every form, and
 * the history for the next frame.
 */
#include "exact/glossy.h"
#include "test/support/random.h"
#include "test/support/stages.h"

#include <math.h>

#define WIDTH 45
#define HEIGHT 31

/* Plausible light: AO in [0,1], here and there a rounding above 1, unit bent
 * normals, a part of what is blocked behind surfaces that face away, nothing at
 * the sky. */
static exact_planes plant_resolved(setup *s) {
  random_state r = {23};
  int width = (int)s->config.width, height = (int)s->config.height;
  exact_planes light = checked_planes(width, height, EXACT_GLOSSY_RESOLVED);
  for (int i = 0; i < width * height; ++i) {
    int x = i % width, y = i / width;
    bool sky = !(s->input[EXACT_DEPTH][i] > 0.0f);
    double polar = acos(2.0 * random_unit(&r) - 1.0);
    double azimuth = 2.0 * PI * random_unit(&r);
    *exact_at(&light, HBIL_LIGHT_AO, x, y) =
        sky           ? 1.0
        : i % 11 == 0 ? 1.0 + 0x1p-23
                      : (double)(float)random_unit(&r);
    for (int c = 0; c < 3 && !sky; ++c)
      *exact_at(&light, HBIL_LIGHT_RED + c, x, y) =
          (double)(float)(3.0 * random_unit(&r));
    if (sky)
      continue;
    *exact_at(&light, HBIL_LIGHT_BENT, x, y) = sin(polar) * cos(azimuth);
    *exact_at(&light, HBIL_LIGHT_BENT + 1, x, y) = sin(polar) * sin(azimuth);
    *exact_at(&light, HBIL_LIGHT_BENT + 2, x, y) = cos(polar);
    *exact_at(&light, HBIL_LIGHT_UNKNOWN, x, y) =
        fmax(0.0, 1.0 - *exact_at(&light, HBIL_LIGHT_AO, x, y)) *
        random_unit(&r);
    for (int p = EXACT_GLOSSY_PLANES; p < EXACT_GLOSSY_RESOLVED; ++p)
      *exact_at(&light, p, x, y) = (double)(float)random_unit(&r);
  }
  stage_write(s, HBIL_STAGE_RESOLVED, &light);
  return light;
}

static void random_environment(setup *s) {
  random_state r = {31};
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      s->frame.environment[i][c] =
          (float)(i ? random_unit(&r) - 0.5 : 2.0 + random_unit(&r));
}

/* Starts the plan, writes random light, and runs composite on both sides. */
static void run_both(setup *s, exact_planes *got, exact_planes *want,
                     exact_planes *history) {
  exact_planes light;
  setup_start(s);
  if (s->config.outputs.glossy.component) /* composite itself reads no layers */
    setup_run(s, enqueue_split);
  light = plant_resolved(s);
  setup_run(s, enqueue_composite);
  *got = outputs_read(s);
  *want = checked_planes(got->width, got->height, EXACT_OUTPUT_PLANES);
  *history = checked_planes(got->width, got->height, HBIL_HISTORY_PLANES);
  exact_composite(&s->job, &light, want, history);
  if (s->config.outputs.glossy.component) {
    exact_planes split = stage_read(s, HBIL_STAGE_SPLIT);
    exact_glossy(&s->job, &split, &light, NULL, want);
    exact_planes_free(&split);
  }
  exact_planes_free(&light);
}

static void check_outputs(setup *s, const exact_planes *got,
                          const exact_planes *want) {
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id) {
    const hbil_plane_format *format = plane_format(&s->config, id);
    int first = plane_first(id), count = plane_channels(id);
    /* derived: half floats round by 2^-11; else a dozen fp32 roundings */
    double limit = format->component == HBIL_FLOAT16 ? 5e-4 : 3e-6;
    if (format->component == HBIL_NONE)
      continue;
    check_at_most(plane_name(id), largest_error(got, want, first, count),
                  limit * largest_value(want, first, count));
  }
}

static void check_history(setup *s, const exact_planes *want) {
  exact_planes got = stage_read(s, HBIL_STAGE_HISTORY);
  for (int y = 0; y < got.height; ++y)
    for (int x = 0; x < got.width; ++x) {
      double w = *exact_at(&got, HBIL_HISTORY_W, x, y);
      double expected = *exact_at(want, HBIL_HISTORY_W, x, y);
      assert_true(expected > 0.0 ? fabs(w / expected - 1.0) < 5e-7 : w <= 0.0);
    }
  check_at_most("history", largest_error(&got, want, HBIL_HISTORY_RED, 3),
                3e-6 * largest_value(want, HBIL_HISTORY_RED, 3));
  exact_planes_free(&got);
}

/* Only plans with an output that near light takes part in have a history. */
static bool gathers_light(const hbil_config *c) {
  return c->outputs.near_irradiance.component ||
         c->outputs.indirect.component || c->outputs.beauty.component ||
         c->outputs.unknown.component || c->outputs.glossy.component;
}

static void check_composite(setup *s) {
  exact_planes got, want, history;
  run_both(s, &got, &want, &history);
  check_outputs(s, &got, &want);
  if (gathers_light(&s->config))
    check_history(s, &history);
  exact_planes_free(&got);
  exact_planes_free(&want);
  exact_planes_free(&history);
  setup_free(s);
}

static void prepare(setup *s, scene_kind kind, hbil_far_field far) {
  setup_scene(s, kind, WIDTH, HEIGHT, 0);
  setup_all_outputs(s);
  s->config.outputs.glossy = three_floats;
  s->config.model.far_field = far;
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  random_environment(s);
}

static void every_far_field_matches(void **state) {
  (void)state;
  for (int i = 0; i < 6; ++i) {
    setup s;
    prepare(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, (hbil_far_field)(i / 2));
    check_composite(&s);
  }
}

static void the_sky_shows_the_environment_without_emission(void **state) {
  (void)state;
  for (int far = HBIL_FAR_NONE; far <= HBIL_FAR_SH; ++far) {
    setup s;
    prepare(&s, SCENE_SKY, (hbil_far_field)far);
    s.config.inputs.emission.component = HBIL_NONE;
    check_composite(&s);
  }
}

static void every_feedback_matches(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i) {
    setup s;
    prepare(&s, SCENE_ROOM, HBIL_FAR_SH);
    s.config.model.feedback =
        i & 1 ? HBIL_FEEDBACK_RADIANCE : HBIL_FEEDBACK_IRRADIANCE;
    s.config.model.gather_emission = i & 2 ? CL_TRUE : CL_FALSE;
    s.config.outputs.bent_normal_space = HBIL_SPACE_WORLD;
    check_composite(&s);
  }
}

static void reflectance_takes_its_share(void **state) {
  setup s;
  random_state r = {2};
  const hbil_plane_format rgba = {HBIL_FLOAT32, 4};
  (void)state;
  prepare(&s, SCENE_ROOM, HBIL_FAR_CONSTANT);
  s.config.inputs.f0 = rgba;
  s.config.model.feedback = HBIL_FEEDBACK_RADIANCE;
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    for (int c = 0; c < 3; ++c) {
      s.input[EXACT_F0 + c][i] = (float)(2.0 * random_unit(&r) - 0.5);
      s.input[EXACT_ALBEDO + c][i] *= (float)(3.0 * random_unit(&r) - 0.5);
      s.input[EXACT_DIRECT + c][i] *= i % 7 ? 1.0f : NAN;
    }
  check_composite(&s);
}

static void every_size_matches(void **state) {
  const int sizes[][2] = {{1, 1}, {3, 5}, {17, 31}, {160, 90}, {640, 360}};
  (void)state;
  for (int i = 0; i < 5; ++i) {
    setup s;
    setup_scene(&s, SCENE_SKY, sizes[i][0], sizes[i][1], 0);
    setup_all_outputs(&s);
    s.config.model.far_field = HBIL_FAR_SH;
    random_environment(&s);
    check_composite(&s);
  }
}

/* Every output in one form, with room around it that has to stay as it is. */
static void check_form(hbil_component component, cl_uint stride) {
  setup s;
  prepare(&s, SCENE_SKY, HBIL_FAR_SH);
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id) {
    plane_layout layout = {8 + (size_t)id, 1 + (size_t)id, 0};
    hbil_plane_format format = {component, stride};
    if (plane_channels(id) == 3 && stride == 1)
      layout.plane_extra = 11;
    s.layout[id] = layout;
    *plane_format(&s.config, id) = format;
  }
  check_composite(&s);
}

static void
every_output_form_matches_and_nothing_else_is_written(void **state) {
  (void)state;
  check_form(HBIL_FLOAT32, 1);
  check_form(HBIL_FLOAT32, 3);
  check_form(HBIL_FLOAT32, 4);
  check_form(HBIL_FLOAT16, 1);
  check_form(HBIL_FLOAT16, 3);
  check_form(HBIL_FLOAT16, 4);
  check_form(HBIL_FLOAT32, 0);
}

static void each_output_can_be_had_alone(void **state) {
  (void)state;
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id) {
    setup s;
    hbil_plane_format format;
    prepare(&s, SCENE_SKY, HBIL_FAR_SH);
    format = *plane_format(&s.config, id);
    for (plane_id other = PLANE_FIRST_OUTPUT; other < PLANE_COUNT; ++other)
      plane_format(&s.config, other)->component = HBIL_NONE;
    *plane_format(&s.config, id) = format;
    check_composite(&s);
  }
}

static void an_even_environment_sends_pi_ao_l(void **state) {
  const float colour[3] = {0.5f, 2.0f, 7.0f};
  (void)state;
  for (int far = HBIL_FAR_CONSTANT; far <= HBIL_FAR_SH; ++far) {
    setup s;
    exact_planes got, want, history;
    prepare(&s, SCENE_ROOM, (hbil_far_field)far);
    memset(s.frame.environment, 0, sizeof(s.frame.environment));
    for (int c = 0; c < 3; ++c)
      s.frame.environment[0][c] =
          colour[c] * (far == HBIL_FAR_SH ? (float)sqrt(4.0 * PI) : 1.0f);
    run_both(&s, &got, &want, &history);
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      for (int c = 0; c < 3 && s.input[EXACT_DEPTH][i] > 0.0f; ++c) {
        double ao = *exact_at(&got, EXACT_AO, i % WIDTH, i / WIDTH);
        double far_irradiance =
            *exact_at(&got, EXACT_FAR_IRRADIANCE + c, i % WIDTH, i / WIDTH);
        /* derived: a dozen roundings; 1 - t^2 has to give AO back */
        assert_true(fabs(far_irradiance - PI * ao * (double)colour[c]) <=
                    1e-6 * PI * (double)colour[c]);
      }
    exact_planes_free(&got);
    exact_planes_free(&want);
    exact_planes_free(&history);
    setup_free(&s);
  }
}

/* Every third surface gets red near light that is no number, and green that a
 * rounding has left below 0. */
static void spoil_near_light(const setup *s, exact_planes *light) {
  for (int i = 0; i < WIDTH * HEIGHT; i += 3)
    if (s->input[EXACT_DEPTH][i] > 0.0f) {
      *exact_at(light, HBIL_LIGHT_RED, i % WIDTH, i / WIDTH) = NAN;
      *exact_at(light, HBIL_LIGHT_RED + 1, i % WIDTH, i / WIDTH) = -1e-7;
    }
}

/* A fault in an earlier pass stays visible: black would hide it. */
static void near_light_that_is_no_number_stays_none(void **state) {
  static const int lit[] = {EXACT_NEAR_IRRADIANCE, EXACT_INDIRECT,
                            EXACT_BEAUTY};
  (void)state;
  for (int half = 0; half < 2; ++half) {
    setup s;
    prepare(&s, SCENE_ROOM, HBIL_FAR_NONE);
    for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
      plane_format(&s.config, id)->component =
          half ? HBIL_FLOAT16 : HBIL_FLOAT32;
    setup_start(&s);
    exact_planes light = plant_resolved(&s);
    spoil_near_light(&s, &light);
    stage_write(&s, HBIL_STAGE_RESOLVED, &light);
    setup_run(&s, enqueue_composite);
    exact_planes out = outputs_read(&s);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
      const int x = i % WIDTH, y = i / WIDTH;
      const bool spoiled = i % 3 == 0 && s.input[EXACT_DEPTH][i] > 0.0f;
      for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c)
          assert_int_equal(isnan(*exact_at(&out, lit[k] + c, x, y)) != 0,
                           spoiled && c == 0);
      assert_true(!spoiled ||
                  *exact_at(&out, EXACT_NEAR_IRRADIANCE + 1, x, y) == 0.0);
    }
    exact_planes_free(&light);
    exact_planes_free(&out);
    setup_free(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_far_field_matches),
      cmocka_unit_test(the_sky_shows_the_environment_without_emission),
      cmocka_unit_test(every_feedback_matches),
      cmocka_unit_test(reflectance_takes_its_share),
      cmocka_unit_test(every_size_matches),
      cmocka_unit_test(every_output_form_matches_and_nothing_else_is_written),
      cmocka_unit_test(each_output_can_be_had_alone),
      cmocka_unit_test(an_even_environment_sends_pi_ao_l),
      cmocka_unit_test(near_light_that_is_no_number_stays_none)};
  return RUN_WITH_DEVICE(tests);
}
