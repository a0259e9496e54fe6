/* hbil-bench: measures time and error of the library on this machine. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/command.h"
#include "bench/opencl.h"
#include "bench/report.h"
#include "hbil/hbil.h"

static const bench_command *const commands[] = {
    &bench_error,     &bench_skips,  &bench_scaling, &bench_temporal,
    &bench_passes,    &bench_pilot,  &bench_truth,   &bench_cache,
    &bench_thickness, &bench_flicker};

enum {
  COMMANDS = sizeof commands / sizeof *commands,
  STATUS_OK = 0,
  STATUS_FAILED = 2
};

static int fail(const image_error *error) {
  fprintf(stderr, "hbil-bench: %s\n", error->text);
  return STATUS_FAILED;
}

static void usage(void) {
  puts("usage: hbil-bench COMMAND [options]\n"
       "\n"
       "Measures time and error of the hbil library on this machine.  Each\n"
       "command answers one question:\n");
  for (int i = 0; i < COMMANDS; i++)
    printf("  %-9s %s\n", commands[i]->name, commands[i]->about);
  puts("\n"
       "  --help     this text; after a command, the options of that command\n"
       "  --version  the version\n"
       "\n"
       "Exit status: 0 measured, 2 bad input or a failure.");
}

static int run_on(const bench_command *command, const bench_options *options,
                  const bench_device *device, image_error *error) {
  if (!(command->accepts & BENCH_TAKES_REPORT))
    return command->run(options, device, NULL, error);
  bench_report *report = bench_report_new(command, device);
  if (!report)
    return image_no_memory(error, command->name);
  int failed = bench_report_check(options, error);
  if (!failed)
    failed = command->run(options, device, report, error);
  if (!failed)
    failed = bench_report_write(report, options, error);
  bench_report_free(report);
  return failed;
}

static int run_command(const bench_command *command, int argc, char **argv) {
  bench_options options = {.program = argv[0]};
  bench_device device;
  image_error error;
  int status = STATUS_OK;
  const int parsed =
      bench_options_parse(command, argc - 1, argv + 1, &options, &error);
  if (parsed < 0 ||
      (parsed == 0 && bench_device_open(options.device, &device, &error) != 0))
    status = fail(&error);
  else if (parsed == 0) {
    if (run_on(command, &options, &device, &error) != 0)
      status = fail(&error);
    bench_device_close(&device);
  }
  free(options.frames);
  return status;
}

int main(int argc, char **argv) {
  image_error error;
  if (argc < 2) {
    image_fail(&error, "no command; hbil-bench --help lists them");
    return fail(&error);
  }
  if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
    usage();
    return STATUS_OK;
  }
  if (strcmp(argv[1], "--version") == 0) {
    printf("hbil-bench %s\n", hbil_version());
    return STATUS_OK;
  }
  for (int i = 0; i < COMMANDS; i++)
    if (strcmp(argv[1], commands[i]->name) == 0)
      return run_command(commands[i], argc, argv);
  image_fail(&error, "%s: no such command; hbil-bench --help lists them",
             argv[1]);
  return fail(&error);
}
