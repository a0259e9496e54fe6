/*
 * Orthographic cameras: the ways to describe one in a header, in a side-car and
 * by options, and that the project's own scenes are what such a camera sees.
 */
#include "test/support/dump_file.h"

#include <stdio.h>
#include <unistd.h>

/* Where the axis is in a picture of -1..1. */
static const double no_offset[] = {0, 0};

/* A header in centimetres, with a camera matrix that is scaled by two. */
TEST_WITH_ORTHOGRAPHIC_CAMERA(headers_have_their_own_units) {
  dump d = dump_begin(SCENE_ROOM);
  hbil_camera *c = &d.s.camera;
  image_matrices *m = &d.img.matrices;
  dump_add_depth(&d, "depth", "Z", 100, 0);
  dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_WORLD, 0);
  c->fx /= 100;
  c->fy /= 100;
  for (int i = 0; i < 3; i++)
    c->world_from_view[4 * i + 3] *= 100;
  dump_add_matrices(&d, AXES_WORLD, AXES_OPENGL, 2 * c->fx / WIDTH,
                    2 * c->fy / HEIGHT, no_offset, 1);
  for (int i = 0; i < 16; i++)
    m->world_to_camera[i] *= i == 15 ? 1 : 2;
  c->fx *= 100;
  c->fy *= 100;
  d.options.unit = 0.01f;
  reading r = dump_reading(&d);
  assert_same_geometry(&d, &r, MATRIX_ROUNDING);
  for (int i = 0; i < 3; i++)
    assert_true(fabs(r.map.camera.world_from_view[4 * i + 3] -
                     0.01 * c->world_from_view[4 * i + 3]) < 1e-5);
  assert_no_findings(&r);
  dump_done(&d, &r);
}

/* Options overrule the file's projection, and a file that is read with the
 * wrong projection has findings. */
TEST_WITH_ORTHOGRAPHIC_CAMERA(options_choose_the_lens) {
  dump d = dump_begin_plain(SCENE_ROOM);
  const double fx = d.s.camera.fx;
  dump_write(&d);
  d.options.fov = 60;
  reading r = dump_read(&d);
  assert_int_equal(r.config.inputs.projection, HBIL_PROJECTION_PERSPECTIVE);
  assert_true(fabs(r.map.camera.fx - 0.5 * WIDTH / tan(PI / 6)) < 1e-9);
  assert_true(r.check.found.count > 0);
  reading_free(&r);
  dump_orthographic = 0; /* the file's camera */
  dump_write(&d);
  dump_orthographic = 1;
  d.options.fov = 0;
  d.options.orthographic = (float)(WIDTH / fx);
  r = dump_read(&d);
  assert_same_geometry(&d, &r, ROUNDING);
  assert_no_findings(&r);
  dump_done(&d, &r);
}

TEST(one_lens_is_given) {
  static const option_group group = SOURCE_GROUP;
  const option_command command = {.groups = &group, .group_count = 1};
  char *argv[] = {(char[]){"test"}, (char[]){"--fov=60"},
                  (char[]){"--orthographic=2"}, NULL};
  source_options options;
  options_given given;
  image_error error;
  source_options_init(&options);
  assert_int_equal(options_read(&command, 3, argv, &options, &given, &error),
                   -1);
  assert_non_null(strstr(error.text, "--fov: not with --orthographic"));
}

static int read_json(const char *path, const char *text, camera_file *out,
                     image_error *error) {
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fprintf(file,
          "{\"camera_to_world\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]], "
          "\"cx\": 3, \"cy\": 2, %s}",
          text);
  fclose(file);
  return camera_read(path, out, error);
}

TEST(side_cars_state_the_scale_in_two_ways) {
  static const struct {
    const char *text;
    double scale;      /* 0: rejected, */
    const char *error; /* with this */
  } cases[] = {
      {"\"projection\": \"orthographic\", \"fx\": 50, \"fy\": 50", 50, NULL},
      {"\"projection\": \"orthographic\", \"ortho_scale\": 4, "
       "\"resolution\": [200, 100]",
       50, NULL},
      {"\"projection\": \"orthographic\", \"ortho_scale\": 4, "
       "\"resolution\": [100, 200]",
       50, NULL},
      /* Blender has one for every camera */
      {"\"ortho_scale\": 6, \"fx\": 50, \"fy\": 50", 50, NULL},
      {"\"projection\": \"orthographic\", \"ortho_scale\": 4", 0,
       "field resolution is missing"},
      {"\"projection\": \"orthographic\", \"ortho_scale\": 4, \"fx\": 50, "
       "\"resolution\": [100, 200]",
       0, "either it, or fx and fy"},
      {"\"projection\": \"orthographic\", \"ortho_scale\": 0, "
       "\"resolution\": [100, 200]",
       0, "field ortho_scale is wrong; a positive number"},
      {"\"projection\": \"orthographic\", \"ortho_scale\": 1e-9, "
       "\"resolution\": [100, 200]",
       0, "1e-6 to 1e9 pixels to a world unit"},
      {"\"projection\": \"orthographic\", \"resolution\": [100, 200]", 0,
       "field fx is missing"},
      {"\"projection\": \"panoramic\", \"fx\": 50, \"fy\": 50", 0,
       "\"perspective\" or \"orthographic\" is needed"},
      {"\"projection\": 3, \"fx\": 50, \"fy\": 50", 0,
       "field projection is wrong"},
  };
  char path[128];
  snprintf(path, sizeof path, "%s/camera.json", dump_folder);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    camera_file camera;
    image_error error = {""};
    const int failed = read_json(path, cases[i].text, &camera, &error);
    if (cases[i].error ? !strstr(error.text, cases[i].error) : failed)
      fail_msg("%s: %s", cases[i].text, error.text);
    assert_int_equal(failed != 0, cases[i].error != NULL);
    if (failed)
      continue;
    assert_true(fabs(camera.fx - cases[i].scale) < 1e-9);
    assert_true(fabs(camera.fy - cases[i].scale) < 1e-9);
    assert_int_equal(camera.orthographic,
                     strstr(cases[i].text, "orthographic") != NULL);
  }
  unlink(path);
}

/* What a pixel's ray comes to in the world, z away. */
static void leads_to(const hbil_camera *c, size_t x, size_t y, double z,
                     double out[3]) {
  const double right = ((double)x + 0.5 - c->cx) / c->fx;
  const double down = ((double)y + 0.5 - c->cy) / c->fy;
  const double *m = c->world_from_view;
  for (int k = 0; k < 3; k++)
    out[k] = m[4 * k] * right + m[4 * k + 1] * down + m[4 * k + 2] * z +
             m[4 * k + 3];
}

/* Where a camera sees a point, and how far away. */
static void seen_at(const hbil_camera *c, const double p[3], double out[3]) {
  const double *m = c->world_from_view;
  for (int k = 0; k < 3; k++) {
    out[k] = 0;
    for (int i = 0; i < 3; i++)
      out[k] += m[4 * i + k] * (p[i] - m[4 * i + 3]);
  }
  out[0] = c->cx + c->fx * out[0];
  out[1] = c->cy + c->fy * out[1];
}

/*
 * The room's floor is z = 0, its yellow sphere of radius .17 is where world.c
 * has put it: the one has the depth at which a ray meets that plane, the other
 * a round outline of .17 fx pixels, and what stands still has moved from where
 * the last camera sees it.  1e-6: floats of some metres.
 */
TEST(scenes_are_what_the_camera_sees) {
  enum { WIDE = 320, HIGH = 180 };
  const double centre[3] = {0.8, 1.2, 0.745 + 0.17}, radius = 0.17;
  scene_frame s, before;
  assert_int_equal(scene_render_orthographic(SCENE_ROOM, WIDE, HIGH, 0, 7, &s),
                   0);
  assert_int_equal(
      scene_render_orthographic(SCENE_ROOM, WIDE, HIGH, 0, 6, &before), 0);
  assert_int_equal(s.projection, HBIL_PROJECTION_ORTHOGRAPHIC);
  const double *m = s.camera.world_from_view;
  double at[3], outline[3];
  size_t floor = 0, sphere = 0;
  seen_at(&s.camera, centre, outline);
  for (size_t i = 0; i < (size_t)WIDE * HIGH; i++) {
    const size_t x = i % WIDE, y = i / WIDE;
    const double p[3] = {s.position[0][i], s.position[1][i], s.position[2][i]};
    assert_true(s.depth[i] > 0);
    leads_to(&s.camera, x, y, (double)s.depth[i], at);
    double facing = 0, away = 0;
    for (int k = 0; k < 3; k++) {
      assert_true(fabs(at[k] - p[k]) < 1e-6);
      facing += m[4 * k + 2] * (double)s.normal[k][i];
      away += (p[k] - centre[k]) * (p[k] - centre[k]);
    }
    assert_true(facing <= 0);
    const double from_middle =
        hypot((double)x + 0.5 - outline[0], (double)y + 0.5 - outline[1]);
    const int on_sphere = fabs(sqrt(away) - radius) < 1e-6;
    if (fabs(from_middle - radius * s.camera.fx) > 1e-3)
      assert_int_equal(on_sphere, from_middle < radius * s.camera.fx);
    sphere += (size_t)on_sphere;
    if (!(fabs(p[2]) < 1e-6))
      continue;
    floor++;
    leads_to(&s.camera, x, y, 0, at);
    assert_true(fabs((double)s.depth[i] + at[2] / m[10]) < 1e-6);
    seen_at(&before.camera, p, at);
    assert_true(fabs(at[0] - (double)x - 0.5 - (double)s.motion[0][i]) < 1e-3);
    assert_true(fabs(at[1] - (double)y - 0.5 - (double)s.motion[1][i]) < 1e-3);
  }
  assert_true(floor > WIDE * HIGH / 10);
  assert_true(sphere > 500);
  scene_free(&before);
  scene_free(&s);
}
