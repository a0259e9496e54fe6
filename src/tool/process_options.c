/* The options of `hbil process`. */
#include "tool/process_options.h"

#include "image/exr_style.h"
#include "tool/layers.h"
#include "tool/settings.h"
#include "tool/process_arguments.h"
#include "tool/source_arguments.h"

#include <string.h>

/* The most slices that the exact integral takes, and its default. */
enum { SLICES_MOST_EXACT = 4096, SLICES_EXACT = 256 };

#define AT(field) offsetof(process_arguments, field)
#define SETTING(field) AT(settings.field)
/* of hbil_config; the library has the same name for it */
#define CONFIG(field) SETTING(config.field), .library = #field

/* What the exact integral doesn't use. */
#define NOT_EXACT(why) NOT_WITH(AT(quality), 1u << HBIL_QUALITY_REFERENCE, why)
#define EVERY_PIXEL NOT_EXACT("which looks at every pixel")

/* What has no light, and what is about the radiance cache. */
#define MODE SETTING(config.model.mode)
#define DARK_MODES (1u << HBIL_MODE_GTAO | 1u << HBIL_MODE_HBAO)
#define OF_CACHE                                                               \
  NOT_EXACT("which has no radiance cache"),                                    \
      NOT_WITH(SETTING(far), 1u << FAR_IS_ENVIRONMENT | 1u << FAR_IS_NONE,     \
               "which leaves the radiance cache out"),                         \
      NOT_WITH(MODE, DARK_MODES,                                               \
               "which looks at no light and has no radiance cache")

/* ------------------------------------------------------------------------ */
/* What is more than a value                                                 */

static int set_layers(const char *text, void *arguments, image_error *error) {
  process_arguments *a = arguments;
  return layers_parse(text, &a->settings.layers, error);
}

static int add_view(const char *text, void *arguments, image_error *error) {
  return frame_list_add(text, &((process_arguments *)arguments)->views, error);
}

static int add_light_view(const char *text, void *arguments,
                          image_error *error) {
  process_arguments *a = arguments;
  return frame_list_add(text, &a->light_views, error);
}

static int set_quality(const char *text, void *arguments, image_error *error) {
  process_arguments *a = arguments;
  hbil_sampling *sampling = &a->settings.config.sampling;
  (void)text, (void)error;
  a->settings.exact = a->quality == HBIL_QUALITY_REFERENCE;
  hbil_sampling_set(sampling, a->quality);
  if (a->settings.exact)
    sampling->slices = SLICES_EXACT;
  return 0;
}

/* The paper has no far light. */
static int set_model(const char *text, void *arguments, image_error *error) {
  process_arguments *a = arguments;
  process_settings *s = &a->settings;
  (void)text, (void)error;
  model_set(&s->config, a->model);
  s->warm_up = model_warm_up(a->model);
  s->paper = a->model == HBIL_MODEL_PAPER;
  s->environment = s->paper ? "none" : NULL;
  return 0;
}

static int set_voxels(const char *text, void *arguments, image_error *error) {
  process_settings *s = &((process_arguments *)arguments)->settings;
  (void)text, (void)error;
  s->cache_voxels = 16u << s->cache_voxels; /* was an index */
  return 0;
}

static const char *const no_yes[] = {"no", "yes", NULL};
static const char *const view_lights[] = {"direct", "radiance", NULL};
static const char *const cache_sizes[] = {"16", "32", "64", "128", "256", NULL};
/* The methods, in the enum's order, then what there is without a cache. */
static const char *const far_words[] = {"rays",        "cones", "lpv", "rsm",
                                        "environment", "none",  NULL};
static const char *const qualities[] = {"fast", "balanced", "high", "reference",
                                        NULL};
static const char *const sample_grids[] = {"same-layer", "full-resolution",
                                           NULL};
static const char *const resolutions[] = {"auto", "full", "half", NULL};
static const char *const precisions[] = {"auto", "half", "float", NULL};
static const char *const beauties[] = {"auto", "replace", "diffuse", NULL};
static const char *const storages[] = {"packed", "float32", NULL};
static const char *const fallbacks[] = {"last-accepted", "black", "frame-mean",
                                        NULL};
static const char *const reprojections[] = {"none", "camera", "motion", NULL};

/* ------------------------------------------------------------------------ */
/* The rows                                                                  */

static const option_row job_rows[] = {
    {ROW_TEXT("output", SETTING(output), "DIR"), .letter = 'o',
     .help = "folder of the results; it is made if it is missing"},
    {ROW_TEXT("frames", AT(frames), "RANGES"),
     .help = "numbers for the patterns, such as 1-240x2,300 (all that exist)"},
    {ROW_NUMBER("pre-roll", SETTING(pre_roll), 0, 100000, "N"),
     .help = "light as many as N frames before the first of --frames, for the "
             "light that they hand on, and write none of them: for chunks of a "
             "sequence ({})",
     .relations = {NEEDS(AT(frames), 0, " with the frames that are written")}},
    {ROW_TEXT("decide-by", SETTING(decide_by), "FRAME.exr"),
     .help = "the frame whose pixels decide what no option says (far light, "
             "emission, kinds of depth and normals): the same one for all "
             "chunks (the first frame)"},
    {ROW_OTHER("layers", SETTING(layers), set_layers, "LIST"),
     .library = "outputs",
     .help = "of near_irradiance, far_irradiance, indirect, ao, bent_normal, "
             "cone_cosine, beauty, unknown, glossy, error_estimate (all that "
             "the mode has, without the last three)"},
    {ROW_CHOICE("beauty", SETTING(beauty), beauties),
     .help = "what beauty is.  diffuse: diffuse light and emission.  replace: "
             "the frame's own picture (Blender's Combined, with its alpha), "
             "with hbil's light in place of its diffuse indirect light, so "
             "that glass, gloss and smoke stay; auto: replace if all frames "
             "have the picture, its diffuse indirect light and albedo ({})"},
    {ROW_FLOATS("crop", SETTING(crop), 4, "X,Y,W,H"),
     .help = "write this part of the picture alone; what lies around it takes "
             "part in the search, as pixels beyond a display window do"},
    {ROW_FLAG("copy-channels", SETTING(copy_channels)),
     .help = "also put the frame's own channels into its result"},
    {ROW_CHOICE("compression", SETTING(compression), exr_compressions),
     .value = "NAME",
     .help = "none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, dwab, or "
             "input for that of the frame ({}, which is written fastest)"},
    {ROW_CHOICE("precision", SETTING(precision), precisions),
     .help = "layers as 32-bit floats or as half floats, which take half the "
             "space; auto: half if the colours of the first frame are half "
             "floats ({})"},
    {ROW_TEXT("camera", SETTING(camera), "FILE"),
     .help = "JSON camera of all frames (FRAME.json beside each FRAME.exr, or "
             "else the header's, or else one that fits the positions, as "
             "`positions` in place of FILE)"},
    {ROW_TEXT("environment", SETTING(environment), "R,G,B"),
     .library = "environment model.far_field",
     .help = "far light, the same from everywhere"},
    {ROW_MORE("environment", "FILE"),
     .help = "far light, a latitude-longitude map"},
    {ROW_MORE("environment", "none|frame"),
     .help = "no far light, or the mean radiance of the frame's own surfaces "
             "(chosen by sky, light and surfaces of the first frame, of "
             "views and of frames that --learn reads)"},
    {ROW_TEXT("device", SETTING(device), "NAME"),
     .help = "index or part of a name, see hbil devices (the first GPU, or "
             "else the first device)",
     .relations = {NOT_EXACT("which runs on the CPUs without OpenCL")}},
    {ROW_FLAG("overwrite", SETTING(overwrite)),
     .help = "replace files that exist already, but none that the job reads; "
             "without it they are an error"},
    {ROW_FLAG("resume", SETTING(resume)),
     .help = "continue an interrupted job: results in DIR that were made from "
             "the same frames, settings, device and version stay; the others "
             "get the same bits as without the interruption.  Replaces only "
             "files that hbil wrote",
     .relations =
         {NOT_WITH(SETTING(timings), 0, "which needs every frame to run"),
          NOT_WITH(SETTING(json), 0, "which needs every frame to run"),
          NOT_WITH(SETTING(overwrite), 0,
                   "which replaces the results that --resume leaves")}},
    {ROW_FLAG("dry-run", SETTING(dry_run)),
     .help =
         "check everything, print what would be written, and write nothing"},
    {ROW_NUMBER("repeat", SETTING(repeat), 1, 100000, "N"),
     .help = "run every frame N times, for more bounces ({})"},
    {ROW_NUMBER("warm-up", SETTING(warm_up), 0, 1000, "N"),
     .help = "run the first frame N more times ({})"},
    {ROW_FLAG("preview", SETTING(preview)),
     .help = "also write DIR/FRAME.LAYER.png"},
    {ROW_TEXT("contact-sheet", SETTING(contact_sheet), "PNG"),
     .help = "layers side by side, with at most eight frames of the sequence "
             "below each other, and what the radiance cache knows; replaces "
             "only pictures that hbil wrote"},
    {ROW_FLAG("timings", SETTING(timings)),
     .help = "print milliseconds per pass and frame (of the last run of each "
             "frame), what was skipped, and where the time of the whole job "
             "went.  A CPU device shares its cores with reading and writing "
             "(hbil-bench measures passes alone)",
     .relations = {NOT_EXACT("which has no passes on a device")}},
    {ROW_FLAG("json", SETTING(json)), .help = "print the timings as JSON",
     .relations = {NOT_EXACT("which has no timings")}},
    {ROW_FLAG("quiet", SETTING(quiet)),
     .help = "print no line per frame and no progress"},
};

static const option_row cache_rows[] = {
    {ROW_OTHER("view", AT(views), add_view, "FILE.exr"),
     .help = "a picture of the same place, with depth, normals, direct light "
             "and a camera of its own, of any size and projection, by the "
             "renderer of the frames.  The cache sees it before the first "
             "frame.  FILE.exr may be a pattern, or have wildcards "
             "('views/*.exr'); the option may be given again",
     .relations = {OF_CACHE}},
    {ROW_FLAG("learn", SETTING(learn)),
     .help =
         "the cache sees all frames, the last one first, before the first one "
         "is lit, and each again in its turn, so each is lit by all; without "
         "it, by those before it.  Reads every frame twice",
     .relations = {OF_CACHE}},
    {ROW_TEXT("cuts", SETTING(cuts), "N,..."),
     .help = "numbers of the frames with which another place begins, or none. "
             "Each place is a job of its own, with its own radiance cache and "
             "its own choice of light.  By default cuts are found where the "
             "camera leaps so far that one cache would be too coarse for both "
             "sides; but not with views, --cache-load, --cache-save or "
             "--decide-by, which tell of one place",
     .relations = {NOT_EXACT("which knows one place"),
                   NOT_WITH(SETTING(cache_load), 0, "which is of one place"),
                   NOT_WITH(SETTING(cache_save), 0, "which is of one place"),
                   NOT_WITH(SETTING(decide_by), 0,
                            "by which chunks of one place agree")}},
    {ROW_TEXT("cache-load", SETTING(cache_load), "FILE"),
     .help = "begin with the cache in a file of --cache-save, which also says "
             "its size and place",
     .relations = {OF_CACHE}},
    {ROW_FLAG("cache-fixed", SETTING(cache_fixed)),
     .help = "the frames don't change the loaded cache, so that each is lit by "
             "it alone, whatever came before",
     .relations = {OF_CACHE, NEEDS(SETTING(cache_load), 0, " FILE"),
                   NOT_WITH(SETTING(learn), 0,
                            "by which the cache sees the frames")}},
    {ROW_TEXT("cache-save", SETTING(cache_save), "FILE"),
     .help = "write the cache to a file at the end; replaces only caches",
     .relations = {OF_CACHE}},
    {ROW_CHOICE("far", SETTING(far), far_words), .low = HBIL_CACHE_METHOD_RAYS,
     .high = FAR_IS_ENVIRONMENT, .library = "model.cache_method",
     .help = "where light from beyond the near field comes from.  From the "
             "cache: by rays (the default and the most accurate), by cones, or "
             "by light propagation volumes.  In place of the cache: from "
             "reflective shadow maps, which are the views of lights.  Without "
             "either: as --environment says, or none at all",
     .relations = {OF_CACHE}},
    {ROW_OTHER("light-view", AT(light_views), add_light_view, "FILE.exr"),
     .help =
         "with --far rsm: a picture as for --view, from where a light is, with "
         "the direct light of that light alone; up to four, or a pattern",
     .relations = {OF_CACHE,
                   NEEDS(SETTING(far), 1u << HBIL_CACHE_METHOD_RSM, "")}},
    {ROW_CHOICE("view-light", SETTING(view_light), view_lights),
     .help = "what views hold: direct light, to which the cache adds the "
             "bounces, or also indirect light (Blender's DiffInd), which is "
             "the radiance of surfaces after all bounces ({})",
     .relations = {OF_CACHE, NEEDS(AT(views), 0, " FILE")}},
    {ROW_CHOICE("cache-size", SETTING(cache_voxels), cache_sizes), .value = "N",
     .set = set_voxels, .library = "voxels",
     .help = "voxels across each of its {levels} levels, 16, 32, 64, 128 or "
             "256; twice as many take eight times the memory ({voxels})",
     .relations = {OF_CACHE,
                   NOT_WITH(SETTING(cache_load), 0, "whose file has a size")}},
};

static const option_row sampling_rows[] = {
    {ROW_CHOICE("quality", AT(quality), qualities),
     .value = "fast|balanced|high", .set = set_quality,
     .help = "sets slices, steps per side, step growth, resolution, sample "
             "grid, filter and storage; options behind it overrule it"},
    {ROW_MORE("quality", "reference"),
     .help = "the exact screen-space integral of the same model, in double "
             "precision, on all CPUs and without OpenCL: looks at every pixel "
             "that a slice crosses, with --slices 1..4096 (256).  Takes "
             "minutes to hours; compare with it to see the sampling error"},
    {ROW_NUMBER("slices", CONFIG(sampling.slices), 1, SLICES_MOST_EXACT, "N"),
     .help = "slices per pixel, 1..32 ({})"},
    {ROW_NUMBER("slice-frames", CONFIG(sampling.slice_frames), 0, 4, "N"),
     .help = "search 1/N of the slices in each frame and take the others from "
             "the frames before, which is faster; --slices is a multiple of N, "
             "1..4 (2 if --slices is even and light is carried over, else 1)",
     .relations = {NOT_EXACT("which takes all from one frame")}},
    {ROW_NUMBER("steps-per-side", CONFIG(sampling.steps_per_side), 1, 256, "N"),
     .help = "samples on each side of a slice, 1..256 ({})",
     .relations = {EVERY_PIXEL}},
    {ROW_FLOATS("step-growth", CONFIG(sampling.step_growth), 1, "G"),
     .help = "0: equal steps; otherwise the last step is (1+G)^2 times the "
             "first ({})",
     .relations = {EVERY_PIXEL}},
    {ROW_CHOICE("sample-grid", CONFIG(sampling.sample_grid), sample_grids),
     .value = "full-resolution", /* `same-layer` is worse in the same time */
     .help = "where samples may lie: at any pixel ({})",
     .relations = {EVERY_PIXEL}},
    {ROW_CHOICE("resolution", CONFIG(sampling.resolution), resolutions),
     .help = "pixels that are computed: all, or every second one in x and y, "
             "and the others are filled in from neighbours on the same "
             "surface; auto: half for pictures of 400000 pixels and more ({})",
     .relations = {NOT_EXACT("which computes every pixel")}},
    {ROW_CHOICE("extrapolate", CONFIG(model.extrapolate), no_yes),
     .help = "find what lies between the samples of occluders that have a "
             "thickness ({})",
     .relations = {EVERY_PIXEL}},
    {.name = "no-skip",
     .kind = OPTION_CLEAR,
     .member = CONFIG(execution.skip),
     .help = "do all work, even if it cannot change the result, but for "
             "roundings after 32 runs of the same frame (see --timings)",
     .relations = {NOT_EXACT("which skips nothing")}},
    {ROW_CHOICE("storage", CONFIG(sampling.storage), storages),
     .help = "precision of the planes between the passes ({})",
     .relations = {NOT_EXACT("which stores double precision")}},
    {ROW_FLAG("unfiltered", CONFIG(sampling.unfiltered)),
     .help = "only undo the 4x4 interleaving, without the filter; not with "
             "--resolution half; auto is full then",
     .relations = {NOT_EXACT("which filters nothing"),
                   NOT_WITH(SETTING(config.sampling.resolution),
                            1u << HBIL_RESOLUTION_HALF,
                            "where the filter fills in the other pixels")}},
};

static const option_row model_rows[] = {
    {ROW_CHOICE("model", AT(model), model_words), .set = set_model,
     .help = "everything below that isn't given: hbil's own model, or that of "
             "the paper (Mayaux 2018): infinite thickness, facing fade -0.1,0, "
             "the last accepted sample's light in place of back-facing ones, "
             "no far light, radiance as feedback, no extrapolation, 2 slices, "
             "8 steps per side, full resolution, no warm-up; options behind it "
             "overrule it ({})"},
    {ROW_CHOICE("mode", CONFIG(model.mode), mode_words),
     .help = "near light and occlusion; cosine-weighted occlusion and bent "
             "normal (all layers but near_irradiance); uniform occlusion with "
             "falloff (ao, far_irradiance, indirect, beauty) ({})"},
    {ROW_CHOICE("falloff", CONFIG(model.falloff), falloff_words),
     .help = "weight of an occluder at distance r within radius R, for hbao: "
             "1-r/R, 1-r/(3R), 1 ({})",
     .relations = {NEEDS(SETTING(config.model.mode), 1u << HBIL_MODE_HBAO,
                         "")}},
    {ROW_FLOATS("radius", CONFIG(model.radius), 1, "R"),
     .help = "of the near field, world units or inf: farther surfaces send no "
             "near light and block no far light ({}; with a radiance cache, "
             "{near_voxels} of its voxels)"},
    {ROW_FLOATS("ao-radius", CONFIG(model.ao_radius), 1, "R"),
     .help = "of the occluders in the layers ao, bent_normal and cone_cosine, "
             "world units or inf; hbao has --radius in its place ({})",
     .relations = {NOT_WITH(SETTING(config.model.mode), 1u << HBIL_MODE_HBAO,
                            "whose --radius it is")}},
    {ROW_FLOATS("thickness", CONFIG(model.thickness), 1, "T"),
     .help = "of occluders, world units ({})"},
    {ROW_FLOATS("relative-thickness", CONFIG(model.relative_thickness), 1, "T"),
     .help =
         "the same as a share of their depth, or of an orthographic picture's "
         "width ({}; with a radiance cache, that of near light is "
         "{thickness_with_cache})"},
    {ROW_FLOATS("facing-fade", CONFIG(model.facing_fade), 2, "A,B"),
     .help = "cosines between which the light of a sample fades in ({})"},
    {ROW_CHOICE("back-facing-fallback", CONFIG(model.back_facing_fallback),
                fallbacks),
     .low = HBIL_FALLBACK_LAST_ACCEPTED,
     .help = "light of samples that face away: that of the last sample before, "
             "none, or the mean radiance of the frame ({})"},
    {ROW_FLOATS("offscreen-light", CONFIG(model.offscreen_light), 1, "SHARE"),
     .help = "radiance of surfaces outside the picture, over that of those in "
             "it, 0..1, where light is guessed from the frame ({})"},
    {ROW_FLOATS("roughness", CONFIG(model.roughness), 1, "R"),
     .help = "of the layer glossy, as Blender has it, 0.3..1 ({})"},
    {ROW_CHOICE("ao-bounces", CONFIG(model.ao_bounces), ao_bounces_words),
     .help =
         "what occluders reflect of far light, which is multiplied by F in "
         "place of the open share AO: nothing; the paper's F = AO (1 + (1 "
         "- AO)^.75 / 2); GTAO's fit with the surface's albedo.  For --mode "
         "gtao and hbao, because near light has these bounces ({})"},
    {ROW_CHOICE("gather-emission", CONFIG(model.gather_emission), no_yes),
     .help = "emission lights neighbours, too (yes if the first frame's direct "
             "light cannot contain what its lamps emit)"},
    {ROW_CHOICE("reprojection", SETTING(config.history.reprojection),
                reprojections),
     .library = "history.reprojection inputs.motion",
     .help = "how light is carried to the next frame: not at all, by the "
             "camera's movement, by motion vectors ({})"},
    {ROW_FLOATS("disocclusion-threshold",
                CONFIG(history.disocclusion_threshold), 1, "S"),
     .help = "drop carried light if its depth differs by more than this share "
             "of the depth, or of an orthographic picture's width ({})"},
};

#define GROUP(table) .rows = table, .count = sizeof table / sizeof *table

const option_group process_groups[PROCESS_GROUPS] = {
    {GROUP(job_rows)},
    {.about =
         "What the frames don't show: a radiance cache in world space holds "
         "what views of the place have shown, and lights the directions that a "
         "frame leaves open.  There is one if the camera moves between frames "
         "by more than 0.01 pixels, or its centre by a pixel, which jitter "
         "doesn't; the frames are then views for those behind them.  Or one of "
         "the first six options asks for it.  --model paper has one only if an "
         "option "
         "asks.  --far environment, --far none, --quality reference and modes "
         "other than hbil have none.",
     .heading = "Radiance cache",
     GROUP(cache_rows)},
    {.heading = "How well", GROUP(sampling_rows)},
    {.heading = "The method", GROUP(model_rows)},
    SOURCE_GROUP,
};

/* ------------------------------------------------------------------------ */
/* The library's names                                                       */

/* Whether a message begins with one of these members: behind its name comes an
 * index, a colon, or another name. */
static int begins_with(const char *message, const char *members) {
  for (const char *m = members; m && *m; m += strspn(m, " ")) {
    const size_t length = strcspn(m, " ");
    if (strncmp(message, m, length) == 0 && message[length] &&
        strchr("[:,.", message[length]))
      return 1;
    m += length;
  }
  return 0;
}

const char *process_option_of(const char *message) {
  for (size_t g = 0; g < PROCESS_GROUPS; g++)
    for (size_t i = 0; i < process_groups[g].count; i++)
      if (begins_with(message, process_groups[g].rows[i].library))
        return process_groups[g].rows[i].name;
  return NULL;
}
