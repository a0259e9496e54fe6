/* The encoding of sRGB. */
#include "image/srgb.h"

#include <math.h>

/* The transfer function of IEC 61966-2-1. */
float linear_of_srgb(float v) {
  return v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f);
}
