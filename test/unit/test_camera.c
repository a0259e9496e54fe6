/*
 * Cameras from a renderer's matrices: points of the world that the matrices
 * project, in double precision, lie at the same places and depths for the
 * camera that is made of them, in every convention.
 */
#include "test/support/random.h"
#include "test/support/tests.h"

#include <hbil/hbil.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { WIDTH = 1283, HEIGHT = 719 };

static random_state dice = {29};

/* ------------------------------------------------------------------------ */
/* A renderer                                                                */

/* What differs among renderers. */
typedef struct renderer {
  double looks;        /* 1: along z, -1: along -z of view space */
  double right, up;    /* 1 or -1: x and y of view space on the screen */
  double mirrored;     /* -1: the view matrix mirrors the world */
  double near, far;    /* far may be infinite */
  double shift[2];     /* of the principal point, in clip space */
  cl_uint conventions; /* without HBIL_MATRIX_COLUMN_MAJOR */
  bool orthographic;
} renderer;

/* What clip space has at the near and at the far plane. */
static void clip_depths(const renderer *r, double *near, double *far) {
  const bool reversed = (r->conventions & HBIL_MATRIX_REVERSED_DEPTH) != 0;
  const double low = r->conventions & HBIL_MATRIX_SIGNED_DEPTH ? -1 : 0;
  *near = reversed ? 1 : low;
  *far = reversed ? low : 1;
}

static void projection_of(const renderer *r, double p[16]) {
  double near, far;
  clip_depths(r, &near, &far);
  memset(p, 0, 16 * sizeof *p);
  p[0] = 1.3 * r->right;
  p[5] = 2.1 * r->up;
  if (r->orthographic) {
    /* z/w is near at the near plane and far at the far one */
    const double slope = (far - near) / (r->far - r->near);
    p[3] = r->shift[0];
    p[7] = r->shift[1];
    p[10] = slope * r->looks;
    p[11] = near - slope * r->near;
    p[15] = 1;
    return;
  }
  /* z/w = a + b / distance, the same at both planes */
  const double b = (near - far) / (1 / r->near - 1 / r->far);
  p[2] = r->shift[0] * r->looks;
  p[6] = r->shift[1] * r->looks;
  p[10] = (near - b / r->near) * r->looks;
  p[11] = b;
  p[14] = r->looks;
}

/* A turned and shifted view. */
static void view_of(const renderer *r, double v[16]) {
  const double a = 0.7, b = -1.1;
  const double rows[3][3] = {{cos(a), 0, sin(a)},
                             {sin(b) * sin(a), cos(b), -sin(b) * cos(a)},
                             {-cos(b) * sin(a), sin(b), cos(b) * cos(a)}};
  const double shift[3] = {3.25, -1.5, 0.75};
  memset(v, 0, 16 * sizeof *v);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k)
      v[4 * i + k] = (i == 0 ? r->mirrored : 1.0) * rows[i][k];
    v[4 * i + 3] = shift[i];
  }
  v[15] = 1;
}

static void apply(const double m[16], const double in[4], double out[4]) {
  for (int r = 0; r < 4; ++r) {
    out[r] = 0;
    for (int c = 0; c < 4; ++c)
      out[r] += m[4 * r + c] * in[c];
  }
}

static void transposed(const double m[16], double out[16]) {
  for (int i = 0; i < 16; ++i)
    out[i] = m[i % 4 * 4 + i / 4];
}

static hbil_config config_of(const renderer *r) {
  hbil_config config;
  hbil_config_init(&config);
  config.width = WIDTH;
  config.height = HEIGHT;
  if (r->orthographic)
    config.inputs.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
  return config;
}

/* ------------------------------------------------------------------------ */
/* Points                                                                    */

/* A world point in front of the renderer's camera, at `distance`. */
static void point_at(const double view[16], const renderer *r, double distance,
                     double point[4]) {
  const double wide = r->orthographic ? 1.0 : distance;
  const double seen[3] = {wide * (1.4 * random_unit(&dice) - 0.7),
                          wide * (0.9 * random_unit(&dice) - 0.45),
                          distance * r->looks};
  for (int i = 0; i < 3; ++i) {
    point[i] = 0;
    for (int k = 0; k < 3; ++k)
      point[i] += view[4 * k + i] * (seen[k] - view[4 * k + 3]);
  }
  point[3] = 1;
}

static void check_point(const renderer *r, const double projection[16],
                        const double view[16], const hbil_camera *camera,
                        const double hardware[2]) {
  const double far = isinf(r->far) ? 1e4 * r->near : r->far;
  const double distance = r->near * pow(far / r->near, random_unit(&dice));
  double point[4], seen[4], clip[4];
  point_at(view, r, distance, point);
  apply(view, point, seen);
  apply(projection, seen, clip);
  const bool down = (r->conventions & HBIL_MATRIX_Y_DOWN) != 0;
  const double column = (clip[0] / clip[3] + 1) / 2 * WIDTH;
  const double row = (1 + (down ? 1 : -1) * clip[1] / clip[3]) / 2 * HEIGHT;
  const double stored = r->conventions & HBIL_MATRIX_SIGNED_DEPTH
                            ? (clip[2] / clip[3] + 1) / 2
                            : clip[2] / clip[3];

  double own[3] = {0, 0, 0};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      own[i] += camera->world_from_view[4 * k + i] *
                (point[k] - camera->world_from_view[4 * k + 3]);
  const double divisor = r->orthographic ? 1.0 : own[2];
  /* measured: 1.4e-14 of the width, 2.6e-14 of it in rows; 5e-16 of the depth
   */
  assert_true(fabs(camera->fx * own[0] / divisor + camera->cx - column) <
              1e-12 * WIDTH);
  assert_true(fabs(camera->fy * own[1] / divisor + camera->cy - row) <
              1e-12 * WIDTH);
  assert_true(fabs(own[2] / distance - 1) < 1e-12 * (1 + 10 / distance));
  const double varying =
      r->orthographic ? hardware[1] * own[2] : hardware[1] / own[2];
  assert_true(fabs(hardware[0] + varying - stored) <= 1e-12);
  assert_true(stored > -1e-9 && stored < 1 + 1e-9);
}

static void check_renderer(const renderer *r) {
  const hbil_config config = config_of(r);
  double p[16], v[16], by_columns[2][16];
  projection_of(r, p);
  view_of(r, v);
  hbil_camera camera, same, without_depth;
  double hardware[2], same_hardware[2];
  const hbil_status status = hbil_camera_from_matrices(
      &camera, hardware, &config, p, v, r->conventions);
  if (status != HBIL_SUCCESS)
    fail_msg("%s", hbil_context_message(NULL));
  assert_int_equal(status, HBIL_SUCCESS);
  for (int i = 0; i < 50; ++i)
    check_point(r, p, v, &camera, hardware);

  transposed(p, by_columns[0]);
  transposed(v, by_columns[1]);
  assert_int_equal(
      hbil_camera_from_matrices(&same, same_hardware, &config, by_columns[0],
                                by_columns[1],
                                r->conventions | HBIL_MATRIX_COLUMN_MAJOR),
      HBIL_SUCCESS);
  assert_memory_equal(&same, &camera, sizeof camera);
  assert_memory_equal(same_hardware, hardware, sizeof hardware);
  assert_int_equal(hbil_camera_from_matrices(&without_depth, NULL, &config, p,
                                             v, r->conventions),
                   HBIL_SUCCESS);
  assert_memory_equal(&without_depth, &camera, sizeof camera);
}

/* ------------------------------------------------------------------------ */
/* Tests                                                                     */

/* Everything that differs, in every combination. */
static void check_all(bool orthographic) {
  const double shifts[3][2] = {
      {0, 0}, {0.3, -0.2}, {0.4 / WIDTH, -0.7 / HEIGHT}};
  for (int i = 0; i < 1 << 7; ++i)
    for (int shift = 0; shift < 3; ++shift)
      for (int end = 0; end < (orthographic ? 1 : 2); ++end) {
        const renderer r = {.looks = i & 1 ? 1 : -1,
                            .right = i & 2 ? 1 : -1,
                            .up = i & 4 ? 1 : -1,
                            .mirrored = i & 8 ? 1 : -1,
                            .near = 0.25,
                            .far = end ? INFINITY : 400.0,
                            .shift = {shifts[shift][0], shifts[shift][1]},
                            .conventions = (cl_uint)(i >> 4) << 1,
                            .orthographic = orthographic};
        check_renderer(&r);
      }
}

TEST(perspective_points_stay_where_they_were) {
  check_all(false);
}

TEST(orthographic_points_stay_where_they_were) {
  check_all(true);
}

static double determinant(const double m[16]) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) -
         m[1] * (m[4] * m[10] - m[6] * m[8]) +
         m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/* gluPerspective(), and a view as Blender's: this is hbil_camera_from_opengl().
 * 1.3 half widths and 2.1 half heights are the focal lengths. */
TEST(opengl_is_the_same_both_ways) {
  const renderer r = {.looks = -1,
                      .right = 1,
                      .up = 1,
                      .mirrored = 1,
                      .near = 0.1,
                      .far = 1000.0,
                      .conventions = HBIL_MATRIX_SIGNED_DEPTH};
  const hbil_config config = config_of(&r);
  double p[16], v[16], camera_to_world[16] = {0};
  hbil_camera want, got;
  double depth[2];
  projection_of(&r, p);
  view_of(&r, v);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      camera_to_world[4 * i + k] = v[4 * k + i];
      camera_to_world[4 * i + 3] -= v[4 * k + i] * v[4 * k + 3];
    }
  camera_to_world[15] = 1;
  hbil_camera_from_opengl(&want, camera_to_world, 1.3 * WIDTH / 2,
                          2.1 * HEIGHT / 2, WIDTH / 2.0, HEIGHT / 2.0);
  assert_int_equal(
      hbil_camera_from_matrices(&got, depth, &config, p, v, r.conventions),
      HBIL_SUCCESS);
  for (int i = 0; i < 16; ++i)
    assert_true(got.world_from_view[i] == want.world_from_view[i]);
  assert_true(fabs(got.fx - want.fx) < 1e-12 * WIDTH);
  assert_true(fabs(got.fy - want.fy) < 1e-12 * WIDTH);
  assert_true(got.cx == want.cx && got.cy == want.cy);
  /* f/(f-n) and -f n/(f-n) */
  assert_true(fabs(depth[0] - 1000 / 999.9) < 1e-12);
  assert_true(fabs(depth[1] + 100 / 999.9) < 1e-12);

  /* the same planes with the lowest row first: y turns, nothing else does */
  assert_int_equal(
      hbil_camera_from_matrices(&got, NULL, &config, p, v,
                                r.conventions | HBIL_MATRIX_Y_DOWN),
      HBIL_SUCCESS);
  for (int i = 0; i < 16; ++i)
    assert_true(got.world_from_view[i] ==
                (i % 4 == 1 ? -1 : 1) * want.world_from_view[i]);
  assert_true(determinant(want.world_from_view) > 0.999);
}

/* Direct3D's left-handed world and view, reversed depth without a far plane: at
 * the origin, looking along z with y up.  All numbers are known. */
TEST(direct3d_keeps_its_own_world) {
  const double projection[16] = {0.5, 0, 0, 0, 0, 1, 0,   0,
                                 0,   0, 0, 1, 0, 0, 0.2, 0};
  const double view[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1};
  const double want[16] = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 5, 0, 0, 0, 1};
  hbil_config config;
  hbil_camera camera;
  double depth[2];
  hbil_config_init(&config);
  config.width = 1600;
  config.height = 800;
  assert_int_equal(hbil_camera_from_matrices(
                       &camera, depth, &config, projection, view,
                       HBIL_MATRIX_COLUMN_MAJOR | HBIL_MATRIX_REVERSED_DEPTH),
                   HBIL_SUCCESS);
  for (int i = 0; i < 16; ++i)
    assert_true(camera.world_from_view[i] == want[i]);
  assert_true(camera.fx == 400 && camera.fy == 400);
  assert_true(camera.cx == 800 && camera.cy == 400);
  assert_true(depth[0] == 0.0 && depth[1] == 0.2);
}

typedef struct mistake {
  const char *reason;
  int element; /* of the projection, from 16 on of the view */
  double value;
  cl_uint conventions; /* instead of none */
  bool orthographic;
} mistake;

static const mistake mistakes[] = {
    {"projection: an element is not finite", 0, NAN, 0, false},
    {"projection: the last row is not 0 0 1 0", 14, 0.0, 0, false},
    {"projection: the last row is not 0 0 1 0", 14, 2.0, 0, false},
    {"projection: the last row is not 0 0 1 0", 15, 1.0, 0, false},
    {"projection: the last row is not 0 0 1 0", 12, 0.1, 0, false},
    {"projection: the last row is not 0 0 0 1", 14, 1.0, 0, true},
    {"projection: the last row is not 0 0 0 1", 15, -1.0, 0, true},
    {"projection: the first two rows are not a 0 b 0", 0, 0.0, 0, false},
    {"projection: the first two rows are not a 0 b 0", 1, 0.1, 0, false},
    {"projection: the first two rows are not a 0 b 0", 3, 0.1, 0, false},
    {"projection: the first two rows are not a 0 b 0", 4, 0.1, 0, false},
    {"projection: the first two rows are not a 0 0 b", 2, 0.1, 0, true},
    {"projection: the third row is not 0 0 e f", 8, 0.1, 0, false},
    {"projection: the third row is not 0 0 e f", 9, 0.1, 0, true},
    {"projection: the third row gives everything the same", 11, 0.0, 0, false},
    {"projection: the third row gives everything the same", 10, 0.0, 0, true},
    {"conventions: not HBIL_MATRIX_REVERSED_DEPTH", 11, 0.25, 0, false},
    {"conventions: HBIL_MATRIX_REVERSED_DEPTH", 0, 1.0, 4, false},
    {"infinite distance has a depth inside 0..1", 10, 0.5, 0, false},
    {"without HBIL_MATRIX_SIGNED_DEPTH?", 10, 0.5, 2, false},
    {"-1..1, HBIL_MATRIX_SIGNED_DEPTH?", 10, 0.5, 0, false},
    {"conventions: 16 is not a sum of", 0, 1.0, 16, false},
    {"inputs.projection); without HBIL_MATRIX_COLUMN_MAJOR it fits", 0, 1.0,
     HBIL_MATRIX_COLUMN_MAJOR, false},
    {"view: not a rigid transform", 16, 2.0, 0, false},
    {"view: not a rigid transform", 17, 0.1, 0, false},
    {"view: not a rigid transform", 28, 0.1, 0, false},
    {"view: not a rigid transform", 19, NAN, 0, false}};

TEST(mistakes_are_named) {
  for (size_t i = 0; i < sizeof mistakes / sizeof *mistakes; ++i) {
    const mistake *m = mistakes + i;
    const renderer r = {.looks = 1,
                        .right = 1,
                        .up = 1,
                        .mirrored = 1,
                        .near = 0.25,
                        .far = 400.0,
                        .orthographic = m->orthographic};
    const hbil_config config = config_of(&r);
    double both[32];
    projection_of(&r, both);
    view_of(&r, both + 16);
    both[m->element] = m->value;
    hbil_camera camera, before;
    double depth[2] = {7.0, 7.0};
    memset(&camera, 1, sizeof camera);
    before = camera;
    assert_int_equal(hbil_camera_from_matrices(&camera, depth, &config, both,
                                               both + 16, m->conventions),
                     HBIL_INVALID_ARGUMENT);
    const char *reason = hbil_context_message(NULL);
    if (!strstr(reason, m->reason) || strchr(reason, '\n'))
      fail_msg("mistake %zu: %s", i, reason);
    assert_memory_equal(&camera, &before, sizeof camera);
    assert_true(depth[0] == 7.0 && depth[1] == 7.0);
  }
}

/* An oblique near plane has no A and B, but a camera all the same. */
TEST(without_depth_the_third_row_is_not_read) {
  const renderer r = {.looks = -1,
                      .right = 1,
                      .up = 1,
                      .mirrored = 1,
                      .near = 0.25,
                      .far = 400.0};
  const hbil_config config = config_of(&r);
  double p[16], v[16];
  hbil_camera want, got;
  projection_of(&r, p);
  view_of(&r, v);
  assert_int_equal(hbil_camera_from_matrices(&want, NULL, &config, p, v, 0),
                   HBIL_SUCCESS);
  p[8] = 0.3;
  p[10] = p[11] = 0.0;
  assert_int_equal(hbil_camera_from_matrices(&got, NULL, &config, p, v, 0),
                   HBIL_SUCCESS);
  assert_memory_equal(&got, &want, sizeof want);
}

TEST(missing_arguments_are_named) {
  const renderer r = {.looks = 1,
                      .right = 1,
                      .up = 1,
                      .mirrored = 1,
                      .near = 0.25,
                      .far = 400.0};
  hbil_config config = config_of(&r);
  double p[16], v[16];
  hbil_camera camera;
  projection_of(&r, p);
  view_of(&r, v);
  const char *names[] = {"camera", "config", "projection", "view"};
  for (int missing = 0; missing < 4; ++missing) {
    assert_int_equal(hbil_camera_from_matrices(
                         missing == 0 ? NULL : &camera, NULL,
                         missing == 1 ? NULL : &config, missing == 2 ? NULL : p,
                         missing == 3 ? NULL : v, 0),
                     HBIL_INVALID_ARGUMENT);
    assert_non_null(strstr(hbil_context_message(NULL), names[missing]));
  }
  config.width = 0;
  assert_int_equal(hbil_camera_from_matrices(&camera, NULL, &config, p, v, 0),
                   HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(NULL), "width"));
}

int main(void) {
  return tests_run();
}
