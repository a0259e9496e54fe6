/* Occluders of finite thickness, as the kernels see them: in sectors. */
#ifndef HBIL_EXACT_SECTORS_H
#define HBIL_EXACT_SECTORS_H

#include "exact/slice.h"

typedef struct sectors {
  unsigned covered; /* bits, from wo outwards */
  double dither;    /* 0..1: moves the sectors' borders */
  vec3 bent;        /* bent integral of what is open */
} sectors;

/* All sectors open.  dither: 0..1, added before rounding down. */
sectors exact_sectors(const half_slice *h, double dither);
/* Covers the angles from front to back.  Returns the measure that was open
 * before. */
double exact_sectors_cover(sectors *s, const half_slice *h, angle front,
                           angle back);

#endif
