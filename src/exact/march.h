/* A pixel that receives light, and one of its half-slices, walked outwards. */
#ifndef HBIL_EXACT_MARCH_H
#define HBIL_EXACT_MARCH_H

#include "exact/coverage.h"
#include "lib/sampling_pattern.h"

/* A pixel that receives light. */
typedef struct receiver {
  const exact_frame *frame;
  const exact_planes *split;
  surface s;
  int x, y;
  coverage_kind kind;
  bool equal_weights;      /* as in exact_dense */
  double pixel_x, pixel_y; /* size of a pixel, in units of the ray's slope */
  double w_scale;          /* of a sample's w: 1 less its rounding */
  double least;            /* excess that the normal's rounding may cause */
  interval *list;          /* memory for a half-slice's intervals, or NULL */
} receiver;

/* list: see exact_coverage().  Where the pixel is sky only s is of use. */
receiver exact_receiver(const exact_frame *frame, const exact_planes *split,
                        int x, int y, coverage_kind kind, interval *list);

/* Sums over what is covered: radiance times measure, and the measure whose
 * light is not known.  The same of the lobe of glossy light, but what is known.
 */
typedef struct received {
  double light[3], unknown;
  double lobe_light[3], lobe_known;
} received;

/* Samples of finite thickness that overlap, in excess: what they cover, the
 * sums of their weights, and what they send, times their weights. */
typedef struct joined {
  double low, high, weight, lobe_weight, blocked;
  received got;
} joined;

/* A half-slice and what was met on it so far.  Measures are those of
 * exact_measure(), light is radiance times measure. */
typedef struct march {
  half_slice h;
  coverage covers;
  joined joined;     /* COVERAGE_SECTORS: not covered yet */
  double covered;    /* measure */
  double blocked;    /* the same, weighed by the falloff */
  received got;      /* of the covered part */
  double last[3];    /* radiance accepted last */
  double lobe_whole; /* the lobe */
  vec3 open_bent;    /* exact_march_end() sets it */
} march;

/* The receiver is pointed at. */
march exact_march_begin(const receiver *r, double ux, double uy);
/* Takes the pixel (x, y), which is in the picture, as a sample.  step: NULL
 * where it stands for itself alone. */
void exact_march_visit(const receiver *r, march *m, int x, int y,
                       const hbil_extent *step);
/* Takes the position (x, y) on the line of the half-slice, one of which is
 * whole, as a sample that stands for itself alone.  The surface of the nearest
 * pixel, at (near_x, near_y), goes on to the line there. */
void exact_march_cross(const receiver *r, march *m, int near_x, int near_y,
                       double x, double y);
/* After the last sample.  The receiver's list is free again. */
void exact_march_end(march *m);

#endif
