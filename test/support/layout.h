/*
 * The planes of a G-buffer and of a plan's outputs in a caller's memory: which
 * there are, where their components lie, and what surrounds them.
 */
#ifndef HBIL_TEST_LAYOUT_H
#define HBIL_TEST_LAYOUT_H

#include <stddef.h>
#include <stdint.h>

#include "hbil/hbil.h"

/* In the order of the members of hbil_config. */
typedef enum plane_id {
  PLANE_DEPTH,
  PLANE_NORMAL,
  PLANE_ALBEDO,
  PLANE_F0,
  PLANE_DIRECT,
  PLANE_EMISSION,
  PLANE_MOTION,
  PLANE_NEAR,
  PLANE_FAR,
  PLANE_AO,
  PLANE_BENT,
  PLANE_CONE,
  PLANE_INDIRECT,
  PLANE_BEAUTY,
  PLANE_COUNT
} plane_id;

#define PLANE_FIRST_OUTPUT PLANE_NEAR

/* The name of the member of hbil_config. */
const char *plane_name(plane_id id);
int plane_channels(plane_id id);
/* The first of its channels among all inputs (EXACT_DEPTH...) or all outputs
 * (EXACT_NEAR_IRRADIANCE...). */
int plane_first(plane_id id);
hbil_plane_format *plane_format(hbil_config *config, plane_id id);
hbil_plane *plane_slot(hbil_frame *frame, plane_id id);

/* Room that is left around a plane, in components. */
typedef struct plane_layout {
  size_t offset, row_extra, plane_extra;
} plane_layout;

/* Where a plane's components lie, in bytes. */
typedef struct placement {
  hbil_component component;
  size_t size, offset, pixel, row, plane, end;
} placement;

placement place_plane(const hbil_config *config, plane_id id,
                      const plane_layout *layout);
/* The first byte of a component. */
size_t placement_of(const placement *p, int channel, size_t x, size_t y);
/* A component's bytes, rounded to its format. */
void encode_component(const placement *p, unsigned char *at, float value);
float decode_component(const placement *p, const unsigned char *at);

/* Every byte of a buffer that is no part of a plane has this value: it makes
 * not-a-numbers in every format. */
#define CANARY 0xff
#define CANARY_BYTES 64

/* IEEE half floats; rounded to the nearest, ties to even. */
float half_to_float(uint16_t half);
uint16_t float_to_half(float value);

#endif
