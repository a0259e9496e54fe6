/* Plots: data and script for gnuplot, and the picture where gnuplot is
 * installed. */
#ifndef HBIL_BENCH_PLOT_H
#define HBIL_BENCH_PLOT_H

#include "bench/command.h"
#include "bench/files.h"

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

/* Writes DIR/NAME.dat by `write`, DIR/NAME.gnuplot, which is the script
 * `source` of the program, and NAME.png by gnuplot.  Where gnuplot is missing
 * or fails, which is no error, it says so. */
int bench_plot_files(const bench_options *options, const char *source,
                     file_writer *write, const void *context,
                     image_error *error);

/* The scatter of error against time.  Sorts points by time. */
int bench_plot_write(const bench_options *options, bench_point *points,
                     size_t count, image_error *error);

#endif
