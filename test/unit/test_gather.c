/*
 * What random settings don't tell of the gather (test_kernels): planes that are
 * hardly rough, and results that are known.
 */
#include "test/support/random.h"
#include "test/support/stages.h"
#include "test/support/vectors.h"

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

static void set_thickness(setup *s, float units, float share) {
  s->config.model.thickness = units;
  s->config.model.relative_thickness = share;
}

/* Planes so slightly rough that angles differ in their last digits, or not at
 * all. Sums and quotients of such differences must not lose precision. */
TEST(hardly_rough_planes_match) {
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
    planes_free(&got, &want);
    setup_free(&s);
  }
}

/*
 * A perspective camera far away sees what an orthographic one sees. The exact
 * pass is run on the same planes twice: as (q, z) = (P.xy, P.z), and from 3e3
 * behind as (P.xy / (P.z + 3e3), P.z + 3e3).
 */
TEST(far_views_become_orthographic) {
  enum { W = 61, H = 37 };
  const double away = 3e3, pixel = 0.1;
  random_state r = {.state = 2};
  exact_planes got[2], split = checked_planes(W, H, HBIL_SPLIT_PLANES);
  setup s;
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
  planes_free(got, got + 1, &split);
  setup_free(&s);
}

static exact_planes room_as_thick_as(float share) {
  setup s;
  exact_planes out;
  setup_scene(&s, SCENE_ROOM, 97, 54, 0);
  set_thickness(&s, INFINITY, share);
  /* a sample of an occluder without a back doesn't stand for its step */
  s.config.model.extrapolate = CL_FALSE;
  setup_start(&s);
  out = stage_gathered(&s);
  setup_free(&s);
  return out;
}

/* Very thick occluders hide as much as endless ones, except for the sectors'
 * rounding: measured .020 of AO, derived below 1/32 a half-slice. */
TEST(endless_occluders_are_the_horizon_s) {
  exact_planes sectors = room_as_thick_as(1e4f);
  exact_planes horizon = room_as_thick_as(INFINITY);
  check_at_most("AO", relative_rmse(&sectors, &horizon, HBIL_LIGHT_AO, 1),
                0.03);
  planes_free(&sectors, &horizon);
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

TEST(the_white_furnace_is_closed) {
  check_furnace(SCENE_ROOM, 1, INFINITY, INFINITY);
  check_furnace(SCENE_ROOM, 2, INFINITY, INFINITY);
  check_furnace(SCENE_SKY, 4, INFINITY, INFINITY);
  check_furnace(SCENE_ROOM, 2, 0.7f, INFINITY);
  check_furnace(SCENE_ROOM, 2, INFINITY, 0.1f);
}
