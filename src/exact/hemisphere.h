/* A pixel's sums over its slices. */
#ifndef HBIL_EXACT_HEMISPHERE_H
#define HBIL_EXACT_HEMISPHERE_H

#include "exact/march.h"
#include "lib/glossy_args.h"

/* Sums over half-slices, each weighed by its J. */
typedef struct hemisphere {
  double whole, open; /* measure of the hemisphere, and of its open part */
  double unknown;     /* measure whose light is not known */
  double light[3];    /* radiance times measure */
  double lobe[HBIL_GATHERED_GLOSSY_PLANES];
  vec3 bent, bent_whole; /* bent integral of the open part, and of everything */
} hemisphere;

/* Adds a slice: its two half-slices, which were ended. */
void exact_add_slice(hemisphere *sum, const hbil_config *config,
                     const march *ahead, const march *behind);
/* Writes the pixel of GATHERED.  slices: how many were added. */
void exact_store_gathered(const receiver *r, const hemisphere *sum, int slices,
                          exact_planes *gathered);
/* The same for sky. */
void exact_store_sky(const receiver *r, exact_planes *gathered);

#endif
