/*
 * Packed storage: directions and light of all magnitudes, and which words a
 * plan stores (test_kernels: the passes lose no more than their words).
 */
#include "test/support/packing.h"
#include "test/support/random.h"
#include "test/support/stages.h"
#include "test/support/vectors.h"

#define WIDTH 45
#define HEIGHT 31

static const cl_uint widths[] = {1, 4, 8, 16};

/* Derived: half a step in u and in v moves a point of the octahedron by up to
 * sqrt(6)/2 steps within its face.  The middle of a face is nearest to the
 * origin, 1/sqrt(3): there this is sqrt(18)/2 steps of 1/32767, 6.5e-5.  fp32
 * adds roundings. */
#define NORMAL_LIMIT 6.6e-5

/* ------------------------------------------------------------------------ */
/* split                                                                     */

static exact_planes split_in(hbil_storage storage, void (*prepare)(setup *),
                             cl_uint vector_width) {
  setup s;
  exact_planes out;
  prepare(&s);
  s.config.sampling.storage = storage;
  s.config.execution.vector_width = vector_width;
  setup_start(&s);
  setup_run(&s, enqueue_split);
  out = stage_read(&s, HBIL_STAGE_SPLIT);
  setup_free(&s);
  return out;
}

/* Inverse depth is exact; normals are compared at surfaces, and finite
 * elsewhere. */
static void check_guides(const exact_planes *got, const exact_planes *want) {
  double worst = 0.0;
  for (int y = 0; y < got->height; ++y)
    for (int x = 0; x < got->width; ++x) {
      double w = *exact_at(want, HBIL_SPLIT_W, x, y), off = 0.0;
      assert_true(*exact_at(got, HBIL_SPLIT_W, x, y) == w);
      for (int c = HBIL_SPLIT_NORMAL; c < HBIL_SPLIT_RED; ++c) {
        double d = *exact_at(got, c, x, y) - *exact_at(want, c, x, y);
        assert_true(isfinite(d));
        off += w > 0.0 ? d * d : 0.0;
      }
      worst = fmax(worst, sqrt(off));
    }
  check_at_most("normal", worst, NORMAL_LIMIT);
}

static void check_split(void (*prepare)(setup *), cl_uint vector_width) {
  exact_planes want = split_in(HBIL_STORAGE_FLOAT32, prepare, vector_width);
  exact_planes got = split_in(HBIL_STORAGE_PACKED, prepare, vector_width);
  assert_int_equal(got.count, want.count);
  check_guides(&got, &want);
  check_at_most(
      "radiance, losses",
      packed_losses(&got, &want, HBIL_SPLIT_RED, PACKED_RADIANCE_BITS, 0.0),
      PACKED_LOSS_LIMIT);
  planes_free(&want, &got);
}

/* A wall seen straight on, whose radiance is its emission. World-space
 * normals, so that it shares kernels with the scenes. */
static void start_wall(setup *s) {
  setup_init(s, WIDTH, HEIGHT);
  s->config.inputs.normal_space = HBIL_SPACE_WORLD;
  setup_fill(s, EXACT_DEPTH, 1.0f);
  setup_fill(s, EXACT_NORMAL + 2, -1.0f);
}

static void room(setup *s) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 1);
}

/* Normals all over the sphere, with the axes and the edges and middles of the
 * octahedron's faces among them. The view is so wide that some that face the
 * eye have a z above 0. Those that face away are turned back until they graze.
 */
static void all_directions(setup *s) {
  random_state r = {31};
  start_wall(s);
  setup_camera(s, 150.0);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_NORMAL + c][i] =
          i % 4 == 0 ? (float)((int)(3.0 * random_unit(&r)) - 1)
                     : (float)(random_unit(&r) - 0.5);
}

TEST(every_direction_survives) {
  exact_planes split = split_in(HBIL_STORAGE_FLOAT32, all_directions, 8);
  int behind = 0;
  for (int i = 0; i < 4; ++i)
    check_split(all_directions, widths[i]);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    behind +=
        *exact_at(&split, HBIL_SPLIT_NORMAL + 2, i % WIDTH, i / WIDTH) > 0;
  assert_true(behind > WIDTH * HEIGHT / 8);
  exact_planes_free(&split);
}

/* The test's own mapping loses no more than the kernels may. */
TEST(the_octahedral_map_loses_half_a_step) {
  random_state r = {5};
  for (int i = 0; i < 20000; ++i) {
    double n[3], back[3], off = 0.0;
    for (int c = 0; c < 3; ++c)
      n[c] = random_unit(&r) - 0.5;
    normalize(n);
    decode_normal(encode_normal(n), back);
    for (int c = 0; c < 3; ++c)
      off += (back[c] - n[c]) * (back[c] - n[c]);
    if (!(sqrt(off) <= NORMAL_LIMIT))
      fail_msg("%g %g %g is off by %g", n[0], n[1], n[2], sqrt(off));
  }
}

/* Light of every magnitude that a float has, beside zeros and beside each
 * other. */
static void any_light(setup *s) {
  const float odd[] = {0.0f,      1.0f,       1e-30f,    1e30f,    3.4e38f,
                       0x1p-118f, 0x1p-7f,    0x1.fep0f, 255.0f,   256.0f,
                       65504.0f,  65505.0f,   65519.0f,  65520.0f, 65024.0f,
                       64512.0f,  65536.0f,   0x1p-14f,  0x1p-15f, 0x1p-24f,
                       0x1p-25f,  0x1.8p-24f, 0x1p-20f,  0x1p-21f, 0x1.ff8p0f};
  const double count = sizeof(odd) / sizeof(*odd);
  random_state r = {71};
  start_wall(s);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    double scale = ldexp(1.0, (int)(236.0 * random_unit(&r)) - 117);
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_EMISSION + c][i] =
          random_unit(&r) < 0.2 ? odd[(int)(count * random_unit(&r))]
                                : (float)(scale * random_unit(&r));
  }
}

TEST(light_of_any_size_survives) {
  for (int i = 0; i < 4; ++i)
    check_split(any_light, widths[i]);
}

/* Denormal light becomes zero or the smallest normal number. */
static void hardly_any_light(setup *s) {
  start_wall(s);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_EMISSION + c][i] = ldexpf((float)(i % 8), -140 - i % 9);
}

TEST(denormal_light_becomes_zero) {
  exact_planes got = split_in(HBIL_STORAGE_PACKED, hardly_any_light, 8);
  check_at_most("denormals", largest_value(&got, HBIL_SPLIT_RED, 3), 0x1p-126);
  exact_planes_free(&got);
}

/* ------------------------------------------------------------------------ */
/* gather                                                                    */

/* SPLIT has radiance only for E_near; GATHERED has AO, E_near, bent normals. */
TEST(only_needed_words_are_stored) {
  for (int outputs = 1; outputs < 8; ++outputs) {
    const bool near_irradiance = outputs & 1, bent = outputs & 2;
    setup s;
    hbil_buffer split, light;
    room(&s);
    s.config.sampling.storage = HBIL_STORAGE_PACKED;
    s.config.outputs.near_irradiance.component =
        near_irradiance ? HBIL_FLOAT32 : HBIL_NONE;
    s.config.outputs.bent_normal.component = bent ? HBIL_FLOAT32 : HBIL_NONE;
    s.config.outputs.ao.component = outputs & 4 ? HBIL_FLOAT32 : HBIL_NONE;
    setup_start(&s);
    assert_success(&s, hbil_plan_buffer(s.plan, HBIL_STAGE_SPLIT, &split));
    assert_success(&s, hbil_plan_buffer(s.plan, HBIL_STAGE_GATHERED, &light));
    assert_int_equal(split.values, near_irradiance ? 3 : 2);
    assert_int_equal(light.values, bent ? 3 : near_irradiance ? 2 : 1);
    setup_free(&s);
  }
}
