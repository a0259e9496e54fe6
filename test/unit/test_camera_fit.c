/*
 * Cameras that positions tell: fitted where no file has one, held against the
 * file where there is one, and pictures that no camera of hbil could have
 * taken are rejected by name.
 */
#include "test/support/dump_file.h"

#include "dump/camera_fit.h"

#include <stdio.h>
#include <string.h>

static dump begin(scene_kind scene) {
  dump d = dump_begin_plain(scene);
  dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
  return d;
}

static double random_share(unsigned *seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return (double)(*seed >> 8) / 16777216.0;
}

/* Samples lie anywhere within `reach` pixels of the pixels' middles, moved over
 * the surface as the position's neighbours are; a share of all is nonsense. */
static void disturb(dump *d, double reach, double nonsense) {
  float *p[3];
  unsigned seed = 1;
  for (int c = 0; c < 3; c++) {
    char name[16];
    snprintf(name, sizeof name, "position.%s", letters_xyz[c]);
    p[c] = dump_plane(d, name);
  }
  for (size_t y = 0; y < HEIGHT; y++)
    for (size_t x = 0; x < WIDTH; x++) {
      const size_t i = y * WIDTH + x, other = x + 1 < WIDTH ? i + 1 : i;
      const double shift = reach * (2 * random_share(&seed) - 1);
      const int wrong = random_share(&seed) < nonsense;
      for (int c = 0; c < 3 && !dump_is_sky(d, i) && !dump_is_sky(d, other);
           c++) {
        const double step =
            (double)d->s.position[c][other] - (double)d->s.position[c][i];
        p[c][i] = (float)((double)d->s.position[c][i] * (wrong ? 0.3 : 1) +
                          shift * (fabs(step) < 0.1 ? step : 0));
      }
    }
}

static void assert_near(double a, double b, double most) {
  if (!(fabs(a - b) <= most))
    fail_msg("%g is not %g", a, b);
}

/* No camera file: the fit replaces it.  Rays of floats are exact to some 1e-4
 * of a focal length; disturbed positions to a hundredth. */
TEST_WITH_BOTH_CAMERAS(a_missing_file_is_replaced) {
  static const struct {
    double reach, nonsense, most;
  } cases[] = {{0, 0, 1e-3}, {0.5, 0, 0.02}, {0, 0.1, 0.01}, {0.5, 0.1, 0.02}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
    for (int scene = SCENE_ROOM; scene <= SCENE_SKY; scene++) {
      dump d = begin((scene_kind)scene);
      const hbil_camera *wanted = &d.s.camera;
      disturb(&d, cases[k].reach, cases[k].nonsense);
      d.json = 0;
      reading r = dump_reading(&d);
      const hbil_camera *is = &r.map.camera;
      const double most = cases[k].most;
      assert_true(r.seen.fitted && r.seen.placed);
      assert_int_equal(r.config.inputs.projection, d.s.projection);
      assert_near(is->fx / wanted->fx, 1, most);
      assert_near(is->fy / wanted->fy, 1, most);
      for (int i = 0; i < 12; i++) {
        if (i % 4 == 3 && dump_orthographic)
          continue; /* moves with the centre */
        assert_near(is->world_from_view[i], wanted->world_from_view[i],
                    i % 4 == 3 ? 10 * most : most);
      }
      dump_done(&d, &r);
    }
}

/* Positions of a left-handed world, of camera space, and of a part of the
 * picture. */
TEST(other_worlds_are_fitted) {
  dump d = dump_begin_plain(SCENE_ROOM);
  dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_OPENGL, 1);
  d.options.positions = SPACE_CAMERA;
  d.options.map = "normal=";
  d.options.from_depth = 1;
  d.json = 0;
  reading r = dump_reading(&d);
  assert_true(r.seen.fitted && !r.seen.placed);
  assert_near(r.map.camera.fx / d.s.camera.fx, 1, 1e-3);
  dump_done(&d, &r);
  d = begin(SCENE_ROOM);
  d.img.x = 30;
  d.img.y = 20;
  d.img.display = (image_window){0, 0, 2 * WIDTH, 2 * HEIGHT};
  d.json = 0;
  r = dump_reading(&d);
  assert_near(r.seen.file.cx, d.s.camera.cx + 30, 0.05);
  assert_near(r.seen.file.cy, d.s.camera.cy + 20, 0.05);
  assert_near(r.camera.cx, d.s.camera.cx, 0.05);
  dump_done(&d, &r);
}

/* Positions on one plane tell no camera without a depth that is distance. */
TEST(a_single_plane_tells_nothing) {
  fit_points p = {.width = WIDTH, .height = HEIGHT};
  for (int y = 0; y < 40; y++)
    for (int x = 0; x < 40; x++) {
      const double z = 5 + 0.02 * y;
      p.list[p.count++] = (fit_point){
          .x = 3 * x, .y = 1.5 * y, .at = {x * z / 50, y * z / 50, z}};
    }
  for (size_t i = 0; i < p.count; i++) /* a plane, indeed */
    p.list[i].at[2] = 0.3 * p.list[i].at[0] + 0.1 * p.list[i].at[1] + 4;
  assert_false(camera_fit_find(&p).found);
}

/* ------------------------------------------------------------------------ */
/* Wrong cameras                                                             */

typedef enum mistake {
  FOCUS,
  CENTRE,
  AXES,
  FORWARD,
  MOVED,
  TURNED,
  MISTAKES
} mistake;

static void spoil(hbil_camera *c, mistake m) {
  double *w = c->world_from_view;
  const double cosine = cos(0.1), sine = sin(0.1);
  switch (m) {
  case FOCUS:
    c->fx *= 1.3;
    c->fy *= 1.3;
    break;
  case CENTRE:
    c->cx += 15;
    break;
  case AXES: /* y up in place of z up */
    for (int k = 0; k < 4; k++) {
      const double y = w[4 + k];
      w[4 + k] = w[8 + k];
      w[8 + k] = -y;
    }
    break;
  case FORWARD: /* the axes of OpenCV, taken for those of OpenGL */
    for (int r = 0; r < 3; r++) {
      w[4 * r + 1] = -w[4 * r + 1];
      w[4 * r + 2] = -w[4 * r + 2];
    }
    break;
  case MOVED:
    w[7] += 0.4;
    w[3] += 0.3;
    break;
  default:
    for (int k = 0; k < 3; k++) {
      const double x = w[k], y = w[4 + k];
      w[k] = cosine * x - sine * y;
      w[4 + k] = sine * x + cosine * y;
    }
  }
}

TEST_WITH_BOTH_CAMERAS(wrong_cameras_are_named) {
  static const char *const texts[MISTAKES] = {
      "focal length", "centre is",        "are x, -z, y of it",
      "OpenGL",       "camera stands 0.", "turned by 5.7 degrees"};
  for (int m = 0; m < MISTAKES; m++)
    for (int reach = 0; reach < 2; reach++) {
      dump d = begin(SCENE_ROOM);
      if (dump_orthographic && m == CENTRE)
        continue; /* the same as a moved camera */
      disturb(&d, 0.5 * reach, 0);
      spoil(&d.s.camera, (mistake)m);
      reading r = dump_reading(&d);
      const findings *found = &r.check.found;
      if (found->count != 1 || !strstr(found->text[0], texts[m]))
        fail_msg("%s: %d findings, %s", texts[m], found->count,
                 found->count ? found->text[0] : "");
      assert_non_null(strstr(found->text[0], "--camera positions"));
      dump_done(&d, &r);
    }
}

/* Samples that lie anywhere in their pixels, and some mixtures, are sound. */
TEST_WITH_BOTH_CAMERAS(right_cameras_have_no_findings) {
  for (int scene = SCENE_ROOM; scene <= SCENE_SKY; scene++) {
    dump d = begin((scene_kind)scene);
    disturb(&d, 0.5, 0.05);
    reading r = dump_reading(&d);
    assert_no_findings(&r);
    dump_done(&d, &r);
  }
}

/* ------------------------------------------------------------------------ */
/* Fisheyes and panoramas                                                    */

/* Of a room of 4 x 6 x 3, seen from its inside. */
static void hit_room(const double u[3], double out[3], double *depth) {
  static const double half[3] = {2, 3, 1.5};
  *depth = INFINITY;
  for (int c = 0; c < 3; c++)
    *depth = fmin(*depth, fabs(half[c] / u[c]));
  for (int c = 0; c < 3; c++)
    out[c] = 1 + *depth * u[c];
}

/* Looks along y.  equirectangular: all around. */
static void look(int panorama, double x, double y, double u[3]) {
  if (panorama) {
    const double azimuth = 2 * PI * (x / WIDTH - 0.5);
    const double elevation = -PI * (y / HEIGHT - 0.5);
    u[0] = sin(azimuth) * cos(elevation);
    u[1] = cos(azimuth) * cos(elevation);
    u[2] = sin(elevation);
  } else {
    const double right = x - 0.5 * WIDTH, up = 0.5 * HEIGHT - y;
    const double r = hypot(right, up) + 1e-9;
    const double angle = PI * r / WIDTH;
    u[0] = sin(angle) * right / r;
    u[1] = cos(angle);
    u[2] = sin(angle) * up / r;
  }
}

TEST(curved_pictures_are_named) {
  for (int panorama = 0; panorama < 2; panorama++) {
    dump d = dump_begin_plain(SCENE_ROOM);
    dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
    for (size_t i = 0; i < PIXELS; i++) {
      double u[3], at[3], depth;
      look(panorama, (double)(i % WIDTH) + 0.5, (double)(i / WIDTH) + 0.5, u);
      hit_room(u, at, &depth);
      dump_plane(&d, "depth.Z")[i] = (float)depth;
      for (int c = 0; c < 3; c++)
        d.img.planes[4 + c].pixels[i] = (float)at[c];
    }
    reading r = dump_reading(&d);
    const char *kind = panorama ? "is a panorama" : "is a fisheye";
    int named = 0;
    for (int i = 0; i < r.check.found.count; i++)
      named += strstr(r.check.found.text[i], kind) != NULL;
    assert_int_equal(named, 1);
    dump_done(&d, &r);
  }
}

/* One plane tells no camera, and is no fisheye, either. */
TEST(single_planes_are_no_fisheyes) {
  for (int turned = 0; turned < 2; turned++) {
    dump d = dump_begin_plain(SCENE_ROOM);
    const hbil_camera *k = &d.s.camera;
    const double *m = k->world_from_view;
    dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
    for (size_t i = 0; i < PIXELS; i++) {
      const double v[3] = {((double)(i % WIDTH) + 0.5 - k->cx) / k->fx,
                           ((double)(i / WIDTH) + 0.5 - k->cy) / k->fy, 1};
      const double z = 5 / (1 + 0.2 * turned * v[0]);
      dump_plane(&d, "depth.Z")[i] = (float)z;
      for (int c = 0; c < 3; c++)
        d.img.planes[4 + c].pixels[i] =
            (float)(m[4 * c + 3] + z * (m[4 * c] * v[0] + m[4 * c + 1] * v[1] +
                                        m[4 * c + 2] * v[2]));
    }
    d.options.from_depth = 1;
    reading r = dump_reading(&d);
    assert_no_findings(&r);
    reading_free(&r);
    /* nor with a wrong camera */
    d.s.camera.fx *= 1.2;
    d.s.camera.fy *= 1.2;
    r = dump_reading(&d);
    dump_done(&d, &r);
  }
}
