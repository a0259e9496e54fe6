/*
 * Invariances: a mirrored picture has mirrored light, a picture turned by a
 * quarter has turned light, and the world's axes don't matter (nor does its
 * unit of length: test_stability, and for a limited radius test_kernels). Light
 * is linear: it scales with its sources, and the light of two lamps is the sum
 * of each lamp's. The kernels' samples are not symmetric. So mirrored and
 * turned pictures are compared by the exact integral, and by kernels with so
 * many slices that the pattern's noise is small.
 */
#include "test/support/random.h"
#include "test/support/stages.h"
#include "test/support/vectors.h"

/* Square, so that it can be turned by a quarter. */
#define SIDE 48
#define PIXELS (SIDE * SIDE)

/* A symmetry of the square: where a pixel comes from, and what becomes of a
 * vector's x and y. */
typedef struct symmetry {
  int xx, xy, yx, yy;
} symmetry;

static const symmetry mirror = {-1, 0, 0, 1};
static const symmetry quarter_turn = {0, 1, -1, 0};

/* The pixel that (x, y) shows after the symmetry. */
static int pixel_before(const symmetry *m, int x, int y) {
  const int u = 2 * x + 1 - SIDE, v = 2 * y + 1 - SIDE;
  const int from_x = (m->xx * u + m->yx * v + SIDE - 1) / 2;
  const int from_y = (m->xy * u + m->yy * v + SIDE - 1) / 2;
  return from_y * SIDE + from_x;
}

/* The room, or its picture after a symmetry. */
static void start(setup *s, const symmetry *m) {
  setup_init(s, SIDE, SIDE);
  setup_load_scene(s, SCENE_ROOM, 0);
  s->config.model.gather_emission = CL_FALSE; /* a small lamp is noise */
  s->config.sampling.slices = 32;
  s->config.sampling.steps_per_side = SIDE;
  s->config.sampling.step_growth = 0.0f;
  /* from world to view space, in which the symmetry acts */
  const hbil_camera camera = s->frame.camera;
  for (int i = 0; i < PIXELS; ++i) {
    double n[3] = {0.0, 0.0, 0.0};
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k)
        n[c] += camera.world_from_view[4 * k + c] *
                (double)s->input[EXACT_NORMAL + k][i];
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_NORMAL + c][i] = (float)n[c];
  }
  setup_camera(s, 60.0);
  for (int p = 0; m && p < EXACT_INPUT_PLANES; ++p) {
    float before[PIXELS];
    memcpy(before, s->input[p], sizeof before);
    for (int i = 0; i < PIXELS; ++i)
      s->input[p][i] = before[pixel_before(m, i % SIDE, i / SIDE)];
  }
  for (int i = 0; m && i < PIXELS; ++i) {
    float *x = s->input[EXACT_NORMAL] + i, *y = s->input[EXACT_NORMAL + 1] + i;
    const float nx = *x, ny = *y;
    *x = (float)m->xx * nx + (float)m->xy * ny;
    *y = (float)m->yx * nx + (float)m->yy * ny;
  }
  setup_start(s);
}

/* Applies the symmetry to GATHERED. */
static exact_planes transformed(const exact_planes *p, const symmetry *m) {
  exact_planes out = checked_planes(SIDE, SIDE, p->count);
  for (int plane = 0; plane < p->count; ++plane)
    for (int i = 0; i < PIXELS; ++i)
      out.values[plane * PIXELS + i] =
          p->values[plane * PIXELS + pixel_before(m, i % SIDE, i / SIDE)];
  for (int i = 0; i < PIXELS; ++i) {
    double *x = out.values + HBIL_LIGHT_BENT * PIXELS + i, *y = x + PIXELS;
    const double bx = *x, by = *y;
    *x = m->xx * bx + m->xy * by;
    *y = m->yx * bx + m->yy * by;
  }
  return out;
}

/* Measured: 1.6e-15 exactly; kernels 1.7e-3, 1.1e-2 and 2.7e-3, the noise of
 * their pattern. */
static void check_symmetry(const symmetry *m, bool exact, double limit) {
  const exact_dense how = {.slices = 128};
  setup plain, changed;
  start(&plain, NULL);
  start(&changed, m);
  exact_planes before = exact ? expected_gathered_densely(&plain, &how)
                              : stage_gathered_mean(&plain, 8);
  exact_planes got = exact ? expected_gathered_densely(&changed, &how)
                           : stage_gathered_mean(&changed, 8);
  exact_planes want = transformed(&before, m);
  check_at_most("AO", relative_rmse(&got, &want, HBIL_LIGHT_AO, 1), limit);
  check_at_most("E_near", relative_rmse(&got, &want, HBIL_LIGHT_RED, 3),
                4.0 * limit);
  check_at_most("bent", relative_rmse(&got, &want, HBIL_LIGHT_BENT, 3),
                2.0 * limit);
  /* and the symmetry does change the picture */
  assert_true(relative_rmse(&got, &before, HBIL_LIGHT_AO, 1) > 0.05);
  planes_free(&before, &got, &want);
  setup_free(&plain);
  setup_free(&changed);
}

TEST(mirrored_pictures_have_mirrored_light) {
  check_symmetry(&mirror, true, 1e-12);
  check_symmetry(&mirror, false, 3e-3);
}

TEST(turned_pictures_have_turned_light) {
  check_symmetry(&quarter_turn, true, 1e-12);
  check_symmetry(&quarter_turn, false, 3e-3);
}

/* ------------------------------------------------------------------------ */
/* The camera in the world                                                   */

/* Two frames of the room, whose world has been turned and moved. */
static exact_planes frames_in_world(const double turn[9],
                                    const double move[3]) {
  setup s;
  setup_scene(&s, SCENE_ROOM, 61, 37, 0);
  setup_all_outputs(&s);
  s.config.outputs.bent_normal_space = HBIL_SPACE_VIEW;
  setup_start(&s);
  for (uint32_t frame = 0; frame < 2; ++frame) {
    setup_load_scene(&s, SCENE_ROOM, frame);
    double *m = s.frame.camera.world_from_view, old[12];
    memcpy(old, m, sizeof old);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) {
        m[4 * r + c] = c == 3 ? move[r] : 0.0;
        for (int k = 0; k < 3; ++k)
          m[4 * r + c] += turn[3 * r + k] * old[4 * k + c];
      }
    for (size_t i = 0; i < setup_pixels(&s); ++i) {
      double n[3] = {0.0, 0.0, 0.0};
      for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k)
          n[r] += turn[3 * r + k] * (double)s.input[EXACT_NORMAL + k][i];
      for (int r = 0; r < 3; ++r)
        s.input[EXACT_NORMAL + r][i] = (float)n[r];
    }
    setup_upload(&s);
    setup_run(&s, hbil_enqueue_frame);
  }
  return last_outputs(&s);
}

/* Derived: the turned normals are rounded once more, by 6e-8. Measured:
 * 1.2e-7, 1.5e-7 and 8.9e-8. */
TEST(the_world_s_axes_do_not_matter) {
  const double none[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, still[3] = {0, 0, 0};
  const double turn[9] = {0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6};
  const double move[3] = {10.0, -3.0, 7.0};
  exact_planes want = frames_in_world(none, still);
  exact_planes got = frames_in_world(turn, move);
  check_at_most("AO", relative_rmse(&got, &want, EXACT_AO, 1), 1e-5);
  check_at_most("E_near", relative_rmse(&got, &want, EXACT_NEAR_IRRADIANCE, 3),
                1e-5);
  check_at_most("bent", relative_rmse(&got, &want, EXACT_BENT_NORMAL, 3), 1e-5);
  planes_free(&want, &got);
}

/* Two frames of the room and its sky, in its own world or in one where z has
 * the other sign.  Such a world is left-handed. */
static exact_planes frames_of_world(float z) {
  setup s;
  setup_scene(&s, SCENE_ROOM, 61, 37, 0);
  setup_all_outputs(&s);
  s.config.outputs.bent_normal_space = HBIL_SPACE_WORLD;
  s.config.model.far_field = HBIL_FAR_SH;
  setup_start(&s);
  for (uint32_t frame = 0; frame < 2; ++frame) {
    setup_load_scene(&s, SCENE_ROOM, frame);
    for (int c = 0; c < 4; ++c)
      s.frame.camera.world_from_view[8 + c] *= (double)z;
    for (size_t i = 0; i < setup_pixels(&s); ++i)
      s.input[EXACT_NORMAL + 2][i] *= z;
    for (int i = 0; i < 9; ++i) /* three of the functions are odd in z */
      for (int c = 0; c < 3; ++c)
        s.frame.environment[i][c] = (i == 2 || i == 5 || i == 7 ? z : 1.0f) *
                                    (i == 0 ? 2.0f : 0.1f * (float)(i + c));
    setup_upload(&s);
    setup_run(&s, hbil_enqueue_frame);
  }
  return last_outputs(&s);
}

/* Exact: every product with z has the same two signs once more. */
TEST(left_handed_worlds_are_lit_alike) {
  exact_planes want = frames_of_world(1.0f), got = frames_of_world(-1.0f);
  const size_t plane = (size_t)(want.width * want.height);
  double *bent = want.values + (EXACT_BENT_NORMAL + 2) * plane, most = 0.0;
  for (size_t i = 0; i < plane; ++i) {
    most = fmax(most, fabs(bent[i]));
    bent[i] = -bent[i];
  }
  assert_true(most > 0.5);
  for (size_t i = 0; i < plane * (size_t)want.count; ++i)
    assert_true(got.values[i] == want.values[i]);
  planes_free(&want, &got);
}

/* ------------------------------------------------------------------------ */
/* Linearity                                                                 */

/* E_near of the room under its own light, of the left half, of the right half,
 * each times `scale`. */
typedef enum lamps { BOTH, LEFT, RIGHT } lamps;

static exact_planes room_lit_by(lamps which, float scale) {
  setup s;
  setup_scene(&s, SCENE_ROOM, 61, 37, 0);
  for (int p = EXACT_DIRECT; p < EXACT_EMISSION + 3; ++p)
    for (size_t i = 0; i < setup_pixels(&s); ++i) {
      const lamps half = i % 61 < 30 ? LEFT : RIGHT;
      s.input[p][i] *= which == BOTH || which == half ? scale : 0.0f;
    }
  setup_start(&s);
  exact_planes out = stage_gathered(&s);
  setup_free(&s);
  return out;
}

/* Exact: a power of two changes no mantissa.  Derived for others: two dozen
 * roundings of 6e-8. */
TEST(light_scales_with_its_sources) {
  exact_planes one = room_lit_by(BOTH, 1.0f);
  exact_planes four = room_lit_by(BOTH, 4.0f), seven = room_lit_by(BOTH, 7.0f);
  const size_t plane = (size_t)(one.width * one.height);
  for (size_t i = HBIL_LIGHT_RED * plane; i < HBIL_LIGHT_BENT * plane; ++i) {
    assert_true(four.values[i] == 4.0 * one.values[i]);
    one.values[i] *= 7.0;
  }
  check_at_most("7 times", relative_rmse(&seven, &one, HBIL_LIGHT_RED, 3),
                1e-6);
  planes_free(&one, &four, &seven);
}

/* Occlusion and bent normals don't depend on light at all. */
TEST(the_light_of_two_lamps_is_their_sum) {
  exact_planes both = room_lit_by(BOTH, 1.0f);
  exact_planes left = room_lit_by(LEFT, 1.0f), right = room_lit_by(RIGHT, 1.0f);
  const size_t plane = (size_t)(both.width * both.height);
  assert_true(largest_error(&left, &both, HBIL_LIGHT_AO, 1) == 0.0);
  assert_true(largest_error(&left, &both, HBIL_LIGHT_BENT, 3) == 0.0);
  for (size_t i = HBIL_LIGHT_RED * plane; i < HBIL_LIGHT_BENT * plane; ++i)
    left.values[i] += right.values[i];
  check_at_most("sum", relative_rmse(&left, &both, HBIL_LIGHT_RED, 3), 1e-6);
  planes_free(&both, &left, &right);
}
