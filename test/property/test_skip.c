/*
 * Skips change no bit: frames are the same with and without them, also when a
 * single pixel decides. Where nothing speaks against it, the work is skipped
 * indeed.
 *
 * Every kernel that is compiled takes seconds, and skips are build defines. So
 * plans of many kinds are compared with plans that skip nothing, which several
 * tests share, and plans of the first kinds with those that lack one skip.
 */
#include "exact/settings.h"
#include "test/support/pair.h"
#include "test/support/random.h"
#include "test/support/vectors.h"

/* ------------------------------------------------------------------------ */
/* open                                                                      */

static void endless(setup *s) {
  pair_wall(s);
}

static void thick(setup *s) {
  pair_wall(s);
  s->config.model.relative_thickness = 0.1f;
  s->config.sampling.storage = HBIL_STORAGE_FLOAT32;
}

static void limited(setup *s) {
  pair_wall(s);
  s->config.model.radius = 0.3f; /* of a wall that is 6 wide: a twentieth */
}

static void limited_pixels(setup *s) {
  limited(s);
  s->config.execution.vector_width = 1;
}

static void ao_alone(setup *s, hbil_mode mode) {
  pair_wall(s);
  s->config.model.mode = mode;
  for (int i = PLANE_FIRST_OUTPUT; i < PLANE_COUNT; ++i)
    if (i != PLANE_AO)
      plane_format(&s->config, (plane_id)i)->component = HBIL_NONE;
}

/* With a single slice, its weight is needed even in open spans. */
static void single_slice(setup *s) {
  limited(s);
  s->config.sampling.slices = 1;
}

/* Open spans have the weights of their lobes. */
static void glossy(setup *s) {
  pair_wall(s);
  s->config.outputs.glossy = three_floats;
  s->config.model.far_field = HBIL_FAR_CONSTANT;
  s->frame.environment[0][0] = 1.0f;
}

static void half_resolution_pixels(setup *s) {
  limited_pixels(s);
  s->config.sampling.resolution = HBIL_RESOLUTION_HALF;
}

static size_t gathered_pixels(const setup *s) {
  size_t count = 0;
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    count += exact_is_gathered(&s->config, i % WIDTH, i / WIDTH);
  return count;
}

static void orthographic_limited(setup *s) {
  limited(s);
  setup_flatten(s, FLAT_WIDTH);
}

static void gtao(setup *s) {
  ao_alone(s, HBIL_MODE_GTAO);
}

static void hbao(setup *s) {
  ao_alone(s, HBIL_MODE_HBAO);
  s->config.model.radius = 0.3f;
}

static prepare_function *const kinds[] = {
    endless,      thick,  limited,
    gtao,         hbao,   orthographic_limited,
    single_slice, glossy, half_resolution_pixels};
#define KINDS (sizeof kinds / sizeof *kinds)

/* One pixel in front of the wall, by anything from a rounding to most of the
 * distance. */
static void lone_occluder(setup *s, random_state *r) {
  const int x = (int)(random_unit(r) * WIDTH),
            y = (int)(random_unit(r) * HEIGHT);
  const double nearer = pow(10.0, -7.0 * random_unit(r));
  s->input[EXACT_DEPTH][pixel_at(x, y)] = (float)(2.0 - 1.9 * nearer);
}

/* Turns the wall, up to almost edge on. */
static void turn(setup *s, random_state *r) {
  const double most = pow(10.0, 1.0 - 8.0 * random_unit(r));
  double n[3] = {most * (random_unit(r) - 0.5), most * (random_unit(r) - 0.5),
                 -1.0};
  normalize(n);
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      const hbil_camera *c = &s->frame.camera;
      const double rx = (x + 0.5 - c->cx) / c->fx,
                   ry = (y + 0.5 - c->cy) / c->fy;
      const double across = n[0] * rx + n[1] * ry;
      double z = -2.0 / (across + n[2]); /* n.(r z) = -2 */
      if (s->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC)
        z = (-2.0 - across) / n[2]; /* n.(q, z) = -2 */
      else if (across + n[2] >= -1e-3)
        z = 0.0;
      s->input[EXACT_DEPTH][pixel_at(x, y)] = (float)fmax(z, 0.0);
      for (int i = 0; i < 3; ++i)
        s->input[EXACT_NORMAL + i][pixel_at(x, y)] = (float)n[i];
    }
}

TEST(every_span_of_a_bare_wall_is_open) {
  for (size_t k = 0; k < KINDS; ++k) {
    pair p;
    pair_start(&p, kinds[k], HBIL_SKIP_ALL);
    pair_fill_wall(&p.with);
    const hbil_statistics found = pair_compare(&p);
    assert_int_equal(found.all.pixels, gathered_pixels(&p.with));
    assert_int_equal(found.open.pixels, found.all.pixels);
    assert_int_equal(found.open.spans, found.all.spans);
    assert_int_equal(statistics_of(&p.without).open.spans, 0);
    pair_free(&p);
  }
}

static void one_pixel_is_seen(prepare_function *prepare, size_t seed,
                              cl_uint skip) {
  random_state r = {.state = 7 + seed};
  size_t blocked = 0;
  pair p;
  pair_start(&p, prepare, skip);
  for (int i = 0; i < 40; ++i) {
    pair_fill_wall(&p.with);
    if (i % 2)
      turn(&p.with, &r);
    lone_occluder(&p.with, &r);
    const hbil_statistics found = pair_compare(&p);
    blocked += found.open.spans < found.all.spans;
  }
  assert_true(blocked > 20);
  pair_free(&p);
}

TEST(one_pixel_anywhere_is_not_overlooked) {
  for (size_t k = 0; k < KINDS; ++k)
    one_pixel_is_seen(kinds[k], k, HBIL_SKIP_ALL);
  one_pixel_is_seen(endless, 0, HBIL_SKIP_OPEN);
}

/* A pillar around the end of the radius, a little nearer and a little farther.
 */
TEST(the_edge_of_the_radius_is_exact) {
  size_t open[2] = {0, 0};
  pair p;
  pair_start(&p, limited, HBIL_SKIP_ALL); /* whose kernels are there */
  for (int i = 0; i < 40; ++i) {
    /* a pillar above the wall; 2 / fy of the wall are a pixel */
    const double step = 2.0 / p.with.frame.camera.fy;
    const int x = (int)(0.3 / step) + i - 20;
    pair_fill_wall(&p.with);
    for (int y = 0; y < HEIGHT; ++y)
      p.with.input[EXACT_DEPTH][pixel_at(150 + x, y)] = 1.99f;
    const hbil_statistics found = pair_compare(&p);
    open[i >= 20] += found.open.spans;
  }
  assert_true(open[0] > 0 && open[1] > 0);
  pair_free(&p);
}

TEST(rooms_are_the_same) {
  for (size_t k = 0; k < KINDS; ++k) {
    pair p;
    pair_start(&p, kinds[k], HBIL_SKIP_ALL);
    for (uint32_t i = 0; i < 2; ++i) {
      setup_load_scene(&p.with, i ? SCENE_SKY : SCENE_ROOM, i);
      if (p.with.config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC)
        setup_flatten(&p.with, FLAT_WIDTH);
      p.without.frame.camera = p.with.frame.camera;
      pair_compare(&p);
    }
    pair_free(&p);
  }
}

/* ------------------------------------------------------------------------ */
/* sky                                                                       */

TEST(a_single_pixel_before_the_sky_is_seen) {
  random_state r = {.state = 3};
  pair p;
  pair_start(&p, endless, HBIL_SKIP_SKY);
  for (int i = 0; i < 10; ++i) {
    pair_fill_wall(&p.with);
    setup_fill(&p.with, EXACT_DEPTH, 0.0f);
    if (i)
      p.with.input[EXACT_DEPTH][pixel_at((int)(random_unit(&r) * WIDTH),
                                         (int)(random_unit(&r) * HEIGHT))] =
          1.0f;
    const hbil_statistics found = pair_compare(&p);
    assert_int_equal(found.sky.pixels, WIDTH * HEIGHT - (i > 0));
    assert_int_equal(found.sky.spans, found.all.spans - (i > 0));
  }
  pair_free(&p);
}

/* ------------------------------------------------------------------------ */
/* dark                                                                      */

static void unlit_room(pair *p) {
  setup_load_scene(&p->with, SCENE_ROOM, 0);
  p->without.frame.camera = p->with.frame.camera;
  for (int c = 0; c < 3; ++c)
    setup_fill(&p->with, EXACT_DIRECT + c, 0.0f);
}

/* The i-th lamp is in turn a square that grows, a pixel, which few samples
 * meet, and a column and a row of pixels, which are seen from both sides. The
 * first one has no size. */
static void only_lamp(pair *p, random_state *r, int i) {
  const int square = 3 * i;
  const int width = (int)p->with.config.width;
  const int height = (int)p->with.config.height;
  for (int c = 0; c < 3; ++c)
    setup_fill(&p->with, EXACT_EMISSION + c, 0.0f);
  const int x0 = i % 4 == 3 ? 0 : (int)(random_unit(r) * width);
  const int y0 = i % 4 == 2 ? 0 : (int)(random_unit(r) * height);
  const int across[] = {square, 1, 1, width}, down[] = {square, 1, height, 1};
  for (int y = y0; y < y0 + down[i % 4] && y < height; ++y)
    for (int x = x0; x < x0 + across[i % 4] && x < width; ++x)
      p->with.input[EXACT_EMISSION][y * width + x] = 1e4f;
}

static void fallback_frame_mean(setup *s) {
  limited(s);
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.model.radius = 2.0f;
}

/* Three by three blocks of cells, so that light can come from a block on any
 * side. */
static void large(setup *s) {
  pair_sized_wall(s, 2 * 256 + 45, 2 * 256 + 27);
}

/* More samples than one block has: light may follow a block without any. */
static void large_limited(setup *s) {
  large(s);
  s->config.sampling.steps_per_side = 80;
  s->config.model.radius = 1.0f;
  s->config.model.facing_fade[0] = s->config.model.facing_fade[1] = -1.0f;
}

static void large_by_pixels(setup *s) {
  large(s);
  s->config.model.back_facing_fallback = HBIL_FALLBACK_BLACK;
  s->config.model.relative_thickness = 0.1f;
  s->config.execution.vector_width = 1;
}

TEST(one_lamp_is_not_overlooked) {
  static prepare_function *const lights[] = {endless, fallback_frame_mean,
                                             large_limited, large_by_pixels};
  for (size_t k = 0; k < sizeof lights / sizeof *lights; ++k) {
    random_state r = {.state = 11 + k};
    size_t near_irradiance = 0;
    pair p;
    pair_start(&p, lights[k], HBIL_SKIP_DARK);
    unlit_room(&p);
    for (int i = 0; i < 12; ++i) {
      only_lamp(&p, &r, i);
      const hbil_statistics found = pair_compare(&p);
      const bool guesses =
          p.with.config.model.back_facing_fallback == HBIL_FALLBACK_FRAME_MEAN;
      if (guesses) /* nothing is dark */
        assert_int_equal(found.dark.spans, 0);
      else if (i == 0) /* no light at all: every span that is not open or sky */
        assert_int_equal(found.dark.spans + found.open.spans + found.sky.spans,
                         found.all.spans);
      exact_planes out = outputs_read(&p.with);
      near_irradiance +=
          i > 0 && largest_value(&out, EXACT_NEAR_IRRADIANCE, 3) > 0.0;
      exact_planes_free(&out);
    }
    if (getenv("HBIL_TEST_VERBOSE"))
      print_message("%zu lamps of 11 light something\n", near_irradiance);
    assert_true(near_irradiance > 0);
    pair_free(&p);
  }
}

/* A column or a row of pixels sends light. */
static void set_line(setup *s, int column, int row, float light) {
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x)
      if (x == column || y == row)
        s->input[EXACT_EMISSION][pixel_at(x, y)] = light;
}

TEST(a_line_on_a_rough_wall_is_not_overlooked) {
  static prepare_function *const walls[] = {endless, limited, thick,
                                            limited_pixels};
  for (size_t k = 0; k < sizeof walls / sizeof *walls; ++k) {
    random_state r = {.state = 23 + k};
    pair p;
    pair_start(&p, walls[k], HBIL_SKIP_ALL);
    pair_fill_wall(&p.with);
    for (size_t i = 0; i < WIDTH * HEIGHT; ++i)
      p.with.input[EXACT_DEPTH][i] *= 1.0f + 0.1f * (float)random_unit(&r);
    for (int c = 0; c < 3; ++c)
      setup_fill(&p.with, EXACT_DIRECT + c, 0.0f);
    for (int i = 5; i < WIDTH + HEIGHT; i += 13) { /* in all parts of a cell */
      const int column = i < WIDTH ? i : -1, row = i - WIDTH;
      set_line(&p.with, column, row, 1e4f);
      pair_compare(&p);
      set_line(&p.with, column, row, 0.0f);
      exact_planes out = outputs_read(&p.with);
      assert_true(largest_value(&out, EXACT_NEAR_IRRADIANCE, 3) > 0.0);
      exact_planes_free(&out);
    }
    pair_free(&p);
  }
}

/* ------------------------------------------------------------------------ */
/* unused                                                                    */

static void picture_alone(setup *s) {
  pair_wall(s);
  for (int i = PLANE_FIRST_OUTPUT; i < PLANE_COUNT; ++i)
    if (i != PLANE_BEAUTY)
      plane_format(&s->config, (plane_id)i)->component = HBIL_NONE;
  s->config.inputs.f0.component = HBIL_FLOAT32;
  /* AO must show: metal alone sends no light to others */
  s->config.model.far_field = HBIL_FAR_CONSTANT;
  s->frame.environment[0][0] = 1.0f;
}

static void picture_by_pixels(setup *s) {
  picture_alone(s);
  s->config.execution.vector_width = 1;
}

static void picture_by_a_slice(setup *s) {
  picture_alone(s);
  s->config.sampling.slices = 1;
}

TEST(metal_shows_no_irradiance) {
  static prepare_function *const pictures[] = {picture_alone, picture_by_pixels,
                                               picture_by_a_slice};
  for (size_t k = 0; k < sizeof pictures / sizeof *pictures; ++k) {
    random_state r = {.state = 5 + k};
    pair p;
    pair_start(&p, pictures[k], HBIL_SKIP_UNUSED);
    for (int i = 0; i < 12; ++i) {
      setup_load_scene(&p.with, SCENE_ROOM, 0);
      p.without.frame.camera = p.with.frame.camera;
      for (int c = 0; c < 3; ++c) {
        setup_fill(&p.with, EXACT_F0 + c, i % 2 ? 1.0f : 0.0f);
        if (i % 2 == 0)
          setup_fill(&p.with, EXACT_ALBEDO + c, 0.0f);
      }
      /* but for one pixel */
      const size_t one = pixel_at((int)(random_unit(&r) * WIDTH),
                                  (int)(random_unit(&r) * HEIGHT));
      if (i > 1) {
        p.with.input[EXACT_F0][one] = 0.5f;
        p.with.input[EXACT_ALBEDO][one] = 0.8f;
      }
      const hbil_statistics found = pair_compare(&p);
      if (i > 1)
        assert_in_range(found.unused.spans, found.all.spans / 2,
                        found.all.spans - 1);
      else
        assert_int_equal(found.unused.spans + found.sky.spans, found.all.spans);
    }
    pair_free(&p);
  }
}

TEST(irradiance_outputs_need_it) {
  setup s;
  picture_alone(&s);
  plane_format(&s.config, PLANE_AO)->component = HBIL_FLOAT32;
  setup_start(&s);
  setup_load_scene(&s, SCENE_ROOM, 0);
  for (int c = 0; c < 3; ++c)
    setup_fill(&s, EXACT_ALBEDO + c, 0.0f);
  run_frame(&s);
  assert_int_equal(statistics_of(&s).unused.spans, 0);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* passes                                                                    */

static void room_with_history(setup *s) {
  pair_wall(s);
  s->config.history.reprojection = HBIL_REPROJECTION_CAMERA;
  s->config.model.far_field = HBIL_FAR_FRAME;
}

TEST(holes_are_filled_and_nothing_else) {
  pair p;
  pair_start(&p, room_with_history, HBIL_SKIP_HOLES);
  for (uint32_t i = 0; i < 4; ++i) {
    setup_load_scene(&p.with, SCENE_ROOM, i / 2); /* every frame twice */
    p.without.frame.camera = p.with.frame.camera;
    const hbil_statistics found = pair_compare(&p);
    assert_int_equal(found.not_run[HBIL_PASS_REPROJECT], i == 0);
    assert_int_equal(found.not_run[HBIL_PASS_PUSH_PULL], i != 2);
    assert_int_equal(statistics_of(&p.without).not_run[HBIL_PASS_PUSH_PULL],
                     i == 0);
    assert_int_equal(found.not_run[HBIL_PASS_GATHER], 0);
  }
  pair_free(&p);
}

TEST(statistics_need_a_frame) {
  hbil_statistics out;
  setup s;
  endless(&s);
  setup_start(&s);
  assert_int_equal(hbil_plan_statistics(NULL, s.device->queue, &out),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_statistics(s.plan, NULL, &out),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_statistics(s.plan, s.device->queue, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_statistics(s.plan, s.device->queue, &out),
                   HBIL_INVALID_ARGUMENT);
  setup_free(&s);
}
