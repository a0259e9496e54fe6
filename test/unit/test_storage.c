/*
 * Packed storage: what the words of SPLIT and GATHERED may lose, and that the
 * passes lose nothing else.
 */
#include "test/support/packing.h"
#include "test/support/random.h"
#include "test/support/stages.h"
#include "test/support/vectors.h"

#define WIDTH 45
#define HEIGHT 31

static const cl_uint widths[] = {1, 4, 8, 16};

/* Bits of the mantissas of packed E_near. */
enum { NEAR_BITS = 10 };

/* Derived: half a step in u and in v moves a point of the octahedron by up to
 * sqrt(6)/2 steps within its face.  The middle of a face is nearest to the
 * origin, 1/sqrt(3): there this is sqrt(18)/2 steps of 1/32767, 6.5e-5.  fp32
 * adds roundings. */
#define NORMAL_LIMIT 6.6e-5
/* Derived: the error of the fp32 search (test_gather.c), and half a step of 16
 * bits. */
#define SEARCH_LIMIT 1e-5
#define SHARE_LIMIT (0.5 / 65535.0 + SEARCH_LIMIT)
#define WEIGHT_LIMIT SEARCH_LIMIT
/* Derived: one step of 8 bits, dithered. */
#define UNKNOWN_LIMIT (1.0 / 255.0 + SEARCH_LIMIT)

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
  exact_planes_free(&want);
  exact_planes_free(&got);
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

static void sky(setup *s) {
  setup_scene(s, SCENE_SKY, WIDTH, HEIGHT, 1);
}

static void scenes_lose_no_more_than_their_words(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i) {
    check_split(room, widths[i]);
    check_split(sky, widths[i]);
  }
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

static void every_direction_survives(void **state) {
  exact_planes split = split_in(HBIL_STORAGE_FLOAT32, all_directions, 8);
  int behind = 0;
  (void)state;
  for (int i = 0; i < 4; ++i)
    check_split(all_directions, widths[i]);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    behind +=
        *exact_at(&split, HBIL_SPLIT_NORMAL + 2, i % WIDTH, i / WIDTH) > 0;
  assert_true(behind > WIDTH * HEIGHT / 8);
  exact_planes_free(&split);
}

/* The test's own mapping loses no more than the kernels may. */
static void the_octahedral_map_loses_half_a_step(void **state) {
  random_state r = {5};
  (void)state;
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

static void light_of_any_size_survives(void **state) {
  (void)state;
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

static void denormal_light_becomes_zero(void **state) {
  exact_planes got = split_in(HBIL_STORAGE_PACKED, hardly_any_light, 8);
  (void)state;
  check_at_most("denormals", largest_value(&got, HBIL_SPLIT_RED, 3), 0x1p-126);
  exact_planes_free(&got);
}

/* ------------------------------------------------------------------------ */
/* gather                                                                    */

/* Few slices make bent normals longer than 1.  Of such a one the word stores
 * the direction alone. */
static double bent_off(const exact_planes *got, const exact_planes *want, int x,
                       int y) {
  double g[3], w[3], most = 0.0, off = 0.0;
  for (int c = 0; c < 3; ++c) {
    g[c] = *exact_at(got, HBIL_LIGHT_BENT + c, x, y);
    w[c] = *exact_at(want, HBIL_LIGHT_BENT + c, x, y);
    most = fmax(most, fabs(w[c]));
  }
  if (most > 1.0) {
    normalize(g);
    normalize(w);
  }
  for (int c = 0; c < 3; ++c)
    off += (g[c] - w[c]) * (g[c] - w[c]);
  return sqrt(off);
}

static double largest_bent_off(const exact_planes *got,
                               const exact_planes *want) {
  double worst = 0.0;
  for (int y = 0; y < got->height; ++y)
    for (int x = 0; x < got->width; ++x)
      worst = fmax(worst, bent_off(got, want, x, y));
  return worst;
}

/* Derived: one unit of 1/1023 in x and in y, one of 1/511 in z. */
#define BENT_LIMIT 2.41e-3
static void check_light(const exact_planes *got, const exact_planes *want) {
  double before = SEARCH_LIMIT * largest_value(want, HBIL_LIGHT_RED, 3);
  check_at_most("AO", largest_error(got, want, HBIL_LIGHT_AO, 1), SHARE_LIMIT);
  if (got->count > HBIL_LIGHT_UNKNOWN)
    check_at_most("unknown", largest_error(got, want, HBIL_LIGHT_UNKNOWN, 1),
                  UNKNOWN_LIMIT);
  if (got->count > HBIL_LIGHT_WEIGHT) /* stored as a float */
    check_at_most("weight", relative_rmse(got, want, HBIL_LIGHT_WEIGHT, 1),
                  WEIGHT_LIMIT);
  check_at_most("E_near, losses",
                packed_losses(got, want, HBIL_LIGHT_RED, NEAR_BITS, before),
                PACKED_LOSS_LIMIT);
  check_at_most("bent", largest_bent_off(got, want), BENT_LIMIT);
}

/* The gather on the words that split wrote, against the exact gather on the
 * same values. */
static void check_gather(setup *s) {
  s->config.sampling.storage = HBIL_STORAGE_PACKED;
  setup_start(s);
  exact_planes got = stage_gathered(s), split = stage_read(s, HBIL_STAGE_SPLIT);
  exact_planes want = checked_planes(split.width, split.height, got.count);
  checked_gather(&s->job, &split, &want);
  check_light(&got, &want);
  exact_planes_free(&got);
  exact_planes_free(&split);
  exact_planes_free(&want);
  setup_free(s);
}

typedef struct settings {
  cl_uint slices, samples;
  hbil_sample_grid grid;
  float radius, relative_thickness, facing[2];
  hbil_back_facing_fallback fallback;
} settings;

static const settings table[] = {{2,
                                  8,
                                  HBIL_GRID_FULL_RESOLUTION,
                                  INFINITY,
                                  INFINITY,
                                  {-0.1f, 0.0f},
                                  HBIL_FALLBACK_LAST_ACCEPTED},
                                 {1,
                                  8,
                                  HBIL_GRID_SAME_LAYER,
                                  1.0f,
                                  INFINITY,
                                  {-0.1f, 0.0f},
                                  HBIL_FALLBACK_BLACK},
                                 {2,
                                  16,
                                  HBIL_GRID_FULL_RESOLUTION,
                                  0.5f,
                                  0.1f,
                                  {-0.5f, 0.5f},
                                  HBIL_FALLBACK_FRAME_MEAN},
                                 {3,
                                  5,
                                  HBIL_GRID_SAME_LAYER,
                                  INFINITY,
                                  0.3f,
                                  {0.2f, 0.2f},
                                  HBIL_FALLBACK_LAST_ACCEPTED},
                                 {4,
                                  4,
                                  HBIL_GRID_FULL_RESOLUTION,
                                  INFINITY,
                                  INFINITY,
                                  {-1.0f, -1.0f},
                                  HBIL_FALLBACK_BLACK},
                                 {1,
                                  16,
                                  HBIL_GRID_FULL_RESOLUTION,
                                  2.0f,
                                  INFINITY,
                                  {0.0f, 1.0f},
                                  HBIL_FALLBACK_FRAME_MEAN}};

static void check_setting(size_t i) {
  setup s;
  const settings *t = table + i;
  setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, 61, 37, 0);
  s.config.sampling.slices = t->slices;
  s.config.sampling.steps_per_side = t->samples;
  s.config.sampling.sample_grid = t->grid;
  s.config.model.radius = t->radius;
  s.config.model.relative_thickness = t->relative_thickness;
  memcpy(s.config.model.facing_fade, t->facing, sizeof(t->facing));
  s.config.model.back_facing_fallback = t->fallback;
  s.frame.frame_index = (cl_uint)i;
  check_gather(&s);
}

static void every_setting_matches(void **state) {
  (void)state;
  for (size_t i = 0; i < sizeof(table) / sizeof(*table); ++i)
    check_setting(i);
}

static void every_vector_width_matches(void **state) {
  (void)state;
  for (int i = 0; i < 8; ++i) {
    setup s;
    setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
    s.config.execution.vector_width = widths[i / 2];
    s.config.model.back_facing_fallback =
        i & 1 ? HBIL_FALLBACK_FRAME_MEAN : HBIL_FALLBACK_LAST_ACCEPTED;
    /* the split of plans with all passes, which many tests have */
    s.config.sampling.slices = i & 1 ? 1 : 2;
    check_gather(&s);
  }
}

/* In a wide view a single slice weighs some directions three times. */
static void long_bent_normals_have_their_direction(void **state) {
  (void)state;
  for (cl_uint slices = 1; slices < 3; ++slices) {
    setup s;
    setup_scene(&s, SCENE_ROOM, 61, 37, 0);
    setup_load_view(&s, SCENE_ROOM, 120.0, 0);
    s.config.sampling.slices = slices;
    check_gather(&s);
  }
}

static exact_planes packed_room(void) {
  setup s;
  exact_planes out;
  room(&s);
  s.config.sampling.storage = HBIL_STORAGE_PACKED;
  setup_start(&s);
  out = stage_gathered(&s);
  setup_free(&s);
  return out;
}

static void every_run_gives_the_same_bits(void **state) {
  exact_planes first = packed_room(), again = packed_room();
  (void)state;
  assert_int_equal(count_different(&again, &first), 0);
  exact_planes_free(&first);
  exact_planes_free(&again);
}

/* Words of SPLIT without radiance and with it; of GATHERED for AO, for E_near,
 * for bent normals. */
typedef struct word_counts {
  cl_uint guides, split, ao, near_irradiance, bent;
} word_counts;

static void check_words(int outputs, word_counts want) {
  setup s;
  hbil_buffer split, light;
  bool near_irradiance = outputs & 1, bent = outputs & 2;
  room(&s);
  s.config.sampling.storage = HBIL_STORAGE_PACKED;
  s.config.outputs.near_irradiance.component =
      near_irradiance ? HBIL_FLOAT32 : HBIL_NONE;
  s.config.outputs.bent_normal.component = bent ? HBIL_FLOAT32 : HBIL_NONE;
  s.config.outputs.ao.component = outputs & 4 ? HBIL_FLOAT32 : HBIL_NONE;
  setup_start(&s);
  assert_success(&s, hbil_plan_buffer(s.plan, HBIL_STAGE_SPLIT, &split));
  assert_success(&s, hbil_plan_buffer(s.plan, HBIL_STAGE_GATHERED, &light));
  assert_int_equal(split.values, near_irradiance ? want.split : want.guides);
  assert_int_equal(light.values, bent              ? want.bent
                                 : near_irradiance ? want.near_irradiance
                                                   : want.ao);
  setup_free(&s);
}

static void only_needed_words_are_stored(void **state) {
  (void)state;
  for (int outputs = 1; outputs < 8; ++outputs)
    check_words(outputs, (word_counts){2, 3, 1, 2, 3});
}

/* ------------------------------------------------------------------------ */
/* recompose                                                                 */

/* Random light; the sky is open and dark, as the gather leaves it. */
static void plant_light(setup *s) {
  random_state r = {17};
  int pixels = WIDTH * HEIGHT;
  exact_planes light = checked_planes(WIDTH, HEIGHT, HBIL_GATHERED_PLANES);
  for (int i = 0; i < pixels * light.count; ++i) {
    int plane = i / pixels;
    bool bent = plane >= HBIL_LIGHT_BENT && plane < HBIL_LIGHT_UNKNOWN;
    light.values[i] = random_unit(&r) - (bent ? 0.5 : 0.0);
    if (plane == HBIL_LIGHT_UNKNOWN) /* of what is not open */
      light.values[i] *= 1.0 - light.values[i % pixels];
    if (!(s->input[EXACT_DEPTH][i % pixels] > 0.0f))
      light.values[i] = plane == HBIL_LIGHT_AO;
  }
  stage_write(s, HBIL_STAGE_GATHERED, &light);
  exact_planes_free(&light);
}

static void check_recompose(scene_kind kind, bool unfiltered,
                            hbil_back_facing_fallback fallback,
                            cl_uint vector_width) {
  setup s;
  exact_planes split, light, got,
      want = checked_planes(WIDTH, HEIGHT, HBIL_LIGHT_PLANES);
  setup_scene(&s, kind, WIDTH, HEIGHT, 0);
  s.config.sampling.storage = HBIL_STORAGE_PACKED;
  s.config.sampling.unfiltered = unfiltered;
  s.config.model.back_facing_fallback = fallback;
  if (fallback == HBIL_FALLBACK_FRAME_MEAN) { /* the kernels of test_unknown */
    s.config.sampling.slices = 1;
    s.config.outputs.unknown = one_float;
  }
  s.config.execution.vector_width = vector_width;
  setup_start(&s);
  light = stage_gathered(&s); /* and what the frame sends on average */
  split = stage_read(&s, HBIL_STAGE_SPLIT);
  exact_estimate_frame(&s.job, &split, &light);
  exact_planes_free(&light);
  plant_light(&s);
  light = stage_read(&s, HBIL_STAGE_GATHERED);
  exact_recompose(&s.job, &split, &light, &want);
  setup_run(&s, enqueue_recompose);
  got = stage_read(&s, HBIL_STAGE_RESOLVED);
  check_at_most("AO", largest_error(&got, &want, 0, 1), 1e-5);
  check_at_most("E_near", relative_rmse(&got, &want, HBIL_LIGHT_RED, 3), 1e-5);
  check_at_most("bent", relative_rmse(&got, &want, HBIL_LIGHT_BENT, 3), 1e-5);
  exact_planes_free(&split);
  exact_planes_free(&light);
  exact_planes_free(&got);
  exact_planes_free(&want);
  setup_free(&s);
}

static void the_filter_matches(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i) {
    check_recompose(SCENE_ROOM, false, HBIL_FALLBACK_LAST_ACCEPTED, widths[i]);
    check_recompose(SCENE_SKY, i & 1, HBIL_FALLBACK_FRAME_MEAN, widths[i]);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(scenes_lose_no_more_than_their_words),
      cmocka_unit_test(every_direction_survives),
      cmocka_unit_test(the_octahedral_map_loses_half_a_step),
      cmocka_unit_test(light_of_any_size_survives),
      cmocka_unit_test(denormal_light_becomes_zero),
      cmocka_unit_test(every_setting_matches),
      cmocka_unit_test(every_vector_width_matches),
      cmocka_unit_test(long_bent_normals_have_their_direction),
      cmocka_unit_test(every_run_gives_the_same_bits),
      cmocka_unit_test(only_needed_words_are_stored),
      cmocka_unit_test(the_filter_matches),
  };
  return RUN_WITH_DEVICE(tests);
}
