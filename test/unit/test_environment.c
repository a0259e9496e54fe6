/*
 * Latitude-longitude maps become spherical harmonics, and cameras of OpenGL's
 * convention become the library's.
 */
#include "test/support/compare.h"
#include "test/support/random.h"

#define WIDTH 256
#define HEIGHT 128

/* Direction in the middle of a map's pixel. */
static void map_direction(int x, int y, double d[3]) {
  double azimuth = (0.5 - (x + 0.5) / WIDTH) * 2.0 * PI;
  double polar = (y + 0.5) / HEIGHT * PI;
  d[0] = sin(polar) * cos(azimuth);
  d[1] = sin(polar) * sin(azimuth);
  d[2] = cos(polar);
}

static void rotate(const float m[9], double d[3]) {
  double r[3];
  for (int i = 0; i < 3; ++i)
    r[i] = (double)m[3 * i] * d[0] + (double)m[3 * i + 1] * d[1] +
           (double)m[3 * i + 2] * d[2];
  memcpy(d, r, sizeof(r));
}

static const float identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
static const float turned[9] = {0.36f, 0.48f, -0.8f, -0.8f, 0.6f,
                                0.0f,  0.48f, 0.64f, 0.6f};

/* To a left-handed world with y up. */
static const float mirrored[9] = {1, 0, 0, 0, 0, 1, 0, 1, 0};

/* A map with `row` floats a row, painted from coefficients in the world. */
static float *painted(const float sh[9][3], const float rotation[9],
                      size_t row) {
  float *map = malloc(row * HEIGHT * sizeof(*map));
  assert_non_null(map);
  for (size_t i = 0; i < row * HEIGHT; ++i)
    map[i] = NAN; /* the padding between the rows must not be read */
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      double d[3], basis[9];
      map_direction(x, y, d);
      rotate(rotation, d);
      exact_sh_basis(d, basis);
      for (int c = 0; c < 3; ++c) {
        double sum = 0.0;
        for (int i = 0; i < 9; ++i)
          sum += basis[i] * (double)sh[i][c];
        map[(size_t)y * row + (size_t)(3 * x + c)] = (float)sum;
      }
    }
  return map;
}

static void check_painted(const float rotation[9], const float *given,
                          size_t row, size_t pitch) {
  random_state r = {41};
  float sh[9][3], got[9][3], *map;
  double worst = 0.0;
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c) /* positive everywhere, as light is */
      sh[i][c] = (float)(i ? random_unit(&r) - 0.5 : 6.0);
  map = painted((const float(*)[3])sh, rotation, row);
  assert_int_equal(
      hbil_environment_from_latlong(map, WIDTH, HEIGHT, pitch, given, got),
      HBIL_SUCCESS);
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      worst = fmax(worst, fabs((double)got[i][c] - (double)sh[i][c]));
  /* measured: 3.5e-4, the midpoint rule on 128 rows */
  check_at_most("coefficients", worst, 1e-3);
  free(map);
}

TEST(painted_coefficients_come_back) {
  check_painted(identity, NULL, 3 * WIDTH, 0);
  check_painted(identity, identity, 3 * WIDTH, 3 * WIDTH * sizeof(float));
}

TEST(rows_may_be_apart) {
  check_painted(identity, NULL, 3 * WIDTH + 5, (3 * WIDTH + 5) * sizeof(float));
}

TEST(maps_may_be_turned) {
  check_painted(turned, turned, 3 * WIDTH, 0);
  check_painted(mirrored, mirrored, 3 * WIDTH, 0);
}

TEST(a_constant_map_has_band_0_alone) {
  const double light[3] = {0.25, 1.0, 300.0};
  float *map = malloc(sizeof(float) * 3 * WIDTH * HEIGHT), sh[9][3];
  assert_non_null(map);
  for (int i = 0; i < 3 * WIDTH * HEIGHT; ++i)
    map[i] = (float)light[i % 3];
  assert_int_equal(
      hbil_environment_from_latlong(map, WIDTH, HEIGHT, 0, NULL, sh),
      HBIL_SUCCESS);
  for (int c = 0; c < 3; ++c) {
    assert_true(fabs((double)sh[0][c] / (sqrt(4.0 * PI) * light[c]) - 1.0) <
                1e-4);
    for (int i = 1; i < 9; ++i)
      assert_true(fabs((double)sh[i][c]) < 2e-4 * light[c]);
  }
  free(map);
}

TEST(bad_arguments_are_refused) {
  float map[3 * 4 * 2] = {0.0f}, sh[9][3];
  assert_int_equal(hbil_environment_from_latlong(NULL, 4, 2, 0, NULL, sh),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_environment_from_latlong(map, 4, 2, 0, NULL, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_environment_from_latlong(map, 0, 2, 0, NULL, sh),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_environment_from_latlong(map, 4, 0, 0, NULL, sh),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_environment_from_latlong(map, 4, 2, 8, NULL, sh),
                   HBIL_INVALID_ARGUMENT); /* shorter than a row */
  assert_int_equal(hbil_environment_from_latlong(map, 4, 2, 50, NULL, sh),
                   HBIL_INVALID_ARGUMENT); /* no multiple of a float */
  assert_int_equal(hbil_environment_from_latlong(map, 4, 2, 0, NULL, sh),
                   HBIL_SUCCESS);
}

/* Sizes whose bytes no size_t counts. */
TEST(maps_must_be_countable) {
  static const size_t most = SIZE_MAX, row = 3 * sizeof(float);
  const struct {
    size_t width, height, pitch;
  } wrong[] = {{most, most, 0},
               {most, 2, 0},
               {most / row + 2, 1, row},
               {2, most / row, 2 * row},
               {4, most, 0}};
  float map[3 * 4 * 2] = {0.0f}, sh[9][3] = {{7.0f}};
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
    assert_int_equal(hbil_environment_from_latlong(map, wrong[i].width,
                                                   wrong[i].height,
                                                   wrong[i].pitch, NULL, sh),
                     HBIL_INVALID_ARGUMENT);
    assert_non_null(strstr(hbil_context_message(NULL), "width, height: "));
    assert_true(sh[0][0] == 7.0f);
  }
}

TEST(matrices_must_be_rotations) {
  static const struct {
    float matrix[9];
    const char *message;
  } wrong[] = {
      {{2, 0, 0, 0, 2, 0, 0, 0, 2}, "column 0 has the length 2, not 1"},
      {{0, 0, 0, 0, 0, 0, 0, 0, 0}, "column 0 has the length 0, not 1"},
      {{1, 0.01f, 0, 0, 1, 0, 0, 0, 1}, "columns 0 and 1 are not at right"},
      {{1, 0, 0, 0, NAN, 0, 0, 0, 1}, "row 1, column 1: nan"}};
  float map[3 * 4 * 2] = {0.0f}, sh[9][3] = {{7.0f}};
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
    assert_int_equal(
        hbil_environment_from_latlong(map, 4, 2, 0, wrong[i].matrix, sh),
        HBIL_INVALID_ARGUMENT);
    const char *message = hbil_context_message(NULL);
    assert_non_null(strstr(message, "world_from_map: not a rotation"));
    assert_non_null(strstr(message, wrong[i].message));
    assert_true(sh[0][0] == 7.0f);
  }
}

/* OpenGL looks along -z with y up: both axes change their sign. */
TEST(opengl_cameras_turn_two_axes) {
  const double gl[16] = {0, 0, 1, 5, 1, 0, 0, 6, 0, 1, 0, 7, 0, 0, 0, 1};
  const double want[16] = {0, 0, -1, 5, 1, 0, 0, 6, 0, -1, 0, 7, 0, 0, 0, 1};
  hbil_camera camera;
  hbil_camera_from_opengl(&camera, gl, 10.0, 11.0, 12.0, 13.0);
  assert_true(camera.fx == 10.0 && camera.fy == 11.0);
  assert_true(camera.cx == 12.0 && camera.cy == 13.0);
  for (int i = 0; i < 16; ++i)
    assert_true(camera.world_from_view[i] == want[i]);
}

int main(void) {
  return tests_run();
}
