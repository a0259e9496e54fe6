/* The command line of `hbil process`: a table with a row for each option. */
#include "tool/process_arguments.h"

#include "image/error.h"
#include "image/exr_style.h"
#include "tool/layers.h"
#include "tool/model.h"
#include "tool/options.h"
#include "tool/source_arguments.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Slices: the most that the library takes, the most that the exact integral
 * takes, and its default. */
enum { SLICES_MOST = 32, SLICES_MOST_EXACT = 4096, SLICES_EXACT = 256 };

typedef enum kind {
  TEXT,        /* a string */
  FLAG,        /* sets an int to 1 */
  FLOATS,      /* `low` numbers */
  NUMBER,      /* a whole number from `low` to `high` */
  CHOICE,      /* an enum: `low` + the index in `words` */
  SPECIAL,     /* see set_special() */
  SPECIAL_FLAG /* the same without a value */
} kind;

typedef struct row {
  const char *name;
  kind kind;
  size_t offset; /* in process_arguments */
  unsigned low, high;
  const char *const *words;
} row;

static const char *const resolutions[] = {"auto", "full", "half", NULL};
static const char *const no_yes[] = {"no", "yes", NULL};
static const char *const sample_grids[] = {"same-layer", "full-resolution",
                                           NULL};
static const char *const storages[] = {"packed", "float32", NULL};
static const char *const fallbacks[] = {"last-accepted", "black", "frame-mean",
                                        NULL};
static const char *const view_lights[] = {"direct", "radiance", NULL};
static const char *const reprojections[] = {"none", "camera", "motion", NULL};

#define AT(field) offsetof(process_arguments, field)
#define SETTING(field) AT(settings.field)
#define CONFIG(field) AT(settings.config.field)

static const row rows[] = {
    {"output", TEXT, SETTING(output), 0, 0, NULL},
    {"frames", TEXT, AT(frames), 0, 0, NULL},
    {"pre-roll", NUMBER, SETTING(pre_roll), 0, 100000, NULL},
    {"decide-by", TEXT, SETTING(decide_by), 0, 0, NULL},
    {"layers", SPECIAL, 0, 0, 0, NULL},
    {"copy-channels", FLAG, SETTING(copy_channels), 0, 0, NULL},
    {"compression", CHOICE, SETTING(compression), 0, 0, exr_compressions},
    {"half", FLAG, SETTING(half), 0, 0, NULL},
    {"camera", TEXT, SETTING(camera), 0, 0, NULL},
    {"view", SPECIAL, 0, 0, 0, NULL},
    {"far", SPECIAL, 0, 0, 0, NULL},
    {"light-view", SPECIAL, 0, 0, 0, NULL},
    {"view-light", CHOICE, SETTING(view_light), 0, 0, view_lights},
    {"learn", FLAG, SETTING(learn), 0, 0, NULL},
    {"cache-size", SPECIAL, 0, 0, 0, NULL},
    {"cache-load", TEXT, SETTING(cache_load), 0, 0, NULL},
    {"cache-fixed", FLAG, SETTING(cache_fixed), 0, 0, NULL},
    {"cache-save", TEXT, SETTING(cache_save), 0, 0, NULL},
    {"environment", TEXT, SETTING(environment), 0, 0, NULL},
    {"device", TEXT, SETTING(device), 0, 0, NULL},
    {"overwrite", FLAG, SETTING(overwrite), 0, 0, NULL},
    {"resume", FLAG, SETTING(resume), 0, 0, NULL},
    {"dry-run", FLAG, SETTING(dry_run), 0, 0, NULL},
    {"repeat", NUMBER, SETTING(repeat), 1, 100000, NULL},
    {"warm-up", NUMBER, SETTING(warm_up), 0, 1000, NULL},
    {"horizon-cache", NUMBER, SETTING(horizon_cache), 0, HORIZON_CACHE_MOST,
     NULL},
    {"preview", FLAG, SETTING(preview), 0, 0, NULL},
    {"contact-sheet", TEXT, SETTING(contact_sheet), 0, 0, NULL},
    {"timings", FLAG, SETTING(timings), 0, 0, NULL},
    {"json", FLAG, SETTING(json), 0, 0, NULL},
    {"quiet", FLAG, SETTING(quiet), 0, 0, NULL},
    {"quality", SPECIAL, 0, 0, 0, NULL},
    {"model", SPECIAL, 0, 0, 0, NULL},
    {"mode", CHOICE, CONFIG(model.mode), 0, 0, mode_words},
    {"falloff", CHOICE, CONFIG(model.falloff), 0, 0, falloff_words},
    {"radius", FLOATS, CONFIG(model.radius), 1, 0, NULL},
    {"thickness", FLOATS, CONFIG(model.thickness), 1, 0, NULL},
    {"relative-thickness", FLOATS, CONFIG(model.relative_thickness), 1, 0,
     NULL},
    {"slices", NUMBER, CONFIG(sampling.slices), 1, SLICES_MOST_EXACT, NULL},
    {"steps-per-side", NUMBER, CONFIG(sampling.steps_per_side), 1, 256, NULL},
    {"step-growth", FLOATS, CONFIG(sampling.step_growth), 1, 0, NULL},
    {"sample-grid", CHOICE, CONFIG(sampling.sample_grid), 0, 0, sample_grids},
    {"resolution", CHOICE, CONFIG(sampling.resolution), 0, 0, resolutions},
    {"extrapolate", CHOICE, CONFIG(model.extrapolate), 0, 0, no_yes},
    {"no-skip", SPECIAL_FLAG, 0, 0, 0, NULL},
    {"storage", CHOICE, CONFIG(sampling.storage), 0, 0, storages},
    {"facing-fade", FLOATS, CONFIG(model.facing_fade), 2, 0, NULL},
    {"back-facing-fallback", CHOICE, CONFIG(model.back_facing_fallback),
     HBIL_FALLBACK_LAST_ACCEPTED, 0, fallbacks},
    {"gather-emission", CHOICE, CONFIG(model.gather_emission), 0, 0, no_yes},
    {"unseen-light", FLOATS, CONFIG(model.unseen_light), 1, 0, NULL},
    {"roughness", FLOATS, CONFIG(model.roughness), 1, 0, NULL},
    {"reprojection", CHOICE, CONFIG(history.reprojection), 0, 0, reprojections},
    {"disocclusion-threshold", FLOATS, CONFIG(history.disocclusion_threshold),
     1, 0, NULL},
    {"max-history-frames", NUMBER, CONFIG(history.max_frames), 0, 1024, NULL},
    {"unfiltered", FLAG, CONFIG(sampling.unfiltered), 0, 0, NULL},
};
enum { ROWS = sizeof rows / sizeof *rows };

/* getopt's value of the first row. */
enum { FIRST_ROW = 256 };

/* Which options were given, by row. */
typedef struct request {
  process_arguments *arguments;
  char given[ROWS];
} request;

static size_t row_index(const char *name) {
  size_t i = 0;
  while (i < ROWS && strcmp(rows[i].name, name) != 0)
    i++;
  return i;
}

static int is_given(const request *r, const char *name) {
  const size_t i = row_index(name);
  return i < ROWS && r->given[i];
}

/* ------------------------------------------------------------------------ */
/* One option                                                                */

static int set_quality(const char *text, process_settings *s,
                       image_error *error) {
  const char *words[HBIL_QUALITY_REFERENCE + 2] = {NULL};
  int value = 0;
  for (int q = 0; q <= HBIL_QUALITY_REFERENCE; q++)
    words[q] = hbil_quality_name((hbil_quality)q);
  if (option_choice("--quality", text, words, &value, error) != 0)
    return -1;
  s->exact = value == HBIL_QUALITY_REFERENCE;
  hbil_sampling_set(&s->config.sampling, (hbil_quality)value);
  if (s->exact)
    s->config.sampling.slices = SLICES_EXACT;
  return 0;
}

/* The paper has no far light. */
static int set_model(const char *text, process_settings *s,
                     image_error *error) {
  int value = 0;
  if (option_choice("--model", text, model_words, &value, error) != 0)
    return -1;
  model_set(&s->config, (hbil_model_name)value);
  s->warm_up = model_warm_up((hbil_model_name)value);
  s->paper = value == HBIL_MODEL_PAPER;
  s->environment = value == HBIL_MODEL_PAPER ? "none" : NULL;
  return 0;
}

/* The providers, in the enum's order, then what there is without a cache. */
static int set_far(const char *text, process_settings *s, image_error *error) {
  static const char *const words[] = {"rays",        "cones", "lpv", "rsm",
                                      "environment", "none",  NULL};
  int value;
  if (option_choice("--far", text, words, &value, error) != 0)
    return -1;
  s->far = HBIL_PROVIDER_RAYS + value;
  return 0;
}

static int set_cache_size(const char *text, process_settings *s,
                          image_error *error) {
  static const char *const sizes[] = {"16", "32", "64", "128", "256", NULL};
  int value = 0;
  if (option_choice("--cache-size", text, sizes, &value, error) != 0)
    return -1;
  s->cache_voxels = 16u << value;
  return 0;
}

static int set_special(const char *name, char *text, process_arguments *a,
                       image_error *error) {
  process_settings *s = &a->settings;
  if (strcmp(name, "view") == 0)
    return frame_list_add(text, &a->views, error);
  if (strcmp(name, "light-view") == 0)
    return frame_list_add(text, &a->light_views, error);
  if (strcmp(name, "far") == 0)
    return set_far(text, s, error);
  if (strcmp(name, "cache-size") == 0)
    return set_cache_size(text, s, error);
  if (strcmp(name, "layers") == 0)
    return layers_parse(text, &s->layers, error);
  if (strcmp(name, "quality") == 0)
    return set_quality(text, s, error);
  if (strcmp(name, "model") == 0)
    return set_model(text, s, error);
  s->config.execution.skip = 0; /* no-skip */
  return 0;
}

static int set_row(const row *r, char *text, process_arguments *a,
                   image_error *error) {
  char *at = (char *)a + r->offset;
  char option[64];
  int value = 1, failed = 0;
  snprintf(option, sizeof option, "--%s", r->name);
  switch (r->kind) {
  case TEXT:
    memcpy(at, &text, sizeof text);
    return 0;
  case FLAG:
    memcpy(at, &value, sizeof value);
    return 0;
  case FLOATS:
    return option_floats(option, text, (float *)(void *)at, r->low, error);
  case NUMBER:
    return option_unsigned(option, text, r->low, r->high,
                           (unsigned *)(void *)at, error);
  case CHOICE:
    failed = option_choice(option, text, r->words, &value, error);
    value += (int)r->low;
    if (!failed)
      memcpy(at, &value, sizeof value);
    return failed;
  default:
    return set_special(r->name, text, a, error);
  }
}

/* ------------------------------------------------------------------------ */
/* Options that fit together                                                 */

/* Whether no option was given that means nothing to the exact integral. */
static int check_exact(const request *r, image_error *error) {
  static const struct {
    const char *name, *why;
  } useless[] = {
      {"steps-per-side", "which looks at every pixel"},
      {"step-growth", "which looks at every pixel"},
      {"extrapolate", "which looks at every pixel"},
      {"sample-grid", "which looks at every pixel"},
      {"resolution", "which computes every pixel"},
      {"horizon-cache", "which caches nothing"},
      {"view", "which has no radiance cache"},
      {"light-view", "which has no radiance cache"},
      {"far", "which has no radiance cache"},
      {"view-light", "which has no radiance cache"},
      {"learn", "which has no radiance cache"},
      {"cache-size", "which has no radiance cache"},
      {"cache-load", "which has no radiance cache"},
      {"cache-fixed", "which has no radiance cache"},
      {"cache-save", "which has no radiance cache"},
      {"storage", "which stores double precision"},
      {"no-skip", "which skips nothing"},
      {"max-history-frames", "which has no noise"},
      {"unfiltered", "which filters nothing"},
      {"device", "which runs on the CPUs without OpenCL"},
      {"timings", "which has no passes on a device"},
      {"json", "which has no timings"},
  };
  for (size_t i = 0; i < sizeof useless / sizeof *useless; i++)
    if (is_given(r, useless[i].name))
      return image_fail(error,
                        "--%s: not with --quality reference, %s; one or the "
                        "other is needed",
                        useless[i].name, useless[i].why);
  return 0;
}

/* Whether later runs of a frame can use a horizon cache. */
static int check_horizon_cache(const hbil_config *c, image_error *error) {
  const char *single = c->model.mode != HBIL_MODE_HBIL ? "--mode gtao or hbao"
                       : c->history.reprojection == HBIL_REPROJECTION_NONE
                           ? "--reprojection none"
                           : NULL;
  if (c->history.max_frames)
    return image_fail(error,
                      "--horizon-cache: not with --max-history-frames, where "
                      "each run of a frame has other samples; one or the "
                      "other is needed");
  if (single)
    return image_fail(error,
                      "--horizon-cache: not with %s, where later runs of a "
                      "frame bring no new light; one or the other is needed",
                      single);
  if (!(c->execution.skip & HBIL_SKIP_STATIC))
    return image_fail(error,
                      "--horizon-cache: not with --no-skip, which makes later "
                      "runs of a frame do all work; one or the other is "
                      "needed");
  return 0;
}

/* `--far environment` and `--far none` switch the cache off, so they are
 * allowed with options and modes that have none.  `--far none` also sets
 * --environment none, and is rejected with another environment. */
static int apply_far(request *r, image_error *error) {
  process_settings *s = &r->arguments->settings;
  if (settings_without_cache(s))
    r->given[row_index("far")] = 0;
  if (s->far != FAR_IS_NONE)
    return 0;
  if (s->environment && strcmp(s->environment, "none") != 0)
    return image_fail(error,
                      "--environment %s: not with --far none, which leaves far "
                      "light out; one or the other is needed",
                      s->environment);
  s->environment = "none";
  return 0;
}

/* Whether options of the radiance cache have one. */
static int check_cache(const request *r, image_error *error) {
  static const char *const names[] = {"view",        "light-view", "view-light",
                                      "learn",       "cache-size", "cache-load",
                                      "cache-fixed", "cache-save", "far"};
  const process_settings *s = &r->arguments->settings;
  const int no_light = s->config.model.mode != HBIL_MODE_HBIL;
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    if (!is_given(r, names[i]))
      continue;
    if (settings_without_cache(s))
      return image_fail(error,
                        "--%s: not with --far %s, which leaves the radiance "
                        "cache out; one or the other is needed",
                        names[i],
                        s->far == FAR_IS_NONE ? "none" : "environment");
    if (no_light)
      return image_fail(error,
                        "--%s: not with --mode %s, which looks at no light and "
                        "has no radiance cache; one or the other is needed",
                        names[i], mode_words[s->config.model.mode]);
  }
  if (is_given(r, "view-light") && !s->view_count)
    return image_fail(error, "--view-light: --view FILE is needed with it");
  if (s->light_view_count && s->far != HBIL_PROVIDER_RSM)
    return image_fail(error, "--light-view: --far rsm is needed with it");
  if (s->far == HBIL_PROVIDER_RSM && !s->light_view_count)
    return image_fail(error, "--far rsm: --light-view FILE is needed with it");
  if (s->light_view_count > HBIL_MAX_LIGHT_VIEWS)
    return image_fail(error, "--light-view: %u files; %d at most can be used",
                      s->light_view_count, HBIL_MAX_LIGHT_VIEWS);
  if (s->cache_fixed && !s->cache_load)
    return image_fail(error, "--cache-fixed: --cache-load FILE is needed with "
                             "it");
  if (s->cache_fixed && s->learn)
    return image_fail(error,
                      "--cache-fixed: not with --learn, by which the cache "
                      "sees the frames; one or the other is needed");
  if (s->cache_load && s->cache_voxels)
    return image_fail(error,
                      "--cache-size: not with --cache-load, whose file has a "
                      "size; one or the other is needed");
  return 0;
}

static int check_together(const request *r, image_error *error) {
  const process_settings *s = &r->arguments->settings;
  if (is_given(r, "pre-roll") && !r->arguments->frames)
    return image_fail(
        error, "--pre-roll: --frames with the frames that are written is "
               "needed with it");
  if (is_given(r, "falloff") && s->config.model.mode != HBIL_MODE_HBAO)
    return image_fail(error, "--falloff: --mode hbao is needed with it");
  if (is_given(r, "horizon-cache") && s->horizon_cache &&
      check_horizon_cache(&s->config, error) != 0)
    return -1;
  if (s->resume && s->timings)
    return image_fail(error,
                      "--resume: not with --timings, which needs every frame "
                      "to run; one or the other is needed");
  if (s->resume && s->overwrite)
    return image_fail(error,
                      "--resume: not with --overwrite, which replaces the "
                      "results that --resume leaves; one or the other is "
                      "needed");
  if (s->exact)
    return check_exact(r, error);
  if (s->config.sampling.resolution == HBIL_RESOLUTION_HALF &&
      s->config.sampling.unfiltered)
    return image_fail(error,
                      "--resolution half: not with --unfiltered, since the "
                      "filter fills in the other pixels; one or the other is "
                      "needed");
  if (s->layers >> LAYER_GLOSSY & 1 && s->far > HBIL_PROVIDER_RAYS &&
      !settings_without_cache(s))
    return image_fail(
        error, "--layers glossy: not with --far cones, lpv or rsm, which "
               "know no reflected light; one or the other is needed");
  if (check_cache(r, error) != 0)
    return -1;
  if (s->config.sampling.slices > SLICES_MOST)
    return image_fail(error,
                      "--slices %u: a whole number from 1 to %d, or --quality "
                      "reference, is needed",
                      (unsigned)s->config.sampling.slices, SLICES_MOST);
  return 0;
}

/* ------------------------------------------------------------------------ */
/* The command line                                                          */

/* The table as getopt_long() takes it, with the options of the source. */
static void make_getopt_table(struct option out[]) {
  size_t n = 0;
  for (; n < ROWS; n++) {
    const int bare = rows[n].kind == FLAG || rows[n].kind == SPECIAL_FLAG;
    out[n] =
        (struct option){rows[n].name, bare ? no_argument : required_argument,
                        NULL, FIRST_ROW + (int)n};
  }
  for (size_t i = 0; i < SOURCE_OPTION_COUNT; i++)
    out[n++] = source_option_rows[i];
  out[n++] = (struct option){"help", no_argument, NULL, 'h'};
  out[n] = (struct option){NULL, 0, NULL, 0};
}

static int take_option(int option, request *r, image_error *error) {
  process_arguments *a = r->arguments;
  if (option >= SOURCE_OPTION)
    return source_option(option, optarg, &a->settings.source, error);
  const size_t i =
      option == 'o' ? row_index("output") : (size_t)(option - FIRST_ROW);
  r->given[i] = 1;
  return set_row(&rows[i], optarg, a, error);
}

int process_arguments_read(int argc, char **argv, process_arguments *out,
                           image_error *error) {
  struct option table[ROWS + SOURCE_OPTION_COUNT + 2];
  request r = {.arguments = out};
  int option;
  memset(out, 0, sizeof *out);
  process_settings_init(&out->settings);
  make_getopt_table(table);
  while ((option = option_next(argc, argv, ":o:h", table, error)) != -1) {
    if (option == 'h')
      return 1;
    if (option == '?' || take_option(option, &r, error) != 0)
      return -1;
  }
  out->settings.emission_given = is_given(&r, "gather-emission");
  out->settings.radius_given = is_given(&r, "radius");
  out->settings.thickness_given = is_given(&r, "relative-thickness");
  out->settings.timings |= out->settings.json;
  out->settings.views = out->views.files;
  out->settings.view_count = (unsigned)out->views.count;
  out->settings.light_views = out->light_views.files;
  out->settings.light_view_count = (unsigned)out->light_views.count;
  out->files = argv + optind;
  out->count = argc - optind;
  return apply_far(&r, error) != 0 || check_together(&r, error) != 0 ? -1 : 0;
}

void process_arguments_free(process_arguments *a) {
  frame_list_free(&a->views);
  frame_list_free(&a->light_views);
  a->settings.views = NULL;
  a->settings.light_views = NULL;
  a->settings.view_count = 0;
}
