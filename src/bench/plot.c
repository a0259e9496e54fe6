/*
 * The scatter of error against time.  gnuplot draws it; what it can't do is
 * find free positions for labels, so this is done here, with the size that a
 * panel has in error.gnuplot.
 */
#define _POSIX_C_SOURCE 200809L
#include "bench/plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/files.h"
#include "bench/opencl.h"

/* Pixels: a panel's area, a character of a label, a dot's radius. */
enum { WIDTH = 750, HEIGHT = 350, CHARACTER = 6, LINE = 12, DOT = 4 };
/* Boxes that a point takes at most: its own, its label's, and those along the
 * line to the next one. */
enum { TAKEN_OF_POINT = 40 };

typedef struct box {
  double x, y, width, height; /* pixels, y upwards */
} box;

typedef struct panel {
  const bench_point *points;
  size_t count;
  int which;
  double low[2], high[2]; /* of time and error, logarithms to base 10 */
  box *taken;             /* by dots and labels */
  size_t taken_count;
} panel;

/* --- positions --- */

static double coordinate(const panel *p, const bench_point *point, int axis) {
  return axis == 0 ? point->milliseconds : point->error[p->which];
}

static int is_drawn(const panel *p, const bench_point *point) {
  const double error = point->error[p->which];
  return isfinite(error) && error > 0.0 && point->milliseconds > 0.0;
}

static double pixel_of(const panel *p, const bench_point *point, int axis) {
  return (log10(coordinate(p, point, axis)) - p->low[axis]) /
         (p->high[axis] - p->low[axis]) * (axis == 0 ? WIDTH : HEIGHT);
}

/* Ranges that hold all points, with a margin of 0.08 decades. */
static void fit(panel *p) {
  p->low[0] = p->low[1] = INFINITY;
  p->high[0] = p->high[1] = -INFINITY;
  for (size_t i = 0; i < p->count; i++)
    for (int axis = 0; axis < 2 && is_drawn(p, &p->points[i]); axis++) {
      const double at = log10(coordinate(p, &p->points[i], axis));
      p->low[axis] = fmin(p->low[axis], at - 0.08);
      p->high[axis] = fmax(p->high[axis], at + 0.08);
    }
}

static int is_free(const panel *p, const box *b) {
  if (b->x < 0 || b->x + b->width > WIDTH || b->y < 0 ||
      b->y + b->height > HEIGHT)
    return 0;
  for (size_t i = 0; i < p->taken_count; i++) {
    const box *t = &p->taken[i];
    if (t->x < b->x + b->width && b->x < t->x + t->width &&
        t->y < b->y + b->height && b->y < t->y + t->height)
      return 0;
  }
  return 1;
}

/* No label lies on the line of the front: small boxes along it are taken. */
static void take_front(panel *p) {
  enum { STEPS = TAKEN_OF_POINT - 2 };
  const bench_point *last = NULL;
  for (size_t i = 0; i < p->count; i++) {
    const bench_point *next = &p->points[i];
    if (!is_drawn(p, next) || next->kind != BENCH_KIND_DEFAULT ||
        !next->front[p->which])
      continue;
    for (int k = 1; last && k <= STEPS; k++) {
      const double t = (double)k / (STEPS + 1);
      p->taken[p->taken_count++] = (box){
          (1 - t) * pixel_of(p, last, 0) + t * pixel_of(p, next, 0),
          (1 - t) * pixel_of(p, last, 1) + t * pixel_of(p, next, 1), 1, 1};
    }
    last = next;
  }
}

/* Left of the dot and below it first: nothing is better than the front, so it
 * is free there.  Returns 0 where no position is. */
static int place_label(panel *p, const bench_point *point, box *out) {
  const double width = CHARACTER * (double)strlen(point->label);
  for (int away = 2 * DOT; away < 3 * LINE; away += LINE)
    for (int side = 0; side < 4; side++) {
      const double dx = side % 2 ? 2 * DOT : -2 * DOT - width;
      const double dy = side == 0 || side == 3 ? -away : away;
      *out = (box){pixel_of(p, point, 0) + dx,
                   pixel_of(p, point, 1) + dy - LINE / 2, width, LINE};
      if (is_free(p, out)) {
        p->taken[p->taken_count++] = *out;
        return 1;
      }
    }
  return 0;
}

/* --- data: blocks of gnuplot, each with a first line that draws nothing --- */

static void write_points(panel *p, bench_kind kind, int front, FILE *out) {
  fprintf(out, "NaN NaN\n");
  for (size_t i = 0; i < p->count; i++) {
    const bench_point *point = &p->points[i];
    if (!is_drawn(p, point) || point->kind != kind ||
        (front && !point->front[p->which]))
      continue;
    fprintf(out, "%g %g\n", point->milliseconds, point->error[p->which]);
    if (!front)
      p->taken[p->taken_count++] =
          (box){pixel_of(p, point, 0) - DOT, pixel_of(p, point, 1) - DOT,
                2 * DOT, 2 * DOT};
  }
  fprintf(out, "\n\n");
}

/* In graph coordinates, 0..1.  Labels without a free position are left to the
 * table. */
static void write_labels(panel *p, FILE *out) {
  box b;
  take_front(p);
  fprintf(out, "0 0 \"\"\n");
  for (int important = 1; important >= 0; important--)
    for (size_t i = 0; i < p->count; i++) {
      const bench_point *point = &p->points[i];
      if (is_drawn(p, point) && point->important == important &&
          (important || point->front[p->which]) && place_label(p, point, &b))
        fprintf(out, "%g %g \"%s\"\n", b.x / WIDTH, (b.y + LINE / 2) / HEIGHT,
                point->label);
    }
  fprintf(out, "\n\n");
}

typedef struct plot {
  const char *name;
  panel panels[BENCH_PANELS];
} plot;

static void write_data(const void *context, FILE *out) {
  for (int which = 0; which < BENCH_PANELS; which++) {
    panel p = ((const plot *)context)->panels[which];
    for (int kind = 0; kind < BENCH_KINDS; kind++)
      write_points(&p, (bench_kind)kind, 0, out);
    write_points(&p, BENCH_KIND_DEFAULT, 1, out);
    write_labels(&p, out);
  }
}

/* The script of the source tree behind the variables that it uses. */
static void write_script(const void *context, FILE *out) {
  const plot *p = context;
  fprintf(out, "data = \"%s.dat\"\npicture = \"%s.png\"\narray range[8]\n",
          p->name, p->name);
  for (int i = 0; i < 4; i++)
    fprintf(out, "range[%d] = %g\nrange[%d] = %g\n", 2 * i + 1,
            pow(10.0, p->panels[i / 2].low[i % 2]), 2 * i + 2,
            pow(10.0, p->panels[i / 2].high[i % 2]));
  fputs(bench_source_text("error.gnuplot"), out);
}

/* --- files --- */

/* The names travel in the environment, whatever characters they have. */
int bench_plot_draw(const char *folder, const char *script) {
  return setenv("HBIL_BENCH_FOLDER", folder, 1) == 0 &&
         setenv("HBIL_BENCH_SCRIPT", script, 1) == 0 &&
         system("cd -- \"$HBIL_BENCH_FOLDER\" && "
                "command -v gnuplot >/dev/null && "
                "gnuplot \"./$HBIL_BENCH_SCRIPT\"") == 0;
}

static int write_files(const bench_options *options, const plot *p, int *made,
                       image_error *error) {
  char *data = bench_result_path(options->output, p->name, "dat");
  char *script = bench_result_path(options->output, p->name, "gnuplot");
  int failed = data && script ? 0 : image_no_memory(error, "the plot");
  failed =
      failed ||
      temporary_write(data, EXISTING_REPLACED, write_data, p, error) != 0 ||
      temporary_write(script, EXISTING_REPLACED, write_script, p, error) != 0;
  if (!failed)
    *made = bench_plot_draw(options->output, strrchr(script, '/') + 1);
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
                     size_t count, int *made, image_error *error) {
  plot p = {.name = options->name};
  box *taken = calloc(TAKEN_OF_POINT * count, sizeof *taken);
  if (!taken)
    return image_no_memory(error, "the plot");
  qsort(points, count, sizeof *points, by_time);
  for (int which = 0; which < BENCH_PANELS; which++) {
    p.panels[which] = (panel){
        .points = points, .count = count, .which = which, .taken = taken};
    fit(&p.panels[which]);
  }
  const int failed = write_files(options, &p, made, error);
  free(taken);
  return failed;
}
