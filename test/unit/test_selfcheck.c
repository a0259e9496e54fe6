/*
 * What people get wrong about their dumps is found, and the message names the
 * option that helps; dumps without mistakes produce no findings.
 */
#include "test/support/dump_file.h"

#include <stdio.h>

/* Where the axis is in a picture of 0..1. */
static const double half_picture[] = {0.5, 0.5};

/* There are `count` findings, and the last one has the text. */
static void finds_last(dump *d, int count, const char *text) {
  dump_write(d);
  reading r = dump_read(d);
  const findings *check = &r.check.found;
  for (int i = 0; i < check->count; i++)
    if (!strstr(check->text[i], text) || check->count != count)
      print_error("found: %s\n", check->text[i]);
  assert_int_equal(check->count, count);
  assert_non_null(strstr(check->text[count - 1], text));
  reading_free(&r);
  dump_end(d);
}

static void finds(dump *d, const char *text) {
  finds_last(d, 1, text);
}

TEST_WITH_BOTH_CAMERAS(dumps_without_mistakes_have_no_findings) {
  for (int scene = 0; scene < SCENE_KINDS; scene++) {
    const uint32_t sizes[][2] = {{33, 17}, {64, 48}, {160, 90}, {480, 270}};
    for (int k = 0; k < 4; k++) {
      dump d =
          dump_begin_sized((scene_kind)scene, sizes[k][0], sizes[k][1], 0.0);
      dump_add_depth(&d, "depth", "Z", 1, 0);
      dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_WORLD, 0);
      dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD,
                       1);
      dump_add_colour(&d, "albedo", letters_rgb, d.s.albedo, NULL, 1);
      dump_add_colour(&d, "direct", letters_rgb, d.s.direct, NULL, 1);
      reading r = dump_reading(&d);
      assert_no_findings(&r);
      assert_true(r.check.facing > 0.999);
      dump_done(&d, &r);
    }
  }
}

TEST(finds_ray_for_planar_depth) {
  for (int ray = 0; ray < 2; ray++) {
    dump d = dump_begin_plain(SCENE_ROOM);
    d.options.depth = ray ? DEPTH_PLANAR : DEPTH_RAY;
    float *z = dump_plane(&d, "depth.Z");
    for (size_t i = 0; ray && i < PIXELS; i++)
      z[i] *= (float)dump_ray_length(&d, i);
    finds(&d, ray ? "--depth ray" : "--depth planar");
  }
}

TEST(finds_it_by_positions_too) {
  dump d = dump_begin_plain(SCENE_ROOM);
  dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
  float *z = dump_plane(&d, "depth.Z");
  for (size_t i = 0; i < PIXELS; i++)
    z[i] *= (float)dump_ray_length(&d, i);
  reading r = dump_reading(&d);
  assert_int_equal(r.check.found.count, 2);
  assert_non_null(strstr(r.check.found.text[1], "--depth ray"));
  dump_done(&d, &r);
}

TEST_WITH_BOTH_CAMERAS(finds_normals_of_another_space) {
  dump d = dump_begin(SCENE_ROOM);
  dump_add_depth(&d, "depth", "Z", 1, 0);
  dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_OPENGL, 0);
  finds(&d, "--normals camera");
  d = dump_begin(SCENE_ROOM);
  dump_add_depth(&d, "depth", "Z", 1, 0);
  dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_LEFT_HANDED, 0);
  finds(&d, "--normals camera --flip z");
  d = dump_begin(SCENE_ROOM);
  dump_add_depth(&d, "depth", "Z", 1, 0);
  dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_MIRRORED, 0);
  finds(&d, "--normals world --flip x");
  d = dump_begin_plain(SCENE_ROOM);
  d.options.normals = SPACE_CAMERA;
  finds(&d, "--normals world");
}

TEST(finds_encoded_normals) {
  dump d = dump_begin_plain(SCENE_ROOM);
  for (size_t p = 1; p < 4; p++)
    for (size_t i = 0; i < PIXELS; i++)
      d.img.planes[p].pixels[i] = 0.5f * d.img.planes[p].pixels[i] + 0.5f;
  finds(&d, "--normals encoded");
}

/* The camera is turned by five degrees about the vertical, or stands
 * elsewhere. */
TEST_WITH_BOTH_CAMERAS(finds_the_camera_of_another_frame) {
  dump d = dump_begin_plain(SCENE_ROOM);
  double *m = d.s.camera.world_from_view;
  const double c = cos(5 * PI / 180), s = sin(5 * PI / 180);
  for (int j = 0; j < 3; j++) {
    const double x = m[j], y = m[4 + j];
    m[j] = c * x - s * y;
    m[4 + j] = s * x + c * y;
  }
  finds(&d, "turned by 5.0 degrees: the camera of another frame");
  d = dump_begin_plain(SCENE_ROOM);
  dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
  d.s.camera.world_from_view[7] += 0.3;
  finds(&d, "the camera of another frame");
}

TEST_WITH_BOTH_CAMERAS(finds_other_units) {
  dump d = dump_begin_plain(SCENE_ROOM);
  dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
  for (size_t p = 0; p < d.img.count; p++)
    for (size_t i = 0; i < PIXELS && (p == 0 || p > 3); i++)
      d.img.planes[p].pixels[i] *= 100.0f;
  /* the pixels of parallel rays have the same size while depth is stretched */
  finds_last(&d, dump_orthographic ? 2 : 1, "--unit-scale 0.01 ");
  d = dump_begin_plain(SCENE_ROOM); /* positions alone */
  dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
  for (size_t p = 4; p < d.img.count; p++)
    for (size_t i = 0; i < PIXELS; i++)
      d.img.planes[p].pixels[i] *= 100.0f;
  finds(&d, "100 times as far");
}

TEST_WITH_BOTH_CAMERAS(finds_a_radius_of_other_units) {
  dump d = dump_begin_plain(SCENE_ROOM);
  reading r = dump_reading(&d);
  const struct {
    float radius;
    const char *text; /* NULL: nothing */
  } cases[] = {{1.0f, NULL},
               {0.05f, NULL},
               {INFINITY, NULL},
               {100.0f, "larger than all that is seen"},
               {0.001f, "less than a pixel"}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    r.config.model.radius = cases[i].radius;
    frame_check_run(&r.g, &r.config, &r.map.camera, &r.check);
    assert_int_equal(r.check.found.count, cases[i].text != NULL);
    if (cases[i].text)
      assert_non_null(strstr(r.check.found.text[0], cases[i].text));
  }
  r.config.model.radius = INFINITY;
  r.config.model.ao_radius = 100.0f;
  frame_check_run(&r.g, &r.config, &r.map.camera, &r.check);
  assert_int_equal(r.check.found.count, 1);
  assert_non_null(strstr(r.check.found.text[0], "--ao-radius"));
  dump_done(&d, &r);
}

TEST(finds_gamma_encoded_albedo) {
  for (int answer = 0; answer < 2; answer++) {
    dump d = dump_begin_plain(SCENE_ROOM);
    /* of many colours, as a textured picture has */
    for (size_t c = 0; c < 3; c++) {
      float *out = dump_add_plane(&d, "albedo", letters_rgb[c]);
      for (size_t i = 0; i < PIXELS; i++)
        out[i] = (float)((i * 7 + c) % 256) / 255.0f;
    }
    if (!answer) {
      finds(&d, "albedo has whole parts of 255");
      continue;
    }
    dump_add_colour(&d, "direct", letters_rgb, d.s.direct, NULL, 1);
    d.options.gamma = 1;
    reading r = dump_reading(&d);
    assert_no_findings(&r);
    assert_true(
        fabs((double)gbuffer_plane(&r.g, ROLE_ALBEDO, 0)[128 * 183 % 256] -
             0.21586) < 1e-4); /* 7 i = 128: sRGB's middle grey */
    /* light that is floats is linear all the same */
    assert_true(
        reading_colour_error(&d, &r, ROLE_DIRECT, d.s.direct, 1, NULL) == 0);
    dump_done(&d, &r);
  }
}

/* Recognized by its name, or by light at sky pixels. */
TEST(finds_a_finished_picture_as_direct_light) {
  dump d = dump_begin_plain(SCENE_ROOM);
  dump_add_colour(&d, "Combined", letters_rgb, d.s.direct, NULL, 1);
  d.options.map = "direct=Combined";
  finds(&d, "finished picture");
  d = dump_begin_plain(SCENE_SKY);
  dump_add_colour(&d, "direct", letters_rgb, d.s.direct, NULL, 1);
  for (size_t p = 4; p < 7; p++)
    for (size_t i = 0; i < PIXELS; i++)
      if (dump_is_sky(&d, i))
        d.img.planes[p].pixels[i] = 0.5f;
  finds(&d, "finished picture");
}

/* The name of a view layer stands before all of its passes. */
TEST(a_view_layer_called_beauty_is_no_picture) {
  static const char *const layers[] = {"beauty", "Beauty Pass.001",
                                       "RGBA combined"};
  for (size_t i = 0; i < sizeof layers / sizeof *layers; i++) {
    char name[64];
    dump d = dump_begin(SCENE_ROOM);
    snprintf(name, sizeof name, "%s.Depth", layers[i]);
    dump_add_depth(&d, name, "Z", 1, 1e10f);
    snprintf(name, sizeof name, "%s.Normal", layers[i]);
    dump_add_vectors(&d, name, letters_xyz, d.s.normal, AXES_WORLD, 0);
    snprintf(name, sizeof name, "%s.DiffCol", layers[i]);
    dump_add_colour(&d, name, letters_rgb, d.s.albedo, NULL, 1);
    snprintf(name, sizeof name, "%s.DiffDir", layers[i]);
    dump_add_colour(&d, name, letters_rgb, d.s.direct, NULL, 1 / PI);
    reading r = dump_reading(&d);
    assert_int_equal(r.map.kind, DUMP_CYCLES);
    assert_no_findings(&r);
    dump_done(&d, &r);
  }
}

TEST_WITH_BOTH_CAMERAS(finds_device_depth) {
  dump d = dump_begin_plain(SCENE_ROOM);
  float *z = dump_plane(&d, "depth.Z");
  for (size_t i = 0; i < PIXELS; i++)
    z[i] = dump_is_sky(&d, i)  ? 0.0f
           : dump_orthographic ? z[i] / 100
                               : 1.0f - 0.1f / z[i];
  finds(&d, "--depth device");
  d = dump_begin_plain(SCENE_ROOM);
  memset(dump_plane(&d, "depth.Z"), 0, sizeof(float) * PIXELS);
  finds(&d, "no pixel has a depth: ");
  for (int reversed = 0; reversed < 2; reversed++) {
    d = dump_begin_plain(SCENE_ROOM);
    d.options.depth = reversed ? DEPTH_REVERSED : DEPTH_DEVICE;
    d.options.clip[0] = 0.1f;
    d.options.clip[1] = 100.0f;
    finds(&d, "depths above 1, up to ");
  }
  d = dump_begin_plain(SCENE_ROOM);
  d.options.sky_depth = 0.001f;
  finds(&d, "all depths are those of the sky");
}

/* The message says what is impossible, and what would help. */
TEST(unusable_input_is_rejected) {
  static const struct {
    const char *map;
    const char *text;
  } cases[] = {
      {"depth=gone", "--map depth=gone: "},
      {"depth", "ROLE=LAYER is needed"},
      {"shine=depth", "ROLE one of depth"},
      {"normal=", "no normals"},
      {"depth=gone.exr:Z", "gone.exr: cannot be read"},
  };
  reading r;
  image_error error;
  dump d = dump_begin_plain(SCENE_ROOM);
  dump_write(&d);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    d.options.map = cases[i].map;
    assert_int_not_equal(dump_try_reading(&d, &r, &error), 0);
    if (!strstr(error.text, cases[i].text))
      fail_msg("%s: %s", cases[i].map, error.text);
  }
  dump_end(&d);
  /* oblique rays; no camera at all; one that doesn't say where it stands */
  d = dump_begin_plain(SCENE_ROOM);
  dump_add_matrices(&d, AXES_WORLD, AXES_OPENGL, 1, 1, half_picture, 0);
  double *w = d.img.matrices.world_to_ndc + 12;
  w[0] = w[1] = w[2] = 0;
  w[3] = 1;
  dump_write(&d);
  assert_int_not_equal(dump_try_reading(&d, &r, &error), 0);
  assert_non_null(strstr(error.text, "no perspective and no orthographic"));
  d.img.matrices.has_camera = 0;
  dump_write(&d);
  assert_int_not_equal(dump_try_reading(&d, &r, &error), 0);
  assert_non_null(strstr(error.text, "--fov"));
  d.options.fov = 60.0f;
  assert_int_not_equal(dump_try_reading(&d, &r, &error), 0);
  assert_non_null(strstr(error.text, "how the camera is turned"));
  dump_end(&d);
}

TEST_WITH_ORTHOGRAPHIC_CAMERA(finds_a_picture_of_another_size) {
  dump d = dump_begin_plain(SCENE_ROOM);
  d.options.orthographic = (float)(4 * WIDTH / d.s.camera.fx);
  finds(&d, "--orthographic");
}

/* With an orthographic camera, no check may depend on how far away the camera
 * stands. */
TEST_WITH_ORTHOGRAPHIC_CAMERA(distant_cameras_have_no_findings) {
  enum { AWAY = 1000 };
  for (int elsewhere = 0; elsewhere < 2; elsewhere++) {
    dump d = dump_begin_plain(SCENE_ROOM);
    double *m = d.s.camera.world_from_view;
    dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
    float *z = dump_plane(&d, "depth.Z");
    for (size_t i = 0; i < PIXELS; i++)
      z[i] += AWAY;
    for (int k = 0; k < 3; k++)
      m[4 * k + 3] -= AWAY * m[4 * k + 2] - (elsewhere ? 0.3 * m[4 * k] : 0);
    if (elsewhere) {
      finds(&d, "the camera of another frame");
      continue;
    }
    reading r = dump_reading(&d);
    r.config.model.radius = 0.05f;
    frame_check_run(&r.g, &r.config, &r.map.camera, &r.check);
    assert_no_findings(&r);
    dump_done(&d, &r);
  }
}

/* Slats of eight rows that begin in the camera's plane. They are straight in
 * depth, but not in inverse depth. */
TEST_WITH_ORTHOGRAPHIC_CAMERA(steep_slats_have_no_findings) {
  enum { SLAT = 8 };
  const double slope = 2; /* depth along the picture */
  const double length = sqrt(slope * slope + 1);
  dump d = dump_begin(SCENE_ROOM);
  dump_add_plane(&d, "depth", "Z");
  for (int c = 0; c < 3; c++) {
    float *n = dump_add_plane(&d, "normal", letters_xyz[c]);
    for (size_t i = 0; i < PIXELS; i++)
      n[i] = (float)((c == 0 ? 0 : c == 1 ? -slope : 1) / length);
  }
  float *z = dump_plane(&d, "depth.Z");
  for (size_t i = 0; i < PIXELS; i++)
    z[i] = (float)(slope * ((double)(i / WIDTH % SLAT) + 0.1) / d.s.camera.fy);
  d.options.normals = SPACE_CAMERA;
  reading r = dump_reading(&d);
  assert_true(r.check.agreement > 0.999);
  assert_no_findings(&r);
  dump_done(&d, &r);
}
