/* The order of the bench: content, device, reference, baseline, every
 * configuration, reports. */
#define _POSIX_C_SOURCE 200809L
#include "bench/bench.h"
#include "image/temporary.h"

#include <errno.h>
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

static int write_files(const char *folder, const bench_report *report,
                       image_error *error) {
  static const struct {
    const char *name;
    void (*write)(const bench_report *, FILE *);
  } files[] = {{"bench.csv", bench_write_csv},
               {"bench.json", bench_write_json},
               {"bench.svg", bench_write_svg}};
  const size_t size = strlen(folder) + sizeof "/bench.json";
  char *path = malloc(size);
  int failed = 0;
  if (!path)
    return image_no_memory(error, folder);
  for (size_t i = 0; i < sizeof files / sizeof *files && !failed; i++) {
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

/* Whether no other row is at least as good in both and better in one. */
static int on_front(const bench_row *rows, size_t count, size_t at, int ao) {
  const double time = rows[at].total.median;
  const double off = ao ? rows[at].ao_error : rows[at].light_error;
  for (size_t i = 0; i < count; i++) {
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

static int measure_rows(bench_lab *lab, const bench_configuration *list,
                        size_t count, unsigned runs, bench_row *rows,
                        image_error *error) {
  for (size_t i = 0; i < count; i++) {
    char label[64];
    bench_label(&list[i], label, sizeof label);
    progress_count(label, i, count);
    if (bench_lab_measure(lab, &list[i], runs, &rows[i], error) != 0)
      return -1;
  }
  progress_count("measured", count, count);
  mark_fronts(rows, count);
  return 0;
}

static int measure(const bench_options *options, const device *d,
                   bench_lab *lab, const bench_content *content,
                   bench_row *rows, bench_report *report, image_error *error) {
  const bench_configuration *list;
  const bench_configuration dense = bench_reference();
  report->content = content;
  report->runs = options->runs;
  report->rows = rows;
  report->count = bench_configurations(options->quick, &list);
  bench_label(&dense, report->reference, sizeof report->reference);
  describe(d, &report->machine);
  progress_count("reference", 0, 1);
  if (bench_lab_refer(lab, &dense, error) != 0)
    return -1;
  progress_count("baseline", 0, 1);
  if (bench_measure_literal(d, content, options->runs, bench_lab_ao(lab),
                            bench_lab_light(lab), &report->literal,
                            error) != 0 ||
      bench_measure_copy(d, bench_pixels(content), options->runs, &report->copy,
                         error) != 0)
    return -1;
  return measure_rows(lab, list, report->count, options->runs, rows, error);
}

static int run_on(const bench_options *options, const device *d,
                  const bench_content *content, image_error *error) {
  const bench_configuration *list;
  bench_report report = {0};
  bench_lab *lab = NULL;
  bench_row *rows =
      calloc(bench_configurations(options->quick, &list), sizeof *rows);
  int failed = rows ? bench_lab_open(d, content, &lab, error)
                    : image_no_memory(error, "the bench");
  if (!failed)
    failed = measure(options, d, lab, content, rows, &report, error);
  if (!failed) {
    bench_write_table(&report, stdout);
    failed = write_files(options->output, &report, error);
  }
  if (!failed)
    printf("written: %s/bench.csv, .json, .svg\n", options->output);
  bench_lab_close(lab);
  free(rows);
  return failed;
}

int bench_run(const bench_options *options, image_error *error) {
  device d;
  bench_content content;
  int created = 0;
  if (device_open(options->device, 1, &d, error) != 0)
    return -1;
  int failed = make_folder(options->output, &created, error);
  if (!failed)
    failed = bench_content_load(options, &content, error);
  if (!failed) {
    failed = run_on(options, &d, &content, error);
    bench_content_free(&content);
  }
  if (failed && created)
    rmdir(options->output); /* succeeds only while nothing is in it */
  device_close(&d);
  return failed;
}
