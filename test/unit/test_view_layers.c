/*
 * Files with several pictures: of view layers the one with the most passes is
 * read, of eyes the first one, both are told, and the options choose another.
 */
#include "test/support/dump_file.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* A sound picture in a view layer and for an eye ("" or ".left"). */
static void add_picture(dump *d, const char *layer, const char *eye) {
  char pass[128];
#define PASS(name)                                                             \
  (snprintf(pass, sizeof pass, "%s." name "%s", layer, eye), pass)
  dump_add_depth(d, PASS("Depth"), "Z", 1, 1e10f);
  dump_add_vectors(d, PASS("Normal"), letters_xyz, d->s.normal, AXES_WORLD, 0);
  dump_add_colour(d, PASS("DiffCol"), letters_rgb, d->s.albedo, NULL, 1);
  dump_add_colour(d, PASS("DiffDir"), letters_rgb, d->s.direct, NULL, 1 / PI);
}

/* Another picture there, which must not be taken for the first one: all is
 * twice as far away. */
static void add_other(dump *d, const char *layer, const char *eye) {
  char pass[128];
  dump_add_depth(d, PASS("Depth"), "Z", 2, 1e10f);
  dump_add_vectors(d, PASS("Normal"), letters_xyz, d->s.normal, AXES_WORLD, 0);
}

static void assert_guessed(const reading *r, const char *text) {
  int found = 0;
  for (int i = 0; i < r->guessed.count; i++)
    found |= strstr(r->guessed.text[i], text) != NULL;
  assert_int_equal(found, text[0] ? 1 : 0);
  if (!text[0])
    assert_int_equal(r->guessed.count, 0);
}

static void assert_rejected(const dump *d, const char *text) {
  image_error error;
  reading r;
  assert_int_not_equal(dump_try_reading(d, &r, &error), 0);
  if (!strstr(error.text, text))
    fail_msg("%s", error.text);
}

TEST(the_richest_view_layer_is_read) {
  dump d = dump_begin(SCENE_SKY);
  add_other(&d, "BG.only", "");
  add_picture(&d, "Foreground Layer", "");
  dump_add_plane(&d, "Composite.Combined", "R");
  reading r = dump_reading(&d);
  assert_int_equal(r.map.kind, DUMP_CYCLES);
  assert_string_equal(r.map.names[ROLE_DEPTH][0], "Foreground Layer.Depth.Z");
  assert_same_geometry(&d, &r, ROUNDING);
  assert_same_light(&d, &r);
  assert_guessed(&r, "view layer Foreground Layer is read, of BG.only, "
                     "Foreground Layer (--view-layer)");
  dump_done(&d, &r);
}

TEST(another_view_layer_can_be_chosen) {
  dump d = dump_begin(SCENE_SKY);
  add_other(&d, "A", "");
  add_picture(&d, "A.b", "");
  add_other(&d, "B", "");
  d.options.view_layer = "B";
  reading r = dump_reading(&d);
  assert_string_equal(r.map.names[ROLE_DEPTH][0], "B.Depth.Z");
  assert_int_equal(r.map.count[ROLE_DIRECT], 0);
  assert_guessed(&r, "");
  reading_free(&r);
  d.options.view_layer = "A.b";
  r = dump_read(&d);
  assert_same_geometry(&d, &r, ROUNDING);
  assert_same_light(&d, &r);
  reading_free(&r);
  d.options.view_layer = "b";
  assert_rejected(&d, "has no view layer b; one of A, A.b, B is needed");
  d.options.view_layer = "B";
  d.options.map = "direct=DiffDir"; /* a layer's last word */
  r = dump_read(&d);
  assert_string_equal(r.map.names[ROLE_DIRECT][0], "A.b.DiffDir.R");
  reading_free(&r);
  d.options.map = "depth=Depth";
  assert_rejected(&d,
                  "several such layers; one of A.Depth, A.b.Depth, B.Depth");
  d.options.map = "depth=gone";
  assert_rejected(&d, "no such layer of 1 channel; it has A.Depth, A.b.Depth");
  dump_end(&d);
}

TEST(a_single_view_layer_needs_no_word) {
  dump d = dump_begin(SCENE_ROOM);
  add_picture(&d, "View Layer", "");
  reading r = dump_reading(&d);
  assert_guessed(&r, "");
  reading_free(&r);
  d.options.eye = "left";
  assert_rejected(&d, "has no eye left; a multi-view file is needed");
  dump_end(&d);
}

/* Each eye has passes with its name, as Blender writes them. */
TEST(eyes_are_read) {
  dump d = dump_begin(SCENE_SKY);
  strcpy(d.img.views[d.img.view_count++], "left");
  strcpy(d.img.views[d.img.view_count++], "right");
  add_other(&d, "ViewLayer", ".left");
  add_picture(&d, "ViewLayer", ".right");
  reading r = dump_reading(&d);
  assert_int_equal(r.map.kind, DUMP_CYCLES);
  assert_string_equal(r.map.names[ROLE_DEPTH][0], "ViewLayer.Depth.left.Z");
  assert_guessed(&r, "eye left is read, of left, right (--eye)");
  reading_free(&r);
  d.options.eye = "right";
  r = dump_read(&d);
  assert_same_geometry(&d, &r, ROUNDING);
  assert_same_light(&d, &r);
  assert_guessed(&r, "");
  reading_free(&r);
  d.options.eye = "middle";
  assert_rejected(&d, "has no eye middle; one of left, right is needed");
  dump_end(&d);
}

/* OpenEXR's own rule: the default view's channels don't have its name. */
TEST(the_default_view_has_plain_names) {
  dump d = dump_begin(SCENE_SKY);
  strcpy(d.img.views[d.img.view_count++], "main");
  strcpy(d.img.views[d.img.view_count++], "second");
  add_picture(&d, "ViewLayer", "");
  add_other(&d, "ViewLayer", ".second");
  reading r = dump_reading(&d);
  assert_same_geometry(&d, &r, ROUNDING);
  assert_same_light(&d, &r);
  reading_free(&r);
  d.options.eye = "second";
  r = dump_read(&d);
  assert_string_equal(r.map.names[ROLE_DEPTH][0], "ViewLayer.Depth.second.Z");
  assert_int_equal(r.map.count[ROLE_DIRECT], 0); /* main has one */
  dump_done(&d, &r);
}

/* FRAME.right.json is the right eye's camera, FRAME.json that of others. */
TEST(an_eye_has_its_own_camera) {
  char all[160], own[160];
  dump d = dump_begin(SCENE_ROOM);
  strcpy(d.img.views[d.img.view_count++], "left");
  strcpy(d.img.views[d.img.view_count++], "right");
  add_picture(&d, "ViewLayer", ".left");
  add_picture(&d, "ViewLayer", ".right");
  d.s.camera.cx += 3;
  dump_write(&d);
  snprintf(all, sizeof all, "%s/frame_0004.json", dump_folder);
  snprintf(own, sizeof own, "%s/frame_0004.right.json", dump_folder);
  assert_int_equal(rename(all, own), 0);
  d.s.camera.cx -= 3;
  reading r = dump_reading(&d);
  assert_true(fabs(r.camera.cx - d.s.camera.cx) < 1e-9);
  reading_free(&r);
  d.options.eye = "right";
  r = dump_read(&d);
  assert_true(fabs(r.camera.cx - d.s.camera.cx - 3) < 1e-9);
  reading_free(&r);
  assert_int_equal(unlink(own), 0);
  dump_end(&d);
}

/* Blender doesn't say in its files from where a border was cropped. */
TEST(a_cropped_border_is_rejected_with_the_fix) {
  image_error error;
  char json[160];
  dump d = dump_begin(SCENE_ROOM);
  add_picture(&d, "ViewLayer", "");
  dump_write(&d);
  snprintf(json, sizeof json, "%s/frame_0004.json", dump_folder);
  camera_file camera;
  assert_int_equal(camera_read(json, &camera, &error), 0);
  camera.width += 40;
  camera.height += 12;
  camera.cx += 30;
  camera.cy += 7;
  assert_int_equal(camera_write(json, &camera, &error), 0);
  assert_rejected(&d, "for a cropped border, that is cx and cy less the pixels "
                      "cropped left and above");
  camera.width -= 40;
  camera.height -= 12;
  camera.cx -= 30;
  camera.cy -= 7;
  assert_int_equal(camera_write(json, &camera, &error), 0);
  reading r = dump_read(&d);
  assert_same_geometry(&d, &r, ROUNDING);
  dump_done(&d, &r);
}
