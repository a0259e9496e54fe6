/* Layers of three channels R, G and B, such as indirect light, in image files.
 */
#ifndef HBIL_BENCH_COLOUR_H
#define HBIL_BENCH_COLOUR_H

#include "image/error.h"
#include "image/image.h"
#include "tool/compare_sides.h"

/* `layers` are names, the best first, and end with NULL.  A name stands for the
 * layer in any view layer, too: "DiffInd" for "ViewLayer.DiffInd".  "" is for
 * channels R, G, B without a layer. */

/* The channels of the first layer of which all three are there.  Returns 1, or
 * 0 if there is none.  The names are the header's. */
int bench_colour_find(const image *header, const char *const *layers,
                      const char *names[3]);

/* Reads that layer as planes R, G, B, which compare_measure() takes.  Returns
 * 0, or -1 with `error` filled; compare_side_free() frees it in both cases. */
int bench_colour_read(const char *path, const char *const *layers,
                      compare_side *out, image_error *error);

/* Planes of that size, filled with a colour, likewise. */
int bench_colour_fill(const image *size, const double rgb[3], compare_side *out,
                      image_error *error);

#endif
