/* Error against time of the providers of far light. */
#ifndef HBIL_BENCH_FAR_PLOT_H
#define HBIL_BENCH_FAR_PLOT_H

#include "bench/command.h"
#include "bench/far_provider.h"

/* Of one provider; errors are NAN where no scene has one. */
typedef struct far_point {
  double milliseconds;
  double error[2]; /* of all scenes; of those with a light view */
} far_point;

/* Writes DIR/NAME.dat and NAME.gnuplot, and NAME.png where gnuplot is.  *made:
 * 0 where it is missing or fails, which is no error. */
int far_plot_write(const bench_options *options,
                   const far_point points[FAR_PROVIDERS], int *made,
                   image_error *error);

#endif
