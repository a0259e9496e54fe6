/*
 * The program hbil-bench: its sub-commands, their options, and its messages.
 *
 * Functions that can fail return 0, or -1 with one sentence in `error`.
 */
#ifndef HBIL_BENCH_COMMAND_H
#define HBIL_BENCH_COMMAND_H

#include <stddef.h>
#include <stdint.h>

#include "image/error.h"

struct bench_device;
struct bench_report;

enum { BENCH_MAX_RUNS = 1000, BENCH_MAX_KERNELS = 2 };

/* Options that only some commands take; a command's `accepts` is a sum. */
enum {
  BENCH_TAKES_FRAMES = 1,   /* --dump, --camera, FRAME.exr... */
  BENCH_TAKES_ERRORS = 2,   /* --pixels */
  BENCH_TAKES_KERNELS = 4,  /* --kernels */
  BENCH_TAKES_REPORT = 8,   /* --output, --name, --markdown, --json */
  BENCH_TAKES_ROOM = 16,    /* --size; with a report --quick, too */
  BENCH_TAKES_FOLDERS = 32, /* FOLDER..., -- OPTIONS */
  BENCH_TAKES_TIMES = 64,   /* --runs */
  BENCH_TAKES_WINDOW = 128  /* --window */
};

typedef struct bench_options {
  const char *program;    /* argv[0], which starts this program again */
  uint32_t width, height; /* of the room in pixels; 0: the default */
  const char **frames;    /* dumps, or folders, to measure on; owned */
  unsigned frame_count;   /* 0: the procedural room */
  char **process;         /* the words behind -- */
  int process_count;
  const char *camera;   /* JSON of every dump's camera; NULL: beside each */
  const char *device;   /* see bench_device_open() */
  const char *output;   /* folder of the results */
  const char *name;     /* of the result files and of the Markdown section */
  const char *markdown; /* file with a section to replace, or NULL */
  const char *kernels[BENCH_MAX_KERNELS]; /* folders; NULL: embedded kernels */
  unsigned kernel_count;
  unsigned runs;      /* counted runs of every setting */
  unsigned pixels;    /* most pixels to measure errors at; 0: the default */
  uint32_t window[4]; /* x, y, width, height of where errors are measured; width
                       * 0: at pixels all over the picture */
  int quick;          /* a short list and a small room */
  int json;           /* prints JSON in place of Markdown */
} bench_options;

typedef struct bench_command {
  const char *name, *about; /* one word; one line for the list of commands */
  const char *details;      /* the help's paragraph, with line ends */
  unsigned accepts, runs;   /* runs: default of --runs; 0: times nothing */
  /* report: NULL where BENCH_TAKES_REPORT is missing. */
  int (*run)(const bench_options *options, const struct bench_device *device,
             struct bench_report *report, image_error *error);
} bench_command;

extern const bench_command bench_error, bench_skips, bench_scaling,
    bench_temporal, bench_passes, bench_pilot, bench_truth, bench_cache,
    bench_thickness, bench_flicker;

/* Reads argv[1...], where argv[0] is the command's name.  Returns 1 when help
 * was asked for and printed.  The caller frees out->frames in every case. */
int bench_options_parse(const bench_command *command, int argc, char **argv,
                        bench_options *out, image_error *error);

/* Milliseconds since an arbitrary moment. */
double bench_clock(void);

#endif
