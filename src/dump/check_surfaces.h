/* Checks that depths are those of surfaces. */
#ifndef HBIL_DUMP_CHECK_SURFACES_H
#define HBIL_DUMP_CHECK_SURFACES_H

#include "dump/findings.h"
#include "dump/surface_points.h"

/* What a frame's depths are besides those of surfaces. */
typedef struct surface_check {
  size_t edges;   /* where one surface ends in front of another */
  double mixed;   /* the share of them that have a pixel on neither surface */
  double scatter; /* half of the pixels on smooth surfaces are off from their
                   * neighbours' line by more than this, in widths of a pixel;
                   * 0: this is a curve of the surface, or a half's rounding */
  double blur;    /* nine tenths of the positions are within so many pixels of
                   * their own pixel's ray; NaN: there are no positions */
} surface_check;

/* Measures.  Returns 0, or -1 if memory runs out. */
int surface_check_measure(const surface_points *s, surface_check *out);

/* Adds at most one finding for the depths.  others: whether the frame doesn't
 * fit its camera, so that only edges say something. */
void check_surfaces(const surface_points *s, int others, findings *out);

#endif
