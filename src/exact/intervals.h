/* Occluders of finite thickness, exactly: in intervals of angles. */
#ifndef HBIL_EXACT_INTERVALS_H
#define HBIL_EXACT_INTERVALS_H

#include "exact/slice.h"

/* Covered angles.  They fall as excess grows, so either tells the order; excess
 * is known without computing the angle. */
typedef struct interval {
  double high, low;  /* excess of the end towards wo, and of the other one */
  angle front, back; /* the angles of those ends */
} interval;

/* Disjoint intervals, from wo outwards.  The memory is the caller's; each
 * occluder adds one interval at most. */
typedef struct intervals {
  interval *list;
  int count;
} intervals;

/* Covers what lies between the excesses high and low at a distance along the
 * half-slice.  Returns the measure that was open before. */
double exact_intervals_cover(intervals *covered, const half_slice *h,
                             double distance, double high, double low);
/* The bent integral of what is open. */
vec3 exact_intervals_bent(const intervals *covered, const half_slice *h);

#endif
