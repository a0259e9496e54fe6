/* The order of the bench: content, device, exact integral, baseline, every
 * configuration, reports. */
#define _POSIX_C_SOURCE 200809L
#include "bench/bench.h"
#include "image/temporary.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* --- the folder --- */

static int make_folder(const char *path, int *created, image_error *error) {
  struct stat info;
  int reason = 0;
  *created = mkdir(path, 0777) == 0;
  if (!*created)
    reason = errno;
  if (reason == EEXIST && stat(path, &info) == 0 && S_ISDIR(info.st_mode))
    reason = access(path, W_OK | X_OK) == 0 ? 0 : errno;
  return reason == 0 ? 0
                     : image_fail(error,
                                  "%s: cannot be written to: %s; a folder that "
                                  "can be, or whose parent can, is needed",
                                  path, strerror(reason));
}

static int write_file(const char *path, const bench_report *report,
                      void (*write)(const bench_report *, FILE *),
                      image_error *error) {
  char *name = temporary_name(path, error);
  if (!name)
    return -1;
  FILE *out = fopen(name, "w");
  if (!out) {
    image_fail(error, "%s: cannot be written: %s", path, strerror(errno));
    temporary_discard(name);
    return -1;
  }
  write(report, out);
  const int failed = ferror(out), unclosed = fclose(out);
  if (failed || unclosed) {
    temporary_discard(name);
    return image_fail(error, "%s: cannot be written in full", path);
  }
  return temporary_commit(name, path, error);
}

typedef struct output {
  const char *name;
  void (*write)(const bench_report *, FILE *);
} output;

static int write_files(const char *folder, const output *files, size_t count,
                       const bench_report *report, image_error *error) {
  const size_t size = strlen(folder) + 64;
  char *path = malloc(size);
  int failed = 0;
  if (!path)
    return image_no_memory(error, folder);
  for (size_t i = 0; i < count && !failed; i++) {
    snprintf(path, size, "%s/%s", folder, files[i].name);
    failed = write_file(path, report, files[i].write, error);
  }
  free(path);
  return failed;
}

/* --- measuring --- */

static void describe(const device *d, bench_machine *out) {
  cl_platform_id platform = NULL;
  clGetDeviceInfo(d->id, CL_DEVICE_PLATFORM, sizeof platform, &platform, NULL);
  clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof out->platform - 1,
                    out->platform, NULL);
  clGetDeviceInfo(d->id, CL_DEVICE_VERSION, sizeof out->version - 1,
                  out->version, NULL);
  clGetDeviceInfo(d->id, CL_DRIVER_VERSION, sizeof out->driver - 1, out->driver,
                  NULL);
  clGetDeviceInfo(d->id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof out->units,
                  &out->units, NULL);
  memcpy(out->device, d->name, sizeof out->device);
}

/* Whether no other row of its model is at least as good in both and better in
 * one. */
static int on_front(const bench_row *rows, size_t count, size_t at, int ao) {
  const double time = rows[at].total.median;
  const double off = ao ? rows[at].ao_error : rows[at].light_error;
  if (isnan(off))
    return 0;
  for (size_t i = 0; i < count; i++) {
    if (rows[i].configuration.model != rows[at].configuration.model ||
        bench_is_adaptive(&rows[i].configuration) !=
            bench_is_adaptive(&rows[at].configuration))
      continue;
    const double t = rows[i].total.median;
    const double e = ao ? rows[i].ao_error : rows[i].light_error;
    if (t <= time && e <= off && (t < time || e < off))
      return 0;
  }
  return 1;
}

static void mark_fronts(bench_row *rows, size_t count) {
  for (size_t i = 0; i < count; i++) {
    rows[i].light_front = on_front(rows, count, i, 0);
    rows[i].ao_front = on_front(rows, count, i, 1);
  }
}

/* Slices of the exact integral: 64 are .001 of AO off 1024 ones. */
enum { EXACT_SLICES = 128, QUICK_SLICES = 64 };

/* All that a configuration is measured with. */
typedef struct bench_bench {
  const bench_options *options;
  const device *device;
  const bench_content *content;
  bench_configuration list[BENCH_MAX_CONFIGURATIONS];
  size_t count;
  bench_exact exact;
  bench_lab *lab;
  bench_row *rows;
  bench_report report;
} bench_bench;

static int measure_motion(bench_bench *b, image_error *error) {
  const bench_configuration standard = bench_default();
  return bench_lab_motion(b->lab, &standard, b->options->runs,
                          &b->report.motion, error);
}

/* Memory is twice as fast in one minute as in another: a copy is what the
 * passes are held against that were timed just before it. */
static int measure_copy(bench_bench *b, image_error *error) {
  return measure_motion(b, error) != 0 ||
                 bench_measure_copy(b->device, bench_pixels(b->content),
                                    b->options->runs, &b->report.copy,
                                    error) != 0
             ? -1
             : 0;
}

static int measure_row(bench_bench *b, size_t i, image_error *error) {
  const bench_configuration *c = &b->list[i];
  const unsigned runs = b->options->runs;
  if (bench_lab_errors(b->lab, &b->exact, c, &b->rows[i], error) != 0 ||
      bench_lab_times(b->lab, c, runs, &b->rows[i], error) != 0)
    return -1;
  if (bench_is_default(c) && measure_copy(b, error) != 0)
    return -1;
  if (bench_is_of_storage(c) &&
      bench_lab_loss(b->lab, c, &b->rows[i], error) != 0)
    return -1;
  return bench_is_thick(c->model)
             ? bench_lab_thickness(b->lab, c, runs, &b->rows[i], error)
             : 0;
}

static int measure_estimate(bench_bench *b, image_error *error) {
  b->report.estimate = NAN;
  for (size_t i = 0; i < b->count; i++)
    if (bench_is_tools_default(&b->list[i]))
      return bench_lab_estimate(b->lab, &b->list[i], b->options->runs,
                                &b->report.estimate, error);
  return 0;
}

static int measure_halves(bench_bench *b, image_error *error) {
  const bench_configuration first = bench_first();
  return bench_lab_halves(b->lab, &first, b->options->runs, b->report.halves,
                          error);
}

static int measure_rows(bench_bench *b, image_error *error) {
  for (size_t i = 0; i < b->count; i++) {
    char label[BENCH_LABEL];
    bench_label(&b->list[i], label, sizeof label);
    progress_count(label, i, b->count);
    if (measure_row(b, i, error) != 0)
      return -1;
  }
  progress_count("measured", b->count, b->count);
  mark_fronts(b->rows, b->count);
  return measure_estimate(b, error) != 0 || measure_halves(b, error) != 0 ? -1
                                                                          : 0;
}

static int measure(bench_bench *b, image_error *error) {
  const unsigned runs = b->options->runs;
  const int slices = b->options->quick ? QUICK_SLICES : EXACT_SLICES;
  bench_report *report = &b->report;
  report->content = b->content;
  report->runs = runs;
  report->rows = b->rows;
  report->count = b->count;
  report->exact_slices = slices;
  describe(b->device, &report->machine);
  if (bench_exact_make(b->content, slices, b->list, b->count, &b->exact,
                       error) != 0 ||
      bench_measure_literal(
          b->device, b->content, runs, b->exact.ao[BENCH_PAPER],
          b->exact.light[BENCH_PAPER], &report->literal, error) != 0)
    return -1;
  return measure_rows(b, error);
}

static int write_all(const bench_bench *b, image_error *error) {
  static const output files[] = {{"bench.csv", bench_write_csv},
                                 {"bench.json", bench_write_json},
                                 {"bench.svg", bench_write_svg}};
  const char *folder = b->options->output;
  int made = 0;
  bench_write_table(&b->report, stdout);
  if (write_files(folder, files, 3, &b->report, error) != 0 ||
      bench_write_png(folder, &made, error) != 0)
    return -1;
  printf("written: %s/bench.csv, .json, .svg%s\n", folder,
         made ? ", .png" : "");
  if (!made)
    puts("no bench.png: rsvg-convert, Debian's librsvg2-bin, is needed for it");
  return 0;
}

static int run_on(const bench_options *options, const device *d,
                  const bench_content *content, image_error *error) {
  bench_bench *b = calloc(1, sizeof *b);
  if (!b)
    return image_no_memory(error, "the bench");
  b->options = options;
  b->device = d;
  b->content = content;
  b->count = bench_configurations(options->quick, b->list);
  b->rows = calloc(b->count, sizeof *b->rows);
  int failed = b->rows ? bench_lab_open(d, content, &b->lab, error)
                       : image_no_memory(error, "the bench");
  failed = failed || measure(b, error) != 0 || write_all(b, error) != 0;
  bench_lab_close(b->lab);
  bench_exact_free(&b->exact);
  free(b->rows);
  free(b);
  return failed ? -1 : 0;
}

static int run_on_content(const bench_options *options, const device *d,
                          image_error *error) {
  bench_content content;
  if (bench_content_load(options, &content, error) != 0)
    return -1;
  const int failed = run_on(options, d, &content, error);
  bench_content_free(&content);
  return failed;
}

static int run_scaling(const bench_options *options, const device *d,
                       image_error *error) {
  static const output files[] = {{"scaling.csv", bench_write_scaling_csv},
                                 {"scaling.json", bench_write_scaling_json}};
  bench_scaling scaling;
  bench_report report = {.scaling = &scaling};
  describe(d, &report.machine);
  if (bench_scaling_measure(options, d, &scaling, error) != 0)
    return -1;
  bench_write_scaling_table(&report, stdout);
  if (write_files(options->output, files, 2, &report, error) != 0)
    return -1;
  printf("written: %s/scaling.csv, .json\n", options->output);
  return 0;
}

static int run_skips(const bench_options *options, const device *d,
                     image_error *error) {
  static const output files[] = {{"skips.json", bench_write_skips_json}};
  bench_content content;
  bench_skip skips[BENCH_SKIPS];
  bench_report report = {.skips = skips, .content = &content};
  report.runs = options->runs;
  describe(d, &report.machine);
  if (bench_content_load(options, &content, error) != 0)
    return -1;
  int failed = bench_skips_measure(options, d, &content, skips, error);
  if (!failed) {
    bench_write_skips_table(&report, stdout);
    failed = write_files(options->output, files, 1, &report, error);
  }
  if (!failed)
    printf("written: %s/skips.json\n", options->output);
  bench_content_free(&content);
  return failed ? -1 : 0;
}

/* Nothing but a table: what it compares with is on this machine alone. */
static int run_against(const bench_options *options, const device *d,
                       image_error *error) {
  bench_content content;
  bench_against against[BENCH_AGAINST];
  bench_report report = {
      .against = against, .content = &content, .runs = options->runs};
  describe(d, &report.machine);
  if (bench_content_load(options, &content, error) != 0)
    return -1;
  const int failed =
      bench_against_measure(options, d, &content, against, error);
  if (!failed)
    bench_write_against_table(&report, stdout);
  bench_content_free(&content);
  return failed ? -1 : 0;
}

static int run_temporal(const bench_options *options, const device *d,
                        image_error *error) {
  static const output files[] = {{"temporal.json", bench_write_temporal_json}};
  const int slices = options->quick ? QUICK_SLICES : EXACT_SLICES;
  bench_options last = *options;
  bench_content content;
  bench_temporal temporal[BENCH_TEMPORALS];
  bench_report report = {.temporal = temporal, .content = &content};
  describe(d, &report.machine);
  last.dump = options->frames[options->frame_count - 1];
  if (bench_content_load(&last, &content, error) != 0)
    return -1;
  int failed =
      bench_temporal_measure(options, d, &content, slices, temporal, error);
  if (!failed) {
    bench_write_temporal_table(&report, stdout);
    failed = write_files(options->output, files, 1, &report, error);
  }
  if (!failed)
    printf("written: %s/temporal.json\n", options->output);
  bench_content_free(&content);
  return failed ? -1 : 0;
}

static int run_adaptive(const bench_options *options, const device *d,
                        image_error *error) {
  static const output files[] = {{"adaptive.json", bench_write_promises_json}};
  const int slices = options->quick ? QUICK_SLICES : EXACT_SLICES;
  bench_promises *promises = malloc(sizeof *promises);
  bench_report report = {
      .promises = promises, .runs = options->runs, .exact_slices = slices};
  if (!promises)
    return image_no_memory(error, "the bench");
  describe(d, &report.machine);
  int failed = bench_promises_measure(options, d, slices, promises, error);
  if (!failed) {
    bench_write_promises_table(&report, stdout);
    failed = write_files(options->output, files, 1, &report, error);
  }
  if (!failed)
    printf("written: %s/adaptive.json\n", options->output);
  bench_promises_free(promises);
  free(promises);
  return failed;
}

/* The sizes of scaling are those of the room. */
static int measure_all(const bench_options *options, const device *d,
                       image_error *error) {
  if (options->temporal)
    return run_temporal(options, d, error);
  if (options->adaptive)
    return run_adaptive(options, d, error);
  if (options->against)
    return run_against(options, d, error);
  if (options->skips)
    return run_skips(options, d, error);
  if (!options->scaling && (run_on_content(options, d, error) != 0 ||
                            run_skips(options, d, error) != 0))
    return -1;
  return options->scaling || !(options->quick || options->dump)
             ? run_scaling(options, d, error)
             : 0;
}

int bench_run(const bench_options *options, image_error *error) {
  device d;
  int created = 0;
  if (device_open(options->device, 1, &d, error) != 0)
    return -1;
  int failed =
      options->against ? 0 : make_folder(options->output, &created, error);
  if (!failed)
    failed = measure_all(options, &d, error);
  if (failed && created)
    rmdir(options->output); /* succeeds only while nothing is in it */
  device_close(&d);
  return failed;
}
