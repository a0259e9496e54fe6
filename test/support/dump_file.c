#define _POSIX_C_SOURCE 200809L /* mkdtemp */
#include "test/support/dump_file.h"

#include <stdio.h>
#include <unistd.h>

#include "dump/surface_points.h"
#include "image/exr_write.h"
#include "image/image_read.h"

char dump_folder[] = "/tmp/hbil-dumps.XXXXXX";
int dump_orthographic;

int main(void) {
  if (!mkdtemp(dump_folder))
    return 99;
  const int failures = tests_run();
  rmdir(dump_folder);
  return failures;
}

int dump_see_orthographic(void **state) {
  (void)state;
  dump_orthographic = 1;
  return 0;
}

int dump_see_perspective(void **state) {
  (void)state;
  dump_orthographic = 0;
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Writing                                                                   */

const char *const letters_xyz[] = {"X", "Y", "Z"};
const char *const letters_rgb[] = {"R", "G", "B"};
const char *const letters_small_rgb[] = {"r", "g", "b"};
const char *const letters_words[] = {"red", "green", "blue"};

dump dump_begin_sized(scene_kind kind, uint32_t width, uint32_t height,
                      double lens) {
  dump d;
  memset(&d, 0, sizeof d);
  assert_int_equal((dump_orthographic
                        ? scene_render_orthographic
                        : scene_render)(kind, width, height, lens, 3, &d.s),
                   0);
  d.img.width = width;
  d.img.height = height;
  d.json = 1;
  source_options_init(&d.options);
  snprintf(d.path, sizeof d.path, "%s/frame_0004.exr", dump_folder);
  return d;
}

dump dump_begin(scene_kind kind) {
  return dump_begin_sized(kind, WIDTH, HEIGHT, 0.0);
}

dump dump_begin_plain(scene_kind kind) {
  dump d = dump_begin(kind);
  dump_add_depth(&d, "depth", "Z", 1, 0);
  dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_WORLD, 0);
  return d;
}

size_t dump_pixels(const dump *d) {
  return (size_t)d->s.width * d->s.height;
}

void dump_end(dump *d) {
  char json[sizeof d->path];
  snprintf(json, sizeof json, "%s/frame_0004.json", dump_folder);
  unlink(d->path);
  unlink(json);
  image_free(&d->img);
  scene_free(&d->s);
}

float *dump_add_plane(dump *d, const char *pass, const char *letter) {
  char name[128];
  snprintf(name, sizeof name, "%s%s%s", pass, *pass && *letter ? "." : "",
           letter);
  image_plane *plane = image_add(&d->img, name);
  assert_non_null(plane);
  return plane->pixels;
}

float *dump_plane(dump *d, const char *name) {
  image_plane *plane = image_find(&d->img, name);
  assert_non_null(plane);
  return plane->pixels;
}

int dump_is_sky(const dump *d, size_t i) {
  return !(d->s.depth[i] > 0.0f);
}

double dump_ray_length(const dump *d, size_t i) {
  const hbil_camera *c = &d->s.camera;
  if (dump_orthographic)
    return 1;
  const double x = ((double)(i % d->s.width) + 0.5 - c->cx) / c->fx;
  const double y = ((double)(i / d->s.width) + 0.5 - c->cy) / c->fy;
  return sqrt(x * x + y * y + 1);
}

void dump_add_depth(dump *d, const char *pass, const char *letter, double scale,
                    float sky) {
  float *out = dump_add_plane(d, pass, letter);
  for (size_t i = 0; i < dump_pixels(d); i++)
    out[i] = dump_is_sky(d, i) ? sky : (float)((double)d->s.depth[i] * scale);
}

void dump_add_ray(dump *d, const char *pass, const char *letter, double near,
                  float sky) {
  float *out = dump_add_plane(d, pass, letter);
  for (size_t i = 0; i < dump_pixels(d); i++)
    out[i] =
        dump_is_sky(d, i)
            ? sky
            : (float)(((double)d->s.depth[i] - near) * dump_ray_length(d, i));
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

void dump_add_vectors(dump *d, const char *pass, const char *const letters[3],
                      float *const in[3], axes a, double w) {
  float *out[3];
  for (int c = 0; c < 3; c++)
    out[c] = dump_add_plane(d, pass, letters[c]);
  for (size_t i = 0; i < dump_pixels(d); i++) {
    const double world[3] = {in[0][i], in[1][i], in[2][i]};
    double v[3] = {0};
    if (!dump_is_sky(d, i))
      in_axes(d, a, world, w, v);
    for (int c = 0; c < 3; c++)
      out[c][i] = (float)v[c];
  }
}

void dump_add_colour(dump *d, const char *pass, const char *const letters[3],
                     float *const in[3], float *const times[3], double scale) {
  for (int c = 0; c < 3; c++) {
    float *out = dump_add_plane(d, pass, letters[c]);
    for (size_t i = 0; i < dump_pixels(d); i++)
      out[i] = (float)((double)in[c][i] * scale *
                       (times ? (double)times[c][i] : 1.0));
  }
}

static void transpose(double m[16]) {
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < i; j++) {
      const double other = m[4 * i + j];
      m[4 * i + j] = m[4 * j + i];
      m[4 * j + i] = other;
    }
}

void dump_add_matrices(dump *d, axes world, axes camera, double scale_x,
                       double scale_y, const double middle[2], int rows) {
  image_matrices *m = &d->img.matrices;
  const double *from = d->s.camera.world_from_view;
  const double forwards = camera == AXES_LEFT_HANDED ? 1 : -1;
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
    const double divisor = dump_orthographic ? k == 3 : z;
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

void dump_write(dump *d) {
  image_error error;
  char json[sizeof d->path];
  const hbil_camera *c = &d->s.camera;
  camera_file camera = {.orthographic = dump_orthographic,
                        .fx = c->fx,
                        .fy = c->fy,
                        .cx = c->cx,
                        .cy = c->cy,
                        .near = d->near,
                        .far = d->far};
  for (int i = 0; i < 16; i++)
    camera.camera_to_world[i] =
        c->world_from_view[i] * (i % 4 == 1 || i % 4 == 2 ? -1 : 1);
  camera.width = d->img.display.width ? d->img.display.width : d->s.width;
  camera.height = d->img.display.width ? d->img.display.height : d->s.height;
  camera.cx += d->img.x - d->img.display.x;
  camera.cy += d->img.y - d->img.display.y;
  snprintf(json, sizeof json, "%s/frame_0004.json", dump_folder);
  assert_int_equal(exr_write(d->path, &d->img, NULL, &error), 0);
  if (d->json)
    assert_int_equal(camera_write(json, &camera, &error), 0);
}

/* ------------------------------------------------------------------------ */
/* Reading                                                                   */

int dump_try_reading(const dump *d, reading *r, image_error *error) {
  image header;
  memset(r, 0, sizeof *r);
  error->text[0] = '\0';
  if (image_read_header(d->path, &header, error) != 0)
    return -1;
  int failed =
      channel_map_read(d->path, &header, &d->options, &r->map, error) != 0 ||
      channel_map_check(&r->map, d->path, error) != 0 ||
      frame_camera_read(d->path, &header, &r->map, NULL, &d->options, &r->seen,
                        NULL, error) != 0 ||
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

reading dump_read(const dump *d) {
  reading r;
  image_error error;
  if (dump_try_reading(d, &r, &error) != 0)
    fail_msg("%s", error.text);
  return r;
}

reading dump_reading(dump *d) {
  dump_write(d);
  return dump_read(d);
}

void reading_free(reading *r) {
  gbuffer_free(&r->g);
  channel_map_free(&r->map);
}

void dump_done(dump *d, reading *r) {
  reading_free(r);
  dump_end(d);
}

void assert_no_findings(const reading *r) {
  for (int i = 0; i < r->check.found.count; i++)
    print_error("found: %s\n", r->check.found.text[i]);
  assert_int_equal(r->check.found.count, 0);
}

double relative_difference(double a, double b) {
  return fabs(a - b) / fmax(1.0, fabs(b));
}

double reading_depth_error(const dump *d, const reading *r) {
  const surface_points s = surface_points_of(&r->g, &r->map.camera);
  double worst = 0;
  for (size_t i = 0; i < dump_pixels(d); i++) {
    const double depth = surface_depth(&s, i % d->s.width, i / d->s.width);
    const int surface = depth > 0.0;
    if (surface == dump_is_sky(d, i))
      return INFINITY;
    if (surface)
      worst = fmax(worst, fabs(depth / (double)d->s.depth[i] - 1));
  }
  return worst;
}

/* In view space, so that a world that was mirrored counts as the same. */
static double reading_normal_error(const dump *d, const reading *r) {
  const double *m = r->map.camera.world_from_view;
  const double *w = d->s.camera.world_from_view;
  double worst = 0;
  for (size_t i = 0; i < dump_pixels(d); i++)
    for (int c = 0; c < 3 && !dump_is_sky(d, i); c++) {
      double is = 0, wanted = 0;
      for (int k = 0; k < 3; k++) {
        const double n =
            (double)gbuffer_plane(&r->g, ROLE_NORMAL, (size_t)k)[i] *
            (double)r->config.inputs.normal_scale[k];
        const int world = r->config.inputs.normal_space == HBIL_SPACE_WORLD;
        is += n * (world ? m[4 * k + c] : k == c);
        wanted += (double)d->s.normal[k][i] * w[4 * k + c];
      }
      worst = fmax(worst, fabs(is - wanted));
    }
  return worst;
}

double reading_colour_error(const dump *d, const reading *r, role which,
                            float *const wanted[3], double scale,
                            const float *const counts[3]) {
  double worst = 0;
  for (size_t c = 0; c < 3; c++)
    for (size_t i = 0; i < dump_pixels(d); i++)
      if (!counts || counts[c][i] > 0.0f)
        worst =
            fmax(worst, relative_difference(
                            (double)gbuffer_plane(&r->g, which, c)[i] * scale,
                            (double)wanted[c][i]));
  return worst;
}

void assert_same_geometry(const dump *d, const reading *r, double most) {
  const hbil_camera *is = &r->map.camera, *wanted = &d->s.camera;
  assert_int_equal(r->config.inputs.projection, d->s.projection);
  assert_true(reading_depth_error(d, r) <= most);
  assert_true(reading_normal_error(d, r) <= most);
  assert_true(relative_difference(is->fx, wanted->fx) <= most);
  assert_true(relative_difference(is->fy, wanted->fy) <= most);
  assert_true(relative_difference(is->cx, wanted->cx) <= most);
  assert_true(relative_difference(is->cy, wanted->cy) <= most);
}

void assert_same_light(const dump *d, const reading *r) {
  const double scale = (double)r->config.inputs.direct_scale;
  const int divided = r->map.how.direct == DIRECT_RADIANCE;
  const float *const albedo[3] = {d->s.albedo[0], d->s.albedo[1],
                                  d->s.albedo[2]};
  assert_true(reading_colour_error(d, r, ROLE_ALBEDO, d->s.albedo, 1, NULL) <=
              2e-6);
  assert_true(reading_colour_error(d, r, ROLE_DIRECT, d->s.direct, scale,
                                   divided ? albedo : NULL) <= 2e-6);
}
