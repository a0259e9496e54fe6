/* Pictures for the eye: tone-mapped layers and heat maps, as PNG. */
#include "tool/tool.h"

#include <math.h>
#include <stdio.h>
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

static int write_picture(const char *path, const picture *p,
                         image_error *error) {
  return png_write(path, p->rgb, p->width, p->height, error);
}

int preview_write(const char *path, const image *result, layer l,
                  float exposure, image_error *error) {
  picture p;
  if (preview_picture(result, l, exposure, &p) != 0)
    return image_no_memory(error, path);
  const int failed = write_picture(path, &p, error);
  picture_free(&p);
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

/* --- the legend of a heat map --- */

/* Pixels.  Five numbers need more room than three. */
enum { BAR = 12, MARGIN = 8, TEXT = 12, LEGEND = 40, LEAST_WIDTH = 200 };
enum { ROOM_OF_FIVE = 360 };

static void draw_bar(picture *p, uint32_t top) {
  const uint32_t length = p->width - 2 * MARGIN;
  for (uint32_t y = top; y < top + BAR; y++)
    for (uint32_t x = 0; x < length; x++)
      heat_colour((float)x / (float)(length - 1),
                  p->rgb + 3 * ((size_t)y * p->width + MARGIN + x));
}

/* Whether there is a font. */
static int draw_numbers(picture *p, uint32_t base, float limit) {
  const int steps = p->width < ROOM_OF_FIVE ? 2 : 4;
  int failed = 0;
  for (int i = 0; i <= steps; i++) {
    const uint32_t length = p->width - 2 * MARGIN - 1;
    char number[32];
    snprintf(number, sizeof number, "%.3g",
             (double)limit * (double)i / (double)steps);
    failed |= picture_text(p, (int)(MARGIN + length * (uint32_t)i / steps),
                           (int)base, TEXT,
                           i == 0       ? PICTURE_LEFT
                           : i == steps ? PICTURE_RIGHT
                                        : PICTURE_CENTRE,
                           number);
  }
  return !failed;
}

static int draw_heatmap(const float *values, uint32_t width, uint32_t height,
                        float limit, picture *out) {
  if (picture_new(width > LEAST_WIDTH ? width : LEAST_WIDTH, height + LEGEND,
                  out) != 0)
    return -1;
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++)
      heat_colour(limit > 0.0f ? values[(size_t)y * width + x] / limit : 0.0f,
                  out->rgb + 3 * ((size_t)y * out->width + x));
  draw_bar(out, height + MARGIN);
  if (!draw_numbers(out, height + LEGEND - MARGIN, limit))
    preview_no_font();
  return 0;
}

int preview_heatmap(const char *path, const float *values, uint32_t width,
                    uint32_t height, float limit, image_error *error) {
  picture p;
  if (draw_heatmap(values, width, height, limit, &p) != 0)
    return image_no_memory(error, path);
  const int failed = write_picture(path, &p, error);
  picture_free(&p);
  return failed;
}

void preview_no_font(void) {
  fputs("hbil: warning: no font for the labels of pictures; DejaVu Sans "
        "(Debian: fonts-dejavu-core) is looked for\n",
        stderr);
}
