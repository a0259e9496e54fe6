/* Pixels in the formats that the library reads. */
#include "scene/store.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

size_t scene_component_size(hbil_component component) {
  switch (component) {
  case HBIL_UNORM8:
  case HBIL_SRGB8:
  case HBIL_SNORM8:
    return 1;
  case HBIL_FLOAT16:
  case HBIL_UNORM16:
  case HBIL_SNORM16:
    return 2;
  default:
    return 4;
  }
}

bool scene_is_word(hbil_component component) {
  return component == HBIL_RGB10A2_UNORM || component == HBIL_R11G11B10_FLOAT ||
         component == HBIL_RGB9E5_FLOAT;
}

/* --- codes ---------------------------------------------------------------- */

/* NaN becomes 0. */
static uint32_t unorm(double v, double largest) {
  return (uint32_t)lrint(fmin(fmax(v, 0.0), 1.0) * largest);
}

static uint32_t snorm(double v, double largest) {
  return (uint32_t)lrint(fmin(fmax(v, -1.0), 1.0) * largest);
}

/* The curve of sRGB (IEC 61966-2-1). */
static double srgb_curve(double v) {
  return v > 0.0031308 ? 1.055 * pow(v, 1.0 / 2.4) - 0.055 : 12.92 * v;
}

/* A float without sign: 5 bits of exponent, so many of mantissa. */
static uint32_t small_float(double v, int bits) {
  const uint32_t infinity = 31u << bits;
  int exponent;
  if (isnan(v))
    return infinity + 1u;
  if (v <= 0.0)
    return 0;
  if (v >= 65536.0)
    return infinity;
  if (v < 0x1p-14)
    return (uint32_t)lrint(ldexp(v, 14 + bits));
  frexp(v, &exponent);
  /* a mantissa that rounds up carries into the exponent by itself */
  return ((uint32_t)(exponent + 13) << bits) +
         (uint32_t)lrint(ldexp(v, bits + 1 - exponent));
}

static uint32_t half_float(double v) {
  return (signbit(v) ? 0x8000u : 0u) + small_float(fabs(v), 10);
}

/* RGB9E5_FLOAT, as OpenGL and Vulkan define it. */
static uint32_t shared_exponent(const double v[3]) {
  double units[3], largest = 0.0;
  int exponent = 0;
  for (int c = 0; c < 3; ++c) {
    units[c] = fmin(fmax(v[c], 0.0), 65408.0);
    largest = fmax(largest, units[c]);
  }
  if (largest >= 0x1p-16)
    frexp(largest, &exponent);
  exponent = largest >= 0x1p-16 ? exponent + 15 : 0;
  if (floor(ldexp(largest, 24 - exponent) + 0.5) == 512.0)
    ++exponent;
  uint32_t word = (uint32_t)exponent << 27;
  for (int c = 0; c < 3; ++c)
    word |= (uint32_t)floor(ldexp(units[c], 24 - exponent) + 0.5) << (9 * c);
  return word;
}

static uint32_t component_code(hbil_component component, double v) {
  const float as_float = (float)v;
  uint32_t bits;
  switch (component) {
  case HBIL_FLOAT16:
    return half_float(v);
  case HBIL_UNORM8:
    return unorm(v, 255.0);
  case HBIL_SRGB8:
    return unorm(srgb_curve(v), 255.0);
  case HBIL_UNORM16:
    return unorm(v, 65535.0);
  case HBIL_UNORM24:
    return unorm(v, 16777215.0);
  case HBIL_SNORM8:
    return snorm(v, 127.0);
  case HBIL_SNORM16:
    return snorm(v, 32767.0);
  default:
    memcpy(&bits, &as_float, sizeof bits);
    return bits;
  }
}

static uint32_t word_code(hbil_component component, const double v[3]) {
  if (component == HBIL_RGB9E5_FLOAT)
    return shared_exponent(v);
  if (component == HBIL_R11G11B10_FLOAT)
    return small_float(v[0], 6) | small_float(v[1], 6) << 11 |
           small_float(v[2], 5) << 22;
  return unorm(v[0], 1023.0) | unorm(v[1], 1023.0) << 10 |
         unorm(v[2], 1023.0) << 20;
}

/* --- pixels --------------------------------------------------------------- */

/* In the byte order of this machine, which is the device's. */
static void put(uint32_t code, size_t size, unsigned char *at) {
  const uint8_t byte = (uint8_t)code;
  const uint16_t two = (uint16_t)code;
  memcpy(at,
         size == 1   ? (const void *)&byte
         : size == 2 ? (const void *)&two
                     : (const void *)&code,
         size);
}

void scene_store(hbil_component component, bool biased, const double *values,
                 int channels, size_t pitch, unsigned char *at) {
  const size_t size = scene_component_size(component);
  double v[3];
  for (int c = 0; c < channels; ++c)
    v[c] = biased ? 0.5 * values[c] + 0.5 : values[c];
  if (scene_is_word(component)) {
    put(word_code(component, v), size, at);
    return;
  }
  for (int c = 0; c < channels; ++c)
    put(component_code(component, v[c]), size, at + (size_t)c * pitch);
}

void scene_octahedral(const double normal[3], double uv[2]) {
  const double sum = fabs(normal[0]) + fabs(normal[1]) + fabs(normal[2]);
  const double u = normal[0] / sum, v = normal[1] / sum;
  uv[0] = normal[2] < 0.0 ? copysign(1.0 - fabs(v), u) : u;
  uv[1] = normal[2] < 0.0 ? copysign(1.0 - fabs(u), v) : v;
}

double scene_hardware_depth(const double projection[2], bool orthographic,
                            double z) {
  const double a = projection[0], b = projection[1];
  const bool reversed = orthographic ? b < 0.0 : b > 0.0;
  if (!(z > 0.0) || isinf(z))
    return reversed ? 0.0 : 1.0;
  return orthographic ? a + b * z : a + b / z;
}
