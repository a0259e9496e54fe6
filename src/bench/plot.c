/* The report as a picture: error against milliseconds, log-log, in SVG. */
#include "bench/bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
  WIDTH = 1200,
  HEAD = 96, /* title, machine, legend */
  PANEL = 640,
  LEFT = 80,
  RIGHT = 1170,
  TOP = 36, /* of the axes, within a panel */
  BOTTOM = 590,
  CHARACTER = 6, /* width of a letter of a label */
  LINE = 11,     /* height of a label */
  LINES = 2048,  /* boxes that stand for lines, at most */
  PEARL = 5,     /* between boxes that stand for a line */
  RINGS = 10     /* how far it may be from its dot, in lines */
};

typedef struct dot {
  double x, y; /* milliseconds, error */
  char label[BENCH_LABEL];
  int front, standard, preset;
  int kind; /* index in kinds[] */
} dot;

/* What dots are of. */
static const struct {
  const char *name, *color;
} kinds[] = {{"the paper's model (library)", "#c33"},
             {"its occluders end", "#d98a00"},
             {"the tool's model", "#1f6fb5"},
             {"GTAO", "#2c8f3c"},
             {"HBAO", "#8a4fb0"},
             {"adaptive", "#0a8f8f"},
             {"literal: the paper as one kernel", "#000"}};

enum { PAPER, THICK, TOOL, GTAO, HBAO, ADAPTIVE, LITERAL, KINDS };

/* A logarithmic axis: decades low..high on pixels from..to. */
typedef struct axis {
  double low, high, from, to;
} axis;

typedef struct box {
  double x, y, width, height;
} box;

typedef struct panel {
  FILE *out;
  const char *title;
  axis x, y;
  dot *dots;
  size_t count;
  box *taken; /* by dots, lines and labels */
  size_t taken_count, taken_most;
} panel;

static double place(const axis *a, double value) {
  return a->from +
         (log10(value) - a->low) / (a->high - a->low) * (a->to - a->from);
}

static void write_text(FILE *out, const char *text) {
  for (; *text; text++)
    if (*text == '<')
      fputs("&lt;", out);
    else if (*text == '>')
      fputs("&gt;", out);
    else if (*text == '&')
      fputs("&amp;", out);
    else
      fputc((unsigned char)*text < ' ' ? ' ' : *text, out);
}

/* --- dots --- */

static int can_be_drawn(const dot *d) {
  return isfinite(d->x) && isfinite(d->y) && d->x > 0.0 && d->y > 0.0;
}

static int kind_of(const bench_configuration *c) {
  if (bench_is_adaptive(c))
    return ADAPTIVE;
  switch (c->model) {
  case BENCH_PAPER:
    return PAPER;
  case BENCH_TOOL:
    return TOOL;
  case BENCH_GTAO:
    return GTAO;
  case BENCH_HBAO:
    return HBAO;
  default:
    return THICK;
  }
}

/* Without " full", which nearly all have. */
static void shorten(const char *label, char *out, size_t size) {
  const char *full = strstr(label, " full");
  if (full)
    snprintf(out, size, "%.*s%s", (int)(full - label), label,
             full + strlen(" full"));
  else
    snprintf(out, size, "%s", label);
}

static dot dot_of(const bench_row *r, int ao) {
  dot d = {.x = r->total.median,
           .y = ao ? r->ao_error : r->light_error,
           .front = ao ? r->ao_front : r->light_front,
           .standard = bench_is_default(&r->configuration),
           .preset = r->configuration.preset != NULL,
           .kind = kind_of(&r->configuration)};
  shorten(r->label, d.label, sizeof d.label);
  return d;
}

static size_t collect(const bench_report *report, int ao, dot *out) {
  size_t count = 0;
  for (size_t i = 0; i < report->count; i++) {
    out[count] = dot_of(&report->rows[i], ao);
    count += (size_t)can_be_drawn(&out[count]);
  }
  const bench_literal *l = &report->literal;
  out[count] = (dot){.x = l->milliseconds.median,
                     .y = ao ? l->ao_error : l->light_error,
                     .label = "literal, unfiltered",
                     .kind = LITERAL};
  return count + (size_t)can_be_drawn(&out[count]);
}

static int by_time(const void *a, const void *b) {
  const double x = ((const dot *)a)->x, y = ((const dot *)b)->x;
  return (x > y) - (x < y);
}

/* --- axes --- */

static void fit(const dot *dots, size_t count, axis *x, axis *y) {
  x->low = y->low = INFINITY;
  x->high = y->high = -INFINITY;
  for (size_t i = 0; i < count; i++) {
    x->low = fmin(x->low, log10(dots[i].x));
    x->high = fmax(x->high, log10(dots[i].x));
    y->low = fmin(y->low, log10(dots[i].y));
    y->high = fmax(y->high, log10(dots[i].y));
  }
  const double margin = 0.08;
  x->low -= margin;
  x->high += margin;
  y->low -= margin;
  y->high += margin;
}

static void write_tick(const panel *p, int horizontal, double value) {
  const double at = place(horizontal ? &p->x : &p->y, value);
  if (horizontal)
    fprintf(p->out,
            "<line x1=\"%.1f\" y1=\"%d\" x2=\"%.1f\" y2=\"%d\" "
            "class=\"grid\"/><text x=\"%.1f\" y=\"%d\" "
            "text-anchor=\"middle\">%g</text>\n",
            at, TOP, at, BOTTOM, at, BOTTOM + 16, value);
  else
    fprintf(p->out,
            "<line x1=\"%d\" y1=\"%.1f\" x2=\"%d\" y2=\"%.1f\" "
            "class=\"grid\"/><text x=\"%d\" y=\"%.1f\" "
            "text-anchor=\"end\">%g</text>\n",
            LEFT, at, RIGHT, at, LEFT - 6, at + 4.0, value);
}

/* 1, 2 and 5 of each decade. */
static void write_ticks(const panel *p, int horizontal) {
  const axis *a = horizontal ? &p->x : &p->y;
  static const double steps[] = {1.0, 2.0, 5.0};
  for (int decade = (int)floor(a->low); decade <= (int)floor(a->high); decade++)
    for (int i = 0; i < 3; i++) {
      const double value = steps[i] * pow(10.0, decade);
      const double at = log10(value);
      if (at >= a->low && at <= a->high)
        write_tick(p, horizontal, value);
    }
}

static void write_axes(const panel *p) {
  write_ticks(p, 1);
  write_ticks(p, 0);
  fprintf(p->out,
          "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" class=\"axes\"/>"
          "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">milliseconds of the "
          "whole frame</text>\n"
          "<text x=\"%d\" y=\"%d\" class=\"title\">%s</text>\n",
          LEFT, TOP, RIGHT - LEFT, BOTTOM - TOP, (LEFT + RIGHT) / 2,
          BOTTOM + 34, LEFT, TOP - 10, p->title);
}

/* --- dots and labels --- */

/* No label lies on a line: boxes along it are taken. */
static void take_segment(panel *p, double x0, double y0, double x1, double y1) {
  const int steps = 1 + (int)(hypot(x1 - x0, y1 - y0) / PEARL);
  for (int i = 1; i < steps && p->taken_count < p->taken_most; i++) {
    const double t = (double)i / steps;
    p->taken[p->taken_count++] =
        (box){x0 + t * (x1 - x0) - 1.0, y0 + t * (y1 - y0) - 1.0, 2.0, 2.0};
  }
}

static void write_front(panel *p, int kind) {
  double last_x = NAN, last_y = NAN;
  fprintf(p->out, "<polyline class=\"front\" stroke=\"%s\" points=\"",
          kinds[kind].color);
  for (size_t i = 0; i < p->count; i++) {
    if (!p->dots[i].front || p->dots[i].kind != kind)
      continue;
    const double x = place(&p->x, p->dots[i].x), y = place(&p->y, p->dots[i].y);
    fprintf(p->out, "%.1f,%.1f ", x, y);
    if (!isnan(last_x))
      take_segment(p, last_x, last_y, x, y);
    last_x = x;
    last_y = y;
  }
  fputs("\"/>\n", p->out);
}

/* Presets are larger and have a ring. */
static void write_dot(panel *p, const dot *d) {
  const double x = place(&p->x, d->x), y = place(&p->y, d->y);
  const double size = d->preset ? 5.0 : 3.5;
  fprintf(p->out,
          "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"%s\"%s/>\n", x, y,
          size, kinds[d->kind].color,
          d->front || d->preset || d->kind == LITERAL ? "" : " opacity=\".5\"");
  if (d->preset)
    fprintf(p->out,
            "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"8\" class=\"preset\" "
            "stroke=\"%s\"/>\n",
            x, y, kinds[d->kind].color);
  p->taken[p->taken_count++] =
      (box){x - size - 1.0, y - size - 1.0, 2.0 * size + 2.0, 2.0 * size + 2.0};
}

static int overlap(const box *a, const box *b) {
  return a->x < b->x + b->width && b->x < a->x + a->width &&
         a->y < b->y + b->height && b->y < a->y + a->height;
}

static int is_free(const panel *p, const box *b) {
  if (b->x < LEFT || b->x + b->width > RIGHT || b->y < TOP ||
      b->y + b->height > BOTTOM)
    return 0;
  for (size_t i = 0; i < p->taken_count; i++)
    if (overlap(&p->taken[i], b))
      return 0;
  return 1;
}

/* Beside the dot, else above or below it, farther and farther.  Not placed: a
 * box without a width. */
static box place_label(const panel *p, double x, double y, double width) {
  for (int ring = 0; ring < RINGS; ring++)
    for (int way = 0; way < 6; way++) {
      const double shift = (way % 3 == 0   ? 0.0
                            : way % 3 == 1 ? -1.0
                                           : 1.0) *
                           (double)(LINE * (ring + 1));
      const box b = {way < 3 ? x + 12.0 : x - 12.0 - width, y - 5.0 + shift,
                     width, LINE};
      if (is_free(p, &b))
        return b;
    }
  return (box){0.0, 0.0, 0.0, 0.0};
}

/* 2: presets, defaults and the baseline; 1: what else is worth a look. */
static int importance(const dot *d) {
  if (d->preset || d->standard || d->kind == LITERAL)
    return 2;
  return d->front || d->kind != PAPER;
}

static void write_label(panel *p, const dot *d) {
  const double x = place(&p->x, d->x), y = place(&p->y, d->y);
  char text[80];
  snprintf(text, sizeof text, "%s%s", d->label,
           d->standard ? " (library's default)" : "");
  const box b = place_label(p, x, y, (double)(CHARACTER * strlen(text)));
  if (!(b.width > 0.0))
    return; /* it has a row in the table */
  p->taken[p->taken_count++] = b;
  if (fabs(b.y + 5.0 - y) > LINE + 1.0) /* too far to be seen as its own */
    fprintf(p->out,
            "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" "
            "class=\"leader\"/>\n",
            x, y, b.x > x ? b.x : b.x + b.width, b.y + 5.0);
  static const char *const styles[] = {"label dim", "label", "label name"};
  fprintf(p->out, "<text x=\"%.1f\" y=\"%.1f\" class=\"%s\">", b.x,
          b.y + LINE - 2.0, styles[importance(d)]);
  write_text(p->out, text);
  fputs("</text>\n", p->out);
}

static void write_dots(panel *p) {
  for (size_t i = 0; i < p->count; i++)
    write_dot(p, &p->dots[i]);
  /* those that matter have the first choice of places */
  for (int level = 2; level >= 0; level--)
    for (size_t i = 0; i < p->count; i++)
      if (importance(&p->dots[i]) == level)
        write_label(p, &p->dots[i]);
}

static void write_panel(const bench_report *report, FILE *out, int ao,
                        dot *dots, box *taken) {
  panel p = {.out = out,
             .title = ao ? "AO: sampling error (RMSE)"
                         : "E_near: sampling error (RMSE / mean)",
             .dots = dots,
             .taken = taken,
             .taken_most = LINES};
  p.count = collect(report, ao, dots);
  qsort(dots, p.count, sizeof *dots, by_time);
  fit(dots, p.count, &p.x, &p.y);
  p.x.from = LEFT;
  p.x.to = RIGHT;
  p.y.from = BOTTOM;
  p.y.to = TOP;
  fprintf(out, "<g transform=\"translate(0,%d)\">\n", HEAD + ao * PANEL);
  if (p.count > 0) {
    write_axes(&p);
    write_front(&p, PAPER);
    write_front(&p, TOOL);
    write_front(&p, ADAPTIVE);
    write_dots(&p);
  }
  fputs("</g>\n", out);
}

/* --- the whole --- */

static void write_line(FILE *out, int y, const char *style, const char *text) {
  fprintf(out, "<text x=\"%d\" y=\"%d\" class=\"%s\">", LEFT, y, style);
  write_text(out, text);
  fputs("</text>\n", out);
}

static void write_legend(FILE *out) {
  int x = LEFT + 4;
  for (int k = 0; k < KINDS; k++) {
    fprintf(out,
            "<circle cx=\"%d\" cy=\"76\" r=\"4\" fill=\"%s\"/>"
            "<text x=\"%d\" y=\"80\">",
            x, kinds[k].color, x + 9);
    write_text(out, kinds[k].name);
    fputs("</text>\n", out);
    x += 30 + CHARACTER * (int)strlen(kinds[k].name);
  }
  fprintf(out,
          "<circle cx=\"%d\" cy=\"76\" r=\"4\"/><circle cx=\"%d\" cy=\"76\" "
          "r=\"7\" class=\"preset\" stroke=\"#000\"/>"
          "<text x=\"%d\" y=\"80\">a preset</text>\n",
          x, x, x + 12);
}

static void write_head(const bench_report *report, FILE *out) {
  const bench_machine *m = &report->machine;
  char text[1200], reference[64];
  fprintf(out,
          "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" "
          "height=\"%d\" font-family=\"sans-serif\" font-size=\"11\">\n"
          "<style>.grid{stroke:#ddd}.axes{fill:none;stroke:#444}"
          ".title{font-size:14px;font-weight:bold}.label{font-size:10px}"
          ".dim{fill:#888}.name{font-weight:bold}"
          ".front{fill:none;stroke-width:1.5}"
          ".preset{fill:none}.leader{stroke:#bbb}</style>\n"
          "<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n",
          WIDTH, HEAD + 2 * PANEL);
  snprintf(text, sizeof text, "hbil %s: error against time, %s, %u x %u",
           hbil_version(), report->content->name, report->content->width,
           report->content->height);
  write_line(out, 22, "title", text);
  snprintf(text, sizeof text, "%s, %u compute units, %s, %s", m->device,
           (unsigned)m->units, m->version, m->driver);
  write_line(out, 40, "", text);
  bench_reference(report, reference, sizeof reference);
  snprintf(text, sizeof text,
           "medians of %u runs; errors after recompose against each model's "
           "%s; slices x samples a side, g: growth of steps; lines: Pareto "
           "fronts",
           report->runs, reference);
  write_line(out, 56, "", text);
  write_legend(out);
}

/* Without memory the file ends early, which the caller notices. */
void bench_write_svg(const bench_report *report, FILE *out) {
  const size_t most = report->count + 1;
  dot *dots = calloc(most, sizeof *dots);
  box *taken = calloc(LINES + 2 * most, sizeof *taken);
  if (dots && taken) {
    write_head(report, out);
    for (int ao = 0; ao < 2; ao++)
      write_panel(report, out, ao, dots, taken);
    fputs("</svg>\n", out);
  }
  free(dots);
  free(taken);
}
