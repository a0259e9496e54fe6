/* hbil bench: time and error of the settings on this machine. */
#include "bench/bench.h"

#include <getopt.h>
#include <string.h>
#include <sys/stat.h>

enum {
  OPTION_SIZE = 256,
  OPTION_DUMP,
  OPTION_SCALE,
  OPTION_CAMERA,
  OPTION_TRUTH,
  OPTION_DEVICE,
  OPTION_RUNS,
  OPTION_PIXELS,
  OPTION_QUICK,
  OPTION_SCALING,
  OPTION_SKIPS,
  OPTION_AGAINST,
  OPTION_TEMPORAL,
  OPTION_ADAPTIVE,
  OPTION_PROBE
};

static const struct option options[] = {
    {"size", required_argument, NULL, OPTION_SIZE},
    {"dump", required_argument, NULL, OPTION_DUMP},
    {"scale", required_argument, NULL, OPTION_SCALE},
    {"camera", required_argument, NULL, OPTION_CAMERA},
    {"truth", required_argument, NULL, OPTION_TRUTH},
    {"device", required_argument, NULL, OPTION_DEVICE},
    {"runs", required_argument, NULL, OPTION_RUNS},
    {"pixels", required_argument, NULL, OPTION_PIXELS},
    {"quick", no_argument, NULL, OPTION_QUICK},
    {"scaling", no_argument, NULL, OPTION_SCALING},
    {"against", required_argument, NULL, OPTION_AGAINST},
    {"temporal", no_argument, NULL, OPTION_TEMPORAL},
    {"adaptive", no_argument, NULL, OPTION_ADAPTIVE},
    {"skips", no_argument, NULL, OPTION_SKIPS},
    {"probe", no_argument, NULL, OPTION_PROBE},
    {"output", required_argument, NULL, 'o'},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static void usage(void) {
  puts(
      "usage: hbil bench [options]\n"
      "\n"
      "Measures the time of every pass and the error of the result for a list\n"
      "of settings and models, beside the paper's method as one plain kernel\n"
      "and a plain copy.  Errors are taken against the exact integral, which\n"
      "needs a while on the CPU at first.  Prints a table; writes\n"
      "DIR/bench.csv, bench.json, bench.svg, and bench.png where rsvg-convert\n"
      "is installed.\n"
      "\n"
      "  -o, --output DIR   folder of the files (./bench)\n"
      "  --size WxH         of the procedural room (1280x720)\n"
      "  --dump FRAME.exr   a captured frame in its place\n"
      "  --scale N          NxN pixels for each of the frame's, 1..16 (1)\n"
      "  --camera FILE      JSON camera of the frame (FRAME.json beside it)\n"
      "  --truth FILE.exr   the frame, path traced: DiffInd.{R,G,B}; also\n"
      "                     measures the model's error\n"
      "  --device NAME      index or part of a name, see hbil devices (the\n"
      "                     first GPU, else the first device)\n"
      "  --runs N           runs that are counted, 1..1000 (9)\n"
      "  --pixels N         most pixels that errors are measured at (8000); "
      "the\n"
      "                     exact integral's time goes with them, and no more\n"
      "                     than one in each block of 4x4 is taken\n"
      "  --quick            a short list and a small room (320x180)\n"
      "  --scaling          nothing but how time and memory grow with pixels,\n"
      "                     samples and threads, and what a first frame "
      "costs;\n"
      "                     writes DIR/scaling.csv and scaling.json (part of "
      "a\n"
      "                     run without --quick and --dump; --size is then "
      "the\n"
      "                     size that 1/2, 3/2, 3 and 6 times are compared "
      "to)\n"
      "  --skips            nothing but what a frame costs that has less to\n"
      "                     do, and what is left out of it; writes\n"
      "                     DIR/skips.json (part of a whole run)\n"
      "  --against DIR      nothing but the time of each pass beside that "
      "with\n"
      "                     the kernel files in DIR, in turns: what a change "
      "of\n"
      "                     kernels brings; no files are written\n"
      "  --temporal FRAME.exr...\n"
      "                     nothing but what the temporal filter takes off "
      "the\n"
      "                     error of the last frame of a sequence, and what "
      "it\n"
      "                     costs; writes DIR/temporal.json.  hbil demo makes\n"
      "                     such frames\n"
      "  --adaptive [FRAME.exr...]\n"
      "                     nothing but adaptive sampling (--max-error of "
      "hbil\n"
      "                     process) in all of these, or the room: whether "
      "its\n"
      "                     limits are kept, and its time beside the fastest\n"
      "                     uniform setting that keeps them; frames of a "
      "folder\n"
      "                     are a sequence; writes DIR/adaptive.json\n"
      "  --probe            what --scaling starts as processes of their own:\n"
      "                     times of a new plan, as JSON");
}

static int set_option(int option, bench_options *o, image_error *error) {
  switch (option) {
  case OPTION_SIZE:
    return option_size("--size", optarg, &o->width, &o->height, error);
  case OPTION_RUNS:
    return option_unsigned("--runs", optarg, 1, BENCH_MAX_RUNS, &o->runs,
                           error);
  case OPTION_PIXELS:
    return option_unsigned("--pixels", optarg, 16, 1u << 28, &o->pixels, error);
  case OPTION_DUMP:
    o->dump = optarg;
    break;
  case OPTION_SCALE:
    return option_unsigned("--scale", optarg, 1, 16, &o->scale, error);
  case OPTION_CAMERA:
    o->camera = optarg;
    break;
  case OPTION_TRUTH:
    o->truth = optarg;
    break;
  case OPTION_DEVICE:
    o->device = optarg;
    break;
  case OPTION_QUICK:
    o->quick = 1;
    break;
  case OPTION_SCALING:
    o->scaling = 1;
    break;
  case OPTION_SKIPS:
    o->skips = 1;
    break;
  case OPTION_AGAINST:
    o->against = optarg;
    break;
  case OPTION_TEMPORAL:
    o->temporal = 1;
    break;
  case OPTION_ADAPTIVE:
    o->adaptive = 1;
    break;
  case OPTION_PROBE:
    o->probe = 1;
    break;
  default:
    o->output = optarg;
  }
  return 0;
}

static int is_folder(const char *path) {
  struct stat info;
  return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

/* Of what can be measured alone, at most one. */
static int check_part(const bench_options *o, image_error *error) {
  const struct {
    const char *name;
    int given;
  } parts[] = {{"--temporal", o->temporal}, {"--adaptive", o->adaptive},
               {"--skips", o->skips},       {"--against", o->against != NULL},
               {"--scaling", o->scaling},   {"--probe", o->probe}};
  const char *first = NULL;
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
    if (parts[i].given && first)
      return image_fail(error,
                        "%s: is a part of its own; it is possible without %s "
                        "only",
                        first, parts[i].name);
    if (parts[i].given)
      first = parts[i].name;
  }
  return 0;
}

/* Frames without an option in front of each. */
static int check_frames(const bench_options *o, image_error *error) {
  const char *part = o->temporal ? "--temporal" : "--adaptive";
  if (o->frame_count > 0 && !o->temporal && !o->adaptive)
    return image_fail(error, "bench: %s: --dump is needed in front of a file",
                      o->frames[0]);
  if (o->temporal && o->frame_count == 0)
    return image_fail(error, "--temporal: no frame; FRAME.exr... are needed");
  if ((o->temporal || o->adaptive) && o->dump)
    return image_fail(error,
                      "%s: works on FRAME.exr... behind it; it is possible "
                      "without --dump only",
                      part);
  if (o->frame_count > 0 && o->width)
    return image_fail(error,
                      "%s: frames have their own size; --size is "
                      "possible without any only",
                      part);
  return 0;
}

static int check_dump(const bench_options *o, image_error *error) {
  if (o->dump && o->width)
    return image_fail(error, "--size: a dump has its own size; it is needed "
                             "without --dump only");
  if (o->dump && (o->scaling || o->probe))
    return image_fail(error,
                      "%s: works on the procedural room; no --dump is "
                      "possible with it",
                      o->scaling ? "--scaling" : "--probe");
  if (o->scale > 1 && !o->dump && !(o->adaptive && o->frame_count > 0))
    return image_fail(error, "--scale: --dump FRAME.exr or --adaptive "
                             "FRAME.exr... is needed with it");
  if (!o->dump && (o->truth || (o->camera && o->frame_count == 0)))
    return image_fail(error, "%s: --dump FRAME.exr is needed with it",
                      o->truth ? "--truth" : "--camera");
  return 0;
}

static int check(const bench_options *o, image_error *error) {
  if (check_part(o, error) != 0 || check_frames(o, error) != 0 ||
      check_dump(o, error) != 0)
    return -1;
  return !o->against || is_folder(o->against)
             ? 0
             : image_fail(error,
                          "--against %s: no folder; one with kernel files is "
                          "needed",
                          o->against);
}

int cmd_bench(int argc, char **argv) {
  bench_options o = {.output = "./bench", .runs = 9, .scale = 1};
  image_error error;
  int option;
  while ((option = option_next(argc, argv, ":o:h", options, &error)) != -1) {
    if (option == 'h') {
      usage();
      return TOOL_OK;
    }
    if (option == '?' || set_option(option, &o, &error) != 0)
      return tool_report(&error);
  }
  o.frames = argv + optind;
  o.frame_count = (unsigned)(argc - optind);
  if (check(&o, &error) != 0 ||
      (o.probe ? bench_probe_print(&o, &error) : bench_run(&o, &error)) != 0)
    return tool_report(&error);
  return TOOL_OK;
}
