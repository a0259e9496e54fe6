/* Means over blocks of pixels, in place of the pixels. */
#ifndef HBIL_TOOL_COMPARE_BLOCKS_H
#define HBIL_TOOL_COMPARE_BLOCKS_H

#include "tool/compare_mask.h"
#include "tool/compare_sides.h"

/* Replaces what is compared by means over blocks of size x size pixels, which
 * begin at the top left; those at the right and at the bottom may be smaller.
 * Pixels that the mask leaves out, or that aren't finite in both images, don't
 * count and aren't changed. */
void compare_take_means(compare_side *a, compare_side *b, const compare_mask *m,
                        unsigned size);

#endif
