/*
 * Layers in words: what each word may lose, and that nothing else is lost.
 */
#include "support.h"

#define WIDTH 45
#define HEIGHT 31

static const cl_uint widths[] = {1, 4, 8, 16};

/* Derived: half a step in u and in v moves a point of the octahedron by up to
 * sqrt(6)/2 steps within its face, whose middle, the nearest to the eye of all,
 * is 1/sqrt(3) away: sqrt(18)/2 steps of 1/32767 are 6.5e-5, and fp32 rounds.
 */
#define NORMAL_LIMIT 6.6e-5
/* Derived: what the fp32 search is off by (test_gather.c), and half a step of
 * 16 bits, or of halves next to 1. */
#define SEARCH_LIMIT 1e-5
#define SHARE_LIMIT (0.5 / 65535.0 + SEARCH_LIMIT)
#define WEIGHT_LIMIT SEARCH_LIMIT
#define HALF_SHARE_LIMIT (0x1p-12 + SEARCH_LIMIT)
/* Derived: one step of 8 bits, dithered. */
#define UNKNOWN_LIMIT (1.0 / 255.0 + SEARCH_LIMIT)

static double most_of(const exact_planes *planes, int first, int x, int y) {
  return fmax(*exact_at(planes, first, x, y),
              fmax(*exact_at(planes, first + 1, x, y),
                   *exact_at(planes, first + 2, x, y)));
}

/* How light is kept: as mantissas of so many bits with one exponent for all, or
 * as floats of 5 exponent bits and so many of mantissa in each channel. */
typedef struct light_word {
  int shared, mantissa[3];
} light_word;
static const light_word radiance_of[] = {
    [HBIL_STORAGE_PACKED] = {8, {0, 0, 0}},
    [HBIL_STORAGE_HALF] = {0, {10, 10, 10}},
    [HBIL_STORAGE_FLOAT11] = {0, {6, 6, 5}}};
static const light_word near_light_of[] = {
    [HBIL_STORAGE_PACKED] = {10, {0, 0, 0}},
    [HBIL_STORAGE_HALF] = {0, {10, 10, 10}},
    [HBIL_STORAGE_FLOAT11] = {10, {0, 0, 0}}};

/* Half a step of a small float; what lies above the largest becomes that. */
static double small_loss(double value, int mantissa) {
  const double largest = ldexp(2.0 - ldexp(1.0, -mantissa), 15);
  if (value >= largest)
    return value - largest;
  const int exponent = value > 0.0 ? (int)fmax(ilogb(value), -14.0) : -14;
  return ldexp(0.5, exponent - mantissa);
}

/* What rounding to the nearest may lose of channel c, where the largest channel
 * is `most`.  That one loses half a unit of its own, also where the others have
 * twice that unit since it is rounded up to the next power of two. */
static double loss_of(const light_word *word, double value, double most,
                      int c) {
  if (!word->shared)
    return small_loss(value, word->mantissa[c]);
  if (!(most > 0.0))
    return 0.0;
  const double own =
      ldexp(1.0, (int)fmax(ilogb(most) + 1 - word->shared, -126));
  return 0.5 * (value < most ? packed_unit(most, word->shared) : own);
}

/* How far light is off at most, in what its words may lose, beyond what it may
 * be off by before it becomes a word. */
static double losses(const exact_planes *got, const exact_planes *want,
                     int first, const light_word *word, double before) {
  double worst = 0.0;
  for (int y = 0; y < got->height; ++y)
    for (int x = 0; x < got->width; ++x) {
      double most = most_of(want, first, x, y);
      for (int c = 0; c < 3; ++c) {
        double value = *exact_at(want, first + c, x, y);
        double off = fabs(*exact_at(got, first + c, x, y) - value);
        if (!(off <= before)) /* no light out of nothing */
          worst = fmax(worst, isfinite(off) ? (off - before) /
                                                  loss_of(word, value, most, c)
                                            : INFINITY);
      }
    }
  return worst;
}

/* Derived: 1, and what fp32 rounds of a mantissa of 10 bits before it is
 * rounded to the nearest: 2^-14 of half a step. */
#define LOSS_LIMIT (1.0 + 1e-4)

/* ------------------------------------------------------------------------ */
/* split                                                                     */

static exact_planes split_in(hbil_storage storage, void (*prepare)(setup *),
                             cl_uint vector_width) {
  setup s;
  exact_planes out;
  prepare(&s);
  s.config.storage = storage;
  s.config.vector_width = vector_width;
  setup_start(&s);
  setup_run(&s, hbil_enqueue_split);
  out = stage_read(&s, HBIL_STAGE_SPLIT);
  setup_free(&s);
  return out;
}

/* Depth to the last bit; normals where there are surfaces, finite elsewhere. */
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

static void check_split(void (*prepare)(setup *), hbil_storage storage,
                        cl_uint vector_width) {
  exact_planes want = split_in(HBIL_STORAGE_FLOAT32, prepare, vector_width);
  exact_planes got = split_in(storage, prepare, vector_width);
  assert_int_equal(got.count, want.count);
  check_guides(&got, &want);
  check_at_most("radiance, losses",
                losses(&got, &want, HBIL_SPLIT_RED, &radiance_of[storage], 0.0),
                LOSS_LIMIT);
  exact_planes_free(&want);
  exact_planes_free(&got);
}

/* A wall seen straight on; emission alone is its radiance.  (World space, so
 * that it goes with the kernels that the scenes have already built.) */
static void start_wall(setup *s) {
  setup_init(s, WIDTH, HEIGHT);
  s->config.normal_space = HBIL_SPACE_WORLD;
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
    check_split(room, HBIL_STORAGE_PACKED, widths[i]);
    check_split(sky, HBIL_STORAGE_PACKED, widths[i]);
  }
}

/* All over the sphere, in a view so wide that some that face the eye have a z
 * above 0; those that don't face it are bent back until they graze it.  Among
 * them the axes, and the edges and the middles of the map's faces. */
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

static void every_direction_is_kept(void **state) {
  exact_planes split = split_in(HBIL_STORAGE_FLOAT32, all_directions, 8);
  int behind = 0;
  (void)state;
  for (int i = 0; i < 4; ++i)
    check_split(all_directions, HBIL_STORAGE_PACKED, widths[i]);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    behind +=
        *exact_at(&split, HBIL_SPLIT_NORMAL + 2, i % WIDTH, i / WIDTH) > 0;
  assert_true(behind > WIDTH * HEIGHT / 8);
  exact_planes_free(&split);
}

/* The mapping itself has no more to lose: the same as the kernel's limit. */
static void the_tests_own_map_is_one(void **state) {
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

/* Every magnitude that a float has, next to 0 and to each other; the ends of
 * the small floats, and ties between two of them. */
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

static void light_of_any_size_is_kept(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i)
    check_split(any_light, HBIL_STORAGE_PACKED, widths[i]);
}

static void small_floats_keep_light_to_half_a_step(void **state) {
  (void)state;
  check_split(any_light, HBIL_STORAGE_HALF, 8);
  check_split(any_light, HBIL_STORAGE_FLOAT11, 1); /* as on GPUs */
}

/* IEEE's own numbers, and the way there and back of all there are. */
static void the_tests_own_floats_are_ieees(void **state) {
  static const int mantissas[] = {10, 6, 5};
  (void)state;
  assert_true(decode_small(0x7bff, 10) == 65504.0);
  assert_true(decode_small(0x3c00, 10) == 1.0);
  assert_true(decode_small(0x3555, 10) == 1365.0 / 4096.0);
  assert_true(decode_small(0x0400, 10) == 0x1p-14);
  assert_true(decode_small(0x0001, 10) == 0x1p-24);
  assert_true(decode_small(0x7bf, 6) == 65024.0);
  assert_true(decode_small(0x001, 6) == 0x1p-20);
  assert_true(decode_small(0x3df, 5) == 64512.0);
  assert_true(encode_small(1e30, 10) == 0x7bff);
  assert_true(encode_small(-1.0, 10) == 0);
  for (int m = 0; m < 3; ++m)
    for (uint32_t bits = 0; bits < 31u << mantissas[m]; ++bits)
      assert_true(
          encode_small(decode_small(bits, mantissas[m]), mantissas[m]) == bits);
}

/* Numbers below a float's normal ones are none, or the least one. */
static void hardly_any_light(setup *s) {
  start_wall(s);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_EMISSION + c][i] = ldexpf((float)(i % 8), -140 - i % 9);
}

static void hardly_any_light_is_none(void **state) {
  exact_planes got = split_in(HBIL_STORAGE_PACKED, hardly_any_light, 8);
  (void)state;
  check_at_most("denormals", largest_value(&got, HBIL_SPLIT_RED, 3), 0x1p-126);
  exact_planes_free(&got);
}

/* ------------------------------------------------------------------------ */
/* gather                                                                    */

static exact_planes gathered(setup *s) {
  setup_run(s, hbil_enqueue_split);
  setup_run(s, hbil_enqueue_gather);
  return stage_read(s, HBIL_STAGE_GATHERED);
}

/* Few slices make bent normals longer than 1, of which a word of 11, 11 and 10
 * bits keeps no more than the direction, and halves as many digits. */
static double bent_off(hbil_storage storage, const exact_planes *got,
                       const exact_planes *want, int x, int y) {
  double g[3], w[3], most = 0.0, off = 0.0;
  for (int c = 0; c < 3; ++c) {
    g[c] = *exact_at(got, HBIL_LIGHT_BENT + c, x, y);
    w[c] = *exact_at(want, HBIL_LIGHT_BENT + c, x, y);
    most = fmax(most, fabs(w[c]));
  }
  if (most > 1.0 && storage != HBIL_STORAGE_HALF) {
    normalize(g);
    normalize(w);
  }
  for (int c = 0; c < 3; ++c)
    off += (g[c] - w[c]) * (g[c] - w[c]);
  return sqrt(off) / (storage == HBIL_STORAGE_HALF ? fmax(most, 1.0) : 1.0);
}

static double largest_bent_off(hbil_storage storage, const exact_planes *got,
                               const exact_planes *want) {
  double worst = 0.0;
  for (int y = 0; y < got->height; ++y)
    for (int x = 0; x < got->width; ++x)
      worst = fmax(worst, bent_off(storage, got, want, x, y));
  return worst;
}

/* Derived: one unit of 1/1023 in x and in y, one of 1/511 in z. */
#define BENT_LIMIT 2.41e-3
/* Derived: half a step in x, y and z, each at most 2^-11 of the largest. */
#define HALF_BENT_LIMIT (1.7321 * 0x1p-11 + SEARCH_LIMIT)

static void check_light(hbil_storage storage, const exact_planes *got,
                        const exact_planes *want) {
  const bool half = storage == HBIL_STORAGE_HALF;
  double before = SEARCH_LIMIT * largest_value(want, HBIL_LIGHT_RED, 3);
  check_at_most("AO", largest_error(got, want, HBIL_LIGHT_AO, 1),
                half ? HALF_SHARE_LIMIT : SHARE_LIMIT);
  if (got->count > HBIL_LIGHT_UNKNOWN)
    check_at_most("unknown", largest_error(got, want, HBIL_LIGHT_UNKNOWN, 1),
                  half ? HALF_SHARE_LIMIT : UNKNOWN_LIMIT);
  if (got->count > HBIL_LIGHT_WEIGHT) /* a float in all of them */
    check_at_most("weight", relative_rmse(got, want, HBIL_LIGHT_WEIGHT, 1),
                  WEIGHT_LIMIT);
  check_at_most(
      "E_near, losses",
      losses(got, want, HBIL_LIGHT_RED, &near_light_of[storage], before),
      LOSS_LIMIT);
  check_at_most("bent", largest_bent_off(storage, got, want),
                half ? HALF_BENT_LIMIT : BENT_LIMIT);
}

/* What the search makes of the very words that it reads. */
static void compare_gather(setup *s) {
  exact_planes got = gathered(s), split = stage_read(s, HBIL_STAGE_SPLIT);
  exact_planes want = checked_planes(split.width, split.height, got.count);
  checked_gather(&s->job, &split, &want);
  check_light(s->config.storage, &got, &want);
  exact_planes_free(&got);
  exact_planes_free(&split);
  exact_planes_free(&want);
}

static void check_gather(setup *s, hbil_storage storage) {
  s->config.storage = storage;
  setup_start(s);
  compare_gather(s);
  setup_free(s);
}

typedef struct settings {
  cl_uint slices, samples;
  hbil_sample_grid lattice;
  float radius, relative_thickness, facing[2];
  hbil_back_facing_fallback refused;
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

static void check_setting(size_t i, hbil_storage storage) {
  setup s;
  const settings *t = table + i;
  setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, 64, 37, 0);
  s.config.slices = t->slices;
  s.config.steps_per_side = t->samples;
  s.config.sample_grid = t->lattice;
  s.config.radius = t->radius;
  s.config.relative_thickness = t->relative_thickness;
  memcpy(s.config.facing_fade, t->facing, sizeof(t->facing));
  s.config.back_facing_fallback = t->refused;
  s.frame.frame_index = (cl_uint)i;
  check_gather(&s, storage);
}

static void every_setting_matches(void **state) {
  (void)state;
  for (size_t i = 0; i < sizeof(table) / sizeof(*table); ++i)
    check_setting(i, HBIL_STORAGE_PACKED);
}

/* The one that has unknown light. */
static void small_floats_match(void **state) {
  (void)state;
  check_setting(2, HBIL_STORAGE_HALF);
  check_setting(2, HBIL_STORAGE_FLOAT11);
}

/* So little light that its halves are denormal: the gather, which is built with
 * fast arithmetic, must not take them for 0. */
static void hardly_any_light_is_gathered(void **state) {
  setup s;
  exact_planes split;
  double most;
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.config.storage = HBIL_STORAGE_HALF;
  s.config.direct_scale *= 3e-5f;
  for (int c = 0; c < 3; ++c)
    setup_fill(&s, EXACT_EMISSION + c, 0.0f);
  setup_start(&s);
  compare_gather(&s);
  split = stage_read(&s, HBIL_STAGE_SPLIT);
  most = largest_value(&split, HBIL_SPLIT_RED, 3);
  if (!(most > 0x1p-20 && most < 0x1p-14))
    fail_msg("radiance of %g at most", most);
  exact_planes_free(&split);
  setup_free(&s);
}

/* Light that no small float holds: the largest there is, and no infinity. */
static void too_much_light_is_the_most_there_is(void **state) {
  setup s;
  exact_planes split, light;
  (void)state;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.config.storage = HBIL_STORAGE_HALF;
  s.config.direct_scale *= 1e20f;
  setup_start(&s);
  light = gathered(&s);
  split = stage_read(&s, HBIL_STAGE_SPLIT);
  assert_true(largest_value(&split, HBIL_SPLIT_RED, 3) == 65504.0);
  assert_true(largest_value(&light, HBIL_LIGHT_RED, 3) == 65504.0);
  exact_planes_free(&split);
  exact_planes_free(&light);
  setup_free(&s);
}

static void every_vector_width_matches(void **state) {
  (void)state;
  for (int i = 0; i < 8; ++i) {
    setup s;
    setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
    s.config.vector_width = widths[i / 2];
    s.config.back_facing_fallback =
        i & 1 ? HBIL_FALLBACK_FRAME_MEAN : HBIL_FALLBACK_LAST_ACCEPTED;
    check_gather(&s, HBIL_STORAGE_PACKED);
  }
}

/* One slice in a wide view weighs some directions thrice. */
static void long_bent_normals_keep_their_direction(void **state) {
  (void)state;
  for (cl_uint slices = 1; slices < 3; ++slices) {
    setup s;
    setup_scene(&s, SCENE_ROOM, 64, 37, 0);
    setup_load_view(&s, SCENE_ROOM, 120.0, 0);
    s.config.slices = slices;
    check_gather(&s, HBIL_STORAGE_PACKED);
    if (slices == 1) {
      setup_scene(&s, SCENE_ROOM, 64, 37, 0);
      setup_load_view(&s, SCENE_ROOM, 120.0, 0);
      s.config.slices = slices;
      check_gather(&s, HBIL_STORAGE_HALF);
    }
  }
}

static exact_planes packed_room(void) {
  setup s;
  exact_planes out;
  room(&s);
  s.config.storage = HBIL_STORAGE_PACKED;
  setup_start(&s);
  out = gathered(&s);
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

static void check_words(hbil_storage storage, int outputs, word_counts want) {
  setup s;
  hbil_buffer split, light;
  bool near_irradiance = outputs & 1, bent = outputs & 2;
  room(&s);
  s.config.storage = storage;
  s.config.near_irradiance.component =
      near_irradiance ? HBIL_FLOAT32 : HBIL_NONE;
  s.config.bent_normal.component = bent ? HBIL_FLOAT32 : HBIL_NONE;
  s.config.ao.component = outputs & 4 ? HBIL_FLOAT32 : HBIL_NONE;
  setup_start(&s);
  assert_success(&s, hbil_plan_buffer(s.plan, HBIL_STAGE_SPLIT, &split));
  assert_success(&s, hbil_plan_buffer(s.plan, HBIL_STAGE_GATHERED, &light));
  assert_int_equal(split.values, near_irradiance ? want.split : want.guides);
  assert_int_equal(light.values, bent              ? want.bent
                                 : near_irradiance ? want.near_irradiance
                                                   : want.ao);
  setup_free(&s);
}

static void only_needed_words_are_kept(void **state) {
  (void)state;
  for (int outputs = 1; outputs < 8; ++outputs)
    check_words(HBIL_STORAGE_PACKED, outputs, (word_counts){2, 3, 1, 2, 3});
  check_words(HBIL_STORAGE_HALF, 1, (word_counts){2, 4, 1, 3, 4});
  check_words(HBIL_STORAGE_HALF, 4, (word_counts){2, 4, 1, 3, 4});
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

static void check_recompose(hbil_storage storage, scene_kind kind, bool raw,
                            hbil_back_facing_fallback refused,
                            cl_uint vector_width) {
  setup s;
  exact_planes split, light, got,
      want = checked_planes(WIDTH, HEIGHT, HBIL_LIGHT_PLANES);
  setup_scene(&s, kind, WIDTH, HEIGHT, 0);
  s.config.storage = storage;
  s.config.unfiltered = raw;
  s.config.back_facing_fallback = refused;
  s.config.vector_width = vector_width;
  setup_start(&s);
  light = gathered(&s); /* and what the frame sends on average */
  exact_planes_free(&light);
  plant_light(&s);
  light = stage_read(&s, HBIL_STAGE_GATHERED);
  split = stage_read(&s, HBIL_STAGE_SPLIT);
  exact_estimate_frame(&s.job, &split);
  exact_recompose(&s.job, &split, &light, &want);
  setup_run(&s, hbil_enqueue_recompose);
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
    check_recompose(HBIL_STORAGE_PACKED, SCENE_ROOM, false,
                    HBIL_FALLBACK_LAST_ACCEPTED, widths[i]);
    check_recompose(HBIL_STORAGE_PACKED, SCENE_SKY, i & 1,
                    HBIL_FALLBACK_FRAME_MEAN, widths[i]);
  }
  check_recompose(HBIL_STORAGE_HALF, SCENE_SKY, false, HBIL_FALLBACK_FRAME_MEAN,
                  8);
}

/* ------------------------------------------------------------------------ */
/* Whole frames                                                              */

/* Root of the mean squared difference over the mean. */
static double rmse_over_mean(const exact_planes *got, const exact_planes *want,
                             image_id id) {
  size_t plane = (size_t)want->width * (size_t)want->height;
  size_t total = plane * (size_t)image_channels(id);
  size_t start = plane * (size_t)image_first(id);
  double off = 0.0, sum = 0.0;
  for (size_t i = start; i < start + total; ++i) {
    double d = got->values[i] - want->values[i];
    off += d * d;
    sum += fabs(want->values[i]);
  }
  if (!isfinite(off))
    return INFINITY;
  return sqrt(off * (double)total) / sum;
}

typedef struct promise {
  image_id id;
  double limit[HBIL_STORAGE_FLOAT11 + 1];
} promise;

/* What the storages may change, in the enum's order; measured on these frames
 * without noise, worst of all: AO 2.7e-5, halves 5.9e-5; E_near 2.1e-3, halves
 * 2.1e-4, float11 4.6e-3.  The others follow, but for the bent normal, which
 * has no direction left in a word where nothing is open. */
static const promise promises[] = {{PLANE_AO, {1e-4, 0.0, 1e-4, 1e-4}},
                                   {PLANE_NEAR, {2.2e-3, 0.0, 3e-4, 5e-3}},
                                   {PLANE_FAR, {2.2e-3, 0.0, 3e-4, 5e-3}},
                                   {PLANE_CONE, {1e-4, 0.0, 1e-4, 1e-4}},
                                   {PLANE_INDIRECT, {2.2e-3, 0.0, 3e-4, 5e-3}},
                                   {PLANE_BEAUTY, {2.2e-3, 0.0, 3e-4, 5e-3}}};
#define PROMISES (sizeof(promises) / sizeof(*promises))

/* The worst of each promise so far. */
static void compare_frames(const exact_planes *got, const exact_planes *want,
                           double worst[PROMISES]) {
  for (size_t i = 0; i < PROMISES; ++i)
    worst[i] = fmax(worst[i], rmse_over_mean(got, want, promises[i].id));
}

static void start_frames(setup *s, scene_kind kind, bool from_the_frame,
                         hbil_storage storage) {
  setup_scene(s, kind, 160, 90, 0);
  setup_all_outputs(s);
  s->config.storage = storage;
  s->config.far_field = HBIL_FAR_CONSTANT;
  for (int c = 0; c < 3 && !from_the_frame; ++c)
    s->frame.environment[0][c] = 0.5f + (float)c;
  if (from_the_frame) {
    s->config.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
    s->config.far_field = HBIL_FAR_FRAME;
  }
  setup_start(s);
}

static exact_planes frame(setup *s, scene_kind kind, uint32_t index) {
  setup_load_scene(s, kind, index);
  s->frame.frame_index = index;
  setup_upload(s);
  setup_run(s, hbil_enqueue_frame);
  return outputs_read(s);
}

/* The worst of three frames, against FLOAT32 and against the reference. */
static void check_frames(scene_kind kind, bool from_the_frame,
                         hbil_storage storage) {
  setup plain, packed;
  exact_state reference;
  double worst[PROMISES] = {0.0};
  start_frames(&plain, kind, from_the_frame, HBIL_STORAGE_FLOAT32);
  start_frames(&packed, kind, from_the_frame, storage);
  checked_state(&reference, 160, 90);
  for (uint32_t i = 0; i < 3; ++i) {
    exact_planes want = frame(&plain, kind, i), got = frame(&packed, kind, i);
    checked_run_frame(&reference, &plain.job);
    compare_frames(&got, &want, worst);
    compare_frames(&got, &reference.out, worst);
    exact_planes_free(&want);
    exact_planes_free(&got);
  }
  exact_state_free(&reference);
  setup_free(&plain);
  setup_free(&packed);
  for (size_t i = 0; i < PROMISES; ++i)
    check_at_most(image_name(promises[i].id), worst[i],
                  promises[i].limit[storage]);
}

static void frames_keep_the_promise(void **state) {
  (void)state;
  check_frames(SCENE_ROOM, false, HBIL_STORAGE_PACKED);
}

static void frames_under_the_sky_keep_the_promise(void **state) {
  (void)state;
  check_frames(SCENE_SKY, false, HBIL_STORAGE_PACKED);
}

static void light_from_the_frame_keeps_the_promise(void **state) {
  (void)state;
  for (hbil_storage storage = HBIL_STORAGE_PACKED;
       storage <= HBIL_STORAGE_FLOAT11; ++storage)
    if (storage != HBIL_STORAGE_FLOAT32) {
      check_frames(SCENE_ROOM, true, storage);
      check_frames(SCENE_SKY, true, storage);
    }
}

/* ------------------------------------------------------------------------ */
/* A bare plane                                                              */

/* Through (0,0,3); what lies behind the eye is sky. */
static void set_plane(setup *s, const double n[3]) {
  const hbil_camera *camera = &s->frame.camera;
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    double ray[3] = {(i % WIDTH + 0.5 - camera->cx) / camera->fx,
                     (i / WIDTH + 0.5 - camera->cy) / camera->fy, 1.0};
    double z = 3.0 * n[2] / dot(n, ray);
    /* half floats end at 65504 */
    s->input[EXACT_DEPTH][i] = dot(n, ray) < 0.0 && z < 6e4 ? (float)z : 0.0f;
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_NORMAL + c][i] = (float)n[c];
  }
}

/* Largest deviations from a bare plane. */
typedef struct deviation {
  double ao, light, bent;
} deviation;

static void compare_pixel(const exact_planes *got, const double n[3], int x,
                          int y, deviation *worst) {
  double off = 0.0;
  for (int c = 0; c < 3; ++c)
    off += pow(*exact_at(got, HBIL_LIGHT_BENT + c, x, y) - n[c], 2.0);
  worst->ao = fmax(worst->ao, 1.0 - *exact_at(got, HBIL_LIGHT_AO, x, y));
  worst->light = fmax(worst->light, most_of(got, HBIL_LIGHT_RED, x, y));
  worst->bent = fmax(worst->bent, sqrt(off));
}

static void add_plane(setup *s, double tilt, double azimuth, deviation *worst) {
  const double n[3] = {sin(tilt) * cos(azimuth), sin(tilt) * sin(azimuth),
                       -cos(tilt)};
  exact_planes got;
  set_plane(s, n);
  setup_upload(s);
  got = gathered(s);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    if (s->input[EXACT_DEPTH][i] > 0.0f)
      compare_pixel(&got, n, i % WIDTH, i / WIDTH, worst);
  exact_planes_free(&got);
}

static void start_plane(setup *s, double fov, hbil_component depth) {
  setup_init(s, WIDTH, HEIGHT);
  setup_camera(s, fov);
  s->config.normal_space = HBIL_SPACE_WORLD;
  s->config.storage = HBIL_STORAGE_PACKED;
  s->config.depth.component = depth;
  for (int c = 0; c < 3; ++c)
    setup_fill(s, EXACT_EMISSION + c, 1.0f);
  setup_start(s);
}

/* AO 1 to the last digit of its 16 bits, and the E_near and the bent normal of
 * test_plane.c, the latter as its word has it. */
static void check_planes(double fov, hbil_component depth) {
  const int tilts[] = {0, 30, 60, 80, 85};
  deviation worst = {0.0, 0.0, 0.0};
  setup s;
  start_plane(&s, fov, depth);
  for (int i = 0; i < 15; ++i)
    add_plane(&s, tilts[i % 5] * PI / 180.0, 0.4 + 1.3 * (i / 5), &worst);
  setup_free(&s);
  check_at_most("1 - AO", worst.ao, SHARE_LIMIT);
  check_at_most("E_near", worst.light, 1e-5);
  check_at_most("bent", worst.bent, BENT_LIMIT + NORMAL_LIMIT);
}

static void planes_are_bare(void **state) {
  (void)state;
  check_planes(60.0, HBIL_FLOAT32);
  check_planes(120.0, HBIL_FLOAT32);
}

static void planes_are_bare_with_half_float_depth(void **state) {
  (void)state;
  check_planes(60.0, HBIL_FLOAT16);
  check_planes(120.0, HBIL_FLOAT16);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(scenes_lose_no_more_than_their_words),
      cmocka_unit_test(every_direction_is_kept),
      cmocka_unit_test(the_tests_own_map_is_one),
      cmocka_unit_test(light_of_any_size_is_kept),
      cmocka_unit_test(small_floats_keep_light_to_half_a_step),
      cmocka_unit_test(the_tests_own_floats_are_ieees),
      cmocka_unit_test(hardly_any_light_is_none),
      cmocka_unit_test(every_setting_matches),
      cmocka_unit_test(every_vector_width_matches),
      cmocka_unit_test(small_floats_match),
      cmocka_unit_test(hardly_any_light_is_gathered),
      cmocka_unit_test(too_much_light_is_the_most_there_is),
      cmocka_unit_test(long_bent_normals_keep_their_direction),
      cmocka_unit_test(every_run_gives_the_same_bits),
      cmocka_unit_test(only_needed_words_are_kept),
      cmocka_unit_test(the_filter_matches),
      cmocka_unit_test(frames_keep_the_promise),
      cmocka_unit_test(frames_under_the_sky_keep_the_promise),
      cmocka_unit_test(light_from_the_frame_keeps_the_promise),
      cmocka_unit_test(planes_are_bare),
      cmocka_unit_test(planes_are_bare_with_half_float_depth)};
  return RUN_WITH_GPU(tests);
}
