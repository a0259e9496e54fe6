/* The results that the program writes, and which planes feed the library. */
#include "tool/layers.h"
#include "image/image_memory.h"

#include <stdio.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* Layers                                                                    */

#define LAYER(field, components)                                               \
  {                                                                            \
#field, components, offsetof(hbil_config, outputs.field),                  \
        offsetof(hbil_frame, field)                                            \
  }

const layer_info layer_table[LAYERS_WRITTEN] = {
    LAYER(near_irradiance, "RGB"), LAYER(far_irradiance, "RGB"),
    LAYER(indirect, "RGB"),        LAYER(ao, "V"),
    LAYER(bent_normal, "XYZ"),     LAYER(cone_cosine, "V"),
    LAYER(beauty, "RGB"),          LAYER(unknown, "V"),
    LAYER(glossy, "RGB"),          LAYER(error_estimate, "XY"),
    {"beauty", "A", 0, 0},
};

int layers_is_light(layer l, size_t i) {
  return strcmp(layer_table[l].components, "RGB") == 0 ||
         (l == LAYER_ERROR_ESTIMATE && i == 1);
}

unsigned layers_of_mode(hbil_mode mode) {
  /* Another plane of floats costs some percent of a file and of the time to
   * write it, which is what limits most jobs. */
  const unsigned all = (1u << LAYER_UNKNOWN) - 1u;
  const unsigned cone = 1u << LAYER_BENT_NORMAL | 1u << LAYER_CONE_COSINE;
  if (mode == HBIL_MODE_HBIL)
    return all;
  return all &
         ~(1u << LAYER_NEAR_IRRADIANCE | (mode == HBIL_MODE_HBAO ? cone : 0u));
}

unsigned layers_possible(hbil_mode mode, int exact) {
  const unsigned error =
      exact || mode == HBIL_MODE_HBAO ? 0u : 1u << LAYER_ERROR_ESTIMATE;
  const unsigned unknown = mode == HBIL_MODE_HBIL ? 1u << LAYER_UNKNOWN : 0u;
  const unsigned glossy =
      exact || mode != HBIL_MODE_HBIL ? 0u : 1u << LAYER_GLOSSY;
  return layers_of_mode(mode) | unknown | glossy | error;
}

int layers_show_guesses(unsigned layers, const hbil_config *config) {
  const unsigned light = 1u << LAYER_NEAR_IRRADIANCE |
                         1u << LAYER_FAR_IRRADIANCE | 1u << LAYER_INDIRECT |
                         1u << LAYER_BEAUTY | 1u << LAYER_UNKNOWN;
  const hbil_model *m = &config->model;
  return m->mode == HBIL_MODE_HBIL && (layers & light) != 0 &&
         (m->far_field == HBIL_FAR_FRAME ||
          (m->back_facing_fallback == HBIL_FALLBACK_FRAME_MEAN &&
           m->facing_fade[1] > -1.0f));
}

void layers_names(unsigned layers, char *text, size_t size) {
  size_t used = 0;
  *text = '\0';
  for (int l = 0; l < LAYER_COUNT; l++)
    if (layers >> l & 1 && used < size)
      used += (size_t)snprintf(text + used, size - used, "%s%s",
                               used ? ", " : "", layer_table[l].name);
}

static int find_layer(const char *name, size_t length) {
  for (int l = 0; l < LAYER_COUNT; l++)
    if (strlen(layer_table[l].name) == length &&
        strncmp(layer_table[l].name, name, length) == 0)
      return l;
  return -1;
}

int layers_parse(const char *text, unsigned *out, image_error *error) {
  char names[160];
  *out = 0;
  for (const char *next = text;; next++) {
    const size_t length = strcspn(next, ",");
    const int found = find_layer(next, length);
    if (found < 0) {
      layers_names((1u << LAYER_COUNT) - 1u, names, sizeof names);
      return image_fail(
          error, "--layers %s: some of %s are needed, separated by commas",
          text, names);
    }
    *out |= 1u << found;
    next += length;
    if (!*next)
      return 0;
  }
}

static void plane_name(layer l, size_t i, char *name, size_t size) {
  snprintf(name, size, "%s.%c", layer_table[l].name,
           layer_table[l].components[i]);
}

static const image_plane *add_plane(image *out, layer l, size_t i, int halves) {
  char name[32];
  plane_name(l, i, name, sizeof name);
  return halves ? image_add_halves(out, name) : image_add(out, name);
}

int layers_image(unsigned layers, unsigned halves, uint32_t width,
                 uint32_t height, image *out) {
  memset(out, 0, sizeof *out);
  out->width = width;
  out->height = height;
  for (int l = 0; l < LAYERS_WRITTEN; l++)
    for (size_t i = 0; layers >> l & 1 && layer_table[l].components[i]; i++)
      if (!add_plane(out, (layer)l, i, halves >> l & 1)) {
        image_free(out);
        return -1;
      }
  return 0;
}

size_t layers_bytes(unsigned layers, unsigned halves, uint32_t width,
                    uint32_t height) {
  const size_t pixels = (size_t)width * height;
  size_t bytes = 0;
  for (int l = 0; l < LAYERS_WRITTEN; l++)
    if (layers >> l & 1)
      bytes += strlen(layer_table[l].components) *
               image_memory_plane(pixels * (halves >> l & 1 ? sizeof(uint16_t)
                                                            : sizeof(float)));
  return bytes;
}

static const image_plane *find_plane(const image *img, layer l, size_t i) {
  char name[32];
  if (i >= strlen(layer_table[l].components))
    return NULL;
  plane_name(l, i, name, sizeof name);
  return image_find(img, name);
}

float *layers_plane(const image *img, layer l, size_t i) {
  const image_plane *plane = find_plane(img, l, i);
  return plane ? plane->pixels : NULL;
}

uint16_t *layers_halves(const image *img, layer l, size_t i) {
  const image_plane *plane = find_plane(img, l, i);
  return plane ? plane->halves : NULL;
}

float *layers_plane_of(const image *one, const image *other, layer l,
                       size_t i) {
  float *plane = layers_plane(one, l, i);
  return plane ? plane : layers_plane(other, l, i);
}

/* ------------------------------------------------------------------------ */
/* Inputs                                                                    */

#define INPUT(role, field)                                                     \
  { role, offsetof(hbil_config, inputs.field), offsetof(hbil_frame, field) }

const input_info input_table[INPUTS] = {
    INPUT(ROLE_DEPTH, depth),       INPUT(ROLE_NORMAL, normal),
    INPUT(ROLE_ALBEDO, albedo),     INPUT(ROLE_DIRECT, direct),
    INPUT(ROLE_EMISSION, emission), INPUT(ROLE_MOTION, motion),
};

static hbil_plane_format *format_at(hbil_config *config, size_t offset) {
  return (hbil_plane_format *)((char *)config + offset);
}

size_t formats_channels(const hbil_config *config, const channel_map *map,
                        int input) {
  const role r = input_table[input].role;
  if (r == ROLE_MOTION &&
      config->history.reprojection != HBIL_REPROJECTION_MOTION)
    return 0;
  return map->count[r];
}

void formats_choose(hbil_config *config, const channel_map *map,
                    unsigned layers, unsigned halves) {
  const hbil_plane_format planes_of_floats = {HBIL_FLOAT32, 4};
  const hbil_plane_format planes_of_halves = {HBIL_FLOAT16, 2};
  for (int i = 0; i < INPUTS; i++)
    if (formats_channels(config, map, i))
      *format_at(config, input_table[i].format) = planes_of_floats;
  for (int l = 0; l < LAYER_COUNT; l++)
    if (layers >> l & 1)
      *format_at(config, layer_table[l].format) =
          halves >> l & 1 ? planes_of_halves : planes_of_floats;
}
