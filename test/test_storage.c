/*
 * Packed layers: what each word may lose, and that nothing else is lost.
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
/* Derived: half a step, and what the fp32 search is off by (test_gather.c). */
#define SHARE_LIMIT (0.5 / 65535.0 + 1e-5)
/* Derived: one step of 8 bits, dithered. */
#define UNKNOWN_LIMIT (1.0 / 255.0 + 1e-5)

static double most_of(const ref_planes *planes, int first, int x, int y) {
  return fmax(
      *ref_at(planes, first, x, y),
      fmax(*ref_at(planes, first + 1, x, y), *ref_at(planes, first + 2, x, y)));
}

/* How far light is off at most, in units of its words, beyond what it may be
 * off by before it becomes a word. */
static double units_off(const ref_planes *got, const ref_planes *want,
                        int first, int bits, double before) {
  double worst = 0.0;
  for (int y = 0; y < got->height; ++y)
    for (int x = 0; x < got->width; ++x) {
      double unit = packed_unit(most_of(want, first, x, y), bits);
      for (int c = first; c < first + 3; ++c) {
        double off = fabs(*ref_at(got, c, x, y) - *ref_at(want, c, x, y));
        if (!(off <= before)) /* a unit of 0: no light out of nothing */
          worst = fmax(worst, isfinite(off) ? (off - before) / unit : INFINITY);
      }
    }
  return worst;
}

/* ------------------------------------------------------------------------ */
/* split                                                                     */

static ref_planes split_in(hbil_storage storage, void (*prepare)(setup *),
                           cl_uint vector_width) {
  setup s;
  ref_planes out;
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
static void check_guides(const ref_planes *got, const ref_planes *want) {
  double worst = 0.0;
  for (int y = 0; y < got->height; ++y)
    for (int x = 0; x < got->width; ++x) {
      double w = *ref_at(want, HBIL_SPLIT_W, x, y), off = 0.0;
      assert_true(*ref_at(got, HBIL_SPLIT_W, x, y) == w);
      for (int c = HBIL_SPLIT_NORMAL; c < HBIL_SPLIT_RED; ++c) {
        double d = *ref_at(got, c, x, y) - *ref_at(want, c, x, y);
        assert_true(isfinite(d));
        off += w > 0.0 ? d * d : 0.0;
      }
      worst = fmax(worst, sqrt(off));
    }
  check_at_most("normal", worst, NORMAL_LIMIT);
}

static void check_split(void (*prepare)(setup *), cl_uint vector_width) {
  ref_planes want = split_in(HBIL_STORAGE_FLOAT32, prepare, vector_width);
  ref_planes got = split_in(HBIL_STORAGE_PACKED, prepare, vector_width);
  assert_int_equal(got.count, want.count);
  check_guides(&got, &want);
  check_at_most("radiance, units",
                units_off(&got, &want, HBIL_SPLIT_RED, 8, 0.0), 1.0);
  ref_planes_free(&want);
  ref_planes_free(&got);
}

/* A wall seen straight on; emission alone is its radiance.  (World space, so
 * that it goes with the kernels that the scenes have already built.) */
static void start_wall(setup *s) {
  setup_init(s, WIDTH, HEIGHT);
  s->config.normal_space = HBIL_SPACE_WORLD;
  setup_fill(s, REF_DEPTH, 1.0f);
  setup_fill(s, REF_NORMAL + 2, -1.0f);
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

/* All over the sphere, in a view so wide that some that face the eye have a z
 * above 0; those that don't face it are bent back until they graze it.  Among
 * them the axes, and the edges and the middles of the map's faces. */
static void all_directions(setup *s) {
  random_state r = {31};
  start_wall(s);
  setup_camera(s, 150.0);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    for (int c = 0; c < 3; ++c)
      s->input[REF_NORMAL + c][i] =
          i % 4 == 0 ? (float)((int)(3.0 * random_unit(&r)) - 1)
                     : (float)(random_unit(&r) - 0.5);
}

static void every_direction_is_kept(void **state) {
  ref_planes split = split_in(HBIL_STORAGE_FLOAT32, all_directions, 8);
  int behind = 0;
  (void)state;
  for (int i = 0; i < 4; ++i)
    check_split(all_directions, widths[i]);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    behind += *ref_at(&split, HBIL_SPLIT_NORMAL + 2, i % WIDTH, i / WIDTH) > 0;
  assert_true(behind > WIDTH * HEIGHT / 8);
  ref_planes_free(&split);
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

/* Every magnitude that a float has, next to 0 and to each other. */
static void any_light(setup *s) {
  const float odd[] = {0.0f,      1.0f,    1e-30f,    1e30f,  3.4e38f,
                       0x1p-118f, 0x1p-7f, 0x1.fep0f, 255.0f, 256.0f};
  random_state r = {71};
  start_wall(s);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    double scale = ldexp(1.0, (int)(236.0 * random_unit(&r)) - 117);
    for (int c = 0; c < 3; ++c)
      s->input[REF_EMISSION + c][i] = random_unit(&r) < 0.2
                                          ? odd[(int)(10.0 * random_unit(&r))]
                                          : (float)(scale * random_unit(&r));
  }
}

static void light_of_any_size_is_kept(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i)
    check_split(any_light, widths[i]);
}

/* Numbers below a float's normal ones are none, or the least one. */
static void hardly_any_light(setup *s) {
  start_wall(s);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    for (int c = 0; c < 3; ++c)
      s->input[REF_EMISSION + c][i] = ldexpf((float)(i % 8), -140 - i % 9);
}

static void hardly_any_light_is_none(void **state) {
  ref_planes got = split_in(HBIL_STORAGE_PACKED, hardly_any_light, 8);
  (void)state;
  check_at_most("denormals", largest_value(&got, HBIL_SPLIT_RED, 3), 0x1p-126);
  ref_planes_free(&got);
}

/* ------------------------------------------------------------------------ */
/* gather                                                                    */

static ref_planes gathered(setup *s) {
  setup_run(s, hbil_enqueue_split);
  setup_run(s, hbil_enqueue_gather);
  return stage_read(s, HBIL_STAGE_GATHERED);
}

/* Few slices make bent normals longer than 1, of which a word keeps no more
 * than the direction. */
static double bent_off(const ref_planes *got, const ref_planes *want, int x,
                       int y) {
  double g[3], w[3], most = 0.0, off = 0.0;
  for (int c = 0; c < 3; ++c) {
    g[c] = *ref_at(got, HBIL_LIGHT_BENT + c, x, y);
    w[c] = *ref_at(want, HBIL_LIGHT_BENT + c, x, y);
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

static double largest_bent_off(const ref_planes *got, const ref_planes *want) {
  double worst = 0.0;
  for (int y = 0; y < got->height; ++y)
    for (int x = 0; x < got->width; ++x)
      worst = fmax(worst, bent_off(got, want, x, y));
  return worst;
}

/* Derived: one unit of 1/1023 in x and in y, one of 1/511 in z. */
#define BENT_LIMIT 2.41e-3

static void check_light(const ref_planes *got, const ref_planes *want) {
  /* what the fp32 search is off by (test_gather.c) */
  double before = 1e-5 * largest_value(want, HBIL_LIGHT_RED, 3);
  check_at_most("AO", largest_error(got, want, HBIL_LIGHT_AO, 1), SHARE_LIMIT);
  if (got->count > HBIL_LIGHT_UNKNOWN)
    check_at_most("unknown", largest_error(got, want, HBIL_LIGHT_UNKNOWN, 1),
                  UNKNOWN_LIMIT);
  check_at_most("E_near, units",
                units_off(got, want, HBIL_LIGHT_RED, 10, before), 1.0);
  check_at_most("bent", largest_bent_off(got, want), BENT_LIMIT);
}

/* What the search makes of the very words that it reads. */
static void check_gather(setup *s) {
  ref_planes got, split, want;
  s->config.storage = HBIL_STORAGE_PACKED;
  setup_start(s);
  got = gathered(s);
  split = stage_read(s, HBIL_STAGE_SPLIT);
  want = ref_planes_new(split.width, split.height, got.count);
  ref_gather(&s->job, &split, &want);
  check_light(&got, &want);
  ref_planes_free(&got);
  ref_planes_free(&split);
  ref_planes_free(&want);
  setup_free(s);
}

typedef struct settings {
  cl_uint slices, samples;
  hbil_lattice lattice;
  float radius, relative_thickness, facing[2];
  hbil_refused refused;
} settings;

static const settings table[] = {
    {2,
     8,
     HBIL_LATTICE_FULL,
     INFINITY,
     INFINITY,
     {-0.1f, 0.0f},
     HBIL_REFUSED_LAST},
    {1,
     8,
     HBIL_LATTICE_LAYER,
     1.0f,
     INFINITY,
     {-0.1f, 0.0f},
     HBIL_REFUSED_BLACK},
    {2, 16, HBIL_LATTICE_FULL, 0.5f, 0.1f, {-0.5f, 0.5f}, HBIL_REFUSED_FRAME},
    {3, 5, HBIL_LATTICE_LAYER, INFINITY, 0.3f, {0.2f, 0.2f}, HBIL_REFUSED_LAST},
    {4,
     4,
     HBIL_LATTICE_FULL,
     INFINITY,
     INFINITY,
     {-1.0f, -1.0f},
     HBIL_REFUSED_BLACK},
    {1,
     16,
     HBIL_LATTICE_FULL,
     2.0f,
     INFINITY,
     {0.0f, 1.0f},
     HBIL_REFUSED_FRAME}};

static void every_setting_matches(void **state) {
  (void)state;
  for (size_t i = 0; i < sizeof(table) / sizeof(*table); ++i) {
    setup s;
    const settings *t = table + i;
    setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, 64, 37, 0);
    s.config.slices = t->slices;
    s.config.samples = t->samples;
    s.config.lattice = t->lattice;
    s.config.radius = t->radius;
    s.config.relative_thickness = t->relative_thickness;
    memcpy(s.config.facing, t->facing, sizeof(t->facing));
    s.config.refused = t->refused;
    s.frame.index = (cl_uint)i;
    check_gather(&s);
  }
}

static void every_vector_width_matches(void **state) {
  (void)state;
  for (int i = 0; i < 8; ++i) {
    setup s;
    setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
    s.config.vector_width = widths[i / 2];
    s.config.refused = i & 1 ? HBIL_REFUSED_FRAME : HBIL_REFUSED_LAST;
    check_gather(&s);
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
    check_gather(&s);
  }
}

static ref_planes packed_room(void) {
  setup s;
  ref_planes out;
  room(&s);
  s.config.storage = HBIL_STORAGE_PACKED;
  setup_start(&s);
  out = gathered(&s);
  setup_free(&s);
  return out;
}

static void every_run_gives_the_same_bits(void **state) {
  ref_planes first = packed_room(), again = packed_room();
  (void)state;
  assert_int_equal(count_different(&again, &first), 0);
  ref_planes_free(&first);
  ref_planes_free(&again);
}

static void only_needed_words_are_kept(void **state) {
  (void)state;
  for (int outputs = 1; outputs < 8; ++outputs) {
    setup s;
    hbil_buffer split, light;
    bool near_light = outputs & 1, bent = outputs & 2;
    room(&s);
    s.config.storage = HBIL_STORAGE_PACKED;
    s.config.near_light.component = near_light ? HBIL_FLOAT32 : HBIL_NONE;
    s.config.bent.component = bent ? HBIL_FLOAT32 : HBIL_NONE;
    s.config.ao.component = outputs & 4 ? HBIL_FLOAT32 : HBIL_NONE;
    setup_start(&s);
    assert_success(&s, hbil_plan_buffer(s.plan, HBIL_STAGE_SPLIT, &split));
    assert_success(&s, hbil_plan_buffer(s.plan, HBIL_STAGE_GATHERED, &light));
    assert_int_equal(split.values, near_light ? 3 : 2);
    assert_int_equal(light.values, bent ? 3 : near_light ? 2 : 1);
    setup_free(&s);
  }
}

/* ------------------------------------------------------------------------ */
/* recompose                                                                 */

/* Random light; the sky is open and dark, as the gather leaves it. */
static void plant_light(setup *s) {
  random_state r = {17};
  int pixels = WIDTH * HEIGHT;
  ref_planes light = ref_planes_new(WIDTH, HEIGHT, HBIL_GATHERED_PLANES);
  for (int i = 0; i < pixels * light.count; ++i) {
    int plane = i / pixels;
    bool bent = plane >= HBIL_LIGHT_BENT && plane < HBIL_LIGHT_UNKNOWN;
    light.values[i] = random_unit(&r) - (bent ? 0.5 : 0.0);
    if (plane == HBIL_LIGHT_UNKNOWN) /* of what is not open */
      light.values[i] *= 1.0 - light.values[i % pixels];
    if (!(s->input[REF_DEPTH][i % pixels] > 0.0f))
      light.values[i] = plane == HBIL_LIGHT_AO;
  }
  stage_write(s, HBIL_STAGE_GATHERED, &light);
  ref_planes_free(&light);
}

static void check_recompose(scene_kind kind, bool raw, hbil_refused refused,
                            cl_uint vector_width) {
  setup s;
  ref_planes split, light, got,
      want = ref_planes_new(WIDTH, HEIGHT, HBIL_LIGHT_PLANES);
  setup_scene(&s, kind, WIDTH, HEIGHT, 0);
  s.config.storage = HBIL_STORAGE_PACKED;
  s.config.raw_interleave = raw;
  s.config.refused = refused;
  s.config.vector_width = vector_width;
  setup_start(&s);
  light = gathered(&s); /* and what the frame sends on average */
  ref_planes_free(&light);
  plant_light(&s);
  light = stage_read(&s, HBIL_STAGE_GATHERED);
  split = stage_read(&s, HBIL_STAGE_SPLIT);
  ref_estimate_frame(&s.job, &split);
  ref_recompose(&s.job, &split, &light, &want);
  setup_run(&s, hbil_enqueue_recompose);
  got = stage_read(&s, HBIL_STAGE_RESOLVED);
  check_at_most("AO", largest_error(&got, &want, 0, 1), 1e-5);
  check_at_most("E_near", relative_rmse(&got, &want, HBIL_LIGHT_RED, 3), 1e-5);
  check_at_most("bent", relative_rmse(&got, &want, HBIL_LIGHT_BENT, 3), 1e-5);
  ref_planes_free(&split);
  ref_planes_free(&light);
  ref_planes_free(&got);
  ref_planes_free(&want);
  setup_free(&s);
}

static void the_filter_matches(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i) {
    check_recompose(SCENE_ROOM, false, HBIL_REFUSED_LAST, widths[i]);
    check_recompose(SCENE_SKY, i & 1, HBIL_REFUSED_FRAME, widths[i]);
  }
}

/* ------------------------------------------------------------------------ */
/* Whole frames                                                              */

/* Root of the mean squared difference over the mean. */
static double rmse_over_mean(const ref_planes *got, const ref_planes *want,
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
  double limit;
} promise;

/* What hbil_storage promises; measured on these frames without noise, worst of
 * all: AO 2.7e-5, E_near 2.1e-3.  The others follow, but for the bent normal,
 * which has no direction left in a word where nothing is open. */
static const promise promises[] = {
    {IMAGE_AO, 1e-4},   {IMAGE_NEAR, 2.2e-3},     {IMAGE_FAR, 2.2e-3},
    {IMAGE_CONE, 1e-4}, {IMAGE_INDIRECT, 2.2e-3}, {IMAGE_RADIANCE, 2.2e-3}};
#define PROMISES (sizeof(promises) / sizeof(*promises))

/* The worst of each promise so far. */
static void compare_frames(const ref_planes *got, const ref_planes *want,
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
    s->config.refused = HBIL_REFUSED_FRAME;
    s->config.far_field = HBIL_FAR_FRAME;
  }
  setup_start(s);
}

static ref_planes frame(setup *s, scene_kind kind, uint32_t index) {
  setup_load_scene(s, kind, index);
  s->frame.index = index;
  setup_upload(s);
  setup_run(s, hbil_enqueue_frame);
  return outputs_read(s);
}

/* The worst of three frames, against FLOAT32 and against the reference. */
static void check_frames(scene_kind kind, bool from_the_frame) {
  setup plain, packed;
  ref_state reference;
  double worst[PROMISES] = {0.0};
  start_frames(&plain, kind, from_the_frame, HBIL_STORAGE_FLOAT32);
  start_frames(&packed, kind, from_the_frame, HBIL_STORAGE_PACKED);
  ref_state_init(&reference, 160, 90);
  for (uint32_t i = 0; i < 3; ++i) {
    ref_planes want = frame(&plain, kind, i), got = frame(&packed, kind, i);
    ref_frame(&reference, &plain.job);
    compare_frames(&got, &want, worst);
    compare_frames(&got, &reference.out, worst);
    ref_planes_free(&want);
    ref_planes_free(&got);
  }
  ref_state_free(&reference);
  setup_free(&plain);
  setup_free(&packed);
  for (size_t i = 0; i < PROMISES; ++i)
    check_at_most(image_name(promises[i].id), worst[i], promises[i].limit);
}

static void frames_keep_the_promise(void **state) {
  (void)state;
  check_frames(SCENE_ROOM, false);
}

static void frames_under_the_sky_keep_the_promise(void **state) {
  (void)state;
  check_frames(SCENE_SKY, false);
}

static void light_from_the_frame_keeps_the_promise(void **state) {
  (void)state;
  check_frames(SCENE_ROOM, true);
  check_frames(SCENE_SKY, true);
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
    s->input[REF_DEPTH][i] = dot(n, ray) < 0.0 && z < 6e4 ? (float)z : 0.0f;
    for (int c = 0; c < 3; ++c)
      s->input[REF_NORMAL + c][i] = (float)n[c];
  }
}

/* Largest deviations from a bare plane. */
typedef struct deviation {
  double ao, light, bent;
} deviation;

static void compare_pixel(const ref_planes *got, const double n[3], int x,
                          int y, deviation *worst) {
  double off = 0.0;
  for (int c = 0; c < 3; ++c)
    off += pow(*ref_at(got, HBIL_LIGHT_BENT + c, x, y) - n[c], 2.0);
  worst->ao = fmax(worst->ao, 1.0 - *ref_at(got, HBIL_LIGHT_AO, x, y));
  worst->light = fmax(worst->light, most_of(got, HBIL_LIGHT_RED, x, y));
  worst->bent = fmax(worst->bent, sqrt(off));
}

static void add_plane(setup *s, double tilt, double azimuth, deviation *worst) {
  const double n[3] = {sin(tilt) * cos(azimuth), sin(tilt) * sin(azimuth),
                       -cos(tilt)};
  ref_planes got;
  set_plane(s, n);
  setup_upload(s);
  got = gathered(s);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    if (s->input[REF_DEPTH][i] > 0.0f)
      compare_pixel(&got, n, i % WIDTH, i / WIDTH, worst);
  ref_planes_free(&got);
}

static void start_plane(setup *s, double fov, hbil_component depth) {
  setup_init(s, WIDTH, HEIGHT);
  setup_camera(s, fov);
  s->config.normal_space = HBIL_SPACE_WORLD;
  s->config.storage = HBIL_STORAGE_PACKED;
  s->config.depth.component = depth;
  for (int c = 0; c < 3; ++c)
    setup_fill(s, REF_EMISSION + c, 1.0f);
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
      cmocka_unit_test(hardly_any_light_is_none),
      cmocka_unit_test(every_setting_matches),
      cmocka_unit_test(every_vector_width_matches),
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
