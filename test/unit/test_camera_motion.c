/* A camera stands still if no pixel moves by more than a hundredth of one over
 * a whole sequence, whatever its numbers are; it jitters if only its centre
 * moves, by less than a pixel; else it moves. */
#include "tool/camera_motion.h"
#include "test/support/tests.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COUNT = 4, WIDTH = 320, HEIGHT = 180 };

static const double focus = 200;
static const depth_range room = {2.0, 8.0};

typedef struct shot {
  hbil_camera cameras[COUNT];
  const hbil_camera *list[COUNT];
  camera_path path;
} shot;

/* Copies of one camera, turned and far from the world's middle. */
static void start(shot *s, hbil_projection projection) {
  static const double m[16] = {.6,  0, .8, 1000, 0, 1, 0, -2000,
                               -.8, 0, .6, 500,  0, 0, 0, 1};
  for (int i = 0; i < COUNT; i++) {
    hbil_camera *c = &s->cameras[i];
    *c = (hbil_camera){
        .fx = focus, .fy = focus, .cx = WIDTH / 2.0, .cy = HEIGHT / 2.0};
    memcpy(c->world_from_view, m, sizeof m);
    s->list[i] = c;
  }
  s->path = (camera_path){s->list, COUNT, projection, WIDTH, HEIGHT};
}

/* Moves a camera along its own axis. */
static void step(hbil_camera *c, int axis, double by) {
  for (int r = 0; r < 3; r++)
    c->world_from_view[4 * r + 3] += c->world_from_view[4 * r + axis] * by;
}

/* Turns a camera about its own axis y, by its x and z. */
static void turn(hbil_camera *c, double angle) {
  double *m = c->world_from_view;
  for (int r = 0; r < 3; r++) {
    const double x = m[4 * r], z = m[4 * r + 2];
    m[4 * r] = cos(angle) * x - sin(angle) * z;
    m[4 * r + 2] = sin(angle) * x + cos(angle) * z;
  }
}

static camera_motion_kind kind_of(const shot *s) {
  return camera_motion_find(&s->path, room).kind;
}

TEST(equal_cameras) {
  shot s;
  start(&s, HBIL_PROJECTION_PERSPECTIVE);
  assert_int_equal(kind_of(&s), CAMERA_STANDS);
  assert_int_equal(camera_motion_needs_depths(&s.path), 0);
  s.path.count = 1;
  assert_int_equal(kind_of(&s), CAMERA_STANDS);
}

/* A step to the side moves the nearest surface by focus / 2 pixels a unit. */
TEST(steps_to_the_side) {
  const double limit = CAMERA_SAME_PIXELS * room.low / focus;
  shot s;
  for (int i = 0; i < 2; i++) {
    start(&s, HBIL_PROJECTION_PERSPECTIVE);
    step(&s.cameras[2], 0, (i ? 1.01 : .99) * limit);
    assert_int_equal(camera_motion_needs_depths(&s.path), 1);
    assert_int_equal(kind_of(&s), i ? CAMERA_MOVES : CAMERA_STANDS);
    const camera_motion found = camera_motion_find(&s.path, room);
    assert_true(fabs(found.pixels / CAMERA_SAME_PIXELS - (i ? 1.01 : .99)) <
                1e-3);
  }
  /* a step along the axis moves the corners, by their distance over 2 */
  start(&s, HBIL_PROJECTION_PERSPECTIVE);
  step(&s.cameras[1], 2, .02 / hypot(WIDTH, HEIGHT));
  assert_int_equal(kind_of(&s), CAMERA_STANDS);
  step(&s.cameras[1], 2, .06 / hypot(WIDTH, HEIGHT));
  assert_int_equal(kind_of(&s), CAMERA_MOVES);
}

/* A turn needs no depth: the middle moves by focus pixels a radian, and the
 * corners by more. */
TEST(turns) {
  shot s;
  start(&s, HBIL_PROJECTION_PERSPECTIVE);
  turn(&s.cameras[3], .5 * CAMERA_SAME_PIXELS / focus);
  assert_int_equal(kind_of(&s), CAMERA_STANDS);
  assert_int_equal(camera_motion_needs_depths(&s.path), 0);
  turn(&s.cameras[3], CAMERA_SAME_PIXELS / focus);
  assert_int_equal(kind_of(&s), CAMERA_MOVES);
  step(&s.cameras[3], 0, 1e-7);
  assert_int_equal(camera_motion_needs_depths(&s.path), 0);
}

/* Turned about: what it saw is behind it. */
TEST(looks_back) {
  shot s;
  start(&s, HBIL_PROJECTION_PERSPECTIVE);
  turn(&s.cameras[1], 3.0);
  assert_int_equal(kind_of(&s), CAMERA_MOVES);
}

TEST(other_lenses) {
  shot s;
  start(&s, HBIL_PROJECTION_PERSPECTIVE);
  s.cameras[1].fx *= 1 + 1e-6;
  assert_int_equal(kind_of(&s), CAMERA_STANDS);
  s.cameras[1].fx *= 1 + 1e-3;
  assert_int_equal(kind_of(&s), CAMERA_MOVES);
}

TEST(jitter) {
  static const double x[COUNT] = {.0, -.25, .25, -.375};
  static const double y[COUNT] = {-.1667, .1667, -.3889, -.0556};
  shot s;
  start(&s, HBIL_PROJECTION_PERSPECTIVE);
  for (int i = 0; i < COUNT; i++) {
    s.cameras[i].cx += x[i];
    s.cameras[i].cy += y[i];
    step(&s.cameras[i], 0, 1e-7 * i);
  }
  const camera_motion found = camera_motion_find(&s.path, room);
  assert_int_equal(found.kind, CAMERA_JITTERS);
  assert_true(fabs(found.jitter - .625) < 1e-9);
  /* one that is less than a pixel isn't seen */
  start(&s, HBIL_PROJECTION_PERSPECTIVE);
  s.cameras[2].cx += .009;
  assert_int_equal(kind_of(&s), CAMERA_STANDS);
  /* a whole pixel shows something else */
  s.cameras[2].cx += .5;
  s.cameras[1].cx -= .5;
  assert_int_equal(kind_of(&s), CAMERA_MOVES);
  /* with a camera that moves there is no jitter */
  start(&s, HBIL_PROJECTION_PERSPECTIVE);
  s.cameras[1].cy += .3;
  step(&s.cameras[2], 1, .5);
  assert_int_equal(kind_of(&s), CAMERA_MOVES);
}

/* The sky doesn't move if the camera does. */
TEST(sky_alone) {
  static const depth_range nothing = {INFINITY, -INFINITY};
  shot s;
  start(&s, HBIL_PROJECTION_PERSPECTIVE);
  step(&s.cameras[1], 0, 5.0);
  assert_int_equal(camera_motion_find(&s.path, nothing).kind, CAMERA_STANDS);
  turn(&s.cameras[1], .01);
  assert_int_equal(camera_motion_find(&s.path, nothing).kind, CAMERA_MOVES);
}

/* With parallel rays, depth counts when the camera turns. */
TEST(parallel_rays) {
  shot s;
  start(&s, HBIL_PROJECTION_ORTHOGRAPHIC);
  step(&s.cameras[1], 0, .9 * CAMERA_SAME_PIXELS / focus);
  assert_int_equal(kind_of(&s), CAMERA_STANDS);
  step(&s.cameras[1], 0, .2 * CAMERA_SAME_PIXELS / focus);
  assert_int_equal(kind_of(&s), CAMERA_MOVES);
  start(&s, HBIL_PROJECTION_ORTHOGRAPHIC);
  step(&s.cameras[1], 2, .5);
  assert_int_equal(kind_of(&s), CAMERA_STANDS);
  turn(&s.cameras[1], .9 * CAMERA_SAME_PIXELS / focus / room.high);
  assert_int_equal(kind_of(&s), CAMERA_STANDS);
  turn(&s.cameras[1], .9 * CAMERA_SAME_PIXELS / focus / room.high);
  assert_int_equal(kind_of(&s), CAMERA_MOVES);
}

int main(void) {
  return tests_run();
}
