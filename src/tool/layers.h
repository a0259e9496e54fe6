/* Layers, which are the results that the program writes, and the inputs of the
 * library. */
#ifndef HBIL_TOOL_LAYERS_H
#define HBIL_TOOL_LAYERS_H

#include "dump/channel_map.h"
#include "hbil/hbil.h"
#include "image/error.h"
#include "image/image.h"

#include <stddef.h>
#include <stdint.h>

/* ------------------------------------------------------------------------ */
/* Layers                                                                    */

typedef enum layer {
  LAYER_NEAR_IRRADIANCE = 0,
  LAYER_FAR_IRRADIANCE,
  LAYER_INDIRECT,
  LAYER_AO,
  LAYER_BENT_NORMAL,
  LAYER_CONE_COSINE,
  LAYER_BEAUTY,
  /* written only on request */
  LAYER_UNKNOWN,
  LAYER_GLOSSY,
  LAYER_ERROR_ESTIMATE,
  LAYER_COUNT,
  /* the alpha of beauty, which comes from the frame; nobody asks for it */
  LAYER_ALPHA = LAYER_COUNT,
  LAYERS_WRITTEN
} layer;

/* A set of layers is a bit mask of 1 << layer. */

typedef struct layer_info {
  const char *name;       /* of the field in hbil_config, and in the file */
  const char *components; /* one letter for each channel: NAME.LETTER */
  size_t format, image;   /* offsets in hbil_config and hbil_frame */
} layer_info;

extern const layer_info layer_table[LAYERS_WRITTEN];

/* What a mode writes without a request. */
unsigned layers_of_mode(hbil_mode mode);

/* What a mode can compute.  exact: by the exact integral, which has no error
 * estimate and no glossy light. */
unsigned layers_possible(hbil_mode mode, int exact);

/* Whether some of these layers show light that the settings allow to be a
 * guess: then the layer `unknown` tells its share. */
int layers_show_guesses(unsigned layers, const hbil_config *config);

/* "ao, indirect" for a set of layers. */
void layers_names(unsigned layers, char *text, size_t size);

/* The set for "ao,indirect".  0, or -1 with `error` filled. */
int layers_parse(const char *text, unsigned *out, image_error *error);

/* An image with the planes of these layers, in the table's order, of halves for
 * those in `halves` and of floats for the others.  Bytes of its pixels, in an
 * image_memory.  0, or -1 if memory runs out. */
int layers_image(unsigned layers, unsigned halves, uint32_t width,
                 uint32_t height, image *out);
size_t layers_bytes(unsigned layers, unsigned halves, uint32_t width,
                    uint32_t height);

/* The plane of channel i of a layer, or NULL; NULL for halves. */
float *layers_plane(const image *img, layer l, size_t i);
/* The same for halves; NULL for floats. */
uint16_t *layers_halves(const image *img, layer l, size_t i);

/* Whether that plane holds light, to which exposure applies. */
int layers_is_light(layer l, size_t i);

/* The same of the first image that has it. */
float *layers_plane_of(const image *one, const image *other, layer l, size_t i);

/* ------------------------------------------------------------------------ */
/* Inputs                                                                    */

typedef struct input_info {
  role role;
  size_t format, image; /* offsets in hbil_config and hbil_frame */
} input_info;

enum { INPUTS = 6 }; /* the last one is motion */
extern const input_info input_table[INPUTS];

/* The number of channels of an input that these settings use; 0: none. */
size_t formats_channels(const hbil_config *config, const channel_map *map,
                        int input);

/* Fills in the formats of the inputs that are used and of a set of layers
 * (layers.h), of which some are of halves. */
void formats_choose(hbil_config *config, const channel_map *map,
                    unsigned layers, unsigned halves);

/* ------------------------------------------------------------------------ */
/* Far light                                                                 */

/* The members of hbil_frame with these names.  All have four bytes, so there is
 * no padding, and jobs hash it (job_key.c). */
typedef struct far_light {
  float environment[9][3];
  float sky_share;
} far_light;

#endif
