/*
 * Work that is left out: the same bits as with it, wherever the one pixel is
 * that decides; and where nothing decides against it, it is left out indeed.
 */
#include "support.h"

/* Three spans across, the last one not whole; two blocks of cells. */
#define WIDTH 301
#define HEIGHT 70
/* Of an orthographic picture, world units: a wall at depth 2 looks as wide. */
#define FLAT 6.0

/* Two plans that differ in one skip. */
typedef struct pair {
  setup with, without;
} pair;

typedef void prepare_function(setup *s);

static void start_pair(pair *p, prepare_function *prepare, cl_uint skip) {
  prepare(&p->with);
  prepare(&p->without);
  p->without.config.skip &= ~skip;
  setup_start(&p->with);
  setup_start(&p->without);
}

static void free_pair(pair *p) {
  setup_free(&p->with);
  setup_free(&p->without);
}

static void run(setup *s) {
  setup_upload(s);
  setup_run(s, hbil_enqueue_frame);
}

static hbil_statistics skipped(setup *s) {
  hbil_statistics out;
  assert_success(s, hbil_plan_statistics(s->plan, s->gpu->queue, &out));
  return out;
}

static void check_same(setup *a, setup *b) {
  exact_planes one = outputs_read(a), two = outputs_read(b);
  assert_int_equal(count_different(&one, &two), 0);
  exact_planes_free(&one);
  exact_planes_free(&two);
}

/* Both on the inputs of the first; what that one left out. */
static hbil_statistics compare(pair *p) {
  const size_t pixels = (size_t)p->with.config.width * p->with.config.height;
  for (int i = 0; i < EXACT_INPUT_PLANES; ++i)
    memcpy(p->without.input[i], p->with.input[i], pixels * sizeof(float));
  run(&p->with);
  run(&p->without);
  check_same(&p->with, &p->without);
  return skipped(&p->with);
}

static size_t at(int x, int y) {
  return (size_t)y * WIDTH + (size_t)x;
}

/* A wall seen straight on that sends light everywhere, as the only frame. */
static void sized_wall(setup *s, uint32_t width, uint32_t height) {
  setup_init(s, width, height);
  s->config.reprojection = HBIL_REPROJECTION_NONE;
  s->config.storage = HBIL_STORAGE_PACKED;
  s->config.normal_space = HBIL_SPACE_WORLD; /* as scenes have them */
  setup_all_outputs(s);
  setup_camera(s, 40.0);
}

static void wall(setup *s) {
  sized_wall(s, WIDTH, HEIGHT);
}

static void bare(setup *s) {
  setup_fill(s, EXACT_DEPTH, 2.0f);
  setup_fill(s, EXACT_NORMAL, 0.0f);
  setup_fill(s, EXACT_NORMAL + 1, 0.0f);
  setup_fill(s, EXACT_NORMAL + 2, -1.0f);
  for (int c = 0; c < 3; ++c) {
    setup_fill(s, EXACT_ALBEDO + c, 0.5f);
    setup_fill(s, EXACT_DIRECT + c, 1.0f + (float)c);
    setup_fill(s, EXACT_EMISSION + c, 0.0f);
  }
}

/* ------------------------------------------------------------------------ */
/* open                                                                      */

static void endless(setup *s) {
  wall(s);
}

static void thick(setup *s) {
  wall(s);
  s->config.relative_thickness = 0.1f;
  s->config.storage = HBIL_STORAGE_FLOAT32;
}

static void limited(setup *s) {
  wall(s);
  s->config.radius = 0.3f; /* of a wall that is 6 wide: a twentieth */
}

static void limited_pixels(setup *s) {
  limited(s);
  s->config.vector_width = 1;
}

static void ao_alone(setup *s, hbil_mode mode) {
  wall(s);
  s->config.mode = mode;
  for (int i = PLANE_FIRST_OUTPUT; i < PLANE_COUNT; ++i)
    if (i != PLANE_AO)
      image_format(&s->config, (image_id)i)->component = HBIL_NONE;
}

/* What a slice weighs is needed where nothing else is. */
static void single_slice(setup *s) {
  limited(s);
  s->config.slices = 1;
}

static void single_slice_gtao(setup *s) {
  ao_alone(s, HBIL_MODE_GTAO);
  s->config.radius = 0.3f;
  s->config.slices = 1;
}

static void orthographic(setup *s) {
  wall(s);
  setup_flatten(s, FLAT);
}

static void orthographic_limited(setup *s) {
  limited(s);
  setup_flatten(s, FLAT);
}

static void gtao(setup *s) {
  ao_alone(s, HBIL_MODE_GTAO);
}

static void hbao(setup *s) {
  ao_alone(s, HBIL_MODE_HBAO);
  s->config.radius = 0.3f;
}

static prepare_function *const kinds[] = {endless,      thick,
                                          limited,      limited_pixels,
                                          gtao,         hbao,
                                          orthographic, orthographic_limited,
                                          single_slice, single_slice_gtao};
#define KINDS (sizeof kinds / sizeof *kinds)

/* One pixel, nearer than the wall by anything from a rounding to nearly all. */
static void lone_occluder(setup *s, random_state *r) {
  const int x = (int)(random_unit(r) * WIDTH),
            y = (int)(random_unit(r) * HEIGHT);
  const double nearer = pow(10.0, -7.0 * random_unit(r));
  s->input[EXACT_DEPTH][at(x, y)] = (float)(2.0 - 1.9 * nearer);
}

/* The wall turned by anything up to nearly edge on. */
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
      if (s->config.projection == HBIL_PROJECTION_ORTHOGRAPHIC)
        z = (-2.0 - across) / n[2]; /* n.(q, z) = -2 */
      else if (across + n[2] >= -1e-3)
        z = 0.0;
      s->input[EXACT_DEPTH][at(x, y)] = (float)fmax(z, 0.0);
      for (int i = 0; i < 3; ++i)
        s->input[EXACT_NORMAL + i][at(x, y)] = (float)n[i];
    }
}

static void every_strip_of_a_bare_wall_is_open(void **state) {
  (void)state;
  for (size_t k = 0; k < KINDS; ++k) {
    pair p;
    start_pair(&p, kinds[k], HBIL_SKIP_OPEN);
    bare(&p.with);
    const hbil_statistics found = compare(&p);
    assert_int_equal(found.all.pixels, WIDTH * HEIGHT);
    assert_int_equal(found.open.pixels, WIDTH * HEIGHT);
    assert_int_equal(found.open.spans, found.all.spans);
    assert_int_equal(skipped(&p.without).open.spans, 0);
    free_pair(&p);
  }
}

static void one_pixel_anywhere_is_not_overlooked(void **state) {
  (void)state;
  for (size_t k = 0; k < KINDS; ++k) {
    random_state r = {.state = 7 + k};
    size_t blocked = 0;
    pair p;
    start_pair(&p, kinds[k], HBIL_SKIP_OPEN);
    for (int i = 0; i < 40; ++i) {
      bare(&p.with);
      if (i % 2)
        turn(&p.with, &r);
      lone_occluder(&p.with, &r);
      const hbil_statistics found = compare(&p);
      blocked += found.open.spans < found.all.spans;
    }
    assert_true(blocked > 20);
    free_pair(&p);
  }
}

/* At the end of the reach, a little nearer and a little farther. */
static void the_edge_of_the_radius_is_kept(void **state) {
  size_t open[2] = {0, 0};
  pair p;
  (void)state;
  start_pair(&p, limited, HBIL_SKIP_OPEN | HBIL_SKIP_RADIUS);
  for (int i = 0; i < 40; ++i) {
    /* a pillar above the wall; 2 / fy of the wall are a pixel */
    const double step = 2.0 / p.with.frame.camera.fy;
    const int x = (int)(0.3 / step) + i - 20;
    bare(&p.with);
    for (int y = 0; y < HEIGHT; ++y)
      p.with.input[EXACT_DEPTH][at(150 + x, y)] = 1.99f;
    const hbil_statistics found = compare(&p);
    open[i >= 20] += found.open.spans;
  }
  assert_true(open[0] > 0 && open[1] > 0);
  free_pair(&p);
}

static void rooms_are_the_same(void **state) {
  (void)state;
  for (size_t k = 0; k < KINDS; ++k) {
    pair p;
    start_pair(&p, kinds[k], HBIL_SKIP_ALL);
    for (uint32_t i = 0; i < 2; ++i) {
      setup_load_scene(&p.with, i ? SCENE_SKY : SCENE_ROOM, i);
      if (p.with.config.projection == HBIL_PROJECTION_ORTHOGRAPHIC)
        setup_flatten(&p.with, FLAT);
      p.without.frame.camera = p.with.frame.camera;
      compare(&p);
    }
    free_pair(&p);
  }
}

/* ------------------------------------------------------------------------ */
/* sky                                                                       */

static void a_single_pixel_before_the_sky_is_seen(void **state) {
  random_state r = {.state = 3};
  pair p;
  (void)state;
  start_pair(&p, endless, HBIL_SKIP_SKY);
  for (int i = 0; i < 10; ++i) {
    bare(&p.with);
    setup_fill(&p.with, EXACT_DEPTH, 0.0f);
    if (i)
      p.with.input[EXACT_DEPTH][at((int)(random_unit(&r) * WIDTH),
                                   (int)(random_unit(&r) * HEIGHT))] = 1.0f;
    const hbil_statistics found = compare(&p);
    assert_int_equal(found.sky.pixels, WIDTH * HEIGHT - (i > 0));
    assert_int_equal(found.sky.spans, found.all.spans - (i > 0));
  }
  free_pair(&p);
}

/* ------------------------------------------------------------------------ */
/* dark                                                                      */

static void dark_room(pair *p) {
  setup_load_scene(&p->with, SCENE_ROOM, 0);
  p->without.frame.camera = p->with.frame.camera;
  for (int c = 0; c < 3; ++c)
    setup_fill(&p->with, EXACT_DIRECT + c, 0.0f);
}

/* The i-th: a pixel, which few samples meet; a square, which grows; a column or
 * a row of pixels, which are seen from both sides.  The first is none. */
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

static void refused_black(setup *s) {
  wall(s);
  s->config.back_facing_fallback = HBIL_FALLBACK_BLACK;
  s->config.storage = HBIL_STORAGE_FLOAT32;
}

static void refused_frame(setup *s) {
  limited(s);
  s->config.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.radius = 2.0f;
}

/* More than are looked at in one go: light may come after a dark part. */
static void many_samples(setup *s) {
  wall(s);
  s->config.steps_per_side = 80;
}

/* Three blocks of cells each way, that light can lie in beside each other,
 * above and below; whoever is in the middle sees those around it. */
static void large(setup *s) {
  sized_wall(s, 2 * 256 + 45, 2 * 256 + 27);
}

static void large_limited(setup *s) {
  large(s);
  s->config.radius = 1.0f;
  s->config.facing_fade[0] = s->config.facing_fade[1] = -1.0f;
}

static void large_by_pixels(setup *s) {
  large(s);
  s->config.back_facing_fallback = HBIL_FALLBACK_BLACK;
  s->config.relative_thickness = 0.1f;
  s->config.vector_width = 1;
}

static void near_room(setup *s) {
  wall(s);
  s->config.radius = 0.5f;
  s->config.facing_fade[0] = s->config.facing_fade[1] = -1.0f;
}

static void one_lamp_is_not_overlooked(void **state) {
  static prepare_function *const lights[] = {
      endless,      refused_black, refused_frame, near_room,
      many_samples, large,         large_limited, large_by_pixels};
  (void)state;
  for (size_t k = 0; k < sizeof lights / sizeof *lights; ++k) {
    random_state r = {.state = 11 + k};
    size_t near_irradiance = 0;
    pair p;
    start_pair(&p, lights[k], HBIL_SKIP_DARK);
    dark_room(&p);
    for (int i = 0; i < 12; ++i) {
      only_lamp(&p, &r, i);
      const hbil_statistics found = compare(&p);
      if (i == 0) /* no light at all: every span that is not open or sky */
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
    free_pair(&p);
  }
}

/* A column or a row of pixels; seen from both sides where every pixel has
 * neighbours that stand out. */
static void set_line(setup *s, int column, int row, float light) {
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x)
      if (x == column || y == row)
        s->input[EXACT_EMISSION][at(x, y)] = light;
}

static void a_line_on_a_rough_wall_is_not_overlooked(void **state) {
  static prepare_function *const walls[] = {endless, limited, thick,
                                            limited_pixels};
  (void)state;
  for (size_t k = 0; k < sizeof walls / sizeof *walls; ++k) {
    random_state r = {.state = 23 + k};
    pair p;
    start_pair(&p, walls[k], HBIL_SKIP_DARK);
    bare(&p.with);
    for (size_t i = 0; i < WIDTH * HEIGHT; ++i)
      p.with.input[EXACT_DEPTH][i] *= 1.0f + 0.1f * (float)random_unit(&r);
    for (int c = 0; c < 3; ++c)
      setup_fill(&p.with, EXACT_DIRECT + c, 0.0f);
    for (int i = 5; i < WIDTH + HEIGHT; i += 13) { /* in all parts of a cell */
      const int column = i < WIDTH ? i : -1, row = i - WIDTH;
      set_line(&p.with, column, row, 1e4f);
      compare(&p);
      set_line(&p.with, column, row, 0.0f);
      exact_planes out = outputs_read(&p.with);
      assert_true(largest_value(&out, EXACT_NEAR_IRRADIANCE, 3) > 0.0);
      exact_planes_free(&out);
    }
    free_pair(&p);
  }
}

/* ------------------------------------------------------------------------ */
/* unused                                                                    */

static void picture_alone(setup *s) {
  wall(s);
  for (int i = PLANE_FIRST_OUTPUT; i < PLANE_COUNT; ++i)
    if (i != PLANE_BEAUTY)
      image_format(&s->config, (image_id)i)->component = HBIL_NONE;
  s->config.f0.component = HBIL_FLOAT32;
  /* AO must show: metal alone sends no light to others */
  s->config.far_field = HBIL_FAR_CONSTANT;
  s->frame.environment[0][0] = 1.0f;
}

static void picture_by_pixels(setup *s) {
  picture_alone(s);
  s->config.vector_width = 1;
}

static void picture_by_a_slice(setup *s) {
  picture_alone(s);
  s->config.slices = 1;
}

static void metal_shows_no_irradiance(void **state) {
  static prepare_function *const pictures[] = {picture_alone, picture_by_pixels,
                                               picture_by_a_slice};
  (void)state;
  for (size_t k = 0; k < sizeof pictures / sizeof *pictures; ++k) {
    random_state r = {.state = 5 + k};
    pair p;
    start_pair(&p, pictures[k], HBIL_SKIP_UNUSED);
    for (int i = 0; i < 12; ++i) {
      setup_load_scene(&p.with, SCENE_ROOM, 0);
      p.without.frame.camera = p.with.frame.camera;
      for (int c = 0; c < 3; ++c) {
        setup_fill(&p.with, EXACT_F0 + c, i % 2 ? 1.0f : 0.0f);
        if (i % 2 == 0)
          setup_fill(&p.with, EXACT_ALBEDO + c, 0.0f);
      }
      /* but for one pixel */
      const size_t one =
          at((int)(random_unit(&r) * WIDTH), (int)(random_unit(&r) * HEIGHT));
      if (i > 1) {
        p.with.input[EXACT_F0][one] = 0.5f;
        p.with.input[EXACT_ALBEDO][one] = 0.8f;
      }
      const hbil_statistics found = compare(&p);
      if (i > 1)
        assert_in_range(found.unused.spans, found.all.spans / 2,
                        found.all.spans - 1);
      else
        assert_int_equal(found.unused.spans + found.sky.spans, found.all.spans);
    }
    free_pair(&p);
  }
}

static void who_shows_irradiance_needs_it(void **state) {
  setup s;
  (void)state;
  picture_alone(&s);
  image_format(&s.config, PLANE_AO)->component = HBIL_FLOAT32;
  setup_start(&s);
  setup_load_scene(&s, SCENE_ROOM, 0);
  for (int c = 0; c < 3; ++c)
    setup_fill(&s, EXACT_ALBEDO + c, 0.0f);
  run(&s);
  assert_int_equal(skipped(&s).unused.spans, 0);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* passes                                                                    */

static void room_with_history(setup *s) {
  wall(s);
  s->config.reprojection = HBIL_REPROJECTION_SCATTER;
  s->config.far_field = HBIL_FAR_FRAME;
}

static void holes_are_filled_and_nothing_else(void **state) {
  pair p;
  (void)state;
  start_pair(&p, room_with_history, HBIL_SKIP_HOLES);
  for (uint32_t i = 0; i < 4; ++i) {
    setup_load_scene(&p.with, SCENE_ROOM, i / 2); /* every frame twice */
    p.without.frame.camera = p.with.frame.camera;
    const hbil_statistics found = compare(&p);
    assert_int_equal(found.not_run[HBIL_PASS_REPROJECT], i == 0);
    assert_int_equal(found.not_run[HBIL_PASS_PUSH_PULL], i != 2);
    assert_int_equal(skipped(&p.without).not_run[HBIL_PASS_PUSH_PULL], i == 0);
    assert_int_equal(found.not_run[HBIL_PASS_GATHER], 0);
  }
  free_pair(&p);
}

/* A moving start, then frames that stand still: every one the same as without
 * the promise.  Returns in which of these nothing was gathered any more. */
static int still_frames(prepare_function *prepare, int frames) {
  int settled = 0;
  setup promised, plain;
  prepare(&promised);
  prepare(&plain);
  setup_start(&promised);
  setup_start(&plain);
  for (int i = 0; i < 2 + frames; ++i) {
    const uint32_t frame = i < 2 ? (uint32_t)i : 1;
    setup_load_scene(&promised, SCENE_ROOM, frame);
    setup_load_scene(&plain, SCENE_ROOM, frame);
    promised.frame.static_frame = i >= 2;
    for (int c = 0; c < 2 && i >= 2; ++c) {
      setup_fill(&promised, EXACT_MOTION + c, 0.0f);
      setup_fill(&plain, EXACT_MOTION + c, 0.0f);
    }
    run(&promised);
    run(&plain);
    check_same(&promised, &plain);
    const hbil_statistics found = skipped(&promised);
    if (i >= 2) {
      assert_true(found.not_run[HBIL_PASS_REPROJECT]);
      assert_true(found.not_run[HBIL_PASS_PUSH_PULL]);
      assert_false(found.not_run[HBIL_PASS_COMPOSITE]);
      assert_int_equal(found.not_run[HBIL_PASS_GATHER],
                       found.not_run[HBIL_PASS_RECOMPOSE]);
    }
    /* the first still frame keeps form factors */
    assert_int_equal(found.by_factors.spans > 0,
                     promised.config.horizon_cache_bytes && i >= 3 &&
                         !found.not_run[HBIL_PASS_GATHER]);
    if (!settled && found.not_run[HBIL_PASS_GATHER])
      settled = i - 1;
  }
  setup_free(&promised);
  setup_free(&plain);
  return settled;
}

static void carried_radiance(setup *s) {
  wall(s);
  s->config.reprojection = HBIL_REPROJECTION_MOTION;
  s->config.feedback = HBIL_FEEDBACK_RADIANCE;
  s->config.storage = HBIL_STORAGE_FLOAT32;
}

static void still_frames_are_the_same(void **state) {
  (void)state;
  /* light settles to the bit where it is packed */
  assert_in_range(still_frames(room_with_history, 40), 2, 39);
  still_frames(carried_radiance, 3);
  /* and at once where there is none to carry */
  assert_int_equal(still_frames(endless, 2), 1);
  assert_int_equal(still_frames(gtao, 2), 1);
}

static void factors(setup *s) {
  room_with_history(s);
  s->config.horizon_cache_bytes = SIZE_MAX;
}

static void factors_by_pixels(setup *s) {
  factors(s);
  s->config.vector_width = 1;
}

static void factors_of_all_light(setup *s) {
  factors(s);
  s->config.facing_fade[0] = s->config.facing_fade[1] = -1.0f;
  s->config.extrapolate = CL_FALSE;
  s->config.storage = HBIL_STORAGE_FLOAT32;
}

static void factors_of_black(setup *s) {
  factors(s);
  s->config.back_facing_fallback = HBIL_FALLBACK_BLACK;
  s->config.relative_thickness = 0.1f;
  s->config.storage = HBIL_STORAGE_HALF;
}

static void factors_of_frame(setup *s) {
  factors(s);
  s->config.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.radius = 2.0f;
  s->config.storage = HBIL_STORAGE_FLOAT11;
}

static void factors_of_a_slice(setup *s) {
  factors(s);
  s->config.slices = 1;
  s->config.steps_per_side = 80; /* more than are looked at in one go */
  s->config.radius = 0.5f;
}

static void factors_of_radiance(setup *s) {
  carried_radiance(s);
  s->config.horizon_cache_bytes = SIZE_MAX;
}

static void factors_of_a_step(setup *s) {
  factors(s);
  s->config.facing_fade[0] = s->config.facing_fade[1] = 0.0f;
}

static void factors_of_parallel_rays(setup *s) {
  factors(s);
  setup_flatten(s, FLAT);
}

/* Surfaces that show none have none. */
static void factors_of_a_picture(setup *s) {
  picture_alone(s);
  s->config.reprojection = HBIL_REPROJECTION_SCATTER;
  s->config.feedback = HBIL_FEEDBACK_RADIANCE;
  s->config.horizon_cache_bytes = SIZE_MAX;
}

/* Two thirds of the picture: 12 of the 18 rows of a layer. */
static void factors_of_some_rows(setup *s) {
  factors(s);
  s->config.steps_per_side = 3;
  setup_keep_rows(s, 12, 18);
}

static void factors_of_some_pixels(setup *s) {
  factors_by_pixels(s);
  setup_keep_rows(s, 12, 18);
}

/* Light goes on spreading through what the gather has kept. */
static void form_factors_bring_the_same_light(void **state) {
  static prepare_function *const kept[] = {factors,
                                           factors_by_pixels,
                                           factors_of_all_light,
                                           factors_of_black,
                                           factors_of_frame,
                                           factors_of_a_slice,
                                           factors_of_a_step,
                                           factors_of_parallel_rays,
                                           factors_of_radiance,
                                           factors_of_a_picture,
                                           factors_of_some_rows,
                                           factors_of_some_pixels};
  (void)state;
  for (size_t k = 0; k < sizeof kept / sizeof *kept; ++k)
    assert_int_equal(still_frames(kept[k], 6), 0);
  assert_in_range(still_frames(factors, 40), 2, 39);
}

static void near_factors(setup *s) {
  factors(s);
  s->config.far_field = HBIL_FAR_NONE;
  s->config.radius = 0.25f;
}

/* A stripe of light, which gets as far as the radius in a frame. */
static void light_in_a_stripe(setup *s) {
  setup_load_scene(s, SCENE_ROOM, 0);
  for (int c = 0; c < 3; ++c) {
    setup_fill(s, EXACT_EMISSION + c, 0.0f);
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      s->input[EXACT_DIRECT + c][i] =
          i % WIDTH >= 175 && i % WIDTH < 190 ? 9.0f : 0.0f;
  }
}

/* Pixels that no light comes to. */
static size_t count_unlit(setup *s) {
  size_t unlit = 0;
  exact_planes out = outputs_read(s);
  for (size_t i = 0; i < WIDTH * HEIGHT; ++i)
    unlit +=
        out.values[(size_t)EXACT_NEAR_IRRADIANCE * WIDTH * HEIGHT + i] == 0.0;
  exact_planes_free(&out);
  return unlit;
}

static void what_is_dark_has_form_factors(void **state) {
  size_t unlit = 0;
  pair p;
  (void)state;
  start_pair(&p, near_factors, HBIL_SKIP_STILL);
  for (int i = 0; i < 8; ++i) {
    light_in_a_stripe(&p.with);
    p.without.frame.camera = p.with.frame.camera;
    p.with.frame.static_frame = i > 0;
    assert_int_equal(compare(&p).by_factors.spans > 0, i > 1);
    if (i == 1) /* where they are kept */
      unlit = count_unlit(&p.with);
  }
  assert_in_range(count_unlit(&p.with), 1, unlit - 100);
  free_pair(&p);
}

/* A lamp that is switched on where nothing was to change: no promise kept, but
 * form factors are there, and light is right. */
static void light_may_come_late(void **state) {
  pair p;
  (void)state;
  start_pair(&p, factors, HBIL_SKIP_STILL);
  for (int i = 0; i < 4; ++i) {
    light_in_a_stripe(&p.with);
    p.without.frame.camera = p.with.frame.camera;
    for (int c = 0; i < 2 && c < 3; ++c)
      setup_fill(&p.with, EXACT_DIRECT + c, 0.0f);
    p.with.frame.static_frame = i > 0;
    const hbil_statistics found = compare(&p);
    assert_int_equal(found.by_factors.spans > 0, i > 1);
    assert_int_equal(found.not_run[HBIL_PASS_GATHER], CL_FALSE);
  }
  free_pair(&p);
}

static void still_is_checked(void **state) {
  setup s;
  (void)state;
  room_with_history(&s);
  setup_start(&s);
  setup_load_scene(&s, SCENE_ROOM, 0);
  s.frame.static_frame = CL_TRUE; /* of the first frame: nothing to be like */
  run(&s);
  assert_false(skipped(&s).not_run[HBIL_PASS_SPLIT]);
  s.frame.frame_index = 1;
  assert_int_equal(
      hbil_enqueue_frame(s.plan, s.gpu->queue, &s.frame, 0, NULL, NULL),
      HBIL_INVALID_FRAME);
  assert_non_null(strstr(hbil_context_message(s.gpu->hbil), "frame_index"));
  s.frame.frame_index = 0;
  s.frame.camera.fx *= 1.5;
  assert_int_equal(
      hbil_enqueue_frame(s.plan, s.gpu->queue, &s.frame, 0, NULL, NULL),
      HBIL_INVALID_FRAME);
  assert_non_null(strstr(hbil_context_message(s.gpu->hbil), "camera"));
  /* nor after a reset */
  hbil_plan_reset(s.plan);
  run(&s);
  assert_false(skipped(&s).not_run[HBIL_PASS_SPLIT]);
  setup_free(&s);
}

static void counts_need_a_frame(void **state) {
  hbil_statistics out;
  setup s;
  (void)state;
  endless(&s);
  setup_start(&s);
  assert_int_equal(hbil_plan_statistics(NULL, s.gpu->queue, &out),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_statistics(s.plan, NULL, &out),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_statistics(s.plan, s.gpu->queue, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_statistics(s.plan, s.gpu->queue, &out),
                   HBIL_INVALID_ARGUMENT);
  setup_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_strip_of_a_bare_wall_is_open),
      cmocka_unit_test(one_pixel_anywhere_is_not_overlooked),
      cmocka_unit_test(the_edge_of_the_radius_is_kept),
      cmocka_unit_test(rooms_are_the_same),
      cmocka_unit_test(a_single_pixel_before_the_sky_is_seen),
      cmocka_unit_test(one_lamp_is_not_overlooked),
      cmocka_unit_test(a_line_on_a_rough_wall_is_not_overlooked),
      cmocka_unit_test(metal_shows_no_irradiance),
      cmocka_unit_test(who_shows_irradiance_needs_it),
      cmocka_unit_test(holes_are_filled_and_nothing_else),
      cmocka_unit_test(still_frames_are_the_same),
      cmocka_unit_test(form_factors_bring_the_same_light),
      cmocka_unit_test(what_is_dark_has_form_factors),
      cmocka_unit_test(light_may_come_late),
      cmocka_unit_test(still_is_checked),
      cmocka_unit_test(counts_need_a_frame),
  };
  return RUN_WITH_GPU(tests);
}
