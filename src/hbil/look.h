/* A picture in host memory that is looked at: its pixels, as numbers. */
#ifndef HBIL_LOOK_H
#define HBIL_LOOK_H

#include <stdbool.h>
#include <stddef.h>

#include "hbil/hbil.h"
#include "names.h"

typedef struct look {
  hbil_host_planes planes; /* with the defaults of the pitches */
  const hbil_config *config;
  const hbil_frame *frame;
  size_t pixels;
} look;

/* A pixel's piece of surface, in view space. */
typedef struct patch {
  double at[3], normal[3], area;
} patch;

double look_dot(const double a[3], const double b[3]);

/* Whether the caller has such a plane. */
bool look_has(const hbil_host_plane *plane);

/* Channel c at pixel i, or the first channel if there is no such one. */
double look_value(const look *l, const hbil_host_plane *plane, size_t c,
                  size_t i);

/* The same of light: 0 if the plane is missing, negative or not finite. */
double look_light(const look *l, const hbil_host_plane *plane, size_t c,
                  size_t i);

/* Irradiance of direct light; 0 where it is unknown. */
double look_irradiance(const look *l, size_t c, size_t i);

bool look_is_sky(const look *l, size_t i);

/* Returns false if the pixel shows no surface. */
bool look_patch(const look *l, size_t i, patch *out);

/* --- what is known of a place (surroundings.c) --- */

/* Adds what a picture shows of how open the place is to `found`. */
void surroundings_add(const look *l, hbil_sources *found);

/* The share of the open directions that ends in a sky which no picture shows,
 * or in nothing, by all pictures that were added.  Sets found->place. */
float surroundings_hidden_sky(hbil_sources *found);

#endif
