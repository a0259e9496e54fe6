/* The part of a half-slice that occluders hide. */
#ifndef HBIL_EXACT_COVERAGE_H
#define HBIL_EXACT_COVERAGE_H

#include "exact/intervals.h"
#include "exact/sectors.h"

typedef enum coverage_kind {
  COVERAGE_HORIZON,  /* infinite thickness: everything beyond one angle */
  COVERAGE_SECTORS,  /* finite thickness as the kernels have it */
  COVERAGE_INTERVALS /* finite thickness, exactly */
} coverage_kind;

typedef struct coverage {
  coverage_kind kind;
  double threshold; /* the excess that a sample must exceed to cover anything */
  /* One of these, by kind: */
  struct {
    angle top;      /* the horizon */
    double measure; /* A(top) */
  } horizon;
  sectors sectors;
  intervals intervals;
  bool glossy;
  double lobe; /* of the lobe, what was covered last; not of intervals */
} coverage;

/* The kind that the settings need; finite: the one for finite thickness. */
coverage_kind exact_coverage_kind(const hbil_config *config,
                                  coverage_kind finite);
/* Nothing covered.  dither: 0..1 (COVERAGE_SECTORS); list: memory
 * for one interval an occluder (COVERAGE_INTERVALS), else NULL. */
coverage exact_coverage(coverage_kind kind, const half_slice *h,
                        double threshold, double dither, interval *list);
/* Covers what a sample at a distance hides, between the excess of its front and
 * that of its back.  Returns the measure that was open before. */
double exact_cover(coverage *c, const half_slice *h, double distance,
                   double front, double back);
/* The bent integral of what is open. */
vec3 exact_open_bent(const coverage *c, const half_slice *h);

#endif
