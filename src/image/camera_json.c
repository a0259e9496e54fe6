#include "image/camera_json.h"
#include "image/regular_file.h"
#include "image/temporary.h"

#include <jansson.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Values beyond these belong to no camera, and would overflow in single
 * precision, which also has to hold squares of positions. */
#define MOST_PIXELS 1e9
#define LEAST_PIXELS 1e-6
#define MOST_UNITS 1e18

typedef struct parser {
  const char *path;
  const json_t *root;
  image_error *error;
} parser;

/* Reports that a field is missing, or wrong if the object has it. */
static int fail_field(const parser *p, const char *field, const char *needed) {
  return image_fail(
      p->error, "%s: field %s is %s; %s is needed", p->path, field,
      json_object_get(p->root, field) ? "wrong" : "missing", needed);
}

static int finite_number(const json_t *value, double *out) {
  if (!json_is_number(value))
    return 0;
  *out = json_number_value(value);
  return isfinite(*out);
}

/* Four rows of four numbers. */
static int read_matrix(const parser *p, const char *field, double out[16]) {
  const json_t *rows = json_object_get(p->root, field);
  for (size_t i = 0; i < 16; i++) {
    const json_t *row = json_array_get(rows, i / 4);
    if (json_array_size(rows) != 4 || json_array_size(row) != 4 ||
        !finite_number(json_array_get(row, i % 4), &out[i]))
      return fail_field(p, field, "a 4x4 array of finite numbers, row by row,");
  }
  return 0;
}

static int read_centre(const parser *p, const char *field, double *out) {
  return finite_number(json_object_get(p->root, field), out) &&
                 fabs(*out) <= MOST_PIXELS
             ? 0
             : fail_field(p, field, "a number of pixels, at most 1e9,");
}

static int is_focal(double pixels) {
  return pixels >= LEAST_PIXELS && pixels <= MOST_PIXELS;
}

static int read_focal(const parser *p, const char *field, double *out) {
  return finite_number(json_object_get(p->root, field), out) && is_focal(*out)
             ? 0
             : fail_field(p, field, "a number of pixels, 1e-6 to 1e9,");
}

static double column_product(const double m[16], int a, int b) {
  return m[a] * m[b] + m[4 + a] * m[4 + b] + m[8 + a] * m[8 + b];
}

static double determinant(const double m[16]) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) +
         m[1] * (m[6] * m[8] - m[4] * m[10]) +
         m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/* hbil_enqueue_frame() accepts the same matrices.  The tolerance of 1e-3 is
 * larger than the rounding of a float matrix and smaller than any scale or
 * shear that is meant. */
static int is_rigid(const double m[16]) {
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      if (!(fabs(column_product(m, a, b) - (a == b)) <= 1e-3))
        return 0;
  for (int c = 0; c < 4; c++)
    if (fabs(m[12 + c] - (c == 3)) > 1e-3 ||
        (c < 3 && fabs(m[4 * c + 3]) > MOST_UNITS))
      return 0;
  return determinant(m) > 0.0;
}

static int read_pose(const parser *p, const char *field, double out[16]) {
  if (read_matrix(p, field, out) != 0)
    return -1;
  return is_rigid(out)
             ? 0
             : fail_field(p, field,
                          "a rigid transform (unit columns at right "
                          "angles, not mirrored, last row 0 0 0 1, not "
                          "beyond 1e18)");
}

static int read_side(const json_t *value, uint32_t *out) {
  const json_int_t n = json_is_integer(value) ? json_integer_value(value) : 0;
  *out = n >= 1 && n <= INT32_MAX ? (uint32_t)n : 0;
  return *out != 0;
}

/* This field is optional. */
static int read_resolution(const parser *p, camera_file *out) {
  const json_t *pair = json_object_get(p->root, "resolution");
  if (!pair)
    return 0;
  if (json_array_size(pair) != 2 ||
      !read_side(json_array_get(pair, 0), &out->width) ||
      !read_side(json_array_get(pair, 1), &out->height))
    return fail_field(p, "resolution", "[width, height]");
  return 0;
}

/* These fields are optional; one without the other is ignored. */
static int read_clipping(const parser *p, camera_file *out) {
  const json_t *near = json_object_get(p->root, "near");
  const json_t *far = json_object_get(p->root, "far");
  if (!near || !far)
    return 0;
  if (!finite_number(near, &out->near) || !finite_number(far, &out->far) ||
      !(out->near >= 0.0) || !(out->far > out->near))
    return fail_field(p, "near", "a distance below that of far");
  return 0;
}

/* This field is optional. */
static int read_exposure(const parser *p, camera_file *out) {
  const json_t *field = json_object_get(p->root, "exposure");
  return !field || (finite_number(field, &out->exposure) &&
                    out->exposure >= CAMERA_LEAST_EXPOSURE &&
                    out->exposure <= CAMERA_MOST_EXPOSURE)
             ? 0
             : fail_field(p, "exposure", "a factor of 1e-12 to 1e12");
}

/* This field is optional; the default is perspective. */
static int read_projection(const parser *p, camera_file *out) {
  const json_t *field = json_object_get(p->root, "projection");
  const char *kind = json_string_value(field);
  out->orthographic = kind && strcmp(kind, "orthographic") == 0;
  return !field || out->orthographic ||
                 (kind && strcmp(kind, "perspective") == 0)
             ? 0
             : fail_field(p, "projection",
                          "\"perspective\" or \"orthographic\"");
}

/* Converts Blender's size of an orthographic camera, which is the number of
 * world units along the longer side of the picture.  It needs the resolution.
 */
static int read_scale(const parser *p, const json_t *scale, camera_file *out) {
  double units;
  if (json_object_get(p->root, "fx") || json_object_get(p->root, "fy"))
    return fail_field(p, "ortho_scale", "either it, or fx and fy,");
  if (!out->width)
    return fail_field(p, "resolution", "[width, height] beside ortho_scale");
  if (!finite_number(scale, &units) || !(units > 0.0))
    return fail_field(p, "ortho_scale", "a positive number of world units");
  out->fx = out->fy =
      (out->width > out->height ? out->width : out->height) / units;
  return is_focal(out->fx) ? 0
                           : fail_field(p, "ortho_scale",
                                        "1e-6 to 1e9 pixels to a world unit");
}

static int read_lens(const parser *p, camera_file *out) {
  const json_t *scale = json_object_get(p->root, "ortho_scale");
  if (out->orthographic && scale)
    return read_scale(p, scale, out);
  return read_focal(p, "fx", &out->fx) != 0 ? -1
                                            : read_focal(p, "fy", &out->fy);
}

static int parse(const parser *p, camera_file *out) {
  if (!json_is_object(p->root))
    return image_fail(p->error,
                      "%s: not a JSON object; an object with "
                      "camera_to_world, fx, fy, cx, cy is needed",
                      p->path);
  return read_pose(p, "camera_to_world", out->camera_to_world) != 0 ||
                 read_resolution(p, out) != 0 || read_projection(p, out) != 0 ||
                 read_lens(p, out) != 0 ||
                 read_centre(p, "cx", &out->cx) != 0 ||
                 read_centre(p, "cy", &out->cy) != 0 ||
                 read_clipping(p, out) != 0 || read_exposure(p, out) != 0
             ? -1
             : 0;
}

static int fail_to_read(const char *path, const char *why, image_error *error) {
  return image_fail(error,
                    "%s: camera cannot be read: %s; a JSON file with "
                    "camera_to_world, fx, fy, cx, cy is needed",
                    path, why);
}

static int read_limited(FILE *file, const char *path, char *text, size_t *size,
                        image_error *error) {
  *size = fread(text, 1, CAMERA_FILE_MOST + 1, file);
  if (ferror(file))
    return fail_to_read(path, strerror(errno), error);
  if (*size > CAMERA_FILE_MOST)
    return image_fail(error,
                      "%s: larger than %d KiB; a camera file with "
                      "camera_to_world, fx, fy, cx, cy is needed",
                      path, CAMERA_FILE_MOST >> 10);
  return 0;
}

/* Returns the content of the file, which the caller frees, or NULL.  jansson
 * reads files itself, but without a limit of size, and its errors give only a
 * position from which last_field() finds the field. */
static char *read_text(const char *path, size_t *size, image_error *error) {
  const char *why;
  FILE *file = regular_file_stream(path, &why);
  if (!file) {
    fail_to_read(path, why, error);
    return NULL;
  }
  char *text = malloc(CAMERA_FILE_MOST + 1);
  const int failed = text ? read_limited(file, path, text, size, error)
                          : image_no_memory(error, path);
  fclose(file);
  if (!failed)
    return text;
  free(text);
  return NULL;
}

/* Finds the field in which the parser stopped: the name before the last colon
 * that precedes the position.  Returns its length, 0 if there is none. */
static int last_field(const char *text, size_t at, const char **name) {
  while (at > 0 && text[at - 1] != ':')
    at--;
  while (at > 0 && text[at - 1] != '"')
    at--;
  const size_t end = at > 0 ? at - 1 : 0;
  size_t begin = end;
  while (begin > 0 && text[begin - 1] != '"')
    begin--;
  *name = text + begin;
  return end - begin < 64 ? (int)(end - begin) : 0;
}

static int fail_syntax(const char *path, const char *text,
                       const json_error_t *why, image_error *error) {
  const char *field;
  const int length =
      last_field(text, why->position > 0 ? (size_t)why->position : 0, &field);
  return image_fail(error,
                    "%s: not JSON (line %d%s%.*s: %s); a camera file with "
                    "camera_to_world, fx, fy, cx, cy is needed",
                    path, why->line, length ? ", field " : "", length, field,
                    why->text);
}

int camera_read(const char *path, camera_file *out, image_error *error) {
  json_error_t why;
  size_t size;
  memset(out, 0, sizeof *out);
  char *text = read_text(path, &size, error);
  if (!text)
    return -1;
  json_t *root = json_loadb(text, size, JSON_REJECT_DUPLICATES, &why);
  const parser p = {path, root, error};
  const int failed =
      root ? parse(&p, out) : fail_syntax(path, text, &why, error);
  json_decref(root);
  free(text);
  return failed;
}

/* Returns NULL if a number is not finite, which JSON can't express. */
static json_t *camera_object(const camera_file *camera) {
  const double *m = camera->camera_to_world;
  json_t *matrix = json_pack("[[f,f,f,f],[f,f,f,f],[f,f,f,f],[f,f,f,f]]", m[0],
                             m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8],
                             m[9], m[10], m[11], m[12], m[13], m[14], m[15]);
  const int clips = camera->far > 0.0;
  /* s* and o* leave out what is NULL, o fails for a NULL object. */
  return json_pack("{s:[i,i], s:o, s:f, s:f, s:f, s:f, s:s*, s:o*, s:o*, s:o*}",
                   "resolution", (int)camera->width, (int)camera->height,
                   "camera_to_world", matrix, "fx", camera->fx, "fy",
                   camera->fy, "cx", camera->cx, "cy", camera->cy, "projection",
                   camera->orthographic ? "orthographic" : NULL, "near",
                   clips ? json_real(camera->near) : NULL, "far",
                   clips ? json_real(camera->far) : NULL, "exposure",
                   camera->exposure > 0.0 ? json_real(camera->exposure) : NULL);
}

static void write_json(const void *root, FILE *out) {
  json_dumpf(root, out, JSON_INDENT(2));
}

int camera_write(const char *path, const camera_file *camera,
                 image_error *error) {
  json_t *root = camera_object(camera);
  if (!root)
    return image_fail(error,
                      "%s: camera cannot be written: its numbers must "
                      "be finite",
                      path);
  const int failed =
      temporary_write(path, EXISTING_REPLACED, write_json, root, error);
  json_decref(root);
  return failed;
}
