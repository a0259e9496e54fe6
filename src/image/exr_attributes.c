#include "image/exr_attributes.h"
#include "image/exr_key.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void exr_attributes_windows(const exr_file *f, image *out) {
  out->x = f->window.min.x;
  out->y = f->window.min.y;
  out->width = f->width;
  out->height = f->height;
  exr_attr_box2i_t box;
  if (exr_get_display_window(f->context, 0, &box) != EXR_ERR_SUCCESS)
    return;
  const int64_t width = exr_extent(box.min.x, box.max.x);
  const int64_t height = exr_extent(box.min.y, box.max.y);
  /* A display window of impossible size is treated as missing. */
  if (width >= 1 && height >= 1 && width <= EXR_MAX_SIDE &&
      height <= EXR_MAX_SIDE)
    out->display =
        (image_window){box.min.x, box.min.y, (uint32_t)width, (uint32_t)height};
}

/* Returns the text of an attribute, which need not end with '\0', or NULL. */
static const char *read_string(const exr_file *f, const char *name,
                               int *length) {
  const char *text = NULL;
  int32_t size = 0;
  if (exr_attr_get_string(f->context, 0, name, &size, &text) !=
          EXR_ERR_SUCCESS ||
      size < 0)
    return NULL;
  *length = size;
  return text;
}

static int read_matrix(const exr_file *f, const char *name, double out[16]) {
  exr_attr_m44f_t m;
  if (exr_attr_get_m44f(f->context, 0, name, &m) != EXR_ERR_SUCCESS)
    return 0;
  for (int i = 0; i < 16; i++)
    out[i] = (double)m.m[i];
  return 1;
}

static float read_float(const exr_file *f, const char *name) {
  float value = 0.0f;
  return exr_attr_get_float(f->context, 0, name, &value) == EXR_ERR_SUCCESS
             ? value
             : 0.0f;
}

static void append_origin(image *out, const char *word, int length) {
  const size_t used = strlen(out->origin);
  snprintf(out->origin + used, sizeof out->origin - used, "%s%.*s",
           used ? " " : "", length, word);
}

/* Programs name themselves in a text attribute, or prefix the names of their
 * attributes with their own name and a slash. */
static void read_origin(const exr_file *f, image *out) {
  static const char *const names[] = {"Software", "software", "generatedBy",
                                      "BlenderMultiChannel"};
  int32_t count = 0;
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    int length = 0;
    const char *text = read_string(f, names[i], &length);
    if (text)
      append_origin(out, text, length);
  }
  exr_get_attribute_count(f->context, 0, &count);
  for (int32_t i = 0; i < count; i++) {
    const exr_attribute_t *attribute = NULL;
    if (exr_get_attribute_by_index(f->context, 0, EXR_ATTR_LIST_FILE_ORDER, i,
                                   &attribute) != EXR_ERR_SUCCESS)
      return;
    const char *slash = strchr(attribute->name, '/');
    if (slash) {
      append_origin(out, attribute->name, (int)(slash - attribute->name));
      return;
    }
  }
}

/* The views of a multi-view file. */
static void read_views(const exr_file *f, image *out) {
  const exr_attribute_t *attribute = NULL;
  if (exr_get_attribute_by_name(f->context, 0, "multiView", &attribute) !=
          EXR_ERR_SUCCESS ||
      attribute->type != EXR_ATTR_STRING_VECTOR)
    return;
  const exr_attr_string_vector_t *names = attribute->stringvector;
  for (int32_t i = 0; i < names->n_strings && i < IMAGE_VIEWS; i++)
    snprintf(out->views[out->view_count++], IMAGE_VIEW_NAME, "%.*s",
             (int)names->strings[i].length, names->strings[i].str);
}

/* A number, or a text that is one; NaN: neither. */
static double number_of(const exr_attribute_t *attribute) {
  char text[32], *end;
  if (attribute->type == EXR_ATTR_FLOAT)
    return (double)attribute->f;
  if (attribute->type == EXR_ATTR_DOUBLE)
    return attribute->d;
  if (attribute->type == EXR_ATTR_INT)
    return attribute->i;
  if (attribute->type != EXR_ATTR_STRING || attribute->string->length <= 0 ||
      attribute->string->length >= (int32_t)sizeof text)
    return (double)NAN;
  snprintf(text, sizeof text, "%.*s", (int)attribute->string->length,
           attribute->string->str);
  const double value = strtod(text, &end);
  return *end ? (double)NAN : value;
}

static void read_numbers(const exr_file *f, image *out) {
  int32_t count = 0;
  exr_get_attribute_count(f->context, 0, &count);
  out->numbers = count > 0 ? calloc(IMAGE_NUMBERS, sizeof *out->numbers) : NULL;
  for (int32_t i = 0;
       out->numbers && i < count && out->number_count < IMAGE_NUMBERS; i++) {
    const exr_attribute_t *attribute = NULL;
    if (exr_get_attribute_by_index(f->context, 0, EXR_ATTR_LIST_FILE_ORDER, i,
                                   &attribute) != EXR_ERR_SUCCESS)
      return;
    const double value = number_of(attribute);
    image_number *number = &out->numbers[out->number_count];
    /* every file has the two, and hbil's own aren't for others */
    if (!isfinite(value) || strlen(attribute->name) >= sizeof number->name ||
        strncmp(attribute->name, "hbil", 4) == 0 ||
        strcmp(attribute->name, "pixelAspectRatio") == 0 ||
        strcmp(attribute->name, "screenWindowWidth") == 0)
      continue;
    strcpy(number->name, attribute->name);
    number->value = value;
    out->number_count++;
  }
}

void exr_attributes_describe(exr_file *f, image *out) {
  image_matrices *m = &out->matrices;
  int length = 0;
  const char *key = read_string(f, EXR_KEY, &length);
  if (key)
    snprintf(out->key, sizeof out->key, "%.*s", length, key);
  out->near_radius = read_float(f, EXR_NEAR_RADIUS);
  out->ao_radius = read_float(f, EXR_AO_RADIUS);
  m->has_camera = read_matrix(f, "worldToCamera", m->world_to_camera);
  m->has_ndc = read_matrix(f, "worldToNDC", m->world_to_ndc);
  read_origin(f, out);
  read_views(f, out);
  read_numbers(f, out);
  /* The library has reported each attribute that is missing, which is no
   * mistake of the file. */
  f->stream.message[0] = '\0';
}
