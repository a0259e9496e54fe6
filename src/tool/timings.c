/* Prints how long a job took, and what was skipped. */
#include "tool/timings.h"

#include "tool/report.h"
#include "tool/unknown.h"

#include <jansson.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* The library's statistics of a frame                                       */

static double percent(size_t part, size_t whole) {
  return whole ? 100.0 * (double)part / (double)whole : 0.0;
}

/* What a frame left out, without an end of line. */
static void statistics_print(const hbil_statistics *s, FILE *out) {
  const struct {
    const char *name;
    const hbil_count *share;
  } shares[] = {{"sky", &s->sky},
                {"open", &s->open},
                {"dark", &s->dark},
                {"unused", &s->unused}};
  const char *between = "";
  for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
    if (!shares[i].share->pixels)
      continue;
    fprintf(out, "%s%s %.1f %% of pixels, %.1f %% of spans", between,
            shares[i].name, percent(shares[i].share->pixels, s->all.pixels),
            percent(shares[i].share->spans, s->all.spans));
    between = "; ";
  }
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    if (s->not_run[p]) {
      fprintf(out, "%sno %s", between, hbil_pass_name((hbil_pass)p));
      between = "; ";
    }
}

static json_t *count_json(const hbil_count *s) {
  return json_pack("{s:I, s:I}", "pixels", (json_int_t)s->pixels, "spans",
                   (json_int_t)s->spans);
}

/* The same as an object: "all", "sky", "open", "dark" and "unused",
 * each with "pixels" and "spans", and the list "not_run" of passes. */
static json_t *statistics_json(const hbil_statistics *s) {
  json_t *passes = json_array();
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    if (s->not_run[p])
      json_array_append_new(passes, json_string(hbil_pass_name((hbil_pass)p)));
  return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "all", count_json(&s->all),
                   "sky", count_json(&s->sky), "open", count_json(&s->open),
                   "dark", count_json(&s->dark), "unused",
                   count_json(&s->unused), "not_run", passes);
}

enum { FACING_AWAY = 7, SANITIZED_INPUTS };

typedef struct sanitized_input {
  const char *name;
  size_t pixels;
} sanitized_input;

static void list_sanitized(const hbil_sanitized *s,
                           sanitized_input out[SANITIZED_INPUTS]) {
  const sanitized_input inputs[SANITIZED_INPUTS] = {
      {"depth", s->depth},   {"normal", s->normal},
      {"albedo", s->albedo}, {"f0", s->f0},
      {"direct", s->direct}, {"emission", s->emission},
      {"motion", s->motion}, {"facing_away", s->facing_away}};
  memcpy(out, inputs, sizeof inputs);
}

/* "depth 3, motion 1": inputs with pixels that were sanitized, without an end
 * of line.  Prints `before` first if there are any; returns whether there are.
 */
static int sanitized_print(const hbil_sanitized *s, const char *before,
                           FILE *out) {
  sanitized_input inputs[SANITIZED_INPUTS];
  int some = 0;
  list_sanitized(s, inputs);
  for (int i = 0; i < SANITIZED_INPUTS; i++) {
    if (!inputs[i].pixels)
      continue;
    fprintf(out, "%s%s %zu", some ? ", " : before, inputs[i].name,
            inputs[i].pixels);
    some = 1;
  }
  return some;
}

/* Normals that face away are for the check of the frame, which knows why. */
void timings_warn_sanitized(const timing_row *rows, size_t count) {
  sanitized_input inputs[SANITIZED_INPUTS];
  size_t sums[SANITIZED_INPUTS] = {0};
  const char *first = NULL, *before = "";
  for (size_t i = 0; i < count; i++) {
    list_sanitized(&rows[i].sanitized, inputs);
    for (int k = 0; k < FACING_AWAY; k++) {
      sums[k] += inputs[k].pixels;
      first = !first && sums[k] ? rows[i].frame : first;
    }
  }
  if (!first)
    return;
  fputs("hbil: warning: pixels whose values mean nothing (NaN, infinite, "
        "negative, albedo above 1, normals of length 0) were replaced: ",
        stderr);
  for (int k = 0; k < FACING_AWAY; k++)
    if (sums[k]) {
      fprintf(stderr, "%s%s %zu", before, inputs[k].name, sums[k]);
      before = ", ";
    }
  fputs("; the first ones in ", stderr);
  report_text(first, stderr);
  fputs(" (hbil info)\n", stderr);
}

/* The number of sanitized pixels of each input, as an object. */
static json_t *sanitized_json(const hbil_sanitized *s) {
  sanitized_input inputs[SANITIZED_INPUTS];
  json_t *object = json_object();
  list_sanitized(s, inputs);
  for (int i = 0; i < SANITIZED_INPUTS; i++)
    json_object_set_new(object, inputs[i].name,
                        json_integer((json_int_t)inputs[i].pixels));
  return object;
}

/* ------------------------------------------------------------------------ */
/* Times                                                                     */

static double total(const timing_row *row) {
  double sum = 0.0;
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    sum += row->milliseconds[p];
  return sum;
}

static const char *const stage_names[PIPELINE_STAGES] = {"decode", "device",
                                                         "encode"};

/* Milliseconds per frame: of each stage, and from start to end. */
typedef struct pace {
  double stages[PIPELINE_STAGES], wall;
  int slowest;
} pace;

static pace find_pace(const timing_report *report) {
  pace p = {.slowest = 0};
  const double scale = 1e3 / (double)(report->computed ? report->computed : 1);
  p.wall = scale * report->wall;
  for (int s = 0; s < PIPELINE_STAGES; s++) {
    for (size_t i = 0; i < report->count; i++)
      p.stages[s] += scale * report->stages[i][s];
    if (p.stages[s] > p.stages[p.slowest])
      p.slowest = s;
  }
  return p;
}

static double over_slowest(const pace *p) {
  const double slowest = p->stages[p->slowest];
  return slowest > 0.0 ? p->wall / slowest : 1.0;
}

void timings_summary(const timing_report *report, FILE *out) {
  const pace p = find_pace(report);
  fprintf(out, "%.1f ms a frame, %.3g frames/s; limited by %s (", p.wall,
          p.wall > 0.0 ? 1e3 / p.wall : 0.0, stage_names[p.slowest]);
  for (int s = 0; s < PIPELINE_STAGES; s++)
    fprintf(out, "%s %.1f, ", stage_names[s], p.stages[s]);
  fprintf(out, "wall %.2f x %s)", over_slowest(&p), stage_names[p.slowest]);
}

static void print_stages(const timing_report *report, int width) {
  printf("%-*s", width, "stage, ms");
  for (int s = 0; s < PIPELINE_STAGES; s++)
    printf(" %10s", stage_names[s]);
  putchar('\n');
  for (size_t i = 0; i < report->count; i++) {
    printf("%-*s", width, report->rows[i].frame);
    for (int s = 0; s < PIPELINE_STAGES; s++)
      printf(" %10.3f", 1e3 * report->stages[i][s]);
    putchar('\n');
  }
  timings_summary(report, stdout);
  putchar('\n');
}

/* ------------------------------------------------------------------------ */
/* The whole job                                                             */

/* The parts, what remains, and the sum of both. */
enum { OTHER = TIMING_PARTS, TOTAL, COLUMNS };
static const char *const column_names[COLUMNS] = {
    "open", "read", "choose", "build", "learn", "frames", "other", "total"};

static void find_columns(const timing_report *report, double out[COLUMNS]) {
  out[TOTAL] = out[OTHER] = 1e3 * report->total;
  for (int i = 0; i < TIMING_PARTS; i++) {
    out[i] = 1e3 * report->parts[i];
    out[OTHER] -= out[i];
  }
}

static void print_job(const timing_report *report, int width) {
  double columns[COLUMNS];
  find_columns(report, columns);
  printf("%-*s", width, "wall, ms");
  for (int i = 0; i < COLUMNS; i++)
    printf(" %10s", column_names[i]);
  printf("\n%-*s", width, "job");
  for (int i = 0; i < COLUMNS; i++)
    printf(" %10.3f", columns[i]);
  putchar('\n');
}

static json_t *job_json(const timing_report *report) {
  double columns[COLUMNS];
  json_t *object = json_object();
  find_columns(report, columns);
  for (int i = 0; i < COLUMNS; i++)
    json_object_set_new(object, column_names[i], json_real(columns[i]));
  return object;
}

/* ------------------------------------------------------------------------ */
/* A table                                                                   */

static void print_row(const timing_row *row, int width) {
  printf("%-*s", width, row->frame);
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    printf(" %10.3f", row->milliseconds[p]);
  printf(" %10.3f\n", total(row));
}

static timing_row mean(const timing_report *report) {
  timing_row row = {.frame = "mean"};
  for (size_t i = 0; i < report->count; i++)
    for (int p = 0; p < HBIL_PASS_COUNT; p++)
      row.milliseconds[p] +=
          report->rows[i].milliseconds[p] / (double)report->count;
  row.unknown = unknown_mean(report->rows, report->count, &row.surfaces);
  return row;
}

void timings_table(const timing_report *report) {
  int width = 9; /* characters of the first column */
  for (size_t i = 0; i < report->count; i++) {
    const int length = (int)strlen(report->rows[i].frame);
    width = length > width ? length : width;
  }
  printf("device %s, %u x %u pixels, %.1f MiB on the device\n", report->device,
         report->width, report->height, (double)report->memory / 1048576.0);
  printf("%-*s", width, "ms");
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    printf(" %10s", hbil_pass_name((hbil_pass)p));
  printf(" %10s\n", "total");
  for (size_t i = 0; i < report->count; i++)
    print_row(&report->rows[i], width);
  const timing_row average = mean(report);
  if (report->count > 1)
    print_row(&average, width);
  print_stages(report, width);
  print_job(report, width);
  if (report->learning >= 0.0)
    printf("radiance cache: %.1f ms before the first frame\n",
           report->learning);
  puts("skipped");
  for (size_t i = 0; i < report->count; i++) {
    printf("%-*s  ", width, report->rows[i].frame);
    statistics_print(&report->rows[i].statistics, stdout);
    putchar('\n');
  }
  for (size_t i = 0; i < report->count; i++) {
    char before[4096 + 32];
    snprintf(before, sizeof before, "%-*s  sanitized pixels: ", width,
             report->rows[i].frame);
    if (sanitized_print(&report->rows[i].sanitized, before, stdout))
      putchar('\n');
  }
}

/* ------------------------------------------------------------------------ */
/* JSON                                                                      */

static json_t *stages_json(const double seconds[PIPELINE_STAGES]) {
  json_t *object = json_object();
  for (int s = 0; s < PIPELINE_STAGES; s++)
    json_object_set_new(object, stage_names[s], json_real(1e3 * seconds[s]));
  return object;
}

static json_t *pipeline_json(const timing_report *report) {
  const pace p = find_pace(report);
  return json_pack("{s:f, s:f, s:f, s:f, s:s, s:f}", "decode", p.stages[0],
                   "device", p.stages[1], "encode", p.stages[2], "wall", p.wall,
                   "limit", stage_names[p.slowest], "wall_over_slowest",
                   over_slowest(&p));
}

static json_t *row_json(const timing_row *row) {
  json_t *passes = json_object();
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    json_object_set_new(passes, hbil_pass_name((hbil_pass)p),
                        json_real(row->milliseconds[p]));
  return json_pack("{s:s, s:o, s:f, s:o, s:o, s:o}", "frame", row->frame,
                   "milliseconds", passes, "total", total(row), "statistics",
                   statistics_json(&row->statistics), "sanitized",
                   sanitized_json(&row->sanitized), "unknown",
                   row->surfaces ? json_real(row->unknown) : json_null());
}

int timings_json(const timing_report *report, image_error *error) {
  json_t *frames = json_array();
  for (size_t i = 0; i < report->count; i++) {
    json_t *row = row_json(&report->rows[i]);
    json_object_set_new(row, "stages", stages_json(report->stages[i]));
    json_array_append_new(frames, row);
  }
  const timing_row average = mean(report);
  json_t *root = json_pack(
      "{s:s, s:i, s:i, s:i, s:I, s:o, s:o, s:o, s:o, s:o}", "device",
      report->device, "width", (int)report->width, "height",
      (int)report->height, "repeat", (int)report->repeat, "device_bytes",
      (json_int_t)report->memory, "frames", frames, "mean", row_json(&average),
      "pipeline", pipeline_json(report), "job", job_json(report),
      "radiance_cache_learning",
      report->learning >= 0.0 ? json_real(report->learning) : json_null());
  const int failed = !root || json_dumpf(root, stdout, JSON_INDENT(2)) != 0;
  json_decref(root);
  if (failed)
    return image_fail(error, "timings: cannot be written as JSON");
  puts("");
  return 0;
}
