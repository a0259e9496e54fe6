#include "test/support/packing.h"

#include <math.h>
#include <string.h>

#include "lib/sampling_pattern.h"

#include "test/support/vectors.h"

/* Octahedral mapping (Cigolle and others 2014): |x| + |y| + |z| = 1, and the
 * half with z > 0 is folded outwards over the diagonals. */
static double folded(double a, double b) {
  return copysign(1.0 - fabs(b), a);
}

uint32_t encode_normal(const double n[3]) {
  double size = fabs(n[0]) + fabs(n[1]) + fabs(n[2]), u = 0.0, v = 0.0;
  if (size > 0.0) {
    double x = n[0] / size, y = n[1] / size;
    u = n[2] > 0.0 ? folded(x, y) : x;
    v = n[2] > 0.0 ? folded(y, x) : y;
  }
  return ((uint32_t)lrint(u * 32767.0) & 0xffff) | (uint32_t)lrint(v * 32767.0)
                                                       << 16;
}

/* Two's complement in some of a word's bits. */
static double signed_bits(uint32_t word, int low, int bits) {
  int32_t value = (int32_t)(word >> low & ((1u << bits) - 1));
  return value >> (bits - 1) ? value - (1 << bits) : value;
}

void decode_normal(uint32_t word, double n[3]) {
  double u = signed_bits(word, 0, 16) / 32767.0;
  double v = signed_bits(word, 16, 16) / 32767.0;
  n[2] = fabs(u) + fabs(v) - 1.0;
  n[0] = n[2] > 0.0 ? folded(u, v) : u;
  n[1] = n[2] > 0.0 ? folded(v, u) : v;
  normalize(n);
}

double packed_unit(double most, int bits) {
  /* no exponent is lower than that of a float's smallest normal number */
  if (!(most > 0.0))
    return 0.0;
  const double unit = ldexp(1.0, (int)fmax(ilogb(most) + 1 - bits, -126));
  /* a value that rounds up to the next power of two gets the next unit */
  return most / unit < ldexp(1.0, bits) - 0.5 ? unit : 2.0 * unit;
}

/* Three mantissas; `exponent` is that of their unit, biased as in a float. */
static uint32_t encode_light(const double light[3], int bits,
                             uint32_t *exponent) {
  double most = fmax(light[0], fmax(light[1], light[2]));
  double unit = packed_unit(most, bits);
  uint32_t word = 0;
  *exponent = 0;
  if (!(most > 0.0))
    return 0;
  for (int c = 0; c < 3; ++c)
    word |= (uint32_t)floor(light[c] / unit + 0.5) << (bits * c);
  *exponent = (uint32_t)(ilogb(unit) + 127);
  return word;
}

static void decode_light(uint32_t word, int bits, uint32_t exponent,
                         double light[3]) {
  for (int c = 0; c < 3; ++c)
    light[c] =
        ldexp(word >> (bits * c) & ((1u << bits) - 1), (int)exponent - 127);
}

static double layer_dither(int x, int y) {
  return (double)hbil_direction_share(4 * (y % 4) + x % 4, HBIL_LAYERS);
}

/* `b` is not longer than 1. */
static uint32_t encode_bent(const double b[3], double dither) {
  uint32_t x = (uint32_t)(int)floor(b[0] * 1023.0 + dither);
  uint32_t y = (uint32_t)(int)floor(b[1] * 1023.0 + dither);
  uint32_t z = (uint32_t)(int)floor(b[2] * 511.0 + dither);
  return (x & 0x7ff) | (y & 0x7ff) << 11 | z << 22;
}

static void decode_bent(uint32_t word, double b[3]) {
  b[0] = signed_bits(word, 0, 11) / 1023.0;
  b[1] = signed_bits(word, 11, 11) / 1023.0;
  b[2] = signed_bits(word, 22, 10) / 511.0;
}

static double decode_float(uint32_t word) {
  float value;
  memcpy(&value, &word, sizeof(value));
  return (double)value;
}

static uint32_t encode_float(double value) {
  const float rounded = (float)value;
  uint32_t word;
  memcpy(&word, &rounded, sizeof(word));
  return word;
}

static void decode_radiance(uint32_t word, double light[3]) {
  decode_light(word, 8, word >> 24, light);
}

static uint32_t encode_radiance(const double light[3]) {
  uint32_t exponent;
  const uint32_t word = encode_light(light, 8, &exponent);
  return word | exponent << 24;
}

void decode_split(packed_pixel *p) {
  p->value[HBIL_SPLIT_W] = decode_float(p->word[HBIL_SPLIT_W]);
  decode_normal(p->word[HBIL_PACKED_NORMAL], p->value + HBIL_SPLIT_NORMAL);
  decode_radiance(p->word[HBIL_PACKED_RADIANCE], p->value + HBIL_SPLIT_RED);
}

void encode_split(packed_pixel *p) {
  p->word[HBIL_SPLIT_W] = encode_float(p->value[HBIL_SPLIT_W]);
  p->word[HBIL_PACKED_NORMAL] = encode_normal(p->value + HBIL_SPLIT_NORMAL);
  p->word[HBIL_PACKED_RADIANCE] = encode_radiance(p->value + HBIL_SPLIT_RED);
}

void decode_history(packed_pixel *p) {
  p->value[HBIL_HISTORY_W] = decode_float(p->word[HBIL_HISTORY_W]);
  decode_radiance(p->word[HBIL_HISTORY_RED], p->value + HBIL_HISTORY_RED);
}

void encode_history(packed_pixel *p) {
  p->word[HBIL_HISTORY_W] = encode_float(p->value[HBIL_HISTORY_W]);
  p->word[HBIL_HISTORY_RED] = encode_radiance(p->value + HBIL_HISTORY_RED);
}

/* The weight is behind the word of light. */
void decode_carried(packed_pixel *p) {
  decode_radiance(p->word[HBIL_CARRIED_RED], p->value + HBIL_CARRIED_RED);
  p->value[HBIL_CARRIED_WEIGHT] = decode_float(p->word[HBIL_CARRIED_RED + 1]);
}

void encode_carried(packed_pixel *p) {
  p->word[HBIL_CARRIED_RED] = encode_radiance(p->value + HBIL_CARRIED_RED);
  p->word[HBIL_CARRIED_RED + 1] = encode_float(p->value[HBIL_CARRIED_WEIGHT]);
}

void decode_gathered(packed_pixel *p) {
  p->value[HBIL_LIGHT_AO] = (p->word[HBIL_PACKED_AO] & 0xffff) / 65535.0;
  p->value[HBIL_LIGHT_UNKNOWN] = (p->word[HBIL_PACKED_AO] >> 16 & 0xff) / 255.0;
  decode_light(p->word[HBIL_PACKED_NEAR], 10, p->word[HBIL_PACKED_AO] >> 24,
               p->value + HBIL_LIGHT_RED);
  decode_bent(p->word[HBIL_PACKED_BENT], p->value + HBIL_LIGHT_BENT);
}

void encode_gathered(packed_pixel *p, int x, int y) {
  const double dither = layer_dither(x, y);
  uint32_t exponent;
  p->word[HBIL_PACKED_NEAR] =
      encode_light(p->value + HBIL_LIGHT_RED, 10, &exponent);
  p->word[HBIL_PACKED_AO] =
      (uint32_t)lrint(p->value[HBIL_LIGHT_AO] * 65535.0) |
      (uint32_t)floor(fmin(p->value[HBIL_LIGHT_UNKNOWN], 0.999) * 255.0 +
                      dither)
          << 16 |
      exponent << 24;
  p->word[HBIL_PACKED_BENT] = encode_bent(p->value + HBIL_LIGHT_BENT, dither);
}

static double most_of(const exact_planes *planes, int first, int x, int y) {
  return fmax(*exact_at(planes, first, x, y),
              fmax(*exact_at(planes, first + 1, x, y),
                   *exact_at(planes, first + 2, x, y)));
}

/* Half a step of the largest channel's unit.  That channel itself loses half a
 * unit of its own, also where rounding it up to the next power of two gives the
 * other channels twice that unit.  bits: of the mantissas. */
static double loss_of(int bits, double value, double most) {
  if (!(most > 0.0))
    return 0.0;
  const double own = ldexp(1.0, (int)fmax(ilogb(most) + 1 - bits, -126));
  return 0.5 * (value < most ? packed_unit(most, bits) : own);
}

double packed_loss(const exact_planes *got, const exact_planes *want, int first,
                   int bits, double before, int x, int y) {
  const double most = most_of(want, first, x, y);
  double worst = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double value = *exact_at(want, first + c, x, y);
    const double off = fabs(*exact_at(got, first + c, x, y) - value);
    if (!(off <= before)) /* loss_of() is 0 where there is no light */
      worst = fmax(worst, isfinite(off)
                              ? (off - before) / loss_of(bits, value, most)
                              : HUGE_VAL);
  }
  return worst;
}

double packed_losses(const exact_planes *got, const exact_planes *want,
                     int first, int bits, double before) {
  double worst = 0.0;
  for (int y = 0; y < got->height; ++y)
    for (int x = 0; x < got->width; ++x)
      worst = fmax(worst, packed_loss(got, want, first, bits, before, x, y));
  return worst;
}
