/* The command line of `hbil process`. */
#include "tool/process_arguments.h"

#include "image/error.h"
#include "tool/layers.h"
#include "tool/process_options.h"

#include <getopt.h>
#include <string.h>

/* The most slices that the library takes. */
enum { SLICES_MOST = 32 };

static const option_command command = {
    .usage =
        "usage: hbil process [options] -o DIR FRAME.exr...\n\nComputes the "
        "indirect light of a sequence's frames, in order; each frame hands its "
        "light on to the next.  Writes DIR/FRAME.exr.  Reads the multi-layer "
        "files of renderers (see --source) and those of hbil demo.  FRAME.exr "
        "may be a pattern such as shot.%04d.exr or shot.####.exr, or a folder "
        "that holds the EXR files of one sequence.",
    .groups = process_groups,
    .group_count = PROCESS_GROUPS,
    .notes =
        "Layers: near_irradiance, far_irradiance: E_near, E_far; indirect: "
        "(1-F0)(E_near+E_far)/pi, which renderers call diffuse indirect, "
        "without albedo; ao.V: 1 open, 0 closed; bent_normal: unit vector, "
        "world space; cone_cosine.V: cosine of the bent cone's half-angle; "
        "beauty: the final picture; unknown.V: the share of what a surface "
        "sees whose light is a guess, because the frame doesn't show it; "
        "glossy: light that a rough mirror reflects, without its colour; "
        "error_estimate: how far ao (X) and near_irradiance (Y) of 95 % of the "
        "pixels may be off because samples are few.\n\nAt the end, lines on "
        "standard error tell the mean of `unknown` over all surfaces, with a "
        "warning if most of the light is a guess, and which stage limited the "
        "job; --quiet leaves them out.",
};

static void set_defaults(process_arguments *a) {
  memset(a, 0, sizeof *a);
  process_settings_init(&a->settings);
}

void process_help(void) {
  process_arguments defaults;
  hbil_cache_config cache;
  set_defaults(&defaults);
  hbil_cache_config_init(&cache);
  cache.voxel_size = 1; /* decides about the radius, which is not read here */
  hbil_config with_cache = defaults.settings.config;
  hbil_config_use_cache(&with_cache, &cache);
  const option_value values[] = {
      {"levels", cache.levels},
      {"voxels", cache.voxels},
      {"near_voxels", HBIL_CACHE_NEAR_VOXELS},
      {"thickness_with_cache",
       (double)with_cache.model.near_relative_thickness}};
  option_command c = command;
  c.values = values;
  c.value_count = sizeof values / sizeof *values;
  options_help(&c, &defaults);
}

/* `--far none` also sets --environment none, and is rejected with another
 * environment. */
static int apply_far(process_settings *s, image_error *error) {
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

/* What the rows of the options don't say. */
static int check(const process_settings *s, image_error *error) {
  if (s->exact)
    return 0;
  if (s->layers >> LAYER_GLOSSY & 1 && s->far > HBIL_CACHE_METHOD_RAYS &&
      !settings_without_cache(s))
    return image_fail(
        error, "--layers glossy: not with --far cones, lpv or rsm, which "
               "know no reflected light; one or the other is needed");
  if (s->far == HBIL_CACHE_METHOD_RSM && !s->light_view_count)
    return image_fail(error, "--far rsm: --light-view FILE is needed with it");
  if (s->light_view_count > HBIL_MAX_LIGHT_VIEWS)
    return image_fail(error, "--light-view: %u files; %d at most can be used",
                      s->light_view_count, HBIL_MAX_LIGHT_VIEWS);
  if (s->config.sampling.slices > SLICES_MOST)
    return image_fail(error,
                      "--slices %u: a whole number from 1 to %d, or --quality "
                      "reference, is needed",
                      (unsigned)s->config.sampling.slices, SLICES_MOST);
  return 0;
}

#define GIVEN(field)                                                           \
  given.member[offsetof(process_arguments, settings.config.field)]
_Static_assert(offsetof(process_arguments, settings.source) == 0 &&
                   sizeof(process_arguments) < OPTION_ARGUMENTS,
               "see source_rows and options.h");

int process_arguments_read(int argc, char **argv, process_arguments *out,
                           image_error *error) {
  process_settings *s = &out->settings;
  options_given given;
  set_defaults(out);
  const int read = options_read(&command, argc, argv, out, &given, error);
  if (read != 0)
    return read;
  s->emission_given = GIVEN(model.gather_emission);
  s->radius_given = GIVEN(model.radius);
  s->thickness_given = GIVEN(model.relative_thickness);
  s->timings |= s->json;
  s->views = out->views.files;
  s->view_count = (unsigned)out->views.count;
  s->light_views = out->light_views.files;
  s->light_view_count = (unsigned)out->light_views.count;
  out->files = argv + optind;
  out->count = argc - optind;
  return apply_far(s, error) != 0 || check(s, error) != 0 ? -1 : 0;
}

void process_arguments_free(process_arguments *a) {
  frame_list_free(&a->views);
  frame_list_free(&a->light_views);
  a->settings.views = NULL;
  a->settings.light_views = NULL;
  a->settings.view_count = 0;
}
