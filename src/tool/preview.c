/* Pictures of layers. */
#include "tool/preview.h"

#include "image/error.h"
#include "image/image.h"
#include "image/picture.h"
#include "image/png_write.h"

#include <math.h>
#include <string.h>

static const float pi = 3.14159265f;

/* Irradiance is shown as the radiance of a white surface, so that one exposure
 * serves all layers of light. */
static float light_scale(layer l) {
  return l == LAYER_NEAR_IRRADIANCE || l == LAYER_FAR_IRRADIANCE ? 1.0f / pi
                                                                 : 1.0f;
}

static float luminance(float r, float g, float b) {
  return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

/* The geometric mean of the luminance of all pixels above 0; 0 if there are
 * none. */
static double log_mean(const image *result, layer l) {
  const float *r = layers_plane(result, l, 0), *g = layers_plane(result, l, 1),
              *b = layers_plane(result, l, 2);
  const size_t pixels = (size_t)result->width * result->height;
  double sum = 0.0;
  size_t bright = 0;
  if (!r || !g || !b)
    return 0.0;
  for (size_t i = 0; i < pixels; i++) {
    const float y = light_scale(l) * luminance(r[i], g[i], b[i]);
    if (isfinite(y) && y > 1e-12f) {
      sum += log(y);
      bright++;
    }
  }
  return bright ? exp(sum / (double)bright) : 0.0;
}

float preview_exposure(const image *result) {
  static const layer order[] = {LAYER_BEAUTY, LAYER_INDIRECT,
                                LAYER_NEAR_IRRADIANCE, LAYER_FAR_IRRADIANCE};
  for (size_t i = 0; i < sizeof order / sizeof *order; i++) {
    const double mean = log_mean(result, order[i]);
    if (mean > 0.0)
      return (float)(0.25 / mean);
  }
  return 1.0f;
}

/* Reinhard's curve with white at 16 times the mean (0.25), then sRGB. */
unsigned char preview_light(float value) {
  if (!(value > 0.0f))
    return 0;
  const float v = fminf(value, 1e6f);
  const float c = fminf(v * (1.0f + v / 16.0f) / (1.0f + v), 1.0f);
  return picture_byte(c <= 0.0031308f ? 12.92f * c
                                      : 1.055f * powf(c, 1.0f / 2.4f) - 0.055f);
}

static unsigned char layer_byte(layer l, float value, float exposure) {
  switch (l) {
  case LAYER_AO:
  case LAYER_CONE_COSINE:
  case LAYER_UNKNOWN:
    return picture_byte(value);
  case LAYER_BENT_NORMAL:
    return picture_byte(0.5f * value + 0.5f);
  default:
    return preview_light(exposure * light_scale(l) * value);
  }
}

int preview_picture(const image *result, layer l, float exposure,
                    picture *out) {
  const size_t pixels = (size_t)result->width * result->height;
  const size_t channels = strlen(layer_table[l].components);
  if (picture_new(result->width, result->height, out) != 0)
    return -1;
  for (size_t c = 0; c < 3; c++) {
    const float *plane = layers_plane(result, l, c < channels ? c : 0);
    for (size_t i = 0; i < pixels; i++)
      out->rgb[3 * i + c] = layer_byte(l, plane[i], exposure);
  }
  return 0;
}

int preview_write(const char *path, const image *result, layer l,
                  float exposure, existing_file existing, image_error *error) {
  picture p;
  if (preview_picture(result, l, exposure, &p) != 0)
    return image_no_memory(error, path);
  const int failed = png_write(path, p.rgb, p.width, p.height, existing, error);
  picture_free(&p);
  return failed;
}
