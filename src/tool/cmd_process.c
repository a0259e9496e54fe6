/* hbil process: options of the main job. */
#include "tool/tool.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Slices: what the library takes, the exact integral takes, and that by
 * itself. */
enum { MOST = 32, MOST_EXACT = 4096, EXACT = 256 };

/* Options without a letter of their own. */
enum {
  OPTION_LAYERS = 256,
  OPTION_MODE,
  OPTION_FALLOFF,
  OPTION_QUALITY,
  OPTION_RADIUS,
  OPTION_SLICES,
  OPTION_SAMPLES,
  OPTION_STEP_GROWTH,
  OPTION_EXTRAPOLATE,
  OPTION_MAX_ERROR,
  OPTION_LATTICE,
  OPTION_STORAGE,
  OPTION_NO_SKIP,
  OPTION_FACING,
  OPTION_REFUSED,
  OPTION_GATHER_EMISSION,
  OPTION_REPROJECTION,
  OPTION_FEEDBACK,
  OPTION_DISOCCLUSION,
  OPTION_TEMPORAL,
  OPTION_THICKNESS,
  OPTION_RELATIVE_THICKNESS,
  OPTION_RAW,
  OPTION_ENVIRONMENT,
  OPTION_CAMERA,
  OPTION_DEVICE,
  OPTION_REPEAT,
  OPTION_RESUME,
  OPTION_OVERWRITE,
  OPTION_DRY_RUN,
  OPTION_KEEP,
  OPTION_CONTACT_SHEET,
  OPTION_HALF,
  OPTION_COMPRESSION,
  OPTION_FRAMES,
  OPTION_WARM_UP,
  OPTION_FORM_FACTORS,
  OPTION_CHOOSE_EVERY,
  OPTION_PREVIEW,
  OPTION_TIMINGS,
  OPTION_JSON,
  OPTION_QUIET,
  OPTION_END
};

/* What was asked for, where one option decides whether another may be. */
typedef struct request {
  process_options *options;
  const char *frames; /* their numbers, for patterns; or NULL */
  char given[OPTION_END - OPTION_LAYERS];
} request;

static int is_given(const request *r, int option) {
  return r->given[option - OPTION_LAYERS];
}

static const struct option options[] = {
    {"output", required_argument, NULL, 'o'},
    {"layers", required_argument, NULL, OPTION_LAYERS},
    {"mode", required_argument, NULL, OPTION_MODE},
    {"falloff", required_argument, NULL, OPTION_FALLOFF},
    {"quality", required_argument, NULL, OPTION_QUALITY},
    {"radius", required_argument, NULL, OPTION_RADIUS},
    {"slices", required_argument, NULL, OPTION_SLICES},
    {"samples", required_argument, NULL, OPTION_SAMPLES},
    {"step-growth", required_argument, NULL, OPTION_STEP_GROWTH},
    {"extrapolate", required_argument, NULL, OPTION_EXTRAPOLATE},
    {"max-error", required_argument, NULL, OPTION_MAX_ERROR},
    {"choose-every", required_argument, NULL, OPTION_CHOOSE_EVERY},
    {"thickness", required_argument, NULL, OPTION_THICKNESS},
    {"relative-thickness", required_argument, NULL, OPTION_RELATIVE_THICKNESS},
    {"lattice", required_argument, NULL, OPTION_LATTICE},
    {"storage", required_argument, NULL, OPTION_STORAGE},
    {"no-skip", no_argument, NULL, OPTION_NO_SKIP},
    {"facing", required_argument, NULL, OPTION_FACING},
    {"refused", required_argument, NULL, OPTION_REFUSED},
    {"gather-emission", required_argument, NULL, OPTION_GATHER_EMISSION},
    {"reprojection", required_argument, NULL, OPTION_REPROJECTION},
    {"feedback", required_argument, NULL, OPTION_FEEDBACK},
    {"disocclusion", required_argument, NULL, OPTION_DISOCCLUSION},
    {"temporal", required_argument, NULL, OPTION_TEMPORAL},
    {"raw", no_argument, NULL, OPTION_RAW},
    {"environment", required_argument, NULL, OPTION_ENVIRONMENT},
    {"camera", required_argument, NULL, OPTION_CAMERA},
    {"device", required_argument, NULL, OPTION_DEVICE},
    {"repeat", required_argument, NULL, OPTION_REPEAT},
    {"resume", no_argument, NULL, OPTION_RESUME},
    {"overwrite", no_argument, NULL, OPTION_OVERWRITE},
    {"dry-run", no_argument, NULL, OPTION_DRY_RUN},
    {"keep", no_argument, NULL, OPTION_KEEP},
    {"half", no_argument, NULL, OPTION_HALF},
    {"compression", required_argument, NULL, OPTION_COMPRESSION},
    {"contact-sheet", required_argument, NULL, OPTION_CONTACT_SHEET},
    {"frames", required_argument, NULL, OPTION_FRAMES},
    {"warm-up", required_argument, NULL, OPTION_WARM_UP},
    {"horizon-cache", required_argument, NULL, OPTION_FORM_FACTORS},
    {"preview", no_argument, NULL, OPTION_PREVIEW},
    {"timings", no_argument, NULL, OPTION_TIMINGS},
    {"json", no_argument, NULL, OPTION_JSON},
    {"quiet", no_argument, NULL, OPTION_QUIET},
    SOURCE_OPTIONS,
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static void usage(const hbil_config *defaults) {
  puts(
      "usage: hbil process [options] -o DIR FRAME.exr...\n"
      "\n"
      "Lights the frames of a sequence in order; light is carried from frame\n"
      "to frame.  Writes DIR/FRAME.exr.  Reads Blender Cycles' multi-layer\n"
      "files and those of hbil demo.  FRAME.exr may be a pattern such as\n"
      "shot.%04d.exr or shot.####.exr.\n"
      "\n"
      "  -o, --output DIR      folder of the results (made if its parent is\n"
      "                        there)\n"
      "  --frames RANGES       numbers for the patterns, such as 1-240x2,300 "
      "(all\n"
      "                        that are there)\n"
      "  --layers LIST         of near, far, indirect, AO, bent, cone, "
      "beauty,\n"
      "                        error (all that the mode has, but error)\n"
      "  --keep                put the frame's own channels into its result, "
      "too\n"
      "  --compression NAME    none, rle, zips, zip, piz, pxr24, b44, b44a, "
      "dwaa,\n"
      "                        dwab, or input, as the frame has it (zip)\n"
      "  --half                store the layers as half floats\n"
      "  --camera FILE         JSON camera of all frames (FRAME.json beside\n"
      "                        each FRAME.exr)\n"
      "  --environment R,G,B   far light, the same from everywhere\n"
      "  --environment FILE    far light, a latitude-longitude map\n"
      "  --environment none|frame\n"
      "                        no far light, or what the frame's own surfaces\n"
      "                        send; without this option the latter, less\n"
      "                        what a lit sky in the first frame explains\n"
      "  --device NAME         index or part of a name, see hbil devices (the\n"
      "                        first GPU, else the first device)\n"
      "  --overwrite           replace results that are there already, which\n"
      "                        are refused otherwise\n"
      "  --resume              go on where such a job was broken off: results "
      "in\n"
      "                        DIR of the same frames, settings, device and\n"
      "                        version are kept; the others come out as they\n"
      "                        would have, bit by bit\n"
      "  --dry-run             check everything, tell what would be written, "
      "and\n"
      "                        write nothing\n"
      "  --repeat N            run every frame N times: more bounces (1)\n"
      "  --warm-up N           run the first frame N times more (3)\n"
      "  --horizon-cache MIB    device memory for what a frame's third and\n"
      "                        later runs need not look for again; results\n"
      "                        are the same (where frames run eight times\n"
      "                        and more, a single frame's warm-up included:\n"
      "                        1024, or a quarter of the device's; else, and\n"
      "                        where ulimit limits memory, 0)\n"
      "  --preview             also write DIR/FRAME.LAYER.png\n"
      "  --contact-sheet PNG   layers side by side, at most eight frames of "
      "the\n"
      "                        sequence below each other\n"
      "  --timings             print milliseconds per pass and frame (of the\n"
      "                        last run of each frame), and what was left "
      "out;\n"
      "                        a CPU device shares its cores with reading and\n"
      "                        writing (hbil-bench measures passes alone)\n"
      "  --json                print them as JSON\n"
      "  --quiet               no line per frame, no progress\n"
      "\n"
      "How well:\n"
      "  --quality fast|balanced|high\n"
      "                        sets slices, samples, step growth, lattice and\n"
      "                        storage;\n"
      "                        options after it have the last word\n"
      "  --quality reference   the exact screen-space integral of the same\n"
      "                        model, in double precision, on all CPUs and\n"
      "                        without OpenCL: every pixel that a slice "
      "crosses,\n"
      "                        --slices 1..4096 (256).  Takes minutes to "
      "hours;\n"
      "                        compare with it to see the sampling error\n"
      "\n"
      "The method:\n"
      "  --mode hbil|gtao|hbao near light and occlusion; cosine-weighted\n"
      "                        occlusion and bent normal (all layers but "
      "near);\n"
      "                        uniform occlusion with falloff (AO, far,\n"
      "                        indirect, beauty) (hbil)\n"
      "  --falloff linear|soft|none\n"
      "                        weight of an occluder at distance r within\n"
      "                        radius R, for hbao: 1-r/R, 1-r/(3R), 1 "
      "(linear)");
  printf("  --radius R            world units, or inf (%g)\n"
         "  --thickness T         of occluders, world units (inf)\n"
         "  --relative-thickness T\n"
         "                        the same as a share of their depth, or of\n"
         "                        an orthographic picture's width (%g)\n"
         "  --slices N            per pixel, 1..32 (%u)\n"
         "  --samples N           per side of a slice, 1..256 (%u)\n"
         "  --step-growth G       0: equal steps; the last step is (1+G)^2\n"
         "                        times the first (%g)\n",
         (double)defaults->radius, (double)defaults->relative_thickness,
         defaults->slices, defaults->steps_per_side,
         (double)defaults->step_growth);
  puts("  --lattice full|layer  where samples may lie: any pixel, or every\n"
       "                        fourth\n"
       "  --max-error A,E       95 % of the pixels within A of the exact AO "
       "and\n"
       "                        within E of E_near, over its mean in the "
       "frame:\n"
       "                        fewer slices and samples, from 1x4 on, for\n"
       "                        frames that need no more (inf,inf)\n"
       "  --choose-every N      with --max-error: anew every Nth run (4; with\n"
       "                        --reprojection none 1)\n"
       "  --extrapolate yes|no  judge what lies between the samples by what\n"
       "                        half of them miss (yes)\n"
       "  --no-skip             do all work, even such as can't change a\n"
       "                        result (see --timings)\n"
       "  --storage packed|fp32|half|float11\n"
       "                        how the layers between the passes are kept\n"
       "                        (packed)");
  printf("  --facing A,B          cosines between which the light of a sample\n"
         "                        fades in (%g,%g)\n",
         (double)defaults->facing_fade[0], (double)defaults->facing_fade[1]);
  puts(
      "  --refused last|black|frame\n"
      "                        light of samples that face away: the last one\n"
      "                        accepted, none, what the frame sends on "
      "average\n"
      "  --gather-emission yes|no\n"
      "                        emission lights neighbours, too (yes if the\n"
      "                        first frame's direct light can't hold what its\n"
      "                        lamps send)\n"
      "  --reprojection none|scatter|motion\n"
      "                        how light is carried over: not at all, by the\n"
      "                        camera's movement, by motion vectors (scatter)\n"
      "  --feedback irradiance|radiance\n"
      "                        what is carried over (irradiance)");
  printf(
      "  --disocclusion S      drop carried light where depth is off by more\n"
      "                        than this share of it, or of an orthographic\n"
      "                        picture's width (%g)\n",
      (double)defaults->disocclusion_threshold);
  puts(
      "  --temporal N          mean over N frames, 0..1024, whose sampling\n"
      "                        pattern turns: surfaces are followed by the\n"
      "                        cameras, or by motion vectors with\n"
      "                        --reprojection motion; 2 to 4 where the\n"
      "                        camera moves, more where nothing does (0: off)\n"
      "  --raw                 undo the 4x4 split only, without the filter");
  source_usage();
  puts("\n"
       "Layers: near, far: irradiance E; indirect: (1-F0)(E_near+E_far)/pi,\n"
       "what renderers call diffuse indirect, without albedo; AO.V: 1 open;\n"
       "bent: unit vector, world space; cone.V: cosine of the bent cone's\n"
       "half-angle; beauty: the lit picture; error: what 95 % of the pixels'\n"
       "AO (X) and E_near (Y) may be off by, because samples are few.");
}

/* A word that stands for a value of an enum, in the enum's order. */
static int choice(const char *option, const char *const *words, int *out,
                  image_error *error) {
  return option_choice(option, optarg, words, out, error);
}

static int set_choice(int option, process_options *o, image_error *error) {
  static const char *const lattices[] = {"layer", "full", NULL};
  static const char *const storages[] = {"packed", "fp32", "half", "float11",
                                         NULL};
  static const char *const refusals[] = {"last", "black", "frame", NULL};
  static const char *const answers[] = {"no", "yes", NULL};
  static const char *const reprojections[] = {"none", "scatter", "motion",
                                              NULL};
  static const char *const feedbacks[] = {"irradiance", "radiance", NULL};
  int value = 0, failed = 0;
  switch (option) {
  case OPTION_MODE:
    failed = choice("--mode", process_modes, &value, error);
    o->config.mode = (hbil_mode)value;
    break;
  case OPTION_FALLOFF:
    failed = choice("--falloff", process_falloffs, &value, error);
    o->config.falloff = (hbil_falloff)value;
    break;
  case OPTION_LATTICE:
    failed = choice("--lattice", lattices, &value, error);
    o->config.sample_grid = (hbil_sample_grid)value;
    break;
  case OPTION_STORAGE:
    failed = choice("--storage", storages, &value, error);
    o->config.storage = (hbil_storage)value;
    break;
  case OPTION_REFUSED:
    failed = choice("--refused", refusals, &value, error);
    o->config.back_facing_fallback = (hbil_back_facing_fallback)value;
    break;
  case OPTION_REPROJECTION:
    failed = choice("--reprojection", reprojections, &value, error);
    o->config.reprojection = (hbil_reprojection)value;
    break;
  case OPTION_FEEDBACK:
    failed = choice("--feedback", feedbacks, &value, error);
    o->config.feedback = (hbil_feedback)value;
    break;
  case OPTION_EXTRAPOLATE:
    failed = choice("--extrapolate", answers, &value, error);
    o->config.extrapolate = (cl_bool)value;
    break;
  default:
    failed = choice("--gather-emission", answers, &value, error);
    o->config.gather_emission = (cl_bool)value;
    o->emission_given = 1;
  }
  return failed;
}

static int set_quality(process_options *o, image_error *error) {
  const char *words[HBIL_QUALITY_REFERENCE + 2] = {NULL};
  int value = 0;
  for (int q = 0; q <= HBIL_QUALITY_REFERENCE; q++)
    words[q] = hbil_quality_name((hbil_quality)q);
  if (choice("--quality", words, &value, error) != 0)
    return -1;
  o->exact = value == HBIL_QUALITY_REFERENCE;
  hbil_config_set_quality(&o->config, (hbil_quality)value);
  if (o->exact)
    o->config.slices = EXACT;
  return 0;
}

static int set_number(int option, process_options *o, image_error *error) {
  hbil_config *c = &o->config;
  switch (option) {
  case OPTION_RADIUS:
    return option_floats("--radius", optarg, &c->radius, 1, error);
  case OPTION_STEP_GROWTH:
    return option_floats("--step-growth", optarg, &c->step_growth, 1, error);
  case OPTION_MAX_ERROR:
    return option_floats("--max-error", optarg, c->max_error, 2, error);
  case OPTION_THICKNESS:
    return option_floats("--thickness", optarg, &c->thickness, 1, error);
  case OPTION_RELATIVE_THICKNESS:
    return option_floats("--relative-thickness", optarg, &c->relative_thickness,
                         1, error);
  case OPTION_DISOCCLUSION:
    return option_floats("--disocclusion", optarg, &c->disocclusion_threshold,
                         1, error);
  case OPTION_FACING:
    return option_floats("--facing", optarg, c->facing_fade, 2, error);
  case OPTION_SLICES:
    return option_unsigned("--slices", optarg, 1, MOST_EXACT, &c->slices,
                           error);
  case OPTION_TEMPORAL:
    return option_unsigned("--temporal", optarg, 0, 1024,
                           &c->max_history_frames, error);
  case OPTION_WARM_UP:
    return option_unsigned("--warm-up", optarg, 0, 1000, &o->warm_up, error);
  case OPTION_FORM_FACTORS:
    return option_unsigned("--horizon-cache", optarg, 0, MOST_FORM_FACTORS,
                           &o->horizon_cache_bytes, error);
  case OPTION_CHOOSE_EVERY:
    return option_unsigned("--choose-every", optarg, 1, 1000, &o->choose_every,
                           error);
  case OPTION_SAMPLES:
    return option_unsigned("--samples", optarg, 1, 256, &c->steps_per_side,
                           error);
  default:
    return option_unsigned("--repeat", optarg, 1, 100000, &o->repeat, error);
  }
}

static int set_option(int option, process_options *o, image_error *error) {
  if (option >= SOURCE_OPTION)
    return source_option(option, optarg, &o->source, error);
  switch (option) {
  case 'o':
    o->output = optarg;
    return 0;
  case OPTION_LAYERS:
    return layers_parse(optarg, &o->layers, error);
  case OPTION_CAMERA:
    o->camera = optarg;
    return 0;
  case OPTION_ENVIRONMENT:
    o->environment = optarg;
    return 0;
  case OPTION_DEVICE:
    o->device = optarg;
    return 0;
  case OPTION_NO_SKIP:
    o->config.skip = 0;
    return 0;
  case OPTION_RESUME:
    o->resume = 1;
    return 0;
  case OPTION_OVERWRITE:
    o->overwrite = 1;
    return 0;
  case OPTION_CONTACT_SHEET:
    o->contact_sheet = optarg;
    return 0;
  case OPTION_KEEP:
    o->keep = 1;
    return 0;
  case OPTION_HALF:
    o->half = 1;
    return 0;
  case OPTION_COMPRESSION:
    return choice("--compression", exr_compressions, &o->compression, error);
  case OPTION_DRY_RUN:
    o->dry_run = 1;
    return 0;
  case OPTION_PREVIEW:
    o->preview = 1;
    return 0;
  case OPTION_TIMINGS:
    o->timings = 1;
    return 0;
  case OPTION_JSON:
    o->timings = o->json = 1;
    return 0;
  case OPTION_QUIET:
    o->quiet = 1;
    return 0;
  case OPTION_RAW:
    o->config.unfiltered = CL_TRUE;
    return 0;
  case OPTION_QUALITY:
    return set_quality(o, error);
  case OPTION_MODE:
  case OPTION_FALLOFF:
  case OPTION_LATTICE:
  case OPTION_EXTRAPOLATE:
  case OPTION_STORAGE:
  case OPTION_REFUSED:
  case OPTION_REPROJECTION:
  case OPTION_FEEDBACK:
  case OPTION_GATHER_EMISSION:
    return set_choice(option, o, error);
  default:
    return set_number(option, o, error);
  }
}

/* Options that the exact integral has no use for. */
static int check_exact(const request *r, image_error *error) {
  static const struct {
    int option;
    const char *name, *why;
  } useless[] = {
      {OPTION_SAMPLES, "--samples", "which looks at every pixel"},
      {OPTION_STEP_GROWTH, "--step-growth", "which looks at every pixel"},
      {OPTION_EXTRAPOLATE, "--extrapolate", "which misses nothing"},
      {OPTION_MAX_ERROR, "--max-error", "which has none"},
      {OPTION_LATTICE, "--lattice", "which looks at every pixel"},
      {OPTION_FORM_FACTORS, "--horizon-cache", "which keeps none"},
      {OPTION_STORAGE, "--storage", "which has no layers"},
      {OPTION_NO_SKIP, "--no-skip", "which skips nothing"},
      {OPTION_TEMPORAL, "--temporal", "which has no noise"},
      {OPTION_RAW, "--raw", "which filters nothing"},
      {OPTION_DEVICE, "--device", "which runs on the CPUs without OpenCL"},
      {OPTION_TIMINGS, "--timings", "which has no passes on a device"},
      {OPTION_JSON, "--json", "which has no timings"},
  };
  for (size_t i = 0; i < sizeof useless / sizeof *useless; i++)
    if (is_given(r, useless[i].option))
      return image_fail(error,
                        "%s: not with --quality reference, %s; one or the "
                        "other is needed",
                        useless[i].name, useless[i].why);
  return 0;
}

/* Where a frame's later runs could not use what is kept. */
static int check_form_factors(const hbil_config *c, image_error *error) {
  const char *of_all = c->mode != HBIL_MODE_HBIL ? "--mode gtao or hbao"
                       : c->reprojection == HBIL_REPROJECTION_NONE
                           ? "--reprojection none"
                           : NULL;
  if (c->max_history_frames || !isinf(c->max_error[0]) ||
      !isinf(c->max_error[1]))
    return image_fail(error,
                      "--horizon-cache: not with --temporal or --max-error, "
                      "where each run of a frame has samples of its own; one "
                      "or the other is needed");
  if (of_all)
    return image_fail(error,
                      "--horizon-cache: not with %s, where later runs of a "
                      "frame bring no new light; one or the other is needed",
                      of_all);
  if (!(c->skip & HBIL_SKIP_STILL))
    return image_fail(
        error, "--horizon-cache: not with --no-skip, by which later runs "
               "of a frame do all work; one or the other is needed");
  return 0;
}

/* What only both options together decide. */
static int check_options(const request *r, image_error *error) {
  const process_options *o = r->options;
  if (is_given(r, OPTION_FALLOFF) && o->config.mode != HBIL_MODE_HBAO)
    return image_fail(error, "--falloff: --mode hbao is needed with it");
  if (is_given(r, OPTION_CHOOSE_EVERY) && isinf(o->config.max_error[0]) &&
      isinf(o->config.max_error[1]))
    return image_fail(error, "--choose-every: --max-error is needed with it");
  if (is_given(r, OPTION_FORM_FACTORS) && o->horizon_cache_bytes &&
      check_form_factors(&o->config, error) != 0)
    return -1;
  if (o->resume && o->timings)
    return image_fail(error,
                      "--resume: not with --timings, which wants every frame "
                      "to run; one or the other is needed");
  if (o->resume && o->overwrite)
    return image_fail(error,
                      "--resume: not with --overwrite, which replaces what the "
                      "former keeps; one or the other is needed");
  if (o->exact)
    return check_exact(r, error);
  if (o->config.slices > MOST)
    return image_fail(error,
                      "--slices %u: a whole number from 1 to %d, or --quality "
                      "reference, is needed",
                      (unsigned)o->config.slices, MOST);
  return 0;
}

int cmd_process(int argc, char **argv) {
  process_options o;
  request r = {.options = &o};
  image_error error;
  int option;
  process_options_init(&o);
  while ((option = option_next(argc, argv, ":o:h", options, &error)) != -1) {
    if (option == 'h') {
      process_options_init(&o);
      usage(&o.config);
      return TOOL_OK;
    }
    if (option == OPTION_FRAMES)
      r.frames = optarg;
    else if (option == '?' || set_option(option, &o, &error) != 0)
      return tool_report(&error);
    if (option >= OPTION_LAYERS && option < OPTION_END)
      r.given[option - OPTION_LAYERS] = 1;
  }
  frame_list list;
  if (check_options(&r, &error) != 0 ||
      frames_list(argv + optind, argc - optind, r.frames, &list, &error) != 0)
    return tool_report(&error);
  const int status = process_run(&o, list.files, (int)list.count);
  frames_free(&list);
  return status;
}
