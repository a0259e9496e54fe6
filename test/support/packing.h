/*
 * The words of HBIL_STORAGE_PACKED in double precision, written from their
 * description in shared.h alone.
 */
#ifndef HBIL_TEST_PACKING_H
#define HBIL_TEST_PACKING_H

#include <stdint.h>

#include "test/support/checked_exact.h"

/* A unit vector as an octahedral word, and back. */
uint32_t encode_normal(const double n[3]);
void decode_normal(uint32_t word, double n[3]);
/* The value of one step of a mantissa of `bits` bits where `most` is the
 * largest channel. */
double packed_unit(double most, int bits);

/* The largest error of a pixel's light, in planes from `first` on, relative to
 * what its words may lose, with mantissas of `bits` bits.  Errors of up to
 * `before` are those of earlier passes, and don't count. */
double packed_loss(const exact_planes *got, const exact_planes *want, int first,
                   int bits, double before, int x, int y);
/* The largest one. */
double packed_losses(const exact_planes *got, const exact_planes *want,
                     int first, int bits, double before);

/* Derived: 1 is all that rounding to the nearest may lose.  Computing a
 * mantissa of 10 bits in fp32 adds up to 2^-14 of half a step. */
#define PACKED_LOSS_LIMIT (1.0 + 1e-4)

/* Bits of the mantissas of packed radiance. */
#define PACKED_RADIANCE_BITS 8

/* A pixel's words, and the values that HBIL_STORAGE_FLOAT32 has in their
 * place. */
typedef struct packed_pixel {
  uint32_t word[4];
  double value[HBIL_GATHERED_PLANES];
} packed_pixel;

void decode_split(packed_pixel *p);
void encode_split(packed_pixel *p);
void decode_history(packed_pixel *p);
void encode_history(packed_pixel *p);
void decode_carried(packed_pixel *p);
void encode_carried(packed_pixel *p);
void decode_gathered(packed_pixel *p);
/* The pixel's place decides its dither. */
void encode_gathered(packed_pixel *p, int x, int y);

#endif
