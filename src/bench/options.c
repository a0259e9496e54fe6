/* The command line of a sub-command, described by one table. */
#define _POSIX_C_SOURCE 200809L
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bench/command.h"
#include "hbil/hbil.h"
#include "image/clock.h"

typedef struct description {
  const char *name, *value; /* value: NULL for a flag */
  int letter;               /* what getopt_long() returns */
  unsigned of;              /* commands take it that take all of these */
  const char *help;         /* %u: the default of --runs */
} description;

static const description table[] = {
    {"output", "DIR", 'o', BENCH_TAKES_REPORT,
     "folder of the result files (bench-results)"},
    {"name", "NAME", 'n', BENCH_TAKES_REPORT,
     "name of the files and of the section (the command's)"},
    {"markdown", "FILE", 'm', BENCH_TAKES_REPORT,
     "also replaces what stands in FILE between the lines\n"
     "                      <!-- hbil-bench NAME --> and <!-- end -->"},
    {"json", NULL, 'j', BENCH_TAKES_REPORT, "prints JSON in place of Markdown"},
    {"quick", NULL, 'q', BENCH_TAKES_REPORT | BENCH_TAKES_ROOM,
     "a short list, and a room of 320x180 pixels"},
    {"size", "WxH", 's', BENCH_TAKES_ROOM,
     "pixels of the procedural room (1280x720)"},
    {"dump", "FRAME.exr", 'd', BENCH_TAKES_FRAMES,
     "measures on this captured frame instead of the room"},
    {"camera", "FILE", 'c', BENCH_TAKES_FRAMES,
     "JSON camera of the frames (FRAME.json beside each)"},
    {"truth", "FILE.exr", 't', BENCH_TAKES_TRUTH,
     "path-traced DiffInd.{R,G,B} of the dump; adds the\n"
     "                      error of the model itself"},
    {"pixels", "N", 'p', BENCH_TAKES_ERRORS,
     "most pixels to measure errors at (8000; 1000 with\n"
     "                      --quick); at most one of each 4x4 block is used"},
    {"kernels", "DIR", 'k', BENCH_TAKES_KERNELS,
     "times the kernel files of this folder in turns with\n"
     "                      the embedded ones; given twice: with each other"},
    {"no-times", NULL, 'T', BENCH_TAKES_SCENES,
     "errors alone, for a machine that is busy; no plot"},
    {"device", "NAME", 'D', 0,
     "index or part of a name, as in hbil devices (the\n"
     "                      first GPU, else the first device)"},
    {"runs", "N", 'r', BENCH_TAKES_TIMES,
     "counted runs of each setting, 1..1000"},
    {"runs", "N", 'r', BENCH_TAKES_FOLDERS,
     "also shows whether light grows: the mean of the last\n"
     "                      frame's indirect light after 1, 2, 4, 10, 50, 200\n"
     "                      runs of it alone, up to N of them (1..1000)"},
};

enum { COUNT = sizeof table / sizeof *table };

static int is_taken(const bench_command *command, const description *d) {
  return (command->accepts & d->of) == d->of;
}

static void print_help(const bench_command *command) {
  printf("usage: hbil-bench %s [options]%s\n\n%s\n", command->name,
         command->accepts & BENCH_TAKES_FRAMES    ? " [FRAME.exr...]"
         : command->accepts & BENCH_TAKES_FOLDERS ? " FOLDER... [-- OPTIONS]"
         : command->accepts & BENCH_TAKES_SCENES  ? " FOLDER..."
                                                  : "",
         command->details);
  for (int i = 0; i < COUNT; i++) {
    char option[64];
    if (!is_taken(command, &table[i]))
      continue;
    snprintf(option, sizeof option, "%s--%s%s%s",
             table[i].letter == 'o' ? "-o, " : "", table[i].name,
             table[i].value ? " " : "", table[i].value ? table[i].value : "");
    printf("  %-19s %s", option, table[i].help);
    if (table[i].letter == 'r' && command->runs)
      printf(" (%u)", command->runs);
    putchar('\n');
  }
}

static int read_number(const char *option, const char *text, unsigned low,
                       unsigned high, unsigned *out, image_error *error) {
  char *end;
  const long long value = strtoll(text, &end, 10);
  if (end == text || *end || value < (long long)low || value > (long long)high)
    return image_fail(error, "%s %s: a whole number from %u to %u is needed",
                      option, text, low, high);
  *out = (unsigned)value;
  return 0;
}

static int read_size(const char *text, bench_options *out, image_error *error) {
  char end;
  unsigned width, height;
  if (sscanf(text, "%5ux%5u%c", &width, &height, &end) != 2 || width < 1 ||
      width > HBIL_MAX_SIZE || height < 1 || height > HBIL_MAX_SIZE)
    return image_fail(error,
                      "--size %s: WIDTHxHEIGHT is needed, each from 1 to %d",
                      text, HBIL_MAX_SIZE);
  out->width = width;
  out->height = height;
  return 0;
}

static int add_kernels(const char *folder, bench_options *out,
                       image_error *error) {
  struct stat info;
  if (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode))
    return image_fail(error, "--kernels %s: a folder of kernel files is needed",
                      folder);
  if (out->kernel_count == BENCH_MAX_KERNELS)
    return image_fail(error, "--kernels %s: at most %d folders are compared",
                      folder, BENCH_MAX_KERNELS);
  out->kernels[out->kernel_count++] = folder;
  return 0;
}

static int set_option(int letter, bench_options *out, image_error *error) {
  switch (letter) {
  case 's':
    return read_size(optarg, out, error);
  case 'r':
    return read_number("--runs", optarg, 1, BENCH_MAX_RUNS, &out->runs, error);
  case 'p':
    return read_number("--pixels", optarg, 16, 1u << 28, &out->pixels, error);
  case 'k':
    return add_kernels(optarg, out, error);
  case 'o':
    out->output = optarg;
    break;
  case 'n':
    out->name = optarg;
    break;
  case 'm':
    out->markdown = optarg;
    break;
  case 'd':
    out->frames[out->frame_count++] = optarg;
    break;
  case 'c':
    out->camera = optarg;
    break;
  case 't':
    out->truth = optarg;
    break;
  case 'D':
    out->device = optarg;
    break;
  case 'j':
    out->json = 1;
    break;
  case 'T':
    out->no_times = 1;
    break;
  default:
    out->quick = 1;
  }
  return 0;
}

static int check(const bench_command *command, const bench_options *o,
                 image_error *error) {
  const unsigned folders = BENCH_TAKES_FOLDERS | BENCH_TAKES_SCENES;
  if (!o->frame_count && command->accepts & folders)
    return image_fail(error,
                      "%s: no folder; FOLDER... is needed, see hbil-bench %s "
                      "--help",
                      command->name, command->name);
  if (o->frame_count && !(command->accepts & (BENCH_TAKES_FRAMES | folders)))
    return image_fail(error, "%s: %s: no file is needed here", command->name,
                      o->frames[0]);
  if (o->frame_count && o->width && command->accepts & BENCH_TAKES_FRAMES)
    return image_fail(error, "--size: a dump has its own size; this option is "
                             "for the procedural room");
  if (o->frame_count != 1 && o->truth)
    return image_fail(error, "--truth: one --dump FRAME.exr is needed with it");
  if (!o->frame_count && o->camera)
    return image_fail(error, "--camera: --dump FRAME.exr is needed with it");
  return 0;
}

/* The rows of the table that the command takes, for getopt_long(). */
static void fill_getopt(const bench_command *command,
                        struct option out[COUNT + 2]) {
  int count = 0;
  for (int i = 0; i < COUNT; i++)
    if (is_taken(command, &table[i]))
      out[count++] = (struct option){
          table[i].name, table[i].value ? required_argument : no_argument, NULL,
          table[i].letter};
  out[count++] = (struct option){"help", no_argument, NULL, 'h'};
  out[count] = (struct option){NULL, 0, NULL, 0};
}

/* Takes the words behind "--" away.  Returns how many are left. */
static int take_process(const bench_command *command, int argc, char **argv,
                        bench_options *out) {
  int end = 1;
  while (end < argc && strcmp(argv[end], "--") != 0)
    end++;
  if (end >= argc || !(command->accepts & BENCH_TAKES_FOLDERS))
    return argc;
  out->process = argv + end + 1;
  out->process_count = argc - end - 1;
  return end;
}

int bench_options_parse(const bench_command *command, int argc, char **argv,
                        bench_options *out, image_error *error) {
  struct option options[COUNT + 2];
  int letter, at = 1;
  fill_getopt(command, options);
  out->output = "bench-results";
  out->name = command->name;
  out->runs = command->runs;
  out->frames = calloc((size_t)argc, sizeof *out->frames);
  if (!out->frames)
    return image_no_memory(error, command->name);
  argc = take_process(command, argc, argv, out);
  opterr = 0;
  while ((letter = getopt_long(argc, argv, ":o:h", options, NULL)) != -1) {
    if (letter == ':' || letter == '?')
      return image_fail(error, "%s: %s %s; see hbil-bench %s --help",
                        command->name, argv[optind > at ? optind - 1 : at],
                        letter == ':' ? "needs a value" : "is not an option",
                        command->name);
    if (letter == 'h') {
      print_help(command);
      return 1;
    }
    if (set_option(letter, out, error) != 0)
      return -1;
    at = optind;
  }
  for (int i = optind; i < argc; i++)
    out->frames[out->frame_count++] = argv[i];
  return check(command, out, error);
}

double bench_clock(void) {
  return 1e3 * seconds_now();
}

void bench_progress(const char *what, size_t done, size_t count) {
  if (isatty(STDERR_FILENO))
    fprintf(stderr, "\r%s: %zu of %zu\033[K%s", what, done, count,
            done == count ? "\n" : "");
}
