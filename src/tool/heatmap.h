/* Heat maps: a number for each pixel as a colour, with a legend. */
#ifndef HBIL_TOOL_HEATMAP_H
#define HBIL_TOOL_HEATMAP_H

#include "image/error.h"

#include <stdint.h>

#include <stdint.h>

/* values: one for each pixel, shown from black (0) over red to white (limit).
 * Writes a PNG.  0, or -1 with `error` filled. */
int heatmap_write(const char *path, const float *values, uint32_t width,
                  uint32_t height, float limit, image_error *error);

/* Warns that pictures have no labels because there is no font. */
void heatmap_warn_without_font(void);

#endif
