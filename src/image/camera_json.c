/* The camera beside a dump: a JSON file, through jansson. */
#include "image/image.h"
#include "image/temporary.h"

#include <jansson.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct parser {
  const char *path;
  const json_t *root;
  image_error *error;
} parser;

static int lacks(const parser *p, const char *field, const char *needed) {
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

static int read_number(const parser *p, const char *field, double *out) {
  return finite_number(json_object_get(p->root, field), out)
             ? 0
             : lacks(p, field, "a finite number");
}

static int read_positive(const parser *p, const char *field, double *out) {
  return finite_number(json_object_get(p->root, field), out) && *out > 0.0
             ? 0
             : lacks(p, field, "a number above zero (pixels)");
}

/* Four rows of four numbers. */
static int read_matrix(const parser *p, const char *field, double out[16]) {
  const json_t *rows = json_object_get(p->root, field);
  for (size_t i = 0; i < 16; i++) {
    const json_t *row = json_array_get(rows, i / 4);
    if (json_array_size(rows) != 4 || json_array_size(row) != 4 ||
        !finite_number(json_array_get(row, i % 4), &out[i]))
      return lacks(p, field, "a 4x4 array of finite numbers, row by row,");
  }
  return 0;
}

static int side(const json_t *value, uint32_t *out) {
  const json_int_t n = json_is_integer(value) ? json_integer_value(value) : 0;
  *out = n >= 1 && n <= INT32_MAX ? (uint32_t)n : 0;
  return *out != 0;
}

/* Optional: without it, width and height stay 0. */
static int read_resolution(const parser *p, camera_file *out) {
  const json_t *pair = json_object_get(p->root, "resolution");
  if (!pair)
    return 0;
  if (json_array_size(pair) != 2 ||
      !side(json_array_get(pair, 0), &out->width) ||
      !side(json_array_get(pair, 1), &out->height))
    return lacks(p, "resolution", "[width, height]");
  return 0;
}

static int parse(const parser *p, camera_file *out) {
  if (!json_is_object(p->root))
    return image_fail(p->error,
                      "%s: not a JSON object; an object with "
                      "camera_to_world, fx, fy, cx, cy is needed",
                      p->path);
  if (read_matrix(p, "camera_to_world", out->camera_to_world) != 0 ||
      read_positive(p, "fx", &out->fx) != 0 ||
      read_positive(p, "fy", &out->fy) != 0 ||
      read_number(p, "cx", &out->cx) != 0 ||
      read_number(p, "cy", &out->cy) != 0)
    return -1;
  return read_resolution(p, out);
}

int camera_read(const char *path, camera_file *out, image_error *error) {
  json_error_t why;
  memset(out, 0, sizeof *out);
  FILE *file = fopen(path, "rb");
  if (!file)
    return image_fail(error,
                      "%s: camera cannot be read: %s; a JSON file with "
                      "camera_to_world, fx, fy, cx, cy is needed",
                      path, strerror(errno));
  json_t *root = json_loadf(file, JSON_REJECT_DUPLICATES, &why);
  fclose(file);
  if (!root)
    return image_fail(error,
                      "%s: not JSON (line %d: %s); a camera file with "
                      "camera_to_world, fx, fy, cx, cy is needed",
                      path, why.line, why.text);
  const parser p = {path, root, error};
  const int failed = parse(&p, out);
  json_decref(root);
  return failed;
}

static json_t *matrix_json(const double m[16]) {
  json_t *rows = json_array();
  for (int i = 0; i < 4; i++)
    json_array_append_new(rows, json_pack("[f,f,f,f]", m[4 * i], m[4 * i + 1],
                                          m[4 * i + 2], m[4 * i + 3]));
  return rows;
}

int camera_write(const char *path, const camera_file *camera,
                 image_error *error) {
  char *temporary = temporary_name(path, error);
  if (!temporary)
    return -1;
  json_t *root =
      json_pack("{s:[i,i], s:o, s:f, s:f, s:f, s:f}", "resolution",
                (int)camera->width, (int)camera->height, "camera_to_world",
                matrix_json(camera->camera_to_world), "fx", camera->fx, "fy",
                camera->fy, "cx", camera->cx, "cy", camera->cy);
  if (!root) {
    free(temporary);
    return image_fail(error,
                      "%s: camera cannot be written: its numbers must "
                      "be finite",
                      path);
  }
  const int failed = json_dump_file(root, temporary, JSON_INDENT(2));
  json_decref(root);
  if (failed) {
    temporary_discard(temporary);
    return image_fail(error, "%s: cannot be written: %s", path,
                      strerror(errno));
  }
  return temporary_commit(temporary, path, error);
}
