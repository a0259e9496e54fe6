/* The scatter of error against time: data and script for gnuplot, and the
 * picture where gnuplot is installed. */
#ifndef HBIL_BENCH_PLOT_H
#define HBIL_BENCH_PLOT_H

#include "bench/command.h"

/* Panels of the plot. */
enum { BENCH_PANEL_LIGHT = 0, BENCH_PANEL_AO, BENCH_PANELS };

/* Kinds of points, which have a colour each. */
typedef enum bench_kind {
  BENCH_KIND_DEFAULT = 0,
  BENCH_KIND_PAPER,
  BENCH_KIND_OTHER,
  BENCH_KIND_BASELINE,
  BENCH_KINDS
} bench_kind;

typedef struct bench_point {
  double milliseconds, error[BENCH_PANELS]; /* not finite or 0: not drawn */
  int front[BENCH_PANELS]; /* on the Pareto front of its kind */
  bench_kind kind;
  const char *label; /* NULL: none */
} bench_point;

/* Writes DIR/NAME.dat and NAME.gnuplot, and NAME.png by gnuplot.  Sorts points
 * by time.  *made: 0 where gnuplot is missing or fails, which is no error. */
int bench_plot_write(const bench_options *options, bench_point *points,
                     size_t count, int *made, image_error *error);

#endif
