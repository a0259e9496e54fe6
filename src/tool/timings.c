/* Milliseconds per frame, of passes and stages: as a table, as JSON. */
#include "tool/tool.h"

#include <jansson.h>

#include <stdio.h>
#include <string.h>

static double total(const timing_row *row) {
  double sum = 0.0;
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    sum += row->milliseconds[p];
  return sum;
}

/* --- what was left out --- */

static double percent(size_t part, size_t of) {
  return of ? 100.0 * (double)part / (double)of : 0.0;
}

void timings_print_skipped(const hbil_statistics *s, FILE *out) {
  const struct {
    const char *name;
    const hbil_count *share;
  } shares[] = {{"sky", &s->sky},
                {"open", &s->open},
                {"dark", &s->dark},
                {"unused", &s->unused},
                {"by form factors", &s->by_factors}};
  const char *between = "";
  for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
    if (!shares[i].share->pixels)
      continue;
    fprintf(out, "%s%s %.1f %% of pixels, %.1f %% of spans", between,
            shares[i].name, percent(shares[i].share->pixels, s->all.pixels),
            percent(shares[i].share->spans, s->all.spans));
    between = "; ";
  }
  if (s->adaptive) {
    fprintf(out, "%s%ux%u samples a side%s", between, (unsigned)s->slices,
            (unsigned)s->steps_per_side, s->kept_choice ? ", as before" : "");
    between = "; ";
  }
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    if (s->not_run[p]) {
      fprintf(out, "%sno %s", between, hbil_pass_name((hbil_pass)p));
      between = "; ";
    }
}

static json_t *share(const hbil_count *s) {
  return json_pack("{s:I, s:I}", "pixels", (json_int_t)s->pixels, "spans",
                   (json_int_t)s->spans);
}

json_t *timings_skipped_json(const hbil_statistics *s) {
  json_t *passes = json_array();
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    if (s->not_run[p])
      json_array_append_new(passes, json_string(hbil_pass_name((hbil_pass)p)));
  return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:i, s:b, s:o}", "all",
                   share(&s->all), "sky", share(&s->sky), "open",
                   share(&s->open), "dark", share(&s->dark), "unused",
                   share(&s->unused), "by_factors", share(&s->by_factors),
                   "slices", (int)s->slices, "samples", (int)s->steps_per_side,
                   "kept_choice", (int)s->kept_choice, "not_run", passes);
}

/* --- what was repaired --- */

enum { REPAIRED_INPUTS = 7 };

typedef struct repaired_input {
  const char *name;
  size_t pixels;
} repaired_input;

static void list_repaired(const hbil_sanitized *r,
                          repaired_input out[REPAIRED_INPUTS]) {
  const repaired_input inputs[REPAIRED_INPUTS] = {
      {"depth", r->depth},  {"normal", r->normal}, {"albedo", r->albedo},
      {"f0", r->f0},        {"direct", r->direct}, {"emission", r->emission},
      {"motion", r->motion}};
  memcpy(out, inputs, sizeof inputs);
}

/* A line, if there is anything to tell. */
static void print_repaired(const char *frame, int width,
                           const hbil_sanitized *r) {
  repaired_input inputs[REPAIRED_INPUTS];
  const char *before = "";
  list_repaired(r, inputs);
  for (int i = 0; i < REPAIRED_INPUTS; i++) {
    if (!inputs[i].pixels)
      continue;
    if (!*before)
      printf("%-*s  repaired pixels: ", width, frame);
    printf("%s%s %zu", before, inputs[i].name, inputs[i].pixels);
    before = ", ";
  }
  if (*before)
    putchar('\n');
}

static json_t *repaired_json(const hbil_sanitized *r) {
  repaired_input inputs[REPAIRED_INPUTS];
  json_t *object = json_object();
  list_repaired(r, inputs);
  for (int i = 0; i < REPAIRED_INPUTS; i++)
    json_object_set_new(object, inputs[i].name,
                        json_integer((json_int_t)inputs[i].pixels));
  return object;
}

/* --- the stages of the tool --- */

enum { STAGES = 3 };

static const char *const stage_names[STAGES] = {"decode", "device", "encode"};

/* Milliseconds a frame: of each stage, and of them all together. */
typedef struct pace {
  double stages[STAGES], wall;
  int slowest;
} pace;

static pace find_pace(const timing_report *report) {
  pace p = {.slowest = 0};
  const double scale = 1e3 / (double)(report->lit ? report->lit : 1);
  p.wall = scale * report->wall;
  for (int s = 0; s < STAGES; s++) {
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
  for (int s = 0; s < STAGES; s++)
    fprintf(out, "%s %.1f, ", stage_names[s], p.stages[s]);
  fprintf(out, "wall %.2f x %s)", over_slowest(&p), stage_names[p.slowest]);
}

static void print_stages(const timing_report *report, int width) {
  printf("%-*s", width, "stage, ms");
  for (int s = 0; s < STAGES; s++)
    printf(" %10s", stage_names[s]);
  putchar('\n');
  for (size_t i = 0; i < report->count; i++) {
    printf("%-*s", width, report->rows[i].frame);
    for (int s = 0; s < STAGES; s++)
      printf(" %10.3f", 1e3 * report->stages[i][s]);
    putchar('\n');
  }
  timings_summary(report, stdout);
  putchar('\n');
}

static json_t *stages_json(const double seconds[STAGES]) {
  json_t *object = json_object();
  for (int s = 0; s < STAGES; s++)
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

/* --- table --- */

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
  return row;
}

void timings_table(const timing_report *report) {
  int width = 9;
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
  puts("left out");
  for (size_t i = 0; i < report->count; i++) {
    printf("%-*s  ", width, report->rows[i].frame);
    timings_print_skipped(&report->rows[i].skipped, stdout);
    putchar('\n');
  }
  for (size_t i = 0; i < report->count; i++)
    print_repaired(report->rows[i].frame, width, &report->rows[i].repaired);
}

/* --- JSON --- */

static json_t *row_json(const timing_row *row) {
  json_t *passes = json_object();
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    json_object_set_new(passes, hbil_pass_name((hbil_pass)p),
                        json_real(row->milliseconds[p]));
  return json_pack("{s:s, s:o, s:f, s:o, s:o}", "frame", row->frame,
                   "milliseconds", passes, "total", total(row), "skipped",
                   timings_skipped_json(&row->skipped), "repaired",
                   repaired_json(&row->repaired));
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
      "{s:s, s:i, s:i, s:i, s:I, s:o, s:o, s:o}", "device", report->device,
      "width", (int)report->width, "height", (int)report->height, "repeat",
      (int)report->repeat, "device_bytes", (json_int_t)report->memory, "frames",
      frames, "mean", row_json(&average), "pipeline", pipeline_json(report));
  const int failed = !root || json_dumpf(root, stdout, JSON_INDENT(2)) != 0;
  json_decref(root);
  if (failed)
    return image_fail(error, "timings: cannot be written as JSON");
  puts("");
  return 0;
}
