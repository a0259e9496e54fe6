/* The samples that the kernels take along a half-slice. */
#ifndef HBIL_EXACT_SAMPLES_H
#define HBIL_EXACT_SAMPLES_H

#include "exact/march.h"
#include "shared.h"

/* Where a receiver's samples lie. */
typedef struct sampling {
  hbil_view_args view;
  hbil_pattern_args pattern;
  int site, level; /* of the receiver */
} sampling;

sampling exact_sampling(const receiver *r);
/* The unit direction of a slice in the image plane. */
void exact_slice_direction(const sampling *how, int slice, double *ux,
                           double *uy);
/* Visits the samples of a march, from the nearest to the farthest. */
void exact_visit_samples(const receiver *r, const sampling *how, march *m);

#endif
