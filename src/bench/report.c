/* Tables and notes as Markdown and as JSON. */
#define _POSIX_C_SOURCE 200809L
#include "bench/report.h"

#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "bench/files.h"

typedef struct table {
  const char *title;
  const bench_column *columns;
  size_t count;
  json_t *rows; /* array of objects, borrowed from the document */
} table;

struct bench_report {
  const char *command;
  json_t *document;
  table tables[BENCH_TABLES];
  size_t table_count;
  json_t *row; /* the last one, borrowed */
  size_t cell; /* the next one */
  int failed;  /* out of memory */
};

/* --- the machine --- */

/* The model name of the first CPU, as Linux tells it; else "". */
static void cpu_model(char *out, size_t size) {
  char line[512];
  FILE *in = fopen("/proc/cpuinfo", "r");
  *out = '\0';
  while (in && !*out && fgets(line, sizeof line, in)) {
    const char *colon = strchr(line, ':');
    line[strcspn(line, "\n")] = '\0';
    if (colon && strncmp(line, "model name", 10) == 0)
      snprintf(out, size, "%s", colon + 2);
  }
  if (in)
    fclose(in);
}

static json_t *describe(const bench_command *command, const bench_device *d) {
  const time_t now = time(NULL);
  char cpu[256], date[32] = "";
  struct tm utc;
  cpu_model(cpu, sizeof cpu);
  if (gmtime_r(&now, &utc))
    strftime(date, sizeof date, "%Y-%m-%d", &utc);
  return json_pack(
      "{s:s, s:s, s:s, s:{s:s, s:i, s:s, s:i, s:s, s:s, s:s}, s:[], s:{}}",
      "command", command->name, "hbil", hbil_version(), "date", date, "machine",
      "cpu", cpu, "cores", (int)sysconf(_SC_NPROCESSORS_ONLN), "device",
      d->name, "compute_units", (int)d->units, "platform", d->platform,
      "version", d->version, "driver", d->driver, "notes", "tables");
}

/* --- filling --- */

bench_report *bench_report_new(const bench_command *command,
                               const bench_device *device) {
  bench_report *r = calloc(1, sizeof *r);
  if (!r)
    return NULL;
  r->command = command->name;
  r->document = describe(command, device);
  if (r->document)
    return r;
  free(r);
  return NULL;
}

void bench_report_free(bench_report *r) {
  if (!r)
    return;
  json_decref(r->document);
  free(r);
}

static void set(bench_report *r, json_t *object, const char *key,
                json_t *value) {
  if (json_object_set_new(object, key, value) != 0)
    r->failed = 1;
}

void bench_report_subject(bench_report *r, const char *content, uint32_t width,
                          uint32_t height, unsigned runs) {
  set(r, r->document, "content", json_string(content));
  set(r, r->document, "width", json_integer(width));
  set(r, r->document, "height", json_integer(height));
  if (runs) {
    set(r, r->document, "warm_up_runs", json_integer(BENCH_WARM_UP));
    set(r, r->document, "runs", json_integer(runs));
  }
}

void bench_report_table(bench_report *r, const char *key, const char *title,
                        const bench_column *columns, size_t count) {
  if (r->table_count == BENCH_TABLES) {
    r->failed = 1;
    return;
  }
  json_t *rows = json_array();
  set(r, json_object_get(r->document, "tables"), key, rows);
  r->tables[r->table_count++] = (table){title, columns, count, rows};
}

void bench_report_row(bench_report *r) {
  r->row = json_object();
  r->cell = 0;
  if (json_array_append_new(r->tables[r->table_count - 1].rows, r->row) != 0)
    r->failed = 1;
}

static void add_cell(bench_report *r, json_t *value) {
  const table *t = &r->tables[r->table_count - 1];
  if (!r->failed && r->cell < t->count)
    set(r, r->row, t->columns[r->cell++].key, value);
  else {
    r->failed = 1;
    json_decref(value);
  }
}

void bench_report_text(bench_report *r, const char *text) {
  add_cell(r, json_string(text));
}

void bench_report_number(bench_report *r, double value) {
  add_cell(r, isfinite(value) ? json_real(value) : json_null());
}

void bench_report_spread(bench_report *r, bench_spread s) {
  bench_report_number(r, s.median);
  bench_report_number(r, s.low);
  bench_report_number(r, s.high);
}

void bench_report_note(bench_report *r, const char *format, ...) {
  char text[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (json_array_append_new(json_object_get(r->document, "notes"),
                            json_string(text)) != 0)
    r->failed = 1;
}

/* --- Markdown --- */

static void print_cell(const bench_column *column, const json_t *value,
                       FILE *out) {
  if (json_is_string(value))
    fprintf(out, " %s |", json_string_value(value));
  else if (json_is_real(value))
    fprintf(out, " %.*f |", column->digits, json_real_value(value));
  else
    fputs(" |", out);
}

/* Whether Markdown shows a column: not where all of its cells are empty. */
static int is_shown(const table *t, size_t column) {
  const bench_column *c = &t->columns[column];
  for (size_t i = 0; c->title && i < json_array_size(t->rows); i++) {
    const json_t *cell = json_object_get(json_array_get(t->rows, i), c->key);
    if (json_is_real(cell) ||
        (json_is_string(cell) && json_string_length(cell) > 0))
      return 1;
  }
  return 0;
}

static void print_table(const table *t, FILE *out) {
  fprintf(out, "**%s**\n\n|", t->title);
  for (size_t c = 0; c < t->count; c++)
    if (is_shown(t, c))
      fprintf(out, " %s |", t->columns[c].title);
  fputs("\n|", out);
  for (size_t c = 0; c < t->count; c++)
    if (is_shown(t, c))
      fputs(t->columns[c].digits == BENCH_TEXT ? "---|" : "--:|", out);
  fputc('\n', out);
  for (size_t i = 0; i < json_array_size(t->rows); i++) {
    const json_t *row = json_array_get(t->rows, i);
    fputc('|', out);
    for (size_t c = 0; c < t->count; c++)
      if (is_shown(t, c))
        print_cell(&t->columns[c], json_object_get(row, t->columns[c].key),
                   out);
    fputc('\n', out);
  }
  fputc('\n', out);
}

static const char *text_of(const json_t *object, const char *key) {
  const char *text = json_string_value(json_object_get(object, key));
  return text ? text : "";
}

static int number_of(const json_t *object, const char *key) {
  return (int)json_integer_value(json_object_get(object, key));
}

static void print_subject(const json_t *document, FILE *out) {
  if (json_object_get(document, "runs"))
    fprintf(out,
            "Times are device times: medians of %d runs after %d runs of "
            "warm-up.\n",
            number_of(document, "runs"), (int)BENCH_WARM_UP);
  fprintf(out, "\nMeasured on %s with hbil %s", text_of(document, "date"),
          text_of(document, "hbil"));
  if (json_object_get(document, "content"))
    fprintf(out, ": %s, %d x %d pixels", text_of(document, "content"),
            number_of(document, "width"), number_of(document, "height"));
  fputc(',', out);
}

static void print_markdown(const void *context, FILE *out) {
  const bench_report *r = context;
  const json_t *machine = json_object_get(r->document, "machine");
  const json_t *notes = json_object_get(r->document, "notes");
  for (size_t i = 0; i < r->table_count; i++)
    print_table(&r->tables[i], out);
  for (size_t i = 0; i < json_array_size(notes); i++)
    fprintf(out, "%s\n", json_string_value(json_array_get(notes, i)));
  print_subject(r->document, out);
  fprintf(out,
          " on %s (%s, %s, driver %s; %d compute units) in a machine "
          "with %d cores (%s).\n",
          text_of(machine, "device"), text_of(machine, "platform"),
          text_of(machine, "version"), text_of(machine, "driver"),
          number_of(machine, "compute_units"), number_of(machine, "cores"),
          text_of(machine, "cpu"));
}

static void print_json(const void *context, FILE *out) {
  const bench_report *r = context;
  json_dumpf(r->document, out, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
  fputc('\n', out);
}

/* --- writing --- */

int bench_report_check(const bench_options *options, image_error *error) {
  if (bench_folder_make(options->output, error) != 0)
    return -1;
  return options->markdown
             ? bench_section_check(options->markdown, options->name, error)
             : 0;
}

static int write_result(const bench_report *r, const bench_options *options,
                        const char *suffix, file_writer *write,
                        image_error *error) {
  char *path = bench_result_path(options->output, options->name, suffix);
  if (!path)
    return image_no_memory(error, options->output);
  const int failed = temporary_write(path, EXISTING_REPLACED, write, r, error);
  free(path);
  return failed;
}

int bench_report_write(const bench_report *r, const bench_options *options,
                       image_error *error) {
  if (r->failed)
    return image_no_memory(error, r->command);
  (options->json ? print_json : print_markdown)(r, stdout);
  if (write_result(r, options, "md", print_markdown, error) != 0 ||
      write_result(r, options, "json", print_json, error) != 0)
    return -1;
  return options->markdown
             ? bench_section_replace(options->markdown, options->name,
                                     print_markdown, r, error)
             : 0;
}
