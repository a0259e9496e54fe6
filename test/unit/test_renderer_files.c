/*
 * Files in the exact layouts of Mitsuba 3.9 and LuxCore 2.11, made of the
 * project's own scenes: what is direct light, what are lamps and sky, what is
 * multiplied with the coverage, and which files belong together.
 */
#include "test/support/dump_file.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const float sky_radiance = 0.75f;

/* ------------------------------------------------------------------------ */
/* Mitsuba                                                                   */

/* Half of a pixel beside the sky is sky. */
static float coverage_at(const dump *d, size_t i) {
  const size_t x = i % WIDTH, y = i / WIDTH;
  if (dump_is_sky(d, i))
    return 0.0f;
  return (x > 0 && dump_is_sky(d, i - 1)) ||
                 (x + 1 < WIDTH && dump_is_sky(d, i + 1)) ||
                 (y > 0 && dump_is_sky(d, i - WIDTH)) ||
                 (y + 1 < HEIGHT && dump_is_sky(d, i + WIDTH))
             ? 0.5f
             : 1.0f;
}

static void cover(dump *d, const char *name) {
  float *v = dump_plane(d, name);
  for (size_t i = 0; i < PIXELS; i++)
    v[i] *= coverage_at(d, i);
}

typedef struct picture {
  int lamps, sky;     /* 1: they are seen */
  const char *layers; /* of the picture: "root", "img" or "both" */
  double indirect;    /* radiance of a white surface, as `path` adds it */
} picture;

static void add_picture(dump *d, const picture *p, const char *layer) {
  for (size_t c = 0; c < 3; c++) {
    float *out = dump_add_plane(d, layer, letters_rgb[c]);
    for (size_t i = 0; i < PIXELS; i++) {
      const double share = (double)coverage_at(d, i);
      const double emission = p->lamps ? (double)d->s.emission[c][i] : 0.0;
      out[i] =
          (float)(share * ((double)d->s.albedo[c][i] *
                               ((double)d->s.direct[c][i] / PI + p->indirect) +
                           emission) +
                  (p->sky ? (1.0 - share) * (double)sky_radiance : 0.0));
    }
  }
  float *alpha = dump_add_plane(d, layer, "A");
  for (size_t i = 0; i < PIXELS; i++)
    alpha[i] = coverage_at(d, i);
}

/* dd:depth,pp:position,nn:sh_normal,albedo:albedo around `direct`. */
static dump mitsuba(scene_kind scene, const picture *p) {
  static const char *const multiplied[] = {
      "dd.T", "nn.X", "nn.Y",     "nn.Z",     "pp.X",
      "pp.Y", "pp.Z", "albedo.R", "albedo.G", "albedo.B"};
  dump d = dump_begin(scene);
  dump_add_ray(&d, "dd", "T", 0.01, 0);
  dump_add_vectors(&d, "nn", letters_xyz, d.s.normal, AXES_WORLD, 0);
  dump_add_vectors(&d, "pp", letters_xyz, d.s.position, AXES_WORLD, 1);
  dump_add_colour(&d, "albedo", letters_rgb, d.s.albedo, NULL, 1);
  for (size_t k = 0; k < sizeof multiplied / sizeof *multiplied; k++)
    cover(&d, multiplied[k]);
  if (strcmp(p->layers, "img") != 0)
    add_picture(&d, p, "");
  if (strcmp(p->layers, "root") != 0)
    add_picture(&d, p, "img");
  d.options.source = DUMP_MITSUBA;
  return d;
}

/* Irradiance is the scene's, where the pixel shows one surface and no lamp. */
static void assert_light(const dump *d, const reading *r) {
  const double scale = (double)r->config.inputs.direct_scale;
  size_t compared = 0;
  for (size_t i = 0; i < PIXELS; i++) {
    if (dump_is_sky(d, i) || coverage_at(d, i) < 1.0f ||
        d->s.emission[0][i] > 0.0f)
      continue;
    for (size_t c = 0; c < 3; c++) {
      const double is = (double)gbuffer_plane(&r->g, ROLE_DIRECT, c)[i] * scale;
      /* beside a lamp, light is that of the neighbours */
      compared += d->s.albedo[c][i] > 0.0f &&
                  relative_difference(is, (double)d->s.direct[c][i]) < 1e-5;
    }
  }
  assert_true(compared > PIXELS);
}

TEST(direct_light_is_found) {
  static const char *const layers[] = {"root", "img", "both"};
  for (int k = 0; k < 3; k++) {
    dump d = mitsuba(SCENE_SKY, &(picture){.layers = layers[k]});
    reading r = dump_reading(&d);
    assert_int_equal(r.map.how.direct, DIRECT_RADIANCE);
    assert_string_equal(r.map.names[ROLE_DIRECT][0], k == 1 ? "img.R" : "R");
    assert_int_equal(r.guessed.count, 0);
    assert_same_geometry(&d, &r, ROUNDING);
    assert_true(reading_colour_error(&d, &r, ROLE_ALBEDO, d.s.albedo, 1, NULL) <
                1e-6);
    assert_light(&d, &r);
    assert_no_findings(&r);
    dump_done(&d, &r);
  }
}

/* The sky that direct light shows becomes emission, and edges don't glow. */
TEST(sky_is_taken_out) {
  dump d = mitsuba(SCENE_SKY, &(picture){.sky = 1, .layers = "both"});
  reading r = dump_reading(&d);
  float most = 0.0f;
  for (size_t i = 0; i < PIXELS; i++)
    most = fmaxf(most, d.s.direct[0][i]);
  for (size_t i = 0; i < PIXELS; i++)
    for (size_t c = 0; c < 3; c++) {
      const float emission = gbuffer_plane(&r.g, ROLE_EMISSION, c)[i];
      const float direct = gbuffer_plane(&r.g, ROLE_DIRECT, c)[i];
      assert_true(emission == (dump_is_sky(&d, i) ? sky_radiance : 0.0f));
      assert_true(direct * r.config.inputs.direct_scale <= 1.001f * most);
    }
  assert_light(&d, &r);
  assert_no_findings(&r);
  dump_done(&d, &r);
}

/* Lamps that direct light shows become emission; --map emission= leaves them.
 */
TEST(lamps_are_taken_out) {
  for (int none = 0; none < 2; none++) {
    dump d = mitsuba(SCENE_ROOM, &(picture){.lamps = 1, .layers = "both"});
    size_t lamps = 0, found = 0;
    d.options.map = none ? "emission=" : NULL;
    reading r = dump_reading(&d);
    for (size_t i = 0; i < PIXELS; i++) {
      const float *emission = gbuffer_plane(&r.g, ROLE_EMISSION, 0);
      lamps += d.s.emission[0][i] > 0.0f;
      found += emission && emission[i] > 0.0f;
      assert_true(!emission || emission[i] <= 0.0f ||
                  d.s.emission[0][i] > 0.0f);
    }
    assert_true(lamps > 20);
    assert_int_equal(found, none ? 0 : lamps);
    assert_int_equal(r.guessed.count, none ? 0 : 1);
    if (!none)
      assert_light(&d, &r);
    dump_done(&d, &r);
  }
}

/* As bright a surface is no lamp if its light isn't that of the others. */
TEST(lit_patches_are_no_lamps) {
  dump d = mitsuba(SCENE_ROOM, &(picture){.layers = "both"});
  for (size_t i = 0; i < PIXELS; i++)
    for (size_t c = 0; c < 3 && i / WIDTH > HEIGHT - 14; c++)
      dump_plane(&d, (const char *[]){"R", "G", "B"}[c])[i] *=
          i % WIDTH > 40 && i % WIDTH < 60 ? 1000.0f : 1.0f;
  reading r = dump_reading(&d);
  assert_true(r.map.how.lamps_from == 0.0f);
  dump_done(&d, &r);
}

/* The picture of `path` is warned of. */
TEST(finished_pictures_are_named) {
  dump d = mitsuba(SCENE_ROOM, &(picture){.layers = "both", .indirect = 0.1});
  reading r = dump_reading(&d);
  assert_int_equal(r.check.found.count, 1);
  assert_non_null(strstr(r.check.found.text[0], "finished picture"));
  dump_done(&d, &r);
}

/* ch00 and so on, as mi.util.write_bitmap() names them. */
TEST(loose_channels_are_mapped) {
  static const char *const names[] = {
      "R",    "G",    "B",    "dd.T",     "pp.X",     "pp.Y",    "pp.Z",
      "nn.X", "nn.Y", "nn.Z", "albedo.R", "albedo.G", "albedo.B"};
  reading r;
  image_error error;
  dump d = mitsuba(SCENE_ROOM, &(picture){.layers = "root"});
  for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    snprintf(image_find(&d.img, names[i])->name, sizeof d.img.planes->name,
             "ch%02zu", i);
  dump_write(&d);
  assert_int_not_equal(dump_try_reading(&d, &r, &error), 0);
  assert_non_null(strstr(error.text, "--map depth=ch03"));
  d.options.map = "direct=ch00,ch01,ch02,depth=ch03,normal=ch07,ch08,ch09,"
                  "albedo=ch10,ch11,ch12";
  d.options.clip[0] = 0.01f;
  d.options.clip[1] = 1000.0f;
  r = dump_reading(&d);
  assert_int_equal(r.map.how.depth, DEPTH_RAY);
  assert_same_geometry(&d, &r, ROUNDING);
  assert_light(&d, &r);
  reading_free(&r);
  static const struct {
    const char *map, *text;
  } wrong[] = {{"depth=ch03,albedo=ch10,ch11", "2 channels; 3 are needed"},
               {"albedo=ch10,ch11,ch99", "no such channel"},
               {"albedo=ch10,ch11,ch12,ch03,ch04", "5 channels"}};
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    d.options.map = wrong[i].map;
    assert_int_not_equal(dump_try_reading(&d, &r, &error), 0);
    assert_non_null(strstr(error.text, wrong[i].text));
  }
  dump_end(&d);
}

/* .T is the distance along the ray, whatever the source and the roles are. */
TEST(t_is_ray_depth) {
  for (int generic = 0; generic < 2; generic++) {
    dump d = mitsuba(SCENE_ROOM, &(picture){.layers = "root"});
    d.options.source = generic ? DUMP_PLAIN : DUMP_MITSUBA;
    d.options.map = generic ? "depth=dd.T,normal=nn,position=pp"
                            : "depth=dd.T,albedo=albedo";
    reading r = dump_reading(&d);
    assert_int_equal(r.map.how.depth, DEPTH_RAY);
    dump_done(&d, &r);
  }
}

/* ------------------------------------------------------------------------ */
/* LuxCore                                                                   */

/* The names of a frame's outputs, with %s for the type. */
static const char *const patterns[] = {"%s.exr", "room_%s_0004.exr",
                                       "frame-%s.exr"};
static const char *const types[] = {"DEPTH", "SHADING_NORMAL", "ALBEDO",
                                    "DIRECT_DIFFUSE", "INDIRECT_DIFFUSE"};
enum { TYPES = sizeof types / sizeof *types };

static void file_name(char out[128], int pattern, int type) {
  char word[32], name[64];
  snprintf(word, sizeof word, "%s", types[type]);
  for (char *at = word; *at && pattern == 2; at++)
    *at = (char)(*at == '_' ? '_' : *at - 'A' + 'a');
  snprintf(name, sizeof name, patterns[pattern], word);
  snprintf(out, 128, "%s/%s", dump_folder, name);
}

/* Writes all outputs; the dump of depth is returned. */
static dump luxcore(int pattern) {
  dump out = {0};
  for (int t = TYPES - 1; t >= 0; t--) {
    dump d = dump_begin(SCENE_ROOM);
    if (t == 0) {
      dump_add_ray(&d, "", "R", 0, INFINITY);
      dump_add_ray(&d, "", "G", 0, INFINITY);
      dump_add_ray(&d, "", "B", 0, INFINITY);
    } else if (t == 1)
      dump_add_vectors(&d, "", letters_rgb, d.s.normal, AXES_WORLD, 0);
    else
      dump_add_colour(&d, "", letters_rgb, t < 3 ? d.s.albedo : d.s.direct,
                      t < 3 ? NULL : d.s.albedo, t < 3 ? 1 : 1 / PI);
    file_name(d.path, pattern, t);
    dump_write(&d);
    if (t == 0)
      out = d;
    else {
      image_free(&d.img);
      scene_free(&d.s);
    }
  }
  return out;
}

static void remove_outputs(dump *d, int pattern) {
  char name[128];
  for (int t = 0; t < TYPES; t++) {
    file_name(name, pattern, t);
    unlink(name);
  }
  dump_end(d);
}

/* The fixture writes its camera as frame_0004.json, so it is named. */
static void use_camera(dump *d) {
  char json[160], own[160];
  snprintf(json, sizeof json, "%s/frame_0004.json", dump_folder);
  snprintf(own, sizeof own, "%.*s.json", (int)strlen(d->path) - 4, d->path);
  assert_int_equal(link(json, own), 0);
}

static void drop_camera(const dump *d) {
  char own[160];
  snprintf(own, sizeof own, "%.*s.json", (int)strlen(d->path) - 4, d->path);
  unlink(own);
}

TEST(outputs_are_found_by_name) {
  for (int p = 0; p < 3; p++) {
    dump d = luxcore(p);
    use_camera(&d);
    reading r = dump_read(&d);
    assert_int_equal(r.map.kind, DUMP_LUXCORE);
    assert_int_equal(r.map.how.depth, DEPTH_RAY);
    assert_same_geometry(&d, &r, ROUNDING);
    assert_same_light(&d, &r);
    const double scale = (double)r.config.inputs.direct_scale;
    const float *const albedo[3] = {d.s.albedo[0], d.s.albedo[1],
                                    d.s.albedo[2]};
    assert_true(reading_colour_error(&d, &r, ROLE_INDIRECT, d.s.direct, scale,
                                     albedo) < 2e-6);
    assert_no_findings(&r);
    reading_free(&r);
    drop_camera(&d);
    remove_outputs(&d, p);
  }
}

/* The frame is the depth; another output as frame names it. */
TEST(other_outputs_name_the_depth) {
  dump d = luxcore(1);
  reading r;
  image_error error;
  char depth[128];
  snprintf(depth, sizeof depth, "%s", d.path);
  file_name(d.path, 1, 2);
  assert_int_not_equal(dump_try_reading(&d, &r, &error), 0);
  assert_non_null(strstr(error.text, "room_DEPTH_0004.exr"));
  assert_non_null(strstr(error.text, "is the output ALBEDO"));
  remove_outputs(&d, 1);
}
