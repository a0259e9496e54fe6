/*
 * The planes of a G-buffer and of a plan's outputs in a caller's memory: which
 * there are, where their components lie, and what surrounds them.
 */
#ifndef HBIL_TEST_LAYOUT_H
#define HBIL_TEST_LAYOUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "hbil/hbil.h"
#include "hbil/plane_list.h"

/* The name of the member of hbil_config. */
const char *plane_name(plane_id id);
int plane_channels(plane_id id);
/* The first of its channels among all inputs (EXACT_DEPTH...) or all outputs
 * (EXACT_NEAR_IRRADIANCE...), whose order is the list's. */
int plane_first(plane_id id);
hbil_plane_format *plane_format(hbil_config *config, plane_id id);
hbil_plane *plane_slot(hbil_frame *frame, plane_id id);

/* Room that is left around a plane, in components. */
typedef struct plane_layout {
  size_t offset, row_extra, plane_extra;
} plane_layout;

/* A format whose pixels are `stride` components apart; 0: without gaps. */
hbil_plane_format pitched_format(hbil_component component, cl_uint stride);

/* Where a plane's components lie, in bytes. */
typedef struct placement {
  hbil_component component;
  size_t size, offset, pixel, row, plane, end;
} placement;

placement place_plane(const hbil_config *config, plane_id id,
                      const plane_layout *layout);
/* The first byte of a component. */
size_t placement_of(const placement *p, int channel, size_t x, size_t y);
/* Whether the components of an input are floats that mean themselves. */
bool stores_its_values(const hbil_config *config, plane_id id,
                       const placement *p);
/* Stores an input's channels in a pixel's bytes, and replaces them by what
 * these mean: normals by directions, hardware depth by planar depth. */
void store_pixel(const hbil_config *config, const hbil_frame *frame,
                 plane_id id, const placement *p, unsigned char *bytes,
                 size_t x, size_t y, float values[3]);

/* The value of a component; channel: of a word that holds all of them. */
double component_value(hbil_component component, const unsigned char *at,
                       int channel);
/* A direction, of any length, from octahedral coordinates. */
void octahedral_normal(const double uv[2], double normal[3]);
/* w of a value of the depth buffer: 1/z, in orthographic views -z. */
double hardware_depth_w(const hbil_config *config, const hbil_frame *frame,
                        double d);

/* Every byte of a buffer that is no part of a plane has this value: it makes
 * not-a-numbers in every format. */
#define CANARY 0xff
#define CANARY_BYTES 64

#endif
