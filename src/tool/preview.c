/* Pictures for the eye: tone-mapped layers and heat maps, as PNG. */
#include "tool/tool.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float pi = 3.14159265f;

/* Irradiance is shown as the radiance of a white surface under it, so that one
 * exposure serves all layers of light. */
static float light_scale(layer l) {
  return l == LAYER_NEAR || l == LAYER_FAR ? 1.0f / pi : 1.0f;
}

static float luminance(float r, float g, float b) {
  return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

/* The mean on a logarithmic scale of all that is lit; 0 for black. */
static double log_mean(const image *result, layer l) {
  const float *r = layers_plane(result, l, 0), *g = layers_plane(result, l, 1),
              *b = layers_plane(result, l, 2);
  const size_t pixels = (size_t)result->width * result->height;
  double sum = 0.0;
  size_t lit = 0;
  if (!r || !g || !b)
    return 0.0;
  for (size_t i = 0; i < pixels; i++) {
    const float y = light_scale(l) * luminance(r[i], g[i], b[i]);
    if (isfinite(y) && y > 1e-12f) {
      sum += log(y);
      lit++;
    }
  }
  return lit ? exp(sum / (double)lit) : 0.0;
}

float preview_exposure(const image *result) {
  static const layer order[] = {LAYER_BEAUTY, LAYER_INDIRECT, LAYER_NEAR,
                                LAYER_FAR};
  for (size_t i = 0; i < sizeof order / sizeof *order; i++) {
    const double mean = log_mean(result, order[i]);
    if (mean > 0.0)
      return (float)(0.25 / mean);
  }
  return 1.0f;
}

static unsigned char byte(float value) {
  if (!(value > 0.0f))
    return 0;
  return (unsigned char)(value < 1.0f ? value * 255.0f + 0.5f : 255.0f);
}

/* Reinhard's curve, white at 4 times the mean's image, then sRGB. */
static unsigned char light_byte(float value) {
  if (!(value > 0.0f))
    return 0;
  const float v = fminf(value, 1e6f);
  const float c = fminf(v * (1.0f + v / 16.0f) / (1.0f + v), 1.0f);
  return byte(c <= 0.0031308f ? 12.92f * c
                              : 1.055f * powf(c, 1.0f / 2.4f) - 0.055f);
}

static unsigned char layer_byte(layer l, float value, float exposure) {
  switch (l) {
  case LAYER_AO:
  case LAYER_CONE:
    return byte(value);
  case LAYER_BENT:
    return byte(0.5f * value + 0.5f);
  default:
    return light_byte(exposure * light_scale(l) * value);
  }
}

int preview_write(const char *path, const image *result, layer l,
                  float exposure, image_error *error) {
  const size_t pixels = (size_t)result->width * result->height;
  const size_t channels = strlen(layer_table[l].components);
  unsigned char *rgb = malloc(3 * pixels);
  if (!rgb)
    return image_no_memory(error, path);
  for (size_t c = 0; c < 3; c++) {
    const float *plane = layers_plane(result, l, c < channels ? c : 0);
    for (size_t i = 0; i < pixels; i++)
      rgb[3 * i + c] = layer_byte(l, plane[i], exposure);
  }
  const int failed = png_write(path, rgb, result->width, result->height, error);
  free(rgb);
  return failed;
}

/* Black, purple, red, orange, white: darker is always less. */
static void heat_colour(float t, unsigned char out[3]) {
  static const float stops[5][3] = {{0.0f, 0.0f, 0.0f},
                                    {0.32f, 0.07f, 0.48f},
                                    {0.84f, 0.21f, 0.26f},
                                    {0.98f, 0.65f, 0.18f},
                                    {1.0f, 1.0f, 0.92f}};
  const float x = 4.0f * fminf(fmaxf(t, 0.0f), 1.0f);
  const int i = x < 3.0f ? (int)x : 3;
  for (int c = 0; c < 3; c++)
    out[c] =
        byte(stops[i][c] + (x - (float)i) * (stops[i + 1][c] - stops[i][c]));
}

int preview_heatmap(const char *path, const float *values, uint32_t width,
                    uint32_t height, float limit, image_error *error) {
  const size_t pixels = (size_t)width * height;
  unsigned char *rgb = malloc(3 * pixels);
  if (!rgb)
    return image_no_memory(error, path);
  for (size_t i = 0; i < pixels; i++)
    heat_colour(limit > 0.0f ? values[i] / limit : 0.0f, rgb + 3 * i);
  const int failed = png_write(path, rgb, width, height, error);
  free(rgb);
  return failed;
}
