/*
 * Split matches the exact pass whatever form the G-buffer comes in.
 */
#include "test/support/random.h"
#include "test/support/stages.h"

#define WIDTH 45
#define HEIGHT 31

static const hbil_plane_format rgba32 = {HBIL_FLOAT32, 4};
static const hbil_plane_format planar16 = {HBIL_FLOAT16, 1};

static exact_planes split_of(setup *s) {
  setup_run(s, enqueue_split);
  return stage_read(s, HBIL_STAGE_SPLIT);
}

/* Derived: a rotation, a length and a product with roundings of 6e-8 each.
 * Normals that are turned back to the eye lose digits in a difference first
 * (measured: 1.5e-6). */
#define NORMAL_LIMIT 5e-7
#define BENT_BACK_LIMIT 1e-5

static void check_split(setup *s, double normal_limit) {
  exact_planes got,
      want = checked_planes((int)s->config.width, (int)s->config.height,
                            HBIL_SPLIT_PLANES);
  setup_start(s);
  got = split_of(s);
  exact_split(&s->job, NULL, &want);
  for (int y = 0; y < got.height; ++y)
    for (int x = 0; x < got.width; ++x) {
      double w = *exact_at(&want, HBIL_SPLIT_W, x, y);
      double off = fabs(*exact_at(&got, HBIL_SPLIT_W, x, y) / w - 1.0);
      if (!(off <= 5e-7)) /* derived: four roundings */
        fail_msg("w at (%d,%d): off by %g", x, y, off);
    }
  check_at_most("normal", largest_error(&got, &want, HBIL_SPLIT_NORMAL, 3),
                normal_limit);
  check_at_most("radiance", largest_error(&got, &want, HBIL_SPLIT_RED, 3),
                1e-6 * largest_value(&want, HBIL_SPLIT_RED, 3));
  exact_planes_free(&got);
  exact_planes_free(&want);
  setup_free(s);
}

static void plain_inputs_match_at_every_size(void **state) {
  const int sizes[][2] = {
      {1, 1}, {3, 5}, {17, 31}, {WIDTH, HEIGHT}, {640, 360}};
  (void)state;
  for (int i = 0; i < 10; ++i) {
    setup s;
    setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, sizes[i / 2][0],
                sizes[i / 2][1], 1);
    check_split(&s, NORMAL_LIMIT);
  }
}

static void half_float_inputs_match(void **state) {
  setup s;
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  for (plane_id id = 0; id < PLANE_FIRST_OUTPUT; ++id)
    plane_format(&s.config, id)->component = HBIL_FLOAT16;
  s.config.inputs.f0.component = HBIL_NONE;
  check_split(&s, NORMAL_LIMIT);
}

static void interleaved_rgba_inputs_match(void **state) {
  setup s;
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.config.inputs.normal = s.config.inputs.albedo = s.config.inputs.direct =
      rgba32;
  s.config.inputs.depth.stride = 4;
  check_split(&s, NORMAL_LIMIT);
}

static void planar_inputs_with_pitches_and_offsets_match(void **state) {
  setup s;
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.config.inputs.normal.stride = s.config.inputs.emission.stride = 1;
  s.config.inputs.albedo = s.config.inputs.direct = planar16;
  for (plane_id id = 0; id < PLANE_FIRST_OUTPUT; ++id) {
    plane_layout layout = {5 + (size_t)id, 3 + (size_t)id, 7};
    if (plane_channels(id) == 1 || plane_format(&s.config, id)->stride != 1)
      layout.plane_extra = 0;
    s.layout[id] = layout;
  }
  check_split(&s, NORMAL_LIMIT);
}

static void stride_0_stands_for_the_channels(void **state) {
  setup s;
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  for (plane_id id = 0; id < PLANE_FIRST_OUTPUT; ++id)
    plane_format(&s.config, id)->stride = 0;
  check_split(&s, NORMAL_LIMIT);
}

static void unorm8_albedo_and_f0_match(void **state) {
  setup s;
  random_state r = {2};
  hbil_plane_format unorm = {HBIL_UNORM8, 4};
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.config.inputs.albedo = s.config.inputs.f0 = unorm;
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      s.input[EXACT_F0 + c][i] = (float)random_unit(&r);
  check_split(&s, NORMAL_LIMIT);
}

static void ray_distances_match(void **state) {
  setup s;
  (void)state;
  setup_scene(&s, SCENE_SKY, WIDTH, HEIGHT, 0);
  s.config.inputs.depth_kind = HBIL_DEPTH_RAY;
  s.config.inputs.sky_depth = 20.0f;
  check_split(&s, NORMAL_LIMIT);
}

static void view_space_normals_match(void **state) {
  setup s;
  random_state r = {21};
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.config.inputs.normal_space = HBIL_SPACE_VIEW;
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    s.input[EXACT_NORMAL][i] = (float)(random_unit(&r) - 0.5);
    s.input[EXACT_NORMAL + 1][i] = (float)(random_unit(&r) - 0.5);
    s.input[EXACT_NORMAL + 2][i] = (float)(-0.1 - 3.0 * random_unit(&r));
  }
  check_split(&s, NORMAL_LIMIT); /* some of them face away */
}

/* Distances and depths in centimetres, and depths that count backwards. */
static void scaled_depths_match(void **state) {
  const float scales[] = {0.01f, -1.0f};
  (void)state;
  for (int i = 0; i < 4; ++i) {
    setup s;
    setup_scene(&s, SCENE_SKY, WIDTH, HEIGHT, 0);
    s.config.inputs.depth_kind = i & 1 ? HBIL_DEPTH_RAY : HBIL_DEPTH_PLANAR;
    s.config.inputs.depth_scale = scales[i / 2];
    s.config.inputs.sky_depth = 20.0f;
    for (int p = 0; p < WIDTH * HEIGHT; ++p)
      s.input[EXACT_DEPTH][p] /= scales[i / 2];
    check_split(&s, NORMAL_LIMIT);
  }
}

/* The axes of OpenGL's and Direct3D's view spaces, and of a world with another
 * handedness; lengths are of no account. */
static void turned_normals_match(void **state) {
  const float axes[][3] = {{1, -1, -1}, {1, -1, 1}, {-3, 0.5f, 2}};
  (void)state;
  for (int i = 0; i < 6; ++i) {
    setup s;
    setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
    s.config.inputs.normal_space = i & 1 ? HBIL_SPACE_WORLD : HBIL_SPACE_VIEW;
    for (int p = 0; p < WIDTH * HEIGHT && !(i & 1); ++p)
      s.input[EXACT_NORMAL + 2][p] = -2.0f; /* faces the eye */
    for (int c = 0; c < 3; ++c) {
      s.config.inputs.normal_scale[c] = axes[i / 2][c];
      for (int p = 0; p < WIDTH * HEIGHT; ++p)
        s.input[EXACT_NORMAL + c][p] /= axes[i / 2][c];
    }
    check_split(&s, NORMAL_LIMIT);
  }
}

static void optional_inputs_may_be_absent(void **state) {
  setup s;
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.config.inputs.albedo.component = HBIL_NONE;
  s.config.inputs.emission.component = HBIL_NONE;
  s.config.inputs.motion.component = HBIL_NONE;
  s.config.inputs.direct_scale = 2.5f;
  check_split(&s, NORMAL_LIMIT);
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.config.inputs.direct.component = HBIL_NONE;
  s.config.model.gather_emission = CL_FALSE;
  check_split(&s, NORMAL_LIMIT);
}

/* Not-a-numbers, negative light, zero normals, invalid depths. */
static void spoil_inputs(setup *s) {
  const float odd[] = {NAN, INFINITY, -INFINITY, -1.0f, 0.0f, -0.0f, 1e30f};
  random_state r = {9};
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    for (int p = 0; p < EXACT_MOTION; ++p) {
      float value = odd[(int)(7.0 * random_unit(&r))];
      bool light = p >= EXACT_ALBEDO;
      if (random_unit(&r) < 0.1 && !(light && value > 1e20f && isfinite(value)))
        s->input[p][i] = value;
    }
}

static void odd_values_are_handled_as_specified(void **state) {
  setup s;
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.config.inputs.f0 = rgba32;
  spoil_inputs(&s);
  check_split(&s, NORMAL_LIMIT);
}

static void normals_from_behind_and_without_length_match(void **state) {
  setup s;
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    for (int c = 0; c < 3; ++c)
      s.input[EXACT_NORMAL + c][i] *= i % 3 == 0   ? 0.0f
                                      : i % 3 == 1 ? -1.0f
                                                   : 1e-3f;
  check_split(&s, BENT_BACK_LIMIT);
}

static void carried_light_takes_part(void **state) {
  random_state r = {4};
  (void)state;
  for (int feedback = 0; feedback < 2; ++feedback) {
    setup s;
    exact_planes carried, got, want;
    setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
    s.config.model.feedback = (hbil_feedback)feedback;
    setup_start(&s);
    setup_run(&s, hbil_enqueue_frame); /* there is a history from here on */
    carried = checked_planes(WIDTH, HEIGHT, 4);
    want = checked_planes(WIDTH, HEIGHT, HBIL_SPLIT_PLANES);
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      for (int p = 0; p < 4; ++p)
        carried.values[p * WIDTH * HEIGHT + i] =
            i % 5 == 0 ? 0.0
            : p == 3   ? 1.0
                       : (double)(float)random_unit(&r);
    stage_write(&s, HBIL_STAGE_CARRIED, &carried);
    got = split_of(&s);
    exact_split(&s.job, &carried, &want);
    check_at_most("radiance", largest_error(&got, &want, HBIL_SPLIT_RED, 3),
                  1e-6 * largest_value(&want, HBIL_SPLIT_RED, 3));
    exact_planes_free(&carried);
    exact_planes_free(&got);
    exact_planes_free(&want);
    setup_free(&s);
  }
}

/* Outside the pixels of a layer no inverse depth is above 0. */
static void check_padding(int width, int height) {
  setup s;
  hbil_buffer b;
  exact_planes got;
  float *w;
  size_t size, real = 0, positive = 0;
  setup_scene(&s, SCENE_ROOM, width, height, 0);
  setup_start(&s);
  got = split_of(&s);
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

static void padding_holds_nothing(void **state) {
  (void)state;
  check_padding(1, 1);
  check_padding(3, 5);
  check_padding(17, 31);
  check_padding(64, 64);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(plain_inputs_match_at_every_size),
      cmocka_unit_test(half_float_inputs_match),
      cmocka_unit_test(interleaved_rgba_inputs_match),
      cmocka_unit_test(planar_inputs_with_pitches_and_offsets_match),
      cmocka_unit_test(stride_0_stands_for_the_channels),
      cmocka_unit_test(unorm8_albedo_and_f0_match),
      cmocka_unit_test(ray_distances_match),
      cmocka_unit_test(view_space_normals_match),
      cmocka_unit_test(scaled_depths_match),
      cmocka_unit_test(turned_normals_match),
      cmocka_unit_test(optional_inputs_may_be_absent),
      cmocka_unit_test(odd_values_are_handled_as_specified),
      cmocka_unit_test(normals_from_behind_and_without_length_match),
      cmocka_unit_test(carried_light_takes_part),
      cmocka_unit_test(padding_holds_nothing)};
  return RUN_WITH_DEVICE(tests);
}
