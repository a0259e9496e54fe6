/*
 * Every renderer's layout, written from a traced scene, is read back as the
 * same planes; what people get wrong is found and named with the option that
 * helps.
 */
#define _POSIX_C_SOURCE 200809L /* mkdtemp */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "dump/frame_camera.h"
#include "dump/frame_check.h"
#include "dump/read_channel_map.h"
#include "dump/read_gbuffer.h"
#include "dump/settle.h"
#include "tool/source_arguments.h"

enum { WIDTH = 120, HEIGHT = 68, PIXELS = WIDTH * HEIGHT };

/* Renderers' coordinates of what the scene has in its right-handed world. */
typedef enum axes {
  AXES_WORLD,
  AXES_MIRRORED, /* a left-handed world: x turned */
  AXES_OPENGL,   /* camera: y up, z backwards */
  AXES_FORWARD   /* camera: y up, z forwards, left-handed */
} axes;

/* A scene and the file that is made of it. */
typedef struct dump {
  scene_frame s;
  image img;
  source_options options;
  char path[128];
  int json; /* has a camera beside it */
} dump;

static char folder[] = "/tmp/hbil-sources.XXXXXX";

static const double pi = 3.14159265358979323846;

/* Whether scenes are seen by parallel rays: tests that hold for both have this
 * set before their second run. */
static int parallel;

static int see_parallel(void **state) {
  (void)state;
  parallel = 1;
  return 0;
}

static int see_perspective(void **state) {
  (void)state;
  parallel = 0;
  return 0;
}

/* lens: the angle of the height; the size of the width if rays are parallel; 0:
 * the scene's own. */
static dump begin_sized(scene_kind kind, uint32_t width, uint32_t height,
                        double lens) {
  dump d;
  memset(&d, 0, sizeof d);
  assert_int_equal((parallel ? scene_render_orthographic : scene_render)(
                       kind, width, height, lens, 3, &d.s),
                   0);
  d.img.width = width;
  d.img.height = height;
  d.json = 1;
  source_options_init(&d.options);
  snprintf(d.path, sizeof d.path, "%s/frame_0004.exr", folder);
  return d;
}

static dump begin(scene_kind kind) {
  return begin_sized(kind, WIDTH, HEIGHT, 0.0);
}

static size_t pixels_of(const dump *d) {
  return (size_t)d->s.width * d->s.height;
}

static void end(dump *d) {
  char json[sizeof d->path];
  snprintf(json, sizeof json, "%s/frame_0004.json", folder);
  unlink(d->path);
  unlink(json);
  image_free(&d->img);
  scene_free(&d->s);
}

/* ------------------------------------------------------------------------ */
/* Writing                                                                   */

static float *add_plane(dump *d, const char *pass, const char *letter) {
  char name[128];
  snprintf(name, sizeof name, "%s%s%s", pass, *pass && *letter ? "." : "",
           letter);
  image_plane *plane = image_add(&d->img, name);
  assert_non_null(plane);
  return plane->pixels;
}

static int is_sky(const dump *d, size_t i) {
  return !(d->s.depth[i] > 0.0f);
}

static double ray_length(const dump *d, size_t i) {
  const hbil_camera *c = &d->s.camera;
  if (parallel)
    return 1;
  const double x = ((double)(i % d->s.width) + 0.5 - c->cx) / c->fx;
  const double y = ((double)(i / d->s.width) + 0.5 - c->cy) / c->fy;
  return sqrt(x * x + y * y + 1);
}

/* value(z) of surfaces, another one where there is nothing. */
static void add_depth(dump *d, const char *pass, const char *letter,
                      double scale, float sky) {
  float *out = add_plane(d, pass, letter);
  for (size_t i = 0; i < pixels_of(d); i++)
    out[i] = is_sky(d, i) ? sky : (float)((double)d->s.depth[i] * scale);
}

static void add_ray(dump *d, const char *pass, const char *letter, double near,
                    float sky) {
  float *out = add_plane(d, pass, letter);
  for (size_t i = 0; i < pixels_of(d); i++)
    out[i] = is_sky(d, i)
                 ? sky
                 : (float)(((double)d->s.depth[i] - near) * ray_length(d, i));
}

/* A direction (w 0) or a point (w 1) of the world. */
static void in_axes(const dump *d, axes a, const double world[3], double w,
                    double out[3]) {
  const double *m = d->s.camera.world_from_view;
  double seen[3] = {0};
  for (int c = 0; c < 3; c++)
    for (int k = 0; k < 3; k++)
      seen[c] += m[4 * k + c] * (world[k] - w * m[4 * k + 3]);
  for (int c = 0; c < 3; c++)
    out[c] = a <= AXES_MIRRORED ? world[c] : seen[c];
  if (a == AXES_MIRRORED)
    out[0] = -out[0];
  if (a >= AXES_OPENGL)
    out[1] = -out[1];
  if (a == AXES_OPENGL)
    out[2] = -out[2];
}

static void add_vectors(dump *d, const char *pass, const char *const letters[3],
                        float *const in[3], axes a, double w) {
  float *out[3];
  for (int c = 0; c < 3; c++)
    out[c] = add_plane(d, pass, letters[c]);
  for (size_t i = 0; i < pixels_of(d); i++) {
    const double world[3] = {in[0][i], in[1][i], in[2][i]};
    double v[3] = {0};
    if (!is_sky(d, i))
      in_axes(d, a, world, w, v);
    for (int c = 0; c < 3; c++)
      out[c][i] = (float)v[c];
  }
}

/* times: multiplied by another colour, or NULL. */
static void add_colour(dump *d, const char *pass, const char *const letters[3],
                       float *const in[3], float *const times[3],
                       double scale) {
  for (int c = 0; c < 3; c++) {
    float *out = add_plane(d, pass, letters[c]);
    for (size_t i = 0; i < pixels_of(d); i++)
      out[i] = (float)((double)in[c][i] * scale *
                       (times ? (double)times[c][i] : 1.0));
  }
}

static const char *const xyz[] = {"X", "Y", "Z"};
static const char *const rgb[] = {"R", "G", "B"};
static const char *const small_rgb[] = {"r", "g", "b"};
static const char *const words[] = {"red", "green", "blue"};

static void transpose(double m[16]) {
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < i; j++) {
      const double kept = m[4 * i + j];
      m[4 * i + j] = m[4 * j + i];
      m[4 * j + i] = kept;
    }
}

/* worldToCamera and worldToNDC: the projection's rows x, y are those of a slope
 * to the right and up, k of the distance forwards; of world units, and k is 1,
 * where rays are parallel. */
static void add_matrices(dump *d, axes world, axes camera, double scale_x,
                         double scale_y, const double middle[2], int rows) {
  image_matrices *m = &d->img.matrices;
  const double *from = d->s.camera.world_from_view;
  const double forwards = camera == AXES_FORWARD ? 1 : -1;
  double *c = m->world_to_camera;
  for (int k = 0; k < 3; k++) {
    double axis[3] = {0}, out[3];
    axis[k] = world == AXES_MIRRORED && k == 0 ? -1 : 1;
    in_axes(d, camera, axis, 0, out);
    for (int r = 0; r < 3; r++)
      c[4 * r + k] = out[r];
  }
  for (int r = 0; r < 3; r++)
    for (int k = 0; k < 3; k++)
      c[4 * r + 3] -= c[4 * r + k] * from[4 * k + 3] *
                      (world == AXES_MIRRORED && k == 0 ? -1 : 1);
  c[15] = 1;
  for (int k = 0; k < 4; k++) {
    double *n = m->world_to_ndc;
    const double z = c[8 + k] * forwards;
    const double divisor = parallel ? k == 3 : z;
    n[k] = scale_x * c[k] + middle[0] * divisor;
    n[4 + k] = scale_y * c[4 + k] + middle[1] * divisor;
    n[8 + k] = z - (k == 3 ? 0.1 : 0);
    n[12 + k] = divisor;
  }
  if (rows) {
    transpose(m->world_to_camera);
    transpose(m->world_to_ndc);
  }
  m->has_camera = m->has_ndc = 1;
  d->json = 0;
}

static const double half[] = {0.5, 0.5}, zero[] = {0, 0};

static void write_dump(dump *d) {
  image_error error;
  char json[sizeof d->path];
  const hbil_camera *c = &d->s.camera;
  camera_file camera = {.orthographic = parallel,
                        .fx = c->fx,
                        .fy = c->fy,
                        .cx = c->cx,
                        .cy = c->cy};
  for (int i = 0; i < 16; i++)
    camera.camera_to_world[i] =
        c->world_from_view[i] * (i % 4 == 1 || i % 4 == 2 ? -1 : 1);
  camera.width = d->img.display.width ? d->img.display.width : d->s.width;
  camera.height = d->img.display.width ? d->img.display.height : d->s.height;
  camera.cx += d->img.x - d->img.display.x;
  camera.cy += d->img.y - d->img.display.y;
  snprintf(json, sizeof json, "%s/frame_0004.json", folder);
  assert_int_equal(exr_write(d->path, &d->img, NULL, &error), 0);
  if (d->json)
    assert_int_equal(camera_write(json, &camera, &error), 0);
}

/* ------------------------------------------------------------------------ */
/* Reading                                                                   */

typedef struct reading {
  channel_map map;
  frame_camera seen;
  camera_file camera;
  hbil_config config;
  gbuffer g;
  findings guessed;
  frame_check check;
} reading;

static int try_reading(const dump *d, reading *r, image_error *error) {
  image header;
  memset(r, 0, sizeof *r);
  error->text[0] = '\0';
  if (image_read_header(d->path, &header, error) != 0)
    return -1;
  int failed =
      channel_map_read(d->path, &header, &d->options, &r->map, error) != 0 ||
      channel_map_check(&r->map, d->path, error) != 0 ||
      frame_camera_read(d->path, &header, NULL, &d->options, &r->seen, error) != 0 ||
      frame_camera_aim(d->path, &r->seen, &r->map, &r->camera, error) != 0 ||
      conventions_settle(d->path, &r->map, &r->guessed, error) != 0 ||
      gbuffer_read(d->path, &r->map, ~0u, &r->g, error) != 0;
  image_free(&header);
  hbil_config_init(&r->config);
  channel_map_configure(&r->map, &r->config);
  if (failed)
    channel_map_free(&r->map);
  else
    frame_check_run(&r->g, &r->config, &r->map.camera, &r->check);
  return failed;
}

static reading read_dump(const dump *d) {
  reading r;
  image_error error;
  if (try_reading(d, &r, &error) != 0)
    fail_msg("%s", error.text);
  return r;
}

static void done(reading *r) {
  gbuffer_free(&r->g);
  channel_map_free(&r->map);
}

static void no_findings(const reading *r) {
  for (int i = 0; i < r->check.found.count; i++)
    print_error("found: %s\n", r->check.found.text[i]);
  assert_int_equal(r->check.found.count, 0);
}

/* Largest difference, relative to what is larger than 1. */
static double far_off(double a, double b) {
  return fabs(a - b) / fmax(1.0, fabs(b));
}

static double depth_error(const dump *d, const reading *r) {
  const float *depth = gbuffer_plane(&r->g, ROLE_DEPTH, 0);
  double worst = 0;
  for (size_t i = 0; i < pixels_of(d); i++) {
    const int surface = gbuffer_is_surface(depth[i], r->config.sky_depth);
    if (surface == is_sky(d, i))
      return INFINITY;
    if (surface)
      worst = fmax(worst, fabs((double)depth[i] / (double)d->s.depth[i] - 1));
  }
  return worst;
}

/* In view space, so that a world that was mirrored counts as the same. */
static double normal_error(const dump *d, const reading *r) {
  const double *m = r->map.camera.world_from_view;
  const double *w = d->s.camera.world_from_view;
  double worst = 0;
  for (size_t i = 0; i < pixels_of(d); i++)
    for (int c = 0; c < 3 && !is_sky(d, i); c++) {
      double is = 0, wanted = 0;
      for (int k = 0; k < 3; k++) {
        const double n = gbuffer_plane(&r->g, ROLE_NORMAL, (size_t)k)[i];
        const int world = r->config.normal_space == HBIL_SPACE_WORLD;
        is += n * (world ? m[4 * k + c] : k == c);
        wanted += (double)d->s.normal[k][i] * w[4 * k + c];
      }
      worst = fmax(worst, fabs(is - wanted));
    }
  return worst;
}

static double colour_error(const dump *d, const reading *r, role which,
                           float *const wanted[3], double scale,
                           const float *const counts[3]) {
  double worst = 0;
  for (size_t c = 0; c < 3; c++)
    for (size_t i = 0; i < pixels_of(d); i++)
      if (!counts || counts[c][i] > 0.0f)
        worst = fmax(worst,
                     far_off((double)gbuffer_plane(&r->g, which, c)[i] * scale,
                             (double)wanted[c][i]));
  return worst;
}

/*
 * 2e-6: some ten roundings of floats, which a conversion has; 2e-5 where the
 * camera is told by float matrices, whose inverse and product are taken.
 */
static void same_geometry(const dump *d, const reading *r, double most) {
  const hbil_camera *is = &r->map.camera, *wanted = &d->s.camera;
  assert_int_equal(r->config.projection, d->s.projection);
  assert_true(depth_error(d, r) <= most);
  assert_true(normal_error(d, r) <= most);
  assert_true(far_off(is->fx, wanted->fx) <= most);
  assert_true(far_off(is->fy, wanted->fy) <= most);
  assert_true(far_off(is->cx, wanted->cx) <= most);
  assert_true(far_off(is->cy, wanted->cy) <= most);
}

static void same_light(const dump *d, const reading *r) {
  const double scale = (double)r->config.direct_scale;
  const int divided = r->map.how.direct == DIRECT_RADIANCE;
  const float *const albedo[3] = {d->s.albedo[0], d->s.albedo[1],
                                  d->s.albedo[2]};
  assert_true(colour_error(d, r, ROLE_ALBEDO, d->s.albedo, 1, NULL) <= 2e-6);
  assert_true(colour_error(d, r, ROLE_DIRECT, d->s.direct, scale,
                           divided ? albedo : NULL) <= 2e-6);
}

static const double rounding = 2e-6, matrices = 2e-5;

/* ------------------------------------------------------------------------ */
/* The layouts                                                               */

static void blender(void **state) {
  (void)state;
  for (int scene = 0; scene < SCENE_KINDS; scene++) {
    dump d = begin((scene_kind)scene);
    add_depth(&d, "ViewLayer.Depth", "Z", 1, 1e10f);
    add_vectors(&d, "ViewLayer.Normal", xyz, d.s.normal, AXES_WORLD, 0);
    add_vectors(&d, "ViewLayer.Position", xyz, d.s.position, AXES_WORLD, 1);
    add_colour(&d, "ViewLayer.DiffCol", rgb, d.s.albedo, NULL, 1);
    add_colour(&d, "ViewLayer.DiffDir", rgb, d.s.direct, NULL, 1 / pi);
    add_colour(&d, "ViewLayer.Emit", rgb, d.s.emission, NULL, 1);
    float *x = add_plane(&d, "ViewLayer.Vector", "X");
    float *y = add_plane(&d, "ViewLayer.Vector", "Y");
    for (size_t i = 0; i < PIXELS; i++) {
      x[i] = d.s.motion[0][i];
      y[i] = -d.s.motion[1][i];
    }
    write_dump(&d);
    reading r = read_dump(&d);
    assert_int_equal(r.map.kind, DUMP_CYCLES);
    same_geometry(&d, &r, rounding);
    same_light(&d, &r);
    for (size_t i = 0; i < PIXELS; i++)
      for (size_t c = 0; c < 2; c++)
        assert_true(gbuffer_plane(&r.g, ROLE_MOTION, c)[i] *
                        r.config.motion_scale[c] ==
                    d.s.motion[c][i]);
    assert_true(r.check.positions < 1e-5);
    no_findings(&r);
    done(&r);
    end(&d);
  }
}

/* Positions in the camera's space, forwards; a left-handed world; matrices for
 * columns, of one scale for both sides of the picture. */
static void pbrt(void **state) {
  (void)state;
  dump d = begin(SCENE_ROOM);
  const double scale = d.s.camera.fx / HEIGHT;
  add_vectors(&d, "P", xyz, d.s.position, AXES_FORWARD, 1);
  add_vectors(&d, "Ns", xyz, d.s.normal, AXES_FORWARD, 0);
  add_vectors(&d, "N", xyz, d.s.normal, AXES_FORWARD, 0);
  add_colour(&d, "Albedo", rgb, d.s.albedo, NULL, 1);
  add_depth(&d, "", "dzdx", 1, 0);
  add_matrices(&d, AXES_MIRRORED, AXES_FORWARD, scale, scale, half, 0);
  write_dump(&d);
  reading r = read_dump(&d);
  assert_int_equal(r.map.kind, DUMP_PBRT);
  assert_true(r.seen.mirrored);
  same_geometry(&d, &r, matrices);
  no_findings(&r);
  done(&r);
  /* and without matrices, by the angle or the size alone */
  d.img.matrices.has_camera = 0;
  if (parallel)
    d.options.orthographic = (float)(WIDTH / d.s.camera.fx);
  else
    d.options.fov = (float)(atan(0.5 * WIDTH / d.s.camera.fx) * 360 / pi);
  write_dump(&d);
  r = read_dump(&d);
  same_geometry(&d, &r, matrices);
  done(&r);
  end(&d);
}

/* Distances begin at the near plane. */
static void mitsuba(void **state) {
  (void)state;
  for (int with_positions = 0; with_positions < 2; with_positions++) {
    dump d = begin(SCENE_ROOM);
    add_ray(&d, "dd.y", "T", 0.25, 0);
    add_vectors(&d, "sh_normal", xyz, d.s.normal, AXES_WORLD, 0);
    add_colour(&d, "albedo", rgb, d.s.albedo, NULL, 1);
    if (with_positions)
      add_vectors(&d, "pos", xyz, d.s.position, AXES_WORLD, 1);
    d.options.clip[0] = 0.25f;
    d.options.clip[1] = 100.0f;
    write_dump(&d);
    reading r = read_dump(&d);
    assert_int_equal(r.map.kind, DUMP_MITSUBA);
    assert_int_equal(r.map.how.depth,
                     with_positions ? DEPTH_POSITION : DEPTH_RAY);
    same_geometry(&d, &r, rounding);
    no_findings(&r);
    done(&r);
    end(&d);
  }
}

/* Matrices for rows, a picture of -1..1; planar or ray is found out. */
static void arnold(void **state) {
  (void)state;
  for (int ray = 0; ray < 2; ray++) {
    dump d = begin(SCENE_SKY);
    if (ray)
      add_ray(&d, "", "Z", 0, 1e30f);
    else
      add_depth(&d, "", "Z", 1, 1e30f);
    add_vectors(&d, "N", xyz, d.s.normal, AXES_WORLD, 0);
    add_colour(&d, "diffuse_albedo", rgb, d.s.albedo, NULL, 1);
    add_colour(&d, "diffuse_direct", rgb, d.s.direct, d.s.albedo, 1 / pi);
    add_matrices(&d, AXES_WORLD, AXES_OPENGL, 2 * d.s.camera.fx / WIDTH,
                 2 * d.s.camera.fy / HEIGHT, zero, 1);
    write_dump(&d);
    reading r = read_dump(&d);
    assert_int_equal(r.map.kind, DUMP_ARNOLD);
    assert_int_equal(r.map.how.depth,
                     ray && !parallel ? DEPTH_RAY : DEPTH_PLANAR);
    same_geometry(&d, &r, matrices);
    same_light(&d, &r);
    no_findings(&r);
    done(&r);
    end(&d);
  }
}

static void vray(void **state) {
  (void)state;
  dump d = begin(SCENE_ROOM);
  add_depth(&d, "", "Z", 1, 65504.0f);
  add_vectors(&d, "bump_normals", xyz, d.s.normal, AXES_OPENGL, 0);
  add_colour(&d, "diffuse", words, d.s.albedo, NULL, 1);
  add_colour(&d, "lighting", words, d.s.direct, d.s.albedo, 1 / pi);
  write_dump(&d);
  reading r = read_dump(&d);
  assert_int_equal(r.map.kind, DUMP_VRAY);
  same_geometry(&d, &r, rounding);
  same_light(&d, &r);
  no_findings(&r);
  done(&r);
  end(&d);
}

/* A left-handed world, z forwards, a picture of 0..1 whose y runs down. */
static void renderman(void **state) {
  (void)state;
  dump d = begin(SCENE_ROOM);
  add_depth(&d, "", "z", 1, INFINITY);
  add_vectors(&d, "__Nworld", small_rgb, d.s.normal, AXES_MIRRORED, 0);
  add_vectors(&d, "__Pworld", small_rgb, d.s.position, AXES_MIRRORED, 1);
  add_colour(&d, "albedo", small_rgb, d.s.albedo, NULL, 1);
  add_colour(&d, "directDiffuse", small_rgb, d.s.direct, d.s.albedo, 1 / pi);
  add_matrices(&d, AXES_MIRRORED, AXES_FORWARD, d.s.camera.fx / WIDTH,
               -d.s.camera.fy / HEIGHT, half, 1);
  write_dump(&d);
  reading r = read_dump(&d);
  assert_int_equal(r.map.kind, DUMP_RENDERMAN);
  same_geometry(&d, &r, matrices);
  same_light(&d, &r);
  assert_true(r.check.positions < 1e-4);
  no_findings(&r);
  done(&r);
  end(&d);
}

/* Centimetres; normals of a material that encodes them. */
static void unreal(void **state) {
  (void)state;
  dump d = begin(SCENE_ROOM);
  add_depth(&d, "FinalImageMovieRenderQueue_WorldDepth", "R", 100, 65504.0f);
  add_vectors(&d, "FinalImageMovieRenderQueue_WorldNormal", rgb, d.s.normal,
              AXES_WORLD, 0);
  for (size_t p = 1; p < 4; p++)
    for (size_t i = 0; i < PIXELS; i++)
      if (!is_sky(&d, i))
        d.img.planes[p].pixels[i] = 0.5f * d.img.planes[p].pixels[i] + 0.5f;
  add_colour(&d, "FinalImageMovieRenderQueue_BaseColor", rgb, d.s.albedo, NULL,
             1);
  d.options.unit = 0.01f;
  write_dump(&d);
  reading r = read_dump(&d);
  assert_int_equal(r.map.kind, DUMP_UNREAL);
  assert_true(r.map.how.encoded);
  same_geometry(&d, &r, rounding);
  no_findings(&r);
  done(&r);
  end(&d);
}

/* ------------------------------------------------------------------------ */
/* Kinds of depth and normals                                                */

typedef struct depth_case {
  depth_kind kind;
  double scale, near, far;
  float sky;
} depth_case;

/* 1/z is stored, so near the far plane a rounding is worth more of z: by its
 * ratio to the near one; that of parallel rays is one of the far plane, as seen
 * from the nearest surface at 3. */
static void device_depths(void **state) {
  const double near = 0.5, far = 200;
  const double rounding_of_z = 6e-8 * (parallel ? far / 3 : 90 / near);
  (void)state;
  for (int reversed = 0; reversed < 2; reversed++) {
    dump d = begin(SCENE_SKY);
    float *out = add_plane(&d, "depth", "Z");
    for (size_t i = 0; i < PIXELS; i++) {
      const double z = is_sky(&d, i) ? far : (double)d.s.depth[i];
      const double v = parallel ? (z - near) / (far - near)
                                : far / (far - near) * (1 - near / z);
      out[i] = (float)(reversed ? 1 - v : v);
    }
    add_vectors(&d, "normal", xyz, d.s.normal, AXES_WORLD, 0);
    d.options.depth = reversed ? DEPTH_REVERSED : DEPTH_DEVICE;
    d.options.clip[0] = (float)near;
    d.options.clip[1] = (float)far;
    write_dump(&d);
    reading r = read_dump(&d);
    assert_true(depth_error(&d, &r) <= rounding_of_z);
    no_findings(&r);
    done(&r);
    d.options.clip[0] = 0.0f;
    d.options.clip[1] = parallel ? INFINITY : 0.0f;
    image_error error;
    assert_int_not_equal(try_reading(&d, &r, &error), 0);
    assert_non_null(strstr(error.text, "--clip NEAR,FAR is needed"));
    end(&d);
  }
}

/* Nothing but plain letters: backwards, a half's largest for the sky, normals
 * of the camera; all is found out. */
static void unnamed(void **state) {
  (void)state;
  dump d = begin(SCENE_SKY);
  add_depth(&d, "", "Z", -1, -65504.0f);
  add_vectors(&d, "N", xyz, d.s.normal, AXES_OPENGL, 0);
  write_dump(&d);
  reading r = read_dump(&d);
  assert_int_equal(r.map.kind, DUMP_PLAIN);
  assert_int_equal(r.guessed.count, 3);
  same_geometry(&d, &r, rounding);
  no_findings(&r);
  done(&r);
  end(&d);
}

static void options_have_the_last_word(void **state) {
  (void)state;
  dump d = begin(SCENE_SKY);
  float *const turned[3] = {d.s.normal[0], d.s.normal[1], d.s.normal[2]};
  add_ray(&d, "far", "away", 0, 1000.0f);
  add_vectors(&d, "odd", words, turned, AXES_OPENGL, 0);
  add_colour(&d, "paint", rgb, d.s.albedo, NULL, 1);
  add_colour(&d, "lamp", rgb, d.s.direct, NULL, 1 / pi);
  for (size_t i = 0; i < PIXELS; i++)
    d.img.planes[2].pixels[i] *= -1.0f; /* odd.green */
  d.options.map = "depth=far.away,normal=odd,albedo=paint,direct=lamp";
  d.options.depth = DEPTH_RAY;
  d.options.normals = SPACE_CAMERA;
  d.options.encoded = 0;
  d.options.flips = 2;
  d.options.direct = DIRECT_LIGHT;
  d.options.sky_depth = 999.0f;
  write_dump(&d);
  reading r = read_dump(&d);
  same_geometry(&d, &r, rounding);
  same_light(&d, &r);
  no_findings(&r);
  done(&r);
  end(&d);
}

/* Depth, albedo and the rest each in a file; the albedo is a picture. */
static void one_file_a_pass(void **state) {
  (void)state;
  dump d = begin(SCENE_ROOM);
  dump depth = begin(SCENE_ROOM);
  char png[128];
  image_error error;
  unsigned char bytes[3 * PIXELS];
  snprintf(depth.path, sizeof depth.path, "%s/z.0004.exr", folder);
  snprintf(png, sizeof png, "%s/paint_0004.png", folder);
  depth.json = 0;
  add_depth(&depth, "Z", "", 1, 0);
  write_dump(&depth);
  for (size_t i = 0; i < 3 * PIXELS; i++) {
    const double v = (double)d.s.albedo[i % 3][i / 3];
    bytes[i] = (unsigned char)(255 * (v <= 0.0031308
                                          ? 12.92 * v
                                          : 1.055 * pow(v, 1 / 2.4) - 0.055) +
                               0.5);
  }
  assert_int_equal(png_write(png, bytes, WIDTH, HEIGHT, &error), 0);
  add_vectors(&d, "N", xyz, d.s.normal, AXES_WORLD, 0);
  d.options.map = "depth=z.#.exr:Z,albedo=paint_####.png";
  write_dump(&d);
  reading r = read_dump(&d);
  same_geometry(&d, &r, rounding);
  /* half a step of eight bits, where sRGB is steepest for light colours: 2.4 */
  assert_true(colour_error(&d, &r, ROLE_ALBEDO, d.s.albedo, 1, NULL) <=
              0.5 / 255 * 2.4);
  no_findings(&r);
  done(&r);
  unlink(png);
  end(&depth);
  end(&d);
}

/* A picture of which there is more, then one of which there is less. */
static void windows(void **state) {
  enum { MORE = 10 };
  (void)state;
  dump plain = begin(SCENE_ROOM);
  const hbil_camera *same = &plain.s.camera;
  const double lens = parallel ? (WIDTH + 2 * MORE) / same->fx
                               : 2 * atan((0.5 * HEIGHT + MORE) / same->fy);
  dump d = begin_sized(SCENE_ROOM, WIDTH + 2 * MORE, HEIGHT + 2 * MORE, lens);
  add_depth(&d, "depth", "Z", 1, 0);
  add_vectors(&d, "normal", xyz, d.s.normal, AXES_WORLD, 0);
  d.img.x = 7 - MORE;
  d.img.y = 5 - MORE;
  d.img.display = (image_window){7, 5, WIDTH, HEIGHT};
  write_dump(&d);
  reading r = read_dump(&d);
  assert_int_equal(r.map.display.width, WIDTH);
  assert_int_equal(r.g.planes.width, WIDTH + 2 * MORE);
  same_geometry(&d, &r, rounding);
  no_findings(&r);
  /* the camera of the picture alone is the same one, elsewhere */
  assert_true(fabs(r.camera.cx - plain.s.camera.cx - MORE) < 1e-9);
  assert_true(fabs(r.camera.fx - plain.s.camera.fx) < 1e-6);
  done(&r);
  end(&d);
  d = begin(SCENE_ROOM);
  add_depth(&d, "depth", "Z", 1, 0);
  add_vectors(&d, "normal", xyz, d.s.normal, AXES_WORLD, 0);
  d.img.x = 30;
  d.img.y = 20;
  d.img.display = (image_window){0, 0, 2 * WIDTH, 2 * HEIGHT};
  write_dump(&d);
  r = read_dump(&d);
  same_geometry(&d, &r, rounding);
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
  done(&r);
  end(&d);
  end(&plain);
}

/* The axis leaves the picture elsewhere than in its middle. */
static void off_centre(void **state) {
  enum { AWAY_X = 20, AWAY_Y = 10 };
  (void)state;
  for (int down = 0; down < 2; down++) {
    dump d = begin(SCENE_ROOM);
    const hbil_camera *c = &d.s.camera;
    const double w = WIDTH - AWAY_X, h = HEIGHT - AWAY_Y;
    const double middle[2] = {c->cx / w, down ? c->cy / h : 1 - c->cy / h};
    add_depth(&d, "depth", "Z", 1, 0);
    add_vectors(&d, "normal", xyz, d.s.normal, AXES_WORLD, 0);
    add_matrices(&d, AXES_WORLD, AXES_OPENGL, c->fx / w,
                 (down ? -1 : 1) * c->fy / h, middle, 1);
    d.img.display = (image_window){0, 0, (uint32_t)w, (uint32_t)h};
    write_dump(&d);
    reading r = read_dump(&d);
    same_geometry(&d, &r, matrices);
    no_findings(&r);
    done(&r);
    end(&d);
  }
}

/* ------------------------------------------------------------------------ */
/* Mistakes                                                                  */

/* So many findings, the last of which has the text. */
static void finds_last(dump *d, int count, const char *text) {
  write_dump(d);
  reading r = read_dump(d);
  const findings *check = &r.check.found;
  for (int i = 0; i < check->count; i++)
    if (!strstr(check->text[i], text) || check->count != count)
      print_error("found: %s\n", check->text[i]);
  assert_int_equal(check->count, count);
  assert_non_null(strstr(check->text[count - 1], text));
  done(&r);
  end(d);
}

static void finds(dump *d, const char *text) {
  finds_last(d, 1, text);
}

/* What every one of them begins with: hbil's own channels, by which nothing is
 * left to be guessed. */
static dump sound(scene_kind kind) {
  dump d = begin(kind);
  add_depth(&d, "depth", "Z", 1, 0);
  add_vectors(&d, "normal", xyz, d.s.normal, AXES_WORLD, 0);
  return d;
}

static float *plane_of(dump *d, const char *name) {
  image_plane *plane = image_find(&d->img, name);
  assert_non_null(plane);
  return plane->pixels;
}

static void sound_frames_have_none(void **state) {
  (void)state;
  for (int scene = 0; scene < SCENE_KINDS; scene++) {
    const uint32_t sizes[][2] = {{33, 17}, {64, 48}, {160, 90}, {480, 270}};
    for (int k = 0; k < 4; k++) {
      dump d = begin_sized((scene_kind)scene, sizes[k][0], sizes[k][1], 0.0);
      add_depth(&d, "depth", "Z", 1, 0);
      add_vectors(&d, "normal", xyz, d.s.normal, AXES_WORLD, 0);
      add_vectors(&d, "position", xyz, d.s.position, AXES_WORLD, 1);
      add_colour(&d, "albedo", rgb, d.s.albedo, NULL, 1);
      add_colour(&d, "direct", rgb, d.s.direct, NULL, 1);
      write_dump(&d);
      reading r = read_dump(&d);
      no_findings(&r);
      assert_true(r.check.facing > 0.999);
      done(&r);
      end(&d);
    }
  }
}

static void ray_for_planar(void **state) {
  (void)state;
  for (int ray = 0; ray < 2; ray++) {
    dump d = sound(SCENE_ROOM);
    d.options.depth = ray ? DEPTH_PLANAR : DEPTH_RAY;
    float *z = plane_of(&d, "depth.Z");
    for (size_t i = 0; ray && i < PIXELS; i++)
      z[i] *= (float)ray_length(&d, i);
    finds(&d, ray ? "--depth ray" : "--depth planar");
  }
}

static void positions_tell_it_as_well(void **state) {
  (void)state;
  dump d = sound(SCENE_ROOM);
  add_vectors(&d, "position", xyz, d.s.position, AXES_WORLD, 1);
  float *z = plane_of(&d, "depth.Z");
  for (size_t i = 0; i < PIXELS; i++)
    z[i] *= (float)ray_length(&d, i);
  write_dump(&d);
  reading r = read_dump(&d);
  assert_int_equal(r.check.found.count, 2);
  assert_non_null(strstr(r.check.found.text[1], "--depth ray"));
  done(&r);
  end(&d);
}

static void wrong_space(void **state) {
  (void)state;
  dump d = begin(SCENE_ROOM);
  add_depth(&d, "depth", "Z", 1, 0);
  add_vectors(&d, "normal", xyz, d.s.normal, AXES_OPENGL, 0);
  finds(&d, "--normals camera");
  d = begin(SCENE_ROOM);
  add_depth(&d, "depth", "Z", 1, 0);
  add_vectors(&d, "normal", xyz, d.s.normal, AXES_FORWARD, 0);
  finds(&d, "--normals camera --flip z");
  d = begin(SCENE_ROOM);
  add_depth(&d, "depth", "Z", 1, 0);
  add_vectors(&d, "normal", xyz, d.s.normal, AXES_MIRRORED, 0);
  finds(&d, "--normals world --flip x");
  d = sound(SCENE_ROOM);
  d.options.normals = SPACE_CAMERA;
  finds(&d, "--normals world");
}

static void encoded_normals(void **state) {
  (void)state;
  dump d = sound(SCENE_ROOM);
  for (size_t p = 1; p < 4; p++)
    for (size_t i = 0; i < PIXELS; i++)
      d.img.planes[p].pixels[i] = 0.5f * d.img.planes[p].pixels[i] + 0.5f;
  finds(&d, "--normals encoded");
}

/* Turned by five degrees about the vertical, elsewhere, or both in the units.
 */
static void camera_of_another_frame(void **state) {
  (void)state;
  dump d = sound(SCENE_ROOM);
  double *m = d.s.camera.world_from_view;
  const double c = cos(5 * pi / 180), s = sin(5 * pi / 180);
  for (int j = 0; j < 3; j++) {
    const double x = m[j], y = m[4 + j];
    m[j] = c * x - s * y;
    m[4 + j] = s * x + c * y;
  }
  finds(&d, "turned by 5.0 degrees: the camera of another frame");
  d = sound(SCENE_ROOM);
  add_vectors(&d, "position", xyz, d.s.position, AXES_WORLD, 1);
  d.s.camera.world_from_view[7] += 0.3;
  finds(&d, "the camera of another frame");
}

static void other_units(void **state) {
  (void)state;
  dump d = sound(SCENE_ROOM);
  add_vectors(&d, "position", xyz, d.s.position, AXES_WORLD, 1);
  for (size_t p = 0; p < d.img.count; p++)
    for (size_t i = 0; i < PIXELS && (p == 0 || p > 3); i++)
      d.img.planes[p].pixels[i] *= 100.0f;
  /* pixels of parallel rays keep their size while depth is stretched */
  finds_last(&d, parallel ? 2 : 1, "--unit-scale 0.01 ");
  d = sound(SCENE_ROOM); /* positions alone */
  add_vectors(&d, "position", xyz, d.s.position, AXES_WORLD, 1);
  for (size_t p = 4; p < d.img.count; p++)
    for (size_t i = 0; i < PIXELS; i++)
      d.img.planes[p].pixels[i] *= 100.0f;
  finds(&d, "100 times as far");
}

static void radius_of_other_units(void **state) {
  (void)state;
  dump d = sound(SCENE_ROOM);
  write_dump(&d);
  reading r = read_dump(&d);
  const struct {
    float radius;
    const char *text; /* NULL: nothing */
  } cases[] = {{1.0f, NULL},
               {0.05f, NULL},
               {INFINITY, NULL},
               {100.0f, "larger than all that is seen"},
               {0.001f, "less than a pixel"}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    r.config.radius = cases[i].radius;
    frame_check_run(&r.g, &r.config, &r.map.camera, &r.check);
    assert_int_equal(r.check.found.count, cases[i].text != NULL);
    if (cases[i].text)
      assert_non_null(strstr(r.check.found.text[0], cases[i].text));
  }
  done(&r);
  end(&d);
}

static void gamma_encoded(void **state) {
  (void)state;
  for (int answer = 0; answer < 2; answer++) {
    dump d = sound(SCENE_ROOM);
    /* of many colours, as a textured picture has */
    for (size_t c = 0; c < 3; c++) {
      float *out = add_plane(&d, "albedo", rgb[c]);
      for (size_t i = 0; i < PIXELS; i++)
        out[i] = (float)((i * 7 + c) % 256) / 255.0f;
    }
    if (!answer) {
      finds(&d, "albedo has whole parts of 255");
      continue;
    }
    d.options.gamma = 1;
    write_dump(&d);
    reading r = read_dump(&d);
    no_findings(&r);
    assert_true(
        fabs((double)gbuffer_plane(&r.g, ROLE_ALBEDO, 0)[128 * 183 % 256] -
             0.21586) < 1e-4); /* 7 i = 128: sRGB's middle grey */
    done(&r);
    end(&d);
  }
}

/* By its name, and by the light of a sky that no surface reflects. */
static void combined_for_radiance(void **state) {
  (void)state;
  dump d = sound(SCENE_ROOM);
  add_colour(&d, "Combined", rgb, d.s.direct, NULL, 1);
  d.options.map = "direct=Combined";
  finds(&d, "finished picture");
  d = sound(SCENE_SKY);
  add_colour(&d, "direct", rgb, d.s.direct, NULL, 1);
  for (size_t p = 4; p < 7; p++)
    for (size_t i = 0; i < PIXELS; i++)
      if (is_sky(&d, i))
        d.img.planes[p].pixels[i] = 0.5f;
  finds(&d, "finished picture");
}

static void depth_of_a_device(void **state) {
  (void)state;
  dump d = sound(SCENE_ROOM);
  float *z = plane_of(&d, "depth.Z");
  for (size_t i = 0; i < PIXELS; i++)
    z[i] = is_sky(&d, i) ? 0.0f : parallel ? z[i] / 100 : 1.0f - 0.1f / z[i];
  finds(&d, "--depth device");
  d = sound(SCENE_ROOM);
  memset(plane_of(&d, "depth.Z"), 0, sizeof(float) * PIXELS);
  finds(&d, "no pixel has a depth");
}

/* What cannot be done is said, and what would help. */
static void refusals(void **state) {
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
  (void)state;
  dump d = sound(SCENE_ROOM);
  write_dump(&d);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    d.options.map = cases[i].map;
    assert_int_not_equal(try_reading(&d, &r, &error), 0);
    if (!strstr(error.text, cases[i].text))
      fail_msg("%s: %s", cases[i].map, error.text);
  }
  end(&d);
  /* oblique rays; no camera at all; one that doesn't say where it stands */
  d = sound(SCENE_ROOM);
  add_matrices(&d, AXES_WORLD, AXES_OPENGL, 1, 1, half, 0);
  double *w = d.img.matrices.world_to_ndc + 12;
  w[0] = w[1] = w[2] = 0;
  w[3] = 1;
  write_dump(&d);
  assert_int_not_equal(try_reading(&d, &r, &error), 0);
  assert_non_null(strstr(error.text, "no perspective and no orthographic"));
  d.img.matrices.has_camera = 0;
  write_dump(&d);
  assert_int_not_equal(try_reading(&d, &r, &error), 0);
  assert_non_null(strstr(error.text, "--fov"));
  d.options.fov = 60.0f;
  assert_int_not_equal(try_reading(&d, &r, &error), 0);
  assert_non_null(strstr(error.text, "how the camera is turned"));
  end(&d);
}

/* ------------------------------------------------------------------------ */
/* Parallel rays                                                             */

/* A header in centimetres, of a camera that counts twice as many. */
static void units_of_a_header(void **state) {
  (void)state;
  dump d = begin(SCENE_ROOM);
  hbil_camera *c = &d.s.camera;
  image_matrices *m = &d.img.matrices;
  add_depth(&d, "depth", "Z", 100, 0);
  add_vectors(&d, "normal", xyz, d.s.normal, AXES_WORLD, 0);
  c->fx /= 100;
  c->fy /= 100;
  for (int i = 0; i < 3; i++)
    c->world_from_view[4 * i + 3] *= 100;
  add_matrices(&d, AXES_WORLD, AXES_OPENGL, 2 * c->fx / WIDTH,
               2 * c->fy / HEIGHT, zero, 1);
  for (int i = 0; i < 16; i++)
    m->world_to_camera[i] *= i == 15 ? 1 : 2;
  c->fx *= 100;
  c->fy *= 100;
  d.options.unit = 0.01f;
  write_dump(&d);
  reading r = read_dump(&d);
  same_geometry(&d, &r, matrices);
  for (int i = 0; i < 3; i++)
    assert_true(fabs(r.map.camera.world_from_view[4 * i + 3] -
                     0.01 * c->world_from_view[4 * i + 3]) < 1e-5);
  no_findings(&r);
  done(&r);
  end(&d);
}

static void picture_of_another_size(void **state) {
  (void)state;
  dump d = sound(SCENE_ROOM);
  d.options.orthographic = (float)(4 * WIDTH / d.s.camera.fx);
  finds(&d, "--orthographic");
}

/* Nothing that parallel rays show depends on how far away the camera stands:
 * not what a pixel is, nor how far off is what is elsewhere in the picture. */
static void far_away(void **state) {
  enum { AWAY = 1000 };
  (void)state;
  for (int elsewhere = 0; elsewhere < 2; elsewhere++) {
    dump d = sound(SCENE_ROOM);
    double *m = d.s.camera.world_from_view;
    add_vectors(&d, "position", xyz, d.s.position, AXES_WORLD, 1);
    float *z = plane_of(&d, "depth.Z");
    for (size_t i = 0; i < PIXELS; i++)
      z[i] += AWAY;
    for (int k = 0; k < 3; k++)
      m[4 * k + 3] -= AWAY * m[4 * k + 2] - (elsewhere ? 0.3 * m[4 * k] : 0);
    if (elsewhere) {
      finds(&d, "the camera of another frame");
      continue;
    }
    write_dump(&d);
    reading r = read_dump(&d);
    r.config.radius = 0.05f;
    frame_check_run(&r.g, &r.config, &r.map.camera, &r.check);
    no_findings(&r);
    done(&r);
    end(&d);
  }
}

/* Slats of eight rows that begin in the camera's plane: straight in depth, bent
 * in its inverse. */
static void steep_slats(void **state) {
  enum { SLAT = 8 };
  const double slope = 2; /* depth along the picture */
  const double length = sqrt(slope * slope + 1);
  (void)state;
  dump d = begin(SCENE_ROOM);
  add_plane(&d, "depth", "Z");
  for (int c = 0; c < 3; c++) {
    float *n = add_plane(&d, "normal", xyz[c]);
    for (size_t i = 0; i < PIXELS; i++)
      n[i] = (float)((c == 0 ? 0 : c == 1 ? -slope : 1) / length);
  }
  float *z = plane_of(&d, "depth.Z");
  for (size_t i = 0; i < PIXELS; i++)
    z[i] = (float)(slope * ((double)(i / WIDTH % SLAT) + 0.1) / d.s.camera.fy);
  d.options.normals = SPACE_CAMERA;
  write_dump(&d);
  reading r = read_dump(&d);
  assert_true(r.check.agreement > 0.999);
  no_findings(&r);
  done(&r);
  end(&d);
}

/* Whatever the file says of the lens, the options say another; and a file that
 * is taken for one of perspective doesn't fit. */
static void options_choose_the_lens(void **state) {
  (void)state;
  dump d = sound(SCENE_ROOM);
  const double fx = d.s.camera.fx;
  write_dump(&d);
  d.options.fov = 60;
  reading r = read_dump(&d);
  assert_int_equal(r.config.projection, HBIL_PROJECTION_PERSPECTIVE);
  assert_true(fabs(r.map.camera.fx - 0.5 * WIDTH / tan(pi / 6)) < 1e-9);
  assert_true(r.check.found.count > 0);
  done(&r);
  parallel = 0; /* the file's camera */
  write_dump(&d);
  parallel = 1;
  d.options.fov = 0;
  d.options.orthographic = (float)(WIDTH / fx);
  r = read_dump(&d);
  same_geometry(&d, &r, rounding);
  no_findings(&r);
  done(&r);
  image_error error;
  assert_int_not_equal(source_option(SOURCE_FOV, "60", &d.options, &error), 0);
  assert_non_null(strstr(error.text, "--fov and --orthographic: one of both"));
  end(&d);
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

static void json_sizes(void **state) {
  static const struct {
    const char *text;
    double scale;      /* 0: refused, */
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
  (void)state;
  snprintf(path, sizeof path, "%s/camera.json", folder);
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
static void the_scene_itself(void **state) {
  enum { WIDE = 320, HIGH = 180 };
  const double centre[3] = {0.8, 1.2, 0.745 + 0.17}, radius = 0.17;
  (void)state;
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

/* The same test, of parallel rays. */
#define PARALLEL(test)                                                         \
  { #test " (parallel rays)", test, see_parallel, see_perspective, NULL }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(blender),
      cmocka_unit_test(pbrt),
      cmocka_unit_test(mitsuba),
      cmocka_unit_test(arnold),
      cmocka_unit_test(vray),
      cmocka_unit_test(renderman),
      cmocka_unit_test(unreal),
      cmocka_unit_test(device_depths),
      cmocka_unit_test(unnamed),
      cmocka_unit_test(options_have_the_last_word),
      cmocka_unit_test(one_file_a_pass),
      cmocka_unit_test(windows),
      cmocka_unit_test(off_centre),
      cmocka_unit_test(sound_frames_have_none),
      cmocka_unit_test(ray_for_planar),
      cmocka_unit_test(positions_tell_it_as_well),
      cmocka_unit_test(wrong_space),
      cmocka_unit_test(encoded_normals),
      cmocka_unit_test(camera_of_another_frame),
      cmocka_unit_test(other_units),
      cmocka_unit_test(radius_of_other_units),
      cmocka_unit_test(gamma_encoded),
      cmocka_unit_test(combined_for_radiance),
      cmocka_unit_test(depth_of_a_device),
      cmocka_unit_test(refusals),
      PARALLEL(blender),
      PARALLEL(pbrt),
      PARALLEL(mitsuba),
      PARALLEL(arnold),
      PARALLEL(vray),
      PARALLEL(renderman),
      PARALLEL(unreal),
      PARALLEL(device_depths),
      PARALLEL(unnamed),
      PARALLEL(options_have_the_last_word),
      PARALLEL(windows),
      PARALLEL(off_centre),
      PARALLEL(sound_frames_have_none),
      PARALLEL(wrong_space),
      PARALLEL(camera_of_another_frame),
      PARALLEL(other_units),
      PARALLEL(radius_of_other_units),
      PARALLEL(depth_of_a_device),
      PARALLEL(units_of_a_header),
      PARALLEL(picture_of_another_size),
      PARALLEL(far_away),
      PARALLEL(steep_slats),
      PARALLEL(options_choose_the_lens),
      PARALLEL(json_sizes),
      PARALLEL(the_scene_itself),
  };
  if (!mkdtemp(folder))
    return 99;
  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  rmdir(folder);
  return failed;
}
