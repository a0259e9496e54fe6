/*
 * Frames that the bench enlarges: surfaces stay what they are, and edges where
 * they are.
 */
#include "test/support/compare.h"

#include <math.h>
#include <stdlib.h>

#include "bench/bench.h"

enum { WIDTH = 24, HEIGHT = 16, TIMES = 3, PIXELS = WIDTH * HEIGHT };

/* From this column on there is something near, and above this row sky. */
enum { EDGE = 15, HORIZON = 4 };

/* What is seen at a place of the picture, in pixels of the small one.  A plane
 * has inverse depths that are linear there; by parallel rays, depths. */
static double depth_at(hbil_projection projection, double x, double y) {
  const double linear = 0.2 + 0.011 * x + 0.007 * y;
  const double z =
      projection == HBIL_PROJECTION_ORTHOGRAPHIC ? linear : 1.0 / linear;
  return y < HORIZON ? 0.0 : x < EDGE ? z : 0.25 * z;
}

static float *planes(size_t count) {
  float *p = calloc(count * PIXELS, sizeof *p);
  assert_non_null(p);
  return p;
}

static bench_content small_frame(hbil_projection projection) {
  bench_content c = {
      .name = "plane", .width = WIDTH, .height = HEIGHT, .frames = 1};
  bench_frame *f = &c.frame[0];
  c.config.projection = projection;
  c.config.sky_depth = 1e4f;
  c.config.motion_scale[0] = 1.0f;
  c.config.motion_scale[1] = -1.0f;
  f->camera.fx = 20.0f;
  f->camera.fy = 22.0f;
  f->camera.cx = 11.0f;
  f->camera.cy = 9.0f;
  f->plane[BENCH_DEPTH] = planes(1);
  f->plane[BENCH_ALBEDO] = planes(3);
  f->motion = planes(2);
  c.truth = planes(3);
  for (int i = 0; i < PIXELS; ++i)
    f->plane[BENCH_DEPTH][i] =
        (float)depth_at(projection, i % WIDTH + 0.5, i / WIDTH + 0.5);
  for (int i = 0; i < 3 * PIXELS; ++i)
    f->plane[BENCH_ALBEDO][i] = c.truth[i] = (float)i;
  for (int i = 0; i < 2 * PIXELS; ++i)
    f->motion[i] = (float)-i;
  return c;
}

/* Half a pixel of the small picture is what lies beyond its outermost pixels'
 * centres, and those by an edge: there depth is that of the nearest one. */
static int is_between(double at, double first, double end) {
  return at > first + 0.5 && at < end - 0.5;
}

static void check_depth(const bench_content *c, hbil_projection projection) {
  int within = 0;
  for (int y = 0; y < HEIGHT * TIMES; ++y)
    for (int x = 0; x < WIDTH * TIMES; ++x) {
      const double u = (x + 0.5) / TIMES, v = (y + 0.5) / TIMES;
      const float got = c->frame[0].plane[BENCH_DEPTH][y * WIDTH * TIMES + x];
      const double nearest =
          depth_at(projection, floor(u) + 0.5, floor(v) + 0.5);
      const double want = depth_at(projection, u, v);
      if (is_between(v, HORIZON, HEIGHT) &&
          (is_between(u, 0, EDGE) || is_between(u, EDGE, WIDTH))) {
        assert_float_equal(got, want, 1e-6 * want);
        within += fabs(want - nearest) > 1e-3 * want;
      } else if (v < HORIZON) {
        assert_float_equal(got, 0.0, 0.0);
      } else /* no mixture of two surfaces, nor of one with the sky */ {
        assert_true(fabs(got / nearest - 1.0) < 0.1);
      }
    }
  assert_true(within > PIXELS * TIMES); /* steps would have been seen */
}

static void check_repeated(const float *large, int channels, double sign) {
  for (int c = 0; c < channels; ++c)
    for (int y = 0; y < HEIGHT * TIMES; ++y)
      for (int x = 0; x < WIDTH * TIMES; ++x)
        assert_float_equal(large[(c * HEIGHT * TIMES + y) * WIDTH * TIMES + x],
                           sign * (c * PIXELS + y / TIMES * WIDTH + x / TIMES),
                           0.0);
}

static void surfaces_stay(hbil_projection projection) {
  bench_content c = small_frame(projection);
  image_error error;
  assert_int_equal(bench_content_enlarge(&c, TIMES, &error), 0);
  assert_true(c.width == WIDTH * TIMES && c.height == HEIGHT * TIMES);
  check_depth(&c, projection);
  check_repeated(c.frame[0].plane[BENCH_ALBEDO], 3, 1.0);
  check_repeated(c.truth, 3, 1.0);
  check_repeated(c.frame[0].motion, 2, -1.0);
  assert_null(c.frame[0].plane[BENCH_NORMAL]);
  const hbil_camera *camera = &c.frame[0].camera;
  assert_float_equal(camera->fx, 20.0 * TIMES, 0.0);
  assert_float_equal(camera->fy, 22.0 * TIMES, 0.0);
  assert_float_equal(camera->cx, 11.0 * TIMES, 0.0);
  assert_float_equal(camera->cy, 9.0 * TIMES, 0.0);
  assert_float_equal(c.config.motion_scale[0], TIMES, 0.0);
  assert_float_equal(c.config.motion_scale[1], -TIMES, 0.0);
  bench_content_free(&c);
}

static void surfaces_stay_what_they_are(void **state) {
  (void)state;
  surfaces_stay(HBIL_PROJECTION_PERSPECTIVE);
}

static void and_by_parallel_rays(void **state) {
  (void)state;
  surfaces_stay(HBIL_PROJECTION_ORTHOGRAPHIC);
}

static void what_gets_too_large_is_left_alone(void **state) {
  (void)state;
  bench_content c = small_frame(HBIL_PROJECTION_PERSPECTIVE);
  image_error error;
  assert_int_not_equal(
      bench_content_enlarge(&c, HBIL_MAX_SIZE / WIDTH + 1, &error), 0);
  assert_non_null(strstr(error.text, "no more than 16384"));
  assert_true(c.width == WIDTH && c.height == HEIGHT);
  bench_content_free(&c);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(surfaces_stay_what_they_are),
      cmocka_unit_test(and_by_parallel_rays),
      cmocka_unit_test(what_gets_too_large_is_left_alone)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
