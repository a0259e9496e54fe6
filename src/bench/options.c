/* The options of the sub-commands, in one table. */
#define _POSIX_C_SOURCE 200809L
#include <getopt.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "bench/command.h"
#include "image/clock.h"
#include "tool/options.h"

static int add_frame(const char *path, void *options, image_error *error) {
  bench_options *o = options;
  (void)error;
  o->frames[o->frame_count++] = path;
  return 0;
}

static int set_window(const char *text, void *options, image_error *error) {
  bench_options *o = options;
  uint32_t *w = o->window;
  int end = 0;
  if (sscanf(text, "%" SCNu32 "x%" SCNu32 "+%" SCNu32 "+%" SCNu32 "%n", &w[2],
             &w[3], &w[0], &w[1], &end) != 4 ||
      text[end] || !w[2] || !w[3] || strpbrk(text, "- \t"))
    return image_fail(
        error, "--window %s: WIDTHxHEIGHT+X+Y is needed, in pixels", text);
  return 0;
}

static int add_kernels(const char *folder, void *options, image_error *error) {
  bench_options *o = options;
  struct stat info;
  if (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode))
    return image_fail(error, "--kernels %s: a folder of kernel files is needed",
                      folder);
  if (o->kernel_count == BENCH_MAX_KERNELS)
    return image_fail(error, "--kernels %s: at most %d folders are compared",
                      folder, BENCH_MAX_KERNELS);
  o->kernels[o->kernel_count++] = folder;
  return 0;
}

#define AT(field) offsetof(bench_options, field)

static const option_row rows[] = {
    {ROW_TEXT("output", AT(output), "DIR"), .letter = 'o',
     .only_for = BENCH_TAKES_REPORT, .help = "folder of the result files ({})"},
    {ROW_TEXT("name", AT(name), "NAME"), .only_for = BENCH_TAKES_REPORT,
     .help = "name of the files and of the section (the command's)"},
    {ROW_TEXT("markdown", AT(markdown), "FILE"), .only_for = BENCH_TAKES_REPORT,
     .help = "also replaces what stands in FILE between the lines <!-- "
             "hbil-bench NAME --> and <!-- end -->"},
    {ROW_FLAG("json", AT(json)), .only_for = BENCH_TAKES_REPORT,
     .help = "prints JSON in place of Markdown"},
    {ROW_FLAG("quick", AT(quick)),
     .only_for = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM,
     .help = "a short list, and a room of 320x180 pixels"},
    {.name = "size",
     .kind = OPTION_SIZE,
     .member = AT(width),
     .value = "WxH",
     .only_for = BENCH_TAKES_ROOM,
     .help = "pixels of the procedural room (1280x720)"},
    {ROW_OTHER("dump", AT(frames), add_frame, "FRAME.exr"),
     .only_for = BENCH_TAKES_FRAMES,
     .help = "measures on this captured frame instead of the room"},
    {ROW_TEXT("camera", AT(camera), "FILE"), .only_for = BENCH_TAKES_FRAMES,
     .help = "JSON camera of the frames (FRAME.json beside each)"},
    {ROW_NUMBER("pixels", AT(pixels), 16, 1u << 28, "N"),
     .only_for = BENCH_TAKES_ERRORS,
     .help = "most pixels to measure errors at (8000; 1000 with --quick); at "
             "most one of each 4x4 block is used"},
    {ROW_OTHER("window", AT(window), set_window, "WxH+X+Y"),
     .only_for = BENCH_TAKES_WINDOW,
     .help = "measures errors at all pixels of this rectangle, X and Y being "
             "its first column and row, and what is left of AO's error between "
             "blurs of 1.5 and 8 pixels, the waves that an eye sees"},
    {ROW_OTHER("kernels", AT(kernels), add_kernels, "DIR"),
     .only_for = BENCH_TAKES_KERNELS,
     .help = "times the kernel files of this folder in turns with the embedded "
             "ones; given twice: with each other"},
    {ROW_TEXT("device", AT(device), "NAME"),
     .help = "index or part of a name, as in hbil devices (the first GPU, else "
             "the first device)"},
    {ROW_NUMBER("runs", AT(runs), 1, BENCH_MAX_RUNS, "N"),
     .only_for = BENCH_TAKES_TIMES,
     .help = "counted runs of each setting, 1..1000 ({})"}};
static const option_group group = {.rows = rows,
                                   .count = sizeof rows / sizeof *rows};

static void print_help(const bench_command *command, const option_command *c,
                       const bench_options *defaults) {
  option_command with_usage = *c;
  char usage[4096];
  const size_t length = strlen(command->details) - 1; /* without a line's end */
  snprintf(usage, sizeof usage, "usage: hbil-bench %s [options]%s\n\n%.*s",
           command->name,
           command->accepts & BENCH_TAKES_FRAMES    ? " [FRAME.exr...]"
           : command->accepts & BENCH_TAKES_FOLDERS ? " FOLDER... [-- OPTIONS]"
                                                    : "",
           (int)length, command->details);
  with_usage.usage = usage;
  options_help(&with_usage, defaults);
}

static int check(const bench_command *command, const bench_options *o,
                 image_error *error) {
  if (!o->frame_count && command->accepts & BENCH_TAKES_FOLDERS)
    return image_fail(error,
                      "%s: no folder; FOLDER... is needed, see hbil-bench %s "
                      "--help",
                      command->name, command->name);
  if (o->frame_count &&
      !(command->accepts & (BENCH_TAKES_FRAMES | BENCH_TAKES_FOLDERS)))
    return image_fail(error, "%s: %s: no file is needed here", command->name,
                      o->frames[0]);
  if (o->frame_count && o->width && command->accepts & BENCH_TAKES_FRAMES)
    return image_fail(error, "--size: a dump has its own size; this option is "
                             "for the procedural room");
  if (!o->frame_count && o->camera)
    return image_fail(error, "--camera: --dump FRAME.exr is needed with it");
  return 0;
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
  const option_command c = {
      .groups = &group, .group_count = 1, .accepts = command->accepts};
  options_given given;
  out->output = "bench-results";
  out->name = command->name;
  out->runs = command->runs;
  out->frames = calloc((size_t)argc, sizeof *out->frames);
  if (!out->frames)
    return image_no_memory(error, command->name);
  const bench_options defaults = *out;
  argc = take_process(command, argc, argv, out);
  const int read = options_read(&c, argc, argv, out, &given, error);
  if (read > 0)
    print_help(command, &c, &defaults);
  if (read != 0)
    return read;
  for (int i = optind; i < argc; i++)
    out->frames[out->frame_count++] = argv[i];
  return check(command, out, error);
}

double bench_clock(void) {
  return 1e3 * seconds_now();
}
