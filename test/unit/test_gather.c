/*
 * The gather matches the exact pass, which works with points, angles and
 * integrals in double precision.
 */
#include "test/support/random.h"
#include "test/support/stages.h"
#include "test/support/vectors.h"

/* Relative RMSE; the requirement is 1e-3.  Measured: 1.3e-7, 4.8e-7, 1.9e-7. */
#define AO_LIMIT 1e-5
#define LIGHT_LIMIT 1e-5
#define BENT_LIMIT 1e-5
#define WEIGHT_LIMIT 1e-5

/* What the kernels gather, and what the exact gather does on the same layers.
 */
static void gather_both(setup *s, exact_planes *got, exact_planes *want) {
  exact_planes split;
  setup_start(s);
  *got = stage_gathered(s);
  split = stage_read(s, HBIL_STAGE_SPLIT);
  *want = checked_planes(split.width, split.height, got->count);
  checked_gather(&s->job, &split, want);
  exact_planes_free(&split);
}

/*
 * Whether two samples of finite thickness overlap may depend on a rounding.  If
 * they don't, each is covered and weighed alone, which changes what this pixel
 * gets.  So one pixel of an image may be off by a fifth of the image's root
 * mean square (measured: .11 for its light, .03 for AO, each in one of ten
 * images).  The others are held to the limits above; only the bent normal is
 * less exact, by 3e-5 in one image with one sample a side, and why isn't known.
 */
#define JOINED_LIMIT 0.2
#define JOINED_BENT_LIMIT 1e-4

static void check_light(const char *what, const exact_planes *got,
                        const exact_planes *want, int first, int count,
                        bool joined, double limit) {
  double one, rest = relative_rmse_but_one(got, want, first, count, &one);
  if (joined)
    check_at_most(what, one, JOINED_LIMIT);
  else
    rest = relative_rmse(got, want, first, count);
  check_at_most(what, rest, limit);
}

static void check_gather(setup *s) {
  exact_planes got, want;
  gather_both(s, &got, &want);
  const bool joined = !isinf(s->config.model.thickness) ||
                      !isinf(s->config.model.relative_thickness);
  check_light("AO", &got, &want, HBIL_LIGHT_AO, 1, joined, AO_LIMIT);
  check_light("E_near", &got, &want, HBIL_LIGHT_RED, 3, joined, LIGHT_LIMIT);
  check_light("bent", &got, &want, HBIL_LIGHT_BENT, 3, joined,
              joined ? JOINED_BENT_LIMIT : BENT_LIMIT);
  if (exact_weighs_slices(&s->config))
    check_at_most("weight", relative_rmse(&got, &want, HBIL_LIGHT_WEIGHT, 1),
                  WEIGHT_LIMIT);
  exact_planes_free(&got);
  exact_planes_free(&want);
  setup_free(s);
}

static void every_size_matches(void **state) {
  const int sizes[][2] = {{1, 1}, {3, 5}, {17, 31}, {160, 90}};
  (void)state;
  for (int i = 0; i < 8; ++i) {
    setup s;
    setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, sizes[i / 2][0],
                sizes[i / 2][1], 0);
    check_gather(&s);
  }
}

static void a_large_image_matches(void **state) {
  setup s;
  (void)state;
  setup_scene(&s, SCENE_ROOM, 640, 360, 0);
  check_gather(&s);
}

typedef struct settings {
  cl_uint slices, samples;
  hbil_sample_grid grid;
  float radius, facing[2];
  hbil_back_facing_fallback fallback;
  cl_uint index;
  cl_bool plain; /* not extrapolated */
} settings;

static const settings table[] = {{1,
                                  1,
                                  HBIL_GRID_SAME_LAYER,
                                  INFINITY,
                                  {-0.1f, 0.0f},
                                  HBIL_FALLBACK_LAST_ACCEPTED,
                                  0,
                                  CL_FALSE},
                                 {1,
                                  8,
                                  HBIL_GRID_FULL_RESOLUTION,
                                  1.0f,
                                  {-0.1f, 0.0f},
                                  HBIL_FALLBACK_BLACK,
                                  1,
                                  CL_FALSE},
                                 {2,
                                  16,
                                  HBIL_GRID_SAME_LAYER,
                                  0.5f,
                                  {-1.0f, -1.0f},
                                  HBIL_FALLBACK_LAST_ACCEPTED,
                                  2,
                                  CL_TRUE},
                                 {2,
                                  16,
                                  HBIL_GRID_FULL_RESOLUTION,
                                  INFINITY,
                                  {0.2f, 0.2f},
                                  HBIL_FALLBACK_BLACK,
                                  3,
                                  CL_FALSE},
                                 {4,
                                  8,
                                  HBIL_GRID_SAME_LAYER,
                                  2.0f,
                                  {-0.5f, 0.5f},
                                  HBIL_FALLBACK_BLACK,
                                  0,
                                  CL_FALSE},
                                 {4,
                                  16,
                                  HBIL_GRID_FULL_RESOLUTION,
                                  0.25f,
                                  {-0.1f, 0.0f},
                                  HBIL_FALLBACK_LAST_ACCEPTED,
                                  0,
                                  CL_TRUE},
                                 {2,
                                  1,
                                  HBIL_GRID_FULL_RESOLUTION,
                                  INFINITY,
                                  {1.0f, 1.0f},
                                  HBIL_FALLBACK_LAST_ACCEPTED,
                                  7,
                                  CL_FALSE},
                                 {4,
                                  1,
                                  HBIL_GRID_SAME_LAYER,
                                  1e-3f,
                                  {-0.1f, 0.0f},
                                  HBIL_FALLBACK_LAST_ACCEPTED,
                                  0,
                                  CL_FALSE},
                                 {3,
                                  5,
                                  HBIL_GRID_FULL_RESOLUTION,
                                  1e4f,
                                  {0.0f, 1.0f},
                                  HBIL_FALLBACK_LAST_ACCEPTED,
                                  11,
                                  CL_FALSE}};

static void apply(const settings *t, hbil_config *c) {
  c->sampling.slices = t->slices;
  c->sampling.steps_per_side = t->samples;
  c->sampling.sample_grid = t->grid;
  c->model.radius = t->radius;
  memcpy(c->model.facing_fade, t->facing, sizeof(t->facing));
  c->model.back_facing_fallback = t->fallback;
  c->model.extrapolate = !t->plain;
}

static void every_setting_matches(void **state) {
  (void)state;
  for (size_t i = 0; i < sizeof(table) / sizeof(*table); ++i) {
    setup s;
    const settings *t = table + i;
    setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, 97, 54, 0);
    apply(t, &s.config);
    s.frame.frame_index = t->index;
    check_gather(&s);
  }
}

static void every_vector_width_matches(void **state) {
  const cl_uint widths[] = {1, 4, 8, 16};
  (void)state;
  for (int i = 0; i < 8; ++i) {
    setup s;
    setup_scene(&s, SCENE_ROOM, 77, 45, 0);
    s.config.execution.vector_width = widths[i / 2];
    s.config.model.radius = i & 1 ? 1.0f : INFINITY;
    check_gather(&s);
  }
}

/* Even and odd rows of a layer have different directions. */
static void half_resolution_matches(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i) {
    setup s;
    setup_scene(&s, SCENE_ROOM, 97, 54, 0);
    s.config.sampling.resolution = HBIL_RESOLUTION_HALF;
    s.config.execution.vector_width = i & 1 ? 1 : 0;
    s.config.model.radius = i & 2 ? 1.0f : INFINITY;
    check_gather(&s);
  }
}

static void half_float_depth_matches(void **state) {
  setup s;
  (void)state;
  setup_scene(&s, SCENE_ROOM, 97, 54, 0);
  s.config.inputs.depth.component = HBIL_FLOAT16;
  check_gather(&s);
}

static void equal_and_growing_steps_match(void **state) {
  const float growth[] = {0.0f, 64.0f};
  (void)state;
  for (int i = 0; i < 2; ++i) {
    setup s;
    setup_scene(&s, SCENE_SKY, 64, 37, 0);
    s.config.sampling.step_growth = growth[i];
    check_gather(&s);
  }
}

static void set_thickness(setup *s, float units, float share) {
  s->config.model.thickness = units;
  s->config.model.relative_thickness = share;
}

static void occluders_as_thick_as_they_are_told_match(void **state) {
  const float thickness[][2] = {
      {INFINITY, 0.08f}, {0.1f, INFINITY}, {0.02f, 0.5f}, {1e4f, 1e4f}};
  (void)state;
  for (int i = 0; i < 8; ++i) {
    setup s;
    setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, 97, 54, 0);
    set_thickness(&s, thickness[i / 2][0], thickness[i / 2][1]);
    s.config.execution.vector_width = i & 2 ? 1 : 8;
    s.config.sampling.slices = 1 + (cl_uint)i % 3;
    s.config.model.radius = i == 5 ? 1.0f : INFINITY;
    s.config.model.back_facing_fallback =
        i & 4 ? HBIL_FALLBACK_BLACK : HBIL_FALLBACK_LAST_ACCEPTED;
    check_gather(&s);
  }
}

/* Planes so slightly rough that angles differ in their last digits, or not at
 * all. Sums and quotients of such differences must not lose precision. */
static void hardly_rough_planes_match(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i) {
    setup s;
    random_state r = {.state = 5 + (uint64_t)i};
    exact_planes got, want;
    const double rough = pow(10.0, -4.0 - i);
    setup_scene(&s, SCENE_ROOM, 320, 180, 0);
    for (int c = 0; c < 3; ++c) {
      setup_fill(&s, EXACT_ALBEDO + c, 1.0f);
      setup_fill(&s, EXACT_DIRECT + c, (float)PI);
      setup_fill(&s, EXACT_EMISSION + c, 0.0f);
    }
    for (int p = 0; p < 320 * 180; ++p) {
      s.input[EXACT_DEPTH][p] = (float)(2.0 + rough * random_unit(&r));
      for (int c = 0; c < 3; ++c)
        s.input[EXACT_NORMAL + c][p] =
            (float)-s.frame.camera.world_from_view[4 * c + 2];
    }
    gather_both(&s, &got, &want);
    /* derived: two dozen roundings of 6e-8, of AO and of light of 1 at most */
    check_at_most("AO", largest_error(&got, &want, HBIL_LIGHT_AO, 1), 2e-6);
    check_at_most("E_near", largest_error(&got, &want, HBIL_LIGHT_RED, 3),
                  2e-6 * PI);
    exact_planes_free(&got);
    exact_planes_free(&want);
    setup_free(&s);
  }
}

/* Normals don't fit depths here, which is as rough as a surface can be. */
static void orthographic_views_match(void **state) {
  (void)state;
  for (int i = 0; i < 10; ++i) {
    setup s;
    const settings *t = table + i % 9;
    setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, 97, 54, 0);
    setup_flatten(&s, i & 2 ? 6.0 : 60.0);
    apply(t, &s.config);
    s.config.execution.vector_width = i % 3 ? 8 : 1;
    if (i >= 6)
      set_thickness(&s, i & 1 ? 0.1f : INFINITY, i & 2 ? 0.02f : INFINITY);
    s.config.inputs.depth_kind = i & 4 ? HBIL_DEPTH_RAY : HBIL_DEPTH_PLANAR;
    check_gather(&s);
  }
}

/*
 * A perspective camera far away sees what an orthographic one sees. The exact
 * pass is run on the same planes twice: as (q, z) = (P.xy, P.z), and from 3e3
 * behind as (P.xy / (P.z + 3e3), P.z + 3e3).
 */
static void far_views_become_orthographic(void **state) {
  enum { W = 61, H = 37 };
  const double away = 3e3, pixel = 0.1;
  random_state r = {.state = 2};
  exact_planes got[2], split = checked_planes(W, H, HBIL_SPLIT_PLANES);
  setup s;
  (void)state;
  setup_init(&s, W, H);
  s.config.sampling.slices = 4;
  s.config.sampling.steps_per_side = 16;
  for (int y = 0; y < H; ++y)
    for (int x = 0; x < W; ++x) {
      double n[3] = {random_unit(&r) - 0.5, random_unit(&r) - 0.5, -1.0};
      normalize(n);
      *exact_at(&split, HBIL_SPLIT_W, x, y) =
          -5.0 + 2.0 * random_unit(&r) * random_unit(&r);
      for (int c = 0; c < 3; ++c) {
        *exact_at(&split, HBIL_SPLIT_NORMAL + c, x, y) = n[c];
        *exact_at(&split, HBIL_SPLIT_RED + c, x, y) = random_unit(&r);
      }
    }
  for (int far = 0; far < 2; ++far) {
    setup_flatten(&s, pixel * W);
    s.job.config = &s.config;
    s.job.camera = s.frame.camera;
    if (far) {
      s.config.inputs.projection = HBIL_PROJECTION_PERSPECTIVE;
      s.job.camera.fx *= away;
      s.job.camera.fy *= away;
      for (int i = 0; i < W * H; ++i)
        split.values[i] = 1.0 / (away - split.values[i]);
    }
    got[far] = checked_planes(W, H, HBIL_LIGHT_PLANES);
    checked_gather(&s.job, &split, got + far);
  }
  /* Derived: directions differ by half a picture over the distance, 1e-3, and
   * depths by the tolerance, 2^-22 of 3e3 to a pixel of 0.1: 7e-3 for the
   * nearest samples.  Measured: 1.5e-3, 4.2e-3, 8e-4. */
  check_at_most("AO", relative_rmse(got, got + 1, HBIL_LIGHT_AO, 1), 8e-3);
  check_at_most("E_near", relative_rmse(got, got + 1, HBIL_LIGHT_RED, 3), 8e-3);
  check_at_most("bent", relative_rmse(got, got + 1, HBIL_LIGHT_BENT, 3), 8e-3);
  exact_planes_free(got);
  exact_planes_free(got + 1);
  exact_planes_free(&split);
  setup_free(&s);
}

static exact_planes room_as_thick_as(float share) {
  setup s;
  exact_planes out;
  setup_scene(&s, SCENE_ROOM, 97, 54, 0);
  set_thickness(&s, INFINITY, share);
  /* what lies between the samples is found in different ways */
  s.config.model.extrapolate = CL_FALSE;
  setup_start(&s);
  out = stage_gathered(&s);
  setup_free(&s);
  return out;
}

/* Very thick occluders hide as much as endless ones, except for the sectors'
 * rounding: measured .020 of AO, derived below 1/32 a half-slice. */
static void endless_occluders_are_the_horizon_s(void **state) {
  exact_planes sectors = room_as_thick_as(1e4f);
  exact_planes horizon = room_as_thick_as(INFINITY);
  (void)state;
  check_at_most("AO", relative_rmse(&sectors, &horizon, HBIL_LIGHT_AO, 1),
                0.03);
  exact_planes_free(&sectors);
  exact_planes_free(&horizon);
}

/* With radiance 1 everywhere, every direction that is not open brings 1. */
static void check_furnace(scene_kind kind, cl_uint slices, float radius,
                          float thickness) {
  setup s;
  exact_planes got;
  double worst = 0.0;
  setup_scene(&s, kind, 97, 54, 0);
  s.config.inputs.albedo.component = s.config.inputs.emission.component =
      HBIL_NONE;
  s.config.inputs.direct_scale = (float)PI;
  s.config.sampling.slices = slices;
  s.config.model.radius = radius;
  s.config.model.facing_fade[0] = s.config.model.facing_fade[1] = -1.0f;
  set_thickness(&s, thickness, INFINITY);
  for (int c = 0; c < 3; ++c)
    setup_fill(&s, EXACT_DIRECT + c, 1.0f);
  setup_start(&s);
  got = stage_gathered(&s);
  for (int y = 0; y < got.height; ++y)
    for (int x = 0; x < got.width; ++x)
      for (int c = 0; c < 3; ++c)
        worst = fmax(
            worst, fabs(*exact_at(&got, HBIL_LIGHT_AO, x, y) +
                        *exact_at(&got, HBIL_LIGHT_RED + c, x, y) / PI - 1.0));
  /* measured: 2.8e-7; the requirement is 2e-3 */
  check_at_most("furnace", worst, 1e-5);
  exact_planes_free(&got);
  setup_free(&s);
}

static void the_white_furnace_is_closed(void **state) {
  (void)state;
  check_furnace(SCENE_ROOM, 1, INFINITY, INFINITY);
  check_furnace(SCENE_ROOM, 2, INFINITY, INFINITY);
  check_furnace(SCENE_SKY, 4, INFINITY, INFINITY);
  check_furnace(SCENE_ROOM, 2, 0.7f, INFINITY);
  check_furnace(SCENE_ROOM, 2, INFINITY, 0.1f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_size_matches),
      cmocka_unit_test(a_large_image_matches),
      cmocka_unit_test(every_setting_matches),
      cmocka_unit_test(every_vector_width_matches),
      cmocka_unit_test(half_resolution_matches),
      cmocka_unit_test(half_float_depth_matches),
      cmocka_unit_test(equal_and_growing_steps_match),
      cmocka_unit_test(occluders_as_thick_as_they_are_told_match),
      cmocka_unit_test(hardly_rough_planes_match),
      cmocka_unit_test(orthographic_views_match),
      cmocka_unit_test(far_views_become_orthographic),
      cmocka_unit_test(endless_occluders_are_the_horizon_s),
      cmocka_unit_test(the_white_furnace_is_closed)};
  return RUN_WITH_DEVICE(tests);
}
