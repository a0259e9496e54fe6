/* The words for the conventions, and what can be told from them alone. */
#include "dump/conventions.h"

#include <math.h>
#include <stddef.h>

const char *const depth_words[] = {"planar", "ray",      "position",
                                   "device", "reversed", NULL};
const char *const space_words[] = {"world", "camera", NULL};
const char *const direct_words[] = {"irradiance", "light", "radiance", NULL};

int conventions_depth_is_planar(const conventions *how) {
  return how->depth == DEPTH_PLANAR && how->unit == 1.0 && !how->backwards;
}

int conventions_begin_at_near(const conventions *how) {
  return how->depth == DEPTH_RAY && how->from_near && how->near > 0.0;
}

conventions conventions_as_stored(void) {
  return (conventions){.unit = 1.0, .sky_depth = INFINITY};
}
