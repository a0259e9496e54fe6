/* Plots: the files of any of them, and the scatter of error against time, which
 * error.gnuplot draws. */
#define _POSIX_C_SOURCE 200809L
#include "bench/plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/opencl.h"

typedef struct plot {
  const bench_point *points;
  size_t count;
} plot;

/* Labels are below and to the left of their points: there are few settings that
 * are both faster and better.  A label that would cover the one before it is
 * moved this far below that. */
static const double nearby_time = 1.35, line_height = 0.85;

static int is_drawn(const bench_point *point, int panel) {
  return isfinite(point->error[panel]) && point->error[panel] > 0.0 &&
         point->milliseconds > 0.0;
}

/* --- data: blocks of gnuplot, each with a first line that draws nothing --- */

static void write_points(const plot *p, int panel, bench_kind kind, int front,
                         FILE *out) {
  fprintf(out, "NaN NaN\n");
  for (size_t i = 0; i < p->count; i++) {
    const bench_point *point = &p->points[i];
    if (is_drawn(point, panel) && point->kind == kind &&
        (!front || point->front[panel]))
      fprintf(out, "%g %g\n", point->milliseconds, point->error[panel]);
  }
  fprintf(out, "\n\n");
}

static void write_labels(const plot *p, int panel, FILE *out) {
  double time = 0.0, height = INFINITY;
  fprintf(out, "NaN NaN \"\"\n");
  for (size_t i = 0; i < p->count; i++) {
    const bench_point *point = &p->points[i];
    if (!point->label || !is_drawn(point, panel))
      continue;
    height = point->milliseconds < nearby_time * time
                 ? fmin(point->error[panel], line_height * height)
                 : point->error[panel];
    time = point->milliseconds;
    fprintf(out, "%g %g \"%s\"\n", time, height, point->label);
  }
  fprintf(out, "\n\n");
}

static void write_data(const void *context, FILE *out) {
  const plot *p = context;
  for (int panel = 0; panel < BENCH_PANELS; panel++) {
    for (int kind = 0; kind < BENCH_KINDS; kind++)
      write_points(p, panel, (bench_kind)kind, 0, out);
    write_points(p, panel, BENCH_KIND_DEFAULT, 1, out);
    write_labels(p, panel, out);
  }
}

typedef struct commands {
  const char *name, *source;
} commands;

/* The script of the source tree behind the variables that it uses. */
static void write_script(const void *context, FILE *out) {
  const commands *s = context;
  fprintf(out, "data = \"%s.dat\"\npicture = \"%s.png\"\n", s->name, s->name);
  fputs(bench_source_text(s->source), out);
}

/* --- files --- */

/* The names travel in the environment, whatever characters they have. */
static int draw(const char *folder, const char *script) {
  return setenv("HBIL_BENCH_FOLDER", folder, 1) == 0 &&
         setenv("HBIL_BENCH_SCRIPT", script, 1) == 0 &&
         system("cd -- \"$HBIL_BENCH_FOLDER\" && "
                "command -v gnuplot >/dev/null && "
                "gnuplot \"./$HBIL_BENCH_SCRIPT\"") == 0;
}

int bench_plot_files(const bench_options *options, const char *source,
                     file_writer *write, const void *context,
                     image_error *error) {
  const commands drawing = {.name = options->name, .source = source};
  char *data = bench_result_path(options->output, options->name, "dat");
  char *script = bench_result_path(options->output, options->name, "gnuplot");
  const int failed =
      !data || !script
          ? image_no_memory(error, "the plot")
          : temporary_write(data, EXISTING_REPLACED, write, context, error) ||
                temporary_write(script, EXISTING_REPLACED, write_script,
                                &drawing, error);
  if (!failed && !draw(options->output, strrchr(script, '/') + 1))
    fputs("hbil-bench: no plot was drawn: gnuplot (Debian's gnuplot-nox) is "
          "needed for it\n",
          stderr);
  free(data);
  free(script);
  return failed ? -1 : 0;
}

static int by_time(const void *a, const void *b) {
  const double x = ((const bench_point *)a)->milliseconds;
  const double y = ((const bench_point *)b)->milliseconds;
  return (x > y) - (x < y);
}

int bench_plot_write(const bench_options *options, bench_point *points,
                     size_t count, image_error *error) {
  const plot p = {.points = points, .count = count};
  qsort(points, count, sizeof *points, by_time);
  return bench_plot_files(options, "error.gnuplot", write_data, &p, error);
}
