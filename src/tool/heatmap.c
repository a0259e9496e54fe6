/* Heat maps. */
#include "tool/heatmap.h"

#include "image/error.h"
#include "image/picture.h"
#include "image/png_write.h"

#include <math.h>
#include <stdio.h>

/* Black, purple, red, orange, white: a smaller value is always darker. */
static void heat_colour(float t, unsigned char out[3]) {
  static const float stops[5][3] = {{0.0f, 0.0f, 0.0f},
                                    {0.32f, 0.07f, 0.48f},
                                    {0.84f, 0.21f, 0.26f},
                                    {0.98f, 0.65f, 0.18f},
                                    {1.0f, 1.0f, 0.92f}};
  const float x = 4.0f * fminf(fmaxf(t, 0.0f), 1.0f);
  const int i = x < 3.0f ? (int)x : 3;
  for (int c = 0; c < 3; c++)
    out[c] = picture_byte(stops[i][c] +
                          (x - (float)i) * (stops[i + 1][c] - stops[i][c]));
}

/* Pixels.  Wide pictures have five numbers below them, narrow ones three. */
enum { BAR = 12, MARGIN = 8, TEXT = 12, LEGEND = 40, LEAST_WIDTH = 200 };
enum { ROOM_OF_FIVE = 360 };

static void draw_bar(picture *p, uint32_t top) {
  const uint32_t length = p->width - 2 * MARGIN;
  for (uint32_t y = top; y < top + BAR; y++)
    for (uint32_t x = 0; x < length; x++)
      heat_colour((float)x / (float)(length - 1),
                  p->rgb + 3 * ((size_t)y * p->width + MARGIN + x));
}

/* Returns whether there is a font. */
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
    heatmap_warn_without_font();
  return 0;
}

int heatmap_write(const char *path, const float *values, uint32_t width,
                  uint32_t height, float limit, image_error *error) {
  picture p;
  if (draw_heatmap(values, width, height, limit, &p) != 0)
    return image_no_memory(error, path);
  const int failed =
      png_write(path, p.rgb, p.width, p.height, EXISTING_REPLACED, error);
  picture_free(&p);
  return failed;
}

void heatmap_warn_without_font(void) {
  fputs("hbil: warning: pictures have no labels: there is no font; DejaVu Sans "
        "(Debian: fonts-dejavu-core) is needed\n",
        stderr);
}
