/* How much the light of surfaces changes between two frames that both show
 * them. */
#ifndef HBIL_BENCH_FLICKER_MEASURE_H
#define HBIL_BENCH_FLICKER_MEASURE_H

#include "bench/content.h"

/* Of a pair of frames, over the mean of the first one's light. */
typedef struct flicker_change {
  double rms;      /* RMS of the change */
  double patches;  /* the same after a blur of FLICKER_SIGMA pixels, and without
                    * the change of the whole picture */
  double compared; /* the share of the pixels that was compared */
} flicker_change;

/* Patches of this size are what an eye sees as boiling. */
#define FLICKER_SIGMA 4.0

/* Whether the content has what flicker_measure() needs: NULL, or what is
 * missing. */
const char *flicker_lacks(const bench_content *content);

/* light: an RGB output of the frames `first` and `first` + 1 of the content,
 * plane after plane.  Points that don't move and that both frames show are
 * compared; the second frame is read between its pixels.  Where there are none,
 * the figures are NAN. */
int flicker_measure(const bench_content *content, unsigned first,
                    const float *const light[2], flicker_change *out,
                    image_error *error);

#endif
