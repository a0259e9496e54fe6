/*
 * Renderers' dumps: a scene that is written in the layout of each renderer is
 * read back as the same planes, whatever kind of depth, normals and windows it
 * has.
 */
#include "image/png_write.h"

#include "test/support/dump_file.h"

#include <stdio.h>
#include <unistd.h>

/* Where the axis is in a picture of 0..1, and of -1..1. */
static const double half_picture[] = {0.5, 0.5};
static const double no_offset[] = {0, 0};

/* ------------------------------------------------------------------------ */
/* The layouts                                                               */

TEST_WITH_BOTH_CAMERAS(reads_blender) {
  for (int scene = 0; scene < SCENE_KINDS; scene++) {
    dump d = dump_begin((scene_kind)scene);
    dump_add_depth(&d, "ViewLayer.Depth", "Z", 1, 1e10f);
    dump_add_vectors(&d, "ViewLayer.Normal", letters_xyz, d.s.normal,
                     AXES_WORLD, 0);
    dump_add_vectors(&d, "ViewLayer.Position", letters_xyz, d.s.position,
                     AXES_WORLD, 1);
    dump_add_colour(&d, "ViewLayer.DiffCol", letters_rgb, d.s.albedo, NULL, 1);
    dump_add_colour(&d, "ViewLayer.DiffDir", letters_rgb, d.s.direct, NULL,
                    1 / PI);
    dump_add_colour(&d, "ViewLayer.Emit", letters_rgb, d.s.emission, NULL, 1);
    float *x = dump_add_plane(&d, "ViewLayer.Vector", "X");
    float *y = dump_add_plane(&d, "ViewLayer.Vector", "Y");
    for (size_t i = 0; i < PIXELS; i++) {
      x[i] = d.s.motion[0][i];
      y[i] = -d.s.motion[1][i];
    }
    reading r = dump_reading(&d);
    assert_int_equal(r.map.kind, DUMP_CYCLES);
    assert_same_geometry(&d, &r, ROUNDING);
    assert_same_light(&d, &r);
    for (size_t i = 0; i < PIXELS; i++)
      for (size_t c = 0; c < 2; c++)
        assert_true(gbuffer_plane(&r.g, ROLE_MOTION, c)[i] *
                        r.config.inputs.motion_scale[c] ==
                    d.s.motion[c][i]);
    assert_true(r.check.positions < 1e-5);
    assert_no_findings(&r);
    dump_done(&d, &r);
  }
}

/* EEVEE's sky has the depth of the far plane, a little more. */
TEST_WITH_BOTH_CAMERAS(the_far_plane_of_eevee_is_sky) {
  const double far = 1000;
  for (int said = 0; said < 2; said++) {
    dump d = dump_begin(SCENE_SKY);
    dump_add_depth(&d, "ViewLayer.Depth", "Z", 1, 1000.0725f);
    dump_add_vectors(&d, "ViewLayer.Normal", letters_xyz, d.s.normal,
                     AXES_WORLD, 0);
    d.near = 0.1;
    d.far = far;
    if (said)
      d.options.sky_depth = 1e9f;
    reading r = dump_reading(&d);
    assert_int_equal(r.map.kind, DUMP_CYCLES);
    assert_true(fabs((double)r.config.inputs.sky_depth -
                     (said ? 1e9 : far * (1 - 1e-3))) <= 1e-4 * far);
    if (!said)
      assert_same_geometry(&d, &r, ROUNDING);
    dump_done(&d, &r);
  }
}

/* Positions in camera space with z forwards; a left-handed world; matrices for
 * column vectors, with the same scale for width and height. */
TEST_WITH_BOTH_CAMERAS(reads_pbrt) {
  dump d = dump_begin(SCENE_ROOM);
  const double scale = d.s.camera.fx / HEIGHT;
  dump_add_vectors(&d, "P", letters_xyz, d.s.position, AXES_LEFT_HANDED, 1);
  dump_add_vectors(&d, "Ns", letters_xyz, d.s.normal, AXES_LEFT_HANDED, 0);
  dump_add_vectors(&d, "N", letters_xyz, d.s.normal, AXES_LEFT_HANDED, 0);
  dump_add_colour(&d, "Albedo", letters_rgb, d.s.albedo, NULL, 1);
  dump_add_depth(&d, "", "dzdx", 1, 0);
  dump_add_matrices(&d, AXES_MIRRORED, AXES_LEFT_HANDED, scale, scale,
                    half_picture, 0);
  reading r = dump_reading(&d);
  assert_int_equal(r.map.kind, DUMP_PBRT);
  assert_true(r.seen.mirrored);
  assert_same_geometry(&d, &r, MATRIX_ROUNDING);
  assert_no_findings(&r);
  reading_free(&r);
  /* and without matrices, from the angle of view or the size alone */
  d.img.matrices.has_camera = 0;
  if (dump_orthographic)
    d.options.orthographic = (float)(WIDTH / d.s.camera.fx);
  else
    d.options.fov = (float)(atan(0.5 * WIDTH / d.s.camera.fx) * 360 / PI);
  r = dump_reading(&d);
  assert_same_geometry(&d, &r, MATRIX_ROUNDING);
  dump_done(&d, &r);
}

/* Distances begin at the near plane. */
TEST_WITH_BOTH_CAMERAS(reads_mitsuba) {
  for (int with_positions = 0; with_positions < 2; with_positions++) {
    dump d = dump_begin(SCENE_ROOM);
    dump_add_ray(&d, "dd.y", "T", 0.25, 0);
    dump_add_vectors(&d, "sh_normal", letters_xyz, d.s.normal, AXES_WORLD, 0);
    dump_add_colour(&d, "albedo", letters_rgb, d.s.albedo, NULL, 1);
    if (with_positions)
      dump_add_vectors(&d, "pos", letters_xyz, d.s.position, AXES_WORLD, 1);
    d.options.clip[0] = 0.25f;
    d.options.clip[1] = 100.0f;
    reading r = dump_reading(&d);
    assert_int_equal(r.map.kind, DUMP_MITSUBA);
    assert_int_equal(r.map.how.depth,
                     with_positions ? DEPTH_POSITION : DEPTH_RAY);
    assert_same_geometry(&d, &r, ROUNDING);
    assert_no_findings(&r);
    dump_done(&d, &r);
  }
}

/* Matrices for row vectors, a picture of -1..1; planar or ray depth is found
 * out. */
TEST_WITH_BOTH_CAMERAS(reads_arnold) {
  for (int ray = 0; ray < 2; ray++) {
    dump d = dump_begin(SCENE_SKY);
    if (ray)
      dump_add_ray(&d, "", "Z", 0, 1e30f);
    else
      dump_add_depth(&d, "", "Z", 1, 1e30f);
    dump_add_vectors(&d, "N", letters_xyz, d.s.normal, AXES_WORLD, 0);
    dump_add_colour(&d, "diffuse_albedo", letters_rgb, d.s.albedo, NULL, 1);
    dump_add_colour(&d, "diffuse_direct", letters_rgb, d.s.direct, d.s.albedo,
                    1 / PI);
    dump_add_matrices(&d, AXES_WORLD, AXES_OPENGL, 2 * d.s.camera.fx / WIDTH,
                      2 * d.s.camera.fy / HEIGHT, no_offset, 1);
    reading r = dump_reading(&d);
    assert_int_equal(r.map.kind, DUMP_ARNOLD);
    assert_int_equal(r.map.how.depth,
                     ray && !dump_orthographic ? DEPTH_RAY : DEPTH_PLANAR);
    assert_same_geometry(&d, &r, MATRIX_ROUNDING);
    assert_same_light(&d, &r);
    assert_no_findings(&r);
    dump_done(&d, &r);
  }
}

TEST_WITH_BOTH_CAMERAS(reads_vray) {
  dump d = dump_begin(SCENE_ROOM);
  dump_add_depth(&d, "", "Z", 1, 65504.0f);
  dump_add_vectors(&d, "bump_normals", letters_xyz, d.s.normal, AXES_OPENGL, 0);
  dump_add_colour(&d, "diffuse", letters_words, d.s.albedo, NULL, 1);
  dump_add_colour(&d, "lighting", letters_words, d.s.direct, d.s.albedo,
                  1 / PI);
  reading r = dump_reading(&d);
  assert_int_equal(r.map.kind, DUMP_VRAY);
  assert_same_geometry(&d, &r, ROUNDING);
  assert_same_light(&d, &r);
  assert_no_findings(&r);
  dump_done(&d, &r);
}

/* A left-handed world, z forwards, a picture of 0..1 whose y runs down. */
TEST_WITH_BOTH_CAMERAS(reads_renderman) {
  dump d = dump_begin(SCENE_ROOM);
  dump_add_depth(&d, "", "z", 1, INFINITY);
  dump_add_vectors(&d, "__Nworld", letters_small_rgb, d.s.normal, AXES_MIRRORED,
                   0);
  dump_add_vectors(&d, "__Pworld", letters_small_rgb, d.s.position,
                   AXES_MIRRORED, 1);
  dump_add_colour(&d, "albedo", letters_small_rgb, d.s.albedo, NULL, 1);
  dump_add_colour(&d, "directDiffuse", letters_small_rgb, d.s.direct,
                  d.s.albedo, 1 / PI);
  dump_add_matrices(&d, AXES_MIRRORED, AXES_LEFT_HANDED, d.s.camera.fx / WIDTH,
                    -d.s.camera.fy / HEIGHT, half_picture, 1);
  reading r = dump_reading(&d);
  assert_int_equal(r.map.kind, DUMP_RENDERMAN);
  assert_same_geometry(&d, &r, MATRIX_ROUNDING);
  assert_same_light(&d, &r);
  assert_true(r.check.positions < 1e-4);
  assert_no_findings(&r);
  dump_done(&d, &r);
}

/* Centimetres; normals of a material that encodes them. */
TEST_WITH_BOTH_CAMERAS(reads_unreal) {
  dump d = dump_begin(SCENE_ROOM);
  dump_add_depth(&d, "FinalImageMovieRenderQueue_WorldDepth", "R", 100,
                 65504.0f);
  dump_add_vectors(&d, "FinalImageMovieRenderQueue_WorldNormal", letters_rgb,
                   d.s.normal, AXES_WORLD, 0);
  for (size_t p = 1; p < 4; p++)
    for (size_t i = 0; i < PIXELS; i++)
      if (!dump_is_sky(&d, i))
        d.img.planes[p].pixels[i] = 0.5f * d.img.planes[p].pixels[i] + 0.5f;
  dump_add_colour(&d, "FinalImageMovieRenderQueue_BaseColor", letters_rgb,
                  d.s.albedo, NULL, 1);
  d.options.unit = 0.01f;
  reading r = dump_reading(&d);
  assert_int_equal(r.map.kind, DUMP_UNREAL);
  assert_true(r.map.how.encoded);
  assert_same_geometry(&d, &r, ROUNDING);
  assert_no_findings(&r);
  dump_done(&d, &r);
}

/* ------------------------------------------------------------------------ */
/* Kinds of depth and normals                                                */

typedef struct depth_case {
  depth_kind kind;
  double scale, near, far;
  float sky;
} depth_case;

/* 1/z is stored, so a rounding changes z the more, the larger its ratio to the
 * near plane is. With an orthographic camera the rounding is that of the far
 * plane, relative to the nearest surface at 3. */
TEST_WITH_BOTH_CAMERAS(reads_device_depths) {
  const double near = 0.5, far = 200;
  const double rounding_of_z = 6e-8 * (dump_orthographic ? far / 3 : 90 / near);
  for (int reversed = 0; reversed < 2; reversed++) {
    dump d = dump_begin(SCENE_SKY);
    float *out = dump_add_plane(&d, "depth", "Z");
    for (size_t i = 0; i < PIXELS; i++) {
      const double z = dump_is_sky(&d, i) ? far : (double)d.s.depth[i];
      const double v = dump_orthographic ? (z - near) / (far - near)
                                         : far / (far - near) * (1 - near / z);
      out[i] = (float)(reversed ? 1 - v : v);
    }
    dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_WORLD, 0);
    d.options.depth = reversed ? DEPTH_REVERSED : DEPTH_DEVICE;
    d.options.clip[0] = (float)near;
    d.options.clip[1] = (float)far;
    reading r = dump_reading(&d);
    assert_true(reading_depth_error(&d, &r) <= rounding_of_z);
    assert_no_findings(&r);
    /* sky from half of the depth range on */
    const float half = d.s.projection == HBIL_PROJECTION_ORTHOGRAPHIC
                           ? 100.25f
                           : (float)(2 * near * far / (far + near));
    r.map.how.sky_depth = 0.5f;
    channel_map_configure(&r.map, &r.config);
    assert_true(fabsf(r.config.inputs.sky_depth / half - 1) < 2e-6f);
    r.map.how.sky_depth = 1e9f; /* that of another kind of depth */
    channel_map_configure(&r.map, &r.config);
    assert_true(isinf(r.config.inputs.sky_depth));
    reading_free(&r);
    d.options.clip[0] = 0.0f;
    d.options.clip[1] = dump_orthographic ? INFINITY : 0.0f;
    image_error error;
    assert_int_not_equal(dump_try_reading(&d, &r, &error), 0);
    assert_non_null(strstr(error.text, "--clip NEAR,FAR is needed"));
    dump_end(&d);
  }
}

/* Whether a plane that was read has the bits of a channel in the file. */
static int is_as_stored(const dump *d, const reading *r, role which, size_t c,
                        const char *name) {
  return memcmp(gbuffer_plane(&r->g, which, c), dump_plane((dump *)d, name),
                PIXELS * sizeof(float)) == 0;
}

/* Depth of every kind and normals with any signs go to the library as they are,
 * with a configuration that says what they are. */
TEST_WITH_BOTH_CAMERAS(planes_are_handed_over_as_stored) {
  static const struct {
    int depth;
    hbil_depth_kind kind;
    float unit, scale;
  } cases[] = {{DEPTH_PLANAR, HBIL_DEPTH_PLANAR, 0.01f, 0.01f},
               {DEPTH_RAY, HBIL_DEPTH_RAY, 0, 1},
               {DEPTH_DEVICE, HBIL_DEPTH_HARDWARE, 0, 1},
               {DEPTH_REVERSED, HBIL_DEPTH_HARDWARE, 0, 1}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    dump d = dump_begin(SCENE_SKY);
    double ab[2];
    dump_add_depth(&d, "depth", "Z", i < 2 ? 100 : 0.02, 0);
    dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_OPENGL, 0);
    d.options.depth = cases[i].depth;
    d.options.normals = SPACE_CAMERA;
    d.options.unit = cases[i].unit;
    d.options.clip[0] = 0.5f;
    d.options.clip[1] = 200.0f;
    reading r = dump_reading(&d);
    const hbil_inputs *in = &r.config.inputs;
    assert_true(is_as_stored(&d, &r, ROLE_DEPTH, 0, "depth.Z"));
    assert_true(is_as_stored(&d, &r, ROLE_NORMAL, 1, "normal.Y"));
    assert_int_equal(in->depth_kind, cases[i].kind);
    assert_true(in->depth_scale == cases[i].scale);
    assert_int_equal(in->normal_space, HBIL_SPACE_VIEW);
    assert_true(in->normal_scale[0] == 1 && in->normal_scale[1] == -1 &&
                in->normal_scale[2] == -1);
    channel_map_hardware_depth(&r.map, ab);
    assert_true((ab[1] != 0.0) == (in->depth_kind == HBIL_DEPTH_HARDWARE));
    dump_done(&d, &r);
  }
}

/* Channels named Z and N alone: depth counts backwards, the sky is the largest
 * half float, and normals are in camera space. All of it is found out. */
TEST_WITH_BOTH_CAMERAS(guesses_what_plain_letters_mean) {
  dump d = dump_begin(SCENE_SKY);
  dump_add_depth(&d, "", "Z", -1, -65504.0f);
  dump_add_vectors(&d, "N", letters_xyz, d.s.normal, AXES_OPENGL, 0);
  reading r = dump_reading(&d);
  assert_int_equal(r.map.kind, DUMP_PLAIN);
  assert_int_equal(r.guessed.count, 3);
  assert_same_geometry(&d, &r, ROUNDING);
  assert_no_findings(&r);
  dump_done(&d, &r);
}

TEST_WITH_BOTH_CAMERAS(options_have_the_last_word) {
  dump d = dump_begin(SCENE_SKY);
  float *const turned[3] = {d.s.normal[0], d.s.normal[1], d.s.normal[2]};
  dump_add_ray(&d, "far", "away", 0, 1000.0f);
  dump_add_vectors(&d, "odd", letters_words, turned, AXES_OPENGL, 0);
  dump_add_colour(&d, "paint", letters_rgb, d.s.albedo, NULL, 1);
  dump_add_colour(&d, "lamp", letters_rgb, d.s.direct, NULL, 1 / PI);
  for (size_t i = 0; i < PIXELS; i++)
    d.img.planes[2].pixels[i] *= -1.0f; /* odd.green */
  d.options.map = "depth=far.away,normal=odd,albedo=paint,direct=lamp";
  d.options.depth = DEPTH_RAY;
  d.options.normals = SPACE_CAMERA;
  d.options.encoded = 0;
  d.options.flips = 2;
  d.options.direct = DIRECT_LIGHT;
  d.options.sky_depth = 999.0f;
  reading r = dump_reading(&d);
  assert_same_geometry(&d, &r, ROUNDING);
  assert_same_light(&d, &r);
  assert_no_findings(&r);
  dump_done(&d, &r);
}

/* Depth, albedo and the rest are in files of their own; the albedo is a PNG. */
TEST(reads_one_file_a_pass) {
  dump d = dump_begin(SCENE_ROOM);
  dump depth = dump_begin(SCENE_ROOM);
  char png[128];
  image_error error;
  unsigned char bytes[3 * PIXELS];
  snprintf(depth.path, sizeof depth.path, "%s/z.0004.exr", dump_folder);
  snprintf(png, sizeof png, "%s/paint_0004.png", dump_folder);
  depth.json = 0;
  dump_add_depth(&depth, "Z", "", 1, 0);
  dump_write(&depth);
  for (size_t i = 0; i < 3 * PIXELS; i++) {
    const double v = (double)d.s.albedo[i % 3][i / 3];
    bytes[i] = (unsigned char)(255 * (v <= 0.0031308
                                          ? 12.92 * v
                                          : 1.055 * pow(v, 1 / 2.4) - 0.055) +
                               0.5);
  }
  assert_int_equal(
      png_write(png, bytes, WIDTH, HEIGHT, EXISTING_REPLACED, &error), 0);
  dump_add_vectors(&d, "N", letters_xyz, d.s.normal, AXES_WORLD, 0);
  d.options.map = "depth=z.#.exr:Z,albedo=paint_####.png";
  reading r = dump_reading(&d);
  assert_same_geometry(&d, &r, ROUNDING);
  /* half a step of eight bits, where sRGB is steepest for light colours: 2.4 */
  assert_true(reading_colour_error(&d, &r, ROLE_ALBEDO, d.s.albedo, 1, NULL) <=
              0.5 / 255 * 2.4);
  assert_no_findings(&r);
  reading_free(&r);
  unlink(png);
  dump_end(&depth);
  dump_end(&d);
}

/* A data window that is larger than the display window, then one that is
 * smaller. */
TEST_WITH_BOTH_CAMERAS(reads_display_and_data_windows) {
  enum { MORE = 10 };
  dump plain = dump_begin(SCENE_ROOM);
  const hbil_camera *same = &plain.s.camera;
  const double lens = dump_orthographic
                          ? (WIDTH + 2 * MORE) / same->fx
                          : 2 * atan((0.5 * HEIGHT + MORE) / same->fy);
  dump d =
      dump_begin_sized(SCENE_ROOM, WIDTH + 2 * MORE, HEIGHT + 2 * MORE, lens);
  dump_add_depth(&d, "depth", "Z", 1, 0);
  dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_WORLD, 0);
  d.img.x = 7 - MORE;
  d.img.y = 5 - MORE;
  d.img.display = (image_window){7, 5, WIDTH, HEIGHT};
  reading r = dump_reading(&d);
  assert_int_equal(r.map.display.width, WIDTH);
  assert_int_equal(r.g.planes.width, WIDTH + 2 * MORE);
  assert_same_geometry(&d, &r, ROUNDING);
  assert_no_findings(&r);
  /* the camera of the picture alone is the same one, elsewhere */
  assert_true(fabs(r.camera.cx - plain.s.camera.cx - MORE) < 1e-9);
  assert_true(fabs(r.camera.fx - plain.s.camera.fx) < 1e-6);
  dump_done(&d, &r);
  d = dump_begin(SCENE_ROOM);
  dump_add_depth(&d, "depth", "Z", 1, 0);
  dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_WORLD, 0);
  d.img.x = 30;
  d.img.y = 20;
  d.img.display = (image_window){0, 0, 2 * WIDTH, 2 * HEIGHT};
  r = dump_reading(&d);
  assert_same_geometry(&d, &r, ROUNDING);
  /* and placed in a window that another frame needs as well */
  gbuffer g;
  image_error error;
  r.map.window = (image_window){29, 21, WIDTH, HEIGHT + 1};
  assert_int_equal(gbuffer_read(d.path, &r.map, ~0u, &g, &error), 0);
  const float *depth = gbuffer_plane(&g, ROLE_DEPTH, 0);
  for (size_t y = 0; y <= HEIGHT; y++)
    for (size_t x = 0; x < WIDTH; x++) {
      const int inside = x > 0 && y + 1 < HEIGHT;
      assert_true(depth[y * WIDTH + x] ==
                  (inside ? d.s.depth[(y + 1) * WIDTH + x - 1] : 0.0f));
    }
  gbuffer_free(&g);
  dump_done(&d, &r);
  dump_end(&plain);
}

/* The camera's axis isn't in the middle of the picture. */
TEST_WITH_BOTH_CAMERAS(reads_off_centre_cameras) {
  enum { AWAY_X = 20, AWAY_Y = 10 };
  for (int down = 0; down < 2; down++) {
    dump d = dump_begin(SCENE_ROOM);
    const hbil_camera *c = &d.s.camera;
    const double w = WIDTH - AWAY_X, h = HEIGHT - AWAY_Y;
    const double middle[2] = {c->cx / w, down ? c->cy / h : 1 - c->cy / h};
    dump_add_depth(&d, "depth", "Z", 1, 0);
    dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_WORLD, 0);
    dump_add_matrices(&d, AXES_WORLD, AXES_OPENGL, c->fx / w,
                      (down ? -1 : 1) * c->fy / h, middle, 1);
    d.img.display = (image_window){0, 0, (uint32_t)w, (uint32_t)h};
    reading r = dump_reading(&d);
    assert_same_geometry(&d, &r, MATRIX_ROUNDING);
    assert_no_findings(&r);
    dump_done(&d, &r);
  }
}
