/*
 * Glossy light of whole frames, in closed forms: a furnace, a bare plane, a
 * wall of known radiance.  It is linear in light, finite whatever the inputs
 * hold, and changes no other output.
 */
#include "exact/camera.h"
#include "exact/lobe.h"
#include "test/support/stages.h"

#include <math.h>

#define WIDTH 97
#define HEIGHT 54

static void ask_for_glossy(setup *s, float roughness) {
  s->config.outputs.glossy = three_floats;
  s->config.model.roughness = roughness;
}

/* ------------------------------------------------------------------------ */
/* Even light                                                                */

/* The largest difference from 1 where there is a surface. */
static double off_one(const setup *s, const exact_planes *out) {
  const size_t pixels = setup_pixels(s);
  double worst = 0.0;
  for (size_t i = 0; i < 3 * pixels; ++i)
    if (s->input[EXACT_DEPTH][i % pixels] > 0.0f)
      worst = fmax(worst, fabs(out->values[EXACT_GLOSSY * pixels + i] - 1.0));
  return worst;
}

/* All surfaces emit 1 and reflect nothing, so that a guess knows no bounces. */
static void check_furnace(int i) {
  setup s;
  const bool frame = i & 4;
  setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, WIDTH, HEIGHT, 0);
  ask_for_glossy(&s, i < 4 ? 0.3f : 0.8f);
  s.config.model.relative_thickness = i & 2 ? 0.08f : INFINITY;
  s.config.model.offscreen_light = 1.0f;
  s.config.model.extrapolate = CL_TRUE;
  s.config.model.back_facing_fallback =
      i & 1 ? HBIL_FALLBACK_FRAME_MEAN : HBIL_FALLBACK_LAST_ACCEPTED;
  s.config.model.far_field = frame ? HBIL_FAR_FRAME : HBIL_FAR_CONSTANT;
  s.config.history.reprojection = HBIL_REPROJECTION_NONE;
  s.config.sampling.slices = 1 + (cl_uint)i % 3;
  for (int c = 0; c < 3; ++c) {
    s.frame.environment[0][c] = frame ? 0.0f : 1.0f;
    setup_fill(&s, EXACT_ALBEDO + c, 0.0f);
    setup_fill(&s, EXACT_EMISSION + c, 1.0f);
  }
  exact_planes out = first_outputs(&s);
  /* Derived: light and the known part are the same sums.  Measured: 3e-7 */
  check_at_most("furnace", off_one(&s, &out), 1e-5);
  exact_planes_free(&out);
  setup_free(&s);
}

TEST(a_furnace_is_even) {
  for (int i = 0; i < 8; ++i)
    check_furnace(i);
}

TEST(a_bare_plane_shows_its_environment) {
  for (int i = 0; i < 6; ++i) {
    setup s;
    double normal[3];
    setup_init(&s, WIDTH, HEIGHT);
    setup_camera(&s, 60.0);
    tilted_normal(0.25 * i, 0.8, normal);
    setup_plane(&s, normal);
    ask_for_glossy(&s, 0.3f + 0.1f * (float)i);
    s.config.model.far_field = HBIL_FAR_CONSTANT;
    for (int c = 0; c < 3; ++c)
      s.frame.environment[0][c] = 1.0f;
    exact_planes out = first_outputs(&s);
    /* nothing is known of the lobe */
    assert_true(off_one(&s, &out) == 0.0);
    exact_planes_free(&out);
    setup_free(&s);
  }
}

/* ------------------------------------------------------------------------ */
/* A wall                                                                    */

/* A floor below the eye and a low wall in front of it, which sends 1; nothing
 * above the wall's first row of pixels. */
#define FLOOR 1.0
#define WALL 3.0
#define TOP 24

static void build_corner(setup *s) {
  setup_init(s, WIDTH, HEIGHT);
  setup_camera(s, 75.0);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    double ray[3];
    setup_ray(s, i % WIDTH, i / WIDTH, ray);
    const bool floor = ray[1] > 0.0 && FLOOR / ray[1] < WALL;
    s->input[EXACT_DEPTH][i] = (float)(i / WIDTH < TOP ? 0.0
                                       : floor         ? FLOOR / ray[1]
                                                       : WALL);
    s->input[EXACT_NORMAL + 1][i] = floor ? -1.0f : 0.0f;
    s->input[EXACT_NORMAL + 2][i] = floor ? 0.0f : -1.0f;
    for (int c = 0; c < 3; ++c) {
      s->input[EXACT_ALBEDO + c][i] = 0.0f;
      s->input[EXACT_EMISSION + c][i] = floor ? 0.0f : 1.0f;
    }
  }
}

/* Whether a direction from a place on the floor meets what the picture shows of
 * the wall, up to the centres of its highest pixels. */
static bool meets_the_wall(const setup *s, vec3 at, vec3 w) {
  if (!(w.z > 0.0 && w.y < 0.0))
    return false;
  const vec3 p = vec_add(at, (WALL - at.z) / w.z, w);
  const double x = s->frame.camera.fx * p.x / p.z + s->frame.camera.cx;
  const double y = s->frame.camera.fy * p.y / p.z + s->frame.camera.cy;
  return x >= 0.0 && y >= TOP + 0.5 && x < WIDTH && y < HEIGHT;
}

/* The part of a pixel's lobe, as far as it is above the floor, that shows the
 * wall: a sum over directions that are distributed by the lobe. */
static double wall_share(const setup *s, int x, int y) {
  enum { RINGS = 600, TURNS = 600 };
  double ray[3], above = 0.0, shown = 0.0;
  setup_ray(s, x, y, ray);
  const vec3 n = vec(0.0, -1.0, 0.0);
  const vec3 at = vec_scale(FLOOR / ray[1], vec(ray[0], ray[1], ray[2]));
  const vec3 wo = vec_scale(-1.0, vec_normalize(at));
  const vec3 r = exact_reflected(n, wo);
  const double k = exact_lobe(&s->config, vec_dot(n, wo));
  const vec3 a = vec_normalize(vec(r.z, 0.0, -r.x));
  const vec3 b =
      vec(r.y * a.z - r.z * a.y, r.z * a.x - r.x * a.z, r.x * a.y - r.y * a.x);
  for (int i = 0; i < RINGS * TURNS; ++i) {
    const double u = (i / TURNS + 0.5) / RINGS;
    const double c = 1.0 - 2.0 * u / (1.0 + 2.0 * k * (1.0 - u));
    const double q = sqrt(1.0 - c * c), phi = 2.0 * PI * (i % TURNS) / TURNS;
    const vec3 w =
        vec_add(vec_add(vec_scale(c, r), q * cos(phi), a), q * sin(phi), b);
    above += vec_dot(w, n) > 0.0;
    shown += vec_dot(w, n) > 0.0 && meets_the_wall(s, at, w);
  }
  return shown / above;
}

static void check_wall(float roughness) {
  setup s;
  build_corner(&s);
  ask_for_glossy(&s, roughness);
  hbil_sampling_set(&s.config.sampling, HBIL_QUALITY_REFERENCE);
  s.config.model.facing_fade[0] = s.config.model.facing_fade[1] = -1.0f;
  s.config.history.reprojection = HBIL_REPROJECTION_NONE;
  exact_planes out = first_outputs(&s);
  double worst = 0.0, least = 1.0, most = 0.0;
  for (int i = 0; i < 12; ++i) {
    const int x = 20 + 18 * (i % 4), y = 43 + 5 * (i / 4);
    const double want = wall_share(&s, x, y);
    least = fmin(least, want);
    most = fmax(most, want);
    worst = fmax(worst, fabs(*exact_at(&out, EXACT_GLOSSY, x, y) - want));
  }
  assert_true(most < 0.99 && most - least > 0.05);
  /* Derived: the step from one of 64 half-slices to the next, of a lobe that
   * fills a sixth of them or more.  Measured: 2.3e-3 */
  check_at_most("wall", worst, 0.01);
  exact_planes_free(&out);
  setup_free(&s);
}

TEST(a_wall_fills_its_part_of_the_lobe) {
  check_wall(0.3f);
  check_wall(0.5f);
  check_wall(0.9f);
}

/* ------------------------------------------------------------------------ */
/* Light and inputs                                                          */

static void prepare_room(setup *s, float light) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  setup_all_outputs(s);
  s->config.sampling.storage = HBIL_STORAGE_PACKED;
  s->config.model.far_field = HBIL_FAR_FRAME;
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  for (int p = EXACT_DIRECT; p < EXACT_MOTION; ++p)
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      s->input[p][i] *= light;
}

/* A power of two changes exponents alone. */
TEST(twice_the_light_is_twice_as_glossy) {
  exact_planes out[2];
  for (int i = 0; i < 2; ++i) {
    setup s;
    prepare_room(&s, i ? 4.0f : 1.0f);
    ask_for_glossy(&s, 0.5f);
    out[i] = first_outputs(&s);
    setup_free(&s);
  }
  assert_true(largest_value(&out[0], EXACT_GLOSSY, 3) > 0.1);
  for (size_t k = 0; k < count_values(&out[0]); ++k)
    out[0].values[k] *= 4.0;
  /* derived: the estimate's means of roots of light are not exact */
  check_at_most("linear", largest_error(&out[1], &out[0], EXACT_GLOSSY, 3),
                2e-6 * largest_value(&out[1], EXACT_GLOSSY, 3));
  planes_free(&out[0], &out[1]);
}

TEST(other_outputs_keep_their_bits) {
  for (int k = 0; k < 5; ++k) {
    exact_planes out[2];
    for (int i = 0; i < 2; ++i) {
      setup s;
      prepare_room(&s, 1.0f);
      s.config.model.relative_thickness = k & 1 ? 0.08f : INFINITY;
      s.config.sampling.slices = 1 + (cl_uint)k % 3;
      if (k == 4)
        s.config.sampling.storage = HBIL_STORAGE_FLOAT32;
      if (i)
        ask_for_glossy(&s, 0.5f);
      setup_start(&s);
      setup_run(&s, hbil_enqueue_frame);
      s.frame.static_frame = CL_TRUE;
      out[i] = frame_outputs(&s);
      setup_free(&s);
    }
    for (int p = 0; p < EXACT_GLOSSY; ++p)
      assert_true(largest_error(&out[1], &out[0], p, 1) == 0.0);
    assert_true(largest_value(&out[1], EXACT_GLOSSY, 3) > 0.1);
    planes_free(&out[0], &out[1]);
  }
}

/* Spoiled light, normals and depths, here and there. */
TEST(glossy_light_is_finite) {
  static const float spoiled[] = {NAN, INFINITY, -INFINITY, -1.0f, 1e38f, 0.0f};
  for (int k = 0; k < 4; ++k) {
    setup s;
    prepare_room(&s, 1.0f);
    ask_for_glossy(&s, k & 1 ? 0.3f : 1.0f);
    s.config.model.far_field = (hbil_far_field)k;
    for (int p = 0; p < EXACT_MOTION; ++p)
      for (int i = p % 7; i < WIDTH * HEIGHT; i += 23 + p)
        s.input[p][i] = spoiled[(i + p) % 6];
    setup_start(&s);
    for (int run = 0; run < 2; ++run) {
      exact_planes out = frame_outputs(&s);
      for (int i = 0; i < 3 * WIDTH * HEIGHT; ++i)
        assert_true(out.values[EXACT_GLOSSY * WIDTH * HEIGHT + i] >= 0.0 &&
                    out.values[EXACT_GLOSSY * WIDTH * HEIGHT + i] < 1e31);
      exact_planes_free(&out);
    }
    setup_free(&s);
  }
}
