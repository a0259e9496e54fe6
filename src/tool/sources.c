/*
 * Whose dump it is: what programs call their channels and what they mean by
 * them, one row for each, and the options that overrule a row.
 *
 * A row is right for a program as it comes; what its own settings may change is
 * marked as unsure, and decided by the first frame's pixels (selfcheck.c).
 */
#include "tool/tool.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Behind any or no view layer: "ViewLayer.Depth.Z".  Names up to Blender 4
 * first, then those of Blender 5. */
static const pass_name cycles_passes[] = {
    {ROLE_DEPTH, "Depth"},    {ROLE_NORMAL, "Normal"},
    {ROLE_ALBEDO, "DiffCol"}, {ROLE_ALBEDO, "Diffuse Color"},
    {ROLE_DIRECT, "DiffDir"}, {ROLE_DIRECT, "Diffuse Direct"},
    {ROLE_EMISSION, "Emit"},  {ROLE_EMISSION, "Emission"},
    {ROLE_BACKGROUND, "Env"}, {ROLE_BACKGROUND, "Environment"},
    {ROLE_MOTION, "Vector"},  {ROLE_POSITION, "Position"},
    {ROLE_COUNT, NULL},
};

/* hbil's own first. */
static const pass_name plain_passes[] = {
    {ROLE_DEPTH, "depth"},       {ROLE_NORMAL, "normal"},
    {ROLE_ALBEDO, "albedo"},     {ROLE_DIRECT, "direct"},
    {ROLE_EMISSION, "emission"}, {ROLE_MOTION, "motion"},
    {ROLE_POSITION, "position"}, {ROLE_DEPTH, "Depth"},
    {ROLE_DEPTH, "Z"},           {ROLE_DEPTH, "z"},
    {ROLE_DEPTH, "zdepth"},      {ROLE_NORMAL, "Normal"},
    {ROLE_NORMAL, "normals"},    {ROLE_NORMAL, "Normals"},
    {ROLE_NORMAL, "N"},          {ROLE_NORMAL, "n"},
    {ROLE_ALBEDO, "Albedo"},     {ROLE_ALBEDO, "diffuse_albedo"},
    {ROLE_ALBEDO, "basecolor"},  {ROLE_ALBEDO, "BaseColor"},
    {ROLE_DIRECT, "Direct"},     {ROLE_EMISSION, "Emission"},
    {ROLE_EMISSION, "emissive"}, {ROLE_BACKGROUND, "background"},
    {ROLE_MOTION, "Motion"},     {ROLE_MOTION, "velocity"},
    {ROLE_POSITION, "Position"}, {ROLE_POSITION, "P"},
    {ROLE_COUNT, NULL},
};

/* Ns is the shading normal, N the geometry's. */
static const pass_name pbrt_passes[] = {
    {ROLE_POSITION, "P"}, {ROLE_NORMAL, "Ns"},     {ROLE_NORMAL, "N"},
    {ROLE_DEPTH, "P"},    {ROLE_ALBEDO, "Albedo"}, {ROLE_COUNT, NULL},
};

/* Users choose the names; these are those of its manual and usual ones. */
static const pass_name mitsuba_passes[] = {
    {ROLE_DEPTH, "*.T"},         {ROLE_NORMAL, "sh_normal"},
    {ROLE_NORMAL, "nn"},         {ROLE_NORMAL, "normal"},
    {ROLE_NORMAL, "normals"},    {ROLE_NORMAL, "n"},
    {ROLE_NORMAL, "geo_normal"}, {ROLE_POSITION, "position"},
    {ROLE_POSITION, "pos"},      {ROLE_POSITION, "pp"},
    {ROLE_POSITION, "p"},        {ROLE_ALBEDO, "albedo"},
    {ROLE_ALBEDO, "alb"},        {ROLE_COUNT, NULL},
};

static const pass_name arnold_passes[] = {
    {ROLE_DEPTH, "Z"},
    {ROLE_NORMAL, "N"},
    {ROLE_POSITION, "P"},
    {ROLE_ALBEDO, "diffuse_albedo"},
    {ROLE_ALBEDO, "albedo"},
    {ROLE_DIRECT, "diffuse_direct"},
    {ROLE_EMISSION, "emission"},
    {ROLE_BACKGROUND, "background"},
    {ROLE_MOTION, "motionvector"},
    {ROLE_COUNT, NULL},
};

static const pass_name vray_passes[] = {
    {ROLE_DEPTH, "VRayZDepth"},
    {ROLE_DEPTH, "zDepth"},
    {ROLE_DEPTH, "ZDepth"},
    {ROLE_DEPTH, "Z"},
    {ROLE_DEPTH, "depth"},
    {ROLE_NORMAL, "bump_normals"},
    {ROLE_NORMAL, "VRayBumpNormals"},
    {ROLE_NORMAL, "normals"},
    {ROLE_NORMAL, "VRayNormals"},
    {ROLE_ALBEDO, "diffuse"},
    {ROLE_ALBEDO, "VRayDiffuseFilter"},
    {ROLE_ALBEDO, "diffuseFilter"},
    {ROLE_DIRECT, "lighting"},
    {ROLE_DIRECT, "VRayLighting"},
    {ROLE_EMISSION, "selfIllum"},
    {ROLE_EMISSION, "VRaySelfIllumination"},
    {ROLE_BACKGROUND, "background"},
    {ROLE_BACKGROUND, "VRayBackground"},
    {ROLE_MOTION, "velocity"},
    {ROLE_MOTION, "VRayVelocity"},
    {ROLE_COUNT, NULL},
};

static const pass_name renderman_passes[] = {
    {ROLE_DEPTH, "z"},           {ROLE_DEPTH, "__depth"},
    {ROLE_NORMAL, "__Nworld"},   {ROLE_POSITION, "__Pworld"},
    {ROLE_ALBEDO, "albedo"},     {ROLE_DIRECT, "directDiffuse"},
    {ROLE_EMISSION, "emissive"}, {ROLE_MOTION, "motionBack"},
    {ROLE_COUNT, NULL},
};

static const pass_name unreal_passes[] = {
    {ROLE_DEPTH, "FinalImageMovieRenderQueue_WorldDepth"},
    {ROLE_NORMAL, "FinalImageMovieRenderQueue_WorldNormal"},
    {ROLE_NORMAL, "FinalImageMovieRenderQueue_Normal"},
    {ROLE_ALBEDO, "FinalImageMovieRenderQueue_BaseColor"},
    {ROLE_MOTION, "FinalImageMovieRenderQueue_MotionVectors"},
    {ROLE_COUNT, NULL},
};

static const char *const blender_marks[] = {"Blender", NULL};
static const char *const pbrt_marks[] = {"dzdx", "Ns.X", NULL};
static const char *const mitsuba_marks[] = {"Mitsuba", "sh_normal", NULL};
static const char *const arnold_marks[] = {"arnold", "Arnold", "motionvector",
                                           "diffuse_albedo", NULL};
static const char *const vray_marks[] = {"VRay", "V-Ray", "vray",
                                         "bump_normals", NULL};
static const char *const renderman_marks[] = {
    "RenderMan", "renderman", "__Nworld", "directDiffuse", NULL};
static const char *const unreal_marks[] = {"MovieRenderQueue", "unreal", NULL};

#define ALWAYS .unit = 1.0, .background = INFINITY
#define UNSURE_ALL (UNSURE_DEPTH | UNSURE_NORMALS | UNSURE_SKY)

const source_info source_table[DUMP_KINDS] = {
    [DUMP_PLAIN] = {"generic",
                    "hbil's own channels",
                    plain_passes,
                    NULL,
                    {ALWAYS, .motion_scale = {1, 1}, .unsure = UNSURE_ALL}},
    /* 1e10 where there is nothing; DiffDir is irradiance divided by pi;
     * Vector's y runs up */
    [DUMP_CYCLES] = {"blender",
                     "Blender Cycles passes",
                     cycles_passes,
                     blender_marks,
                     {.unit = 1.0,
                      .background = 1e9f,
                      .direct = DIRECT_LIGHT,
                      .motion_scale = {1, -1}}},
    [DUMP_PBRT] = {"pbrt",
                   "pbrt's gbuffer film",
                   pbrt_passes,
                   pbrt_marks,
                   {ALWAYS, .depth = DEPTH_POSITION, .normals = SPACE_CAMERA,
                    .positions = SPACE_CAMERA, .flips = 4}},
    [DUMP_MITSUBA] = {"mitsuba",
                      "Mitsuba's aov integrator",
                      mitsuba_passes,
                      mitsuba_marks,
                      {ALWAYS, .depth = DEPTH_RAY, .from_near = 1}},
    [DUMP_ARNOLD] = {"arnold",
                     "Arnold's AOVs",
                     arnold_passes,
                     arnold_marks,
                     {ALWAYS, .direct = DIRECT_RADIANCE,
                      .unsure = UNSURE_DEPTH | UNSURE_SKY}},
    [DUMP_VRAY] = {"vray",
                   "V-Ray's render elements",
                   vray_passes,
                   vray_marks,
                   {ALWAYS, .normals = SPACE_CAMERA, .direct = DIRECT_RADIANCE,
                    .unsure = UNSURE_SKY}},
    [DUMP_RENDERMAN] = {"renderman",
                        "RenderMan's AOVs",
                        renderman_passes,
                        renderman_marks,
                        {ALWAYS, .direct = DIRECT_RADIANCE,
                         .unsure = UNSURE_DEPTH | UNSURE_SKY}},
    [DUMP_UNREAL] = {"unreal",
                     "Unreal's Movie Render Queue",
                     unreal_passes,
                     unreal_marks,
                     {ALWAYS, .motion_zero = 0.5f,
                      .unsure = UNSURE_NORMALS | UNSURE_SKY}},
};

const char *const source_words[] = {
    "generic", "blender",   "pbrt",   "mitsuba", "arnold",
    "vray",    "renderman", "unreal", "auto",    NULL};
const char *const depth_words[] = {"planar", "ray",      "position",
                                   "device", "reversed", NULL};
static const char *const direct_words[] = {"irradiance", "light", "radiance",
                                           NULL};
static const char *const space_words[] = {"world", "camera", NULL};
static const char *const colour_words[] = {"linear", "srgb", NULL};

/* ------------------------------------------------------------------------ */
/* Options                                                                   */

void source_options_init(source_options *options) {
  memset(options, 0, sizeof *options);
  options->source = options->depth = options->normals = options->encoded =
      options->positions = options->direct = options->gamma = -1;
  options->background = NAN;
}

/* "world", "camera", "encoded" or one of the first two and the last. */
static int read_normals(const char *text, source_options *out,
                        image_error *error) {
  static const char *const words[] = {"world", "camera", "encoded", NULL};
  char word[16];
  for (const char *at = text;; at++) {
    const size_t length = strcspn(at, ",");
    int value;
    snprintf(word, sizeof word, "%.*s", length < 15 ? (int)length : 15, at);
    if (option_choice("--normals", word, words, &value, error) != 0)
      return -1;
    if (value == 2)
      out->encoded = 1;
    else {
      out->normals = value;
      out->encoded = out->encoded > 0;
    }
    at += length;
    if (!*at)
      return 0;
  }
}

static int read_flips(const char *text, source_options *out,
                      image_error *error) {
  for (const char *at = text; *at; at++) {
    if (*at >= 'x' && *at <= 'z')
      out->flips |= 1u << (*at - 'x');
    else if (*at != ',')
      return image_fail(error, "--flip %s: some of x, y, z are needed", text);
  }
  return 0;
}

/* So many numbers, all above a bound. */
static int read_above(const char *option, const char *text, float bound,
                      float *out, size_t count, image_error *error) {
  if (option_floats(option, text, out, count, error) != 0)
    return -1;
  for (size_t i = 0; i < count; i++)
    if (!(out[i] > bound) || isinf(out[i]))
      return image_fail(error, "%s %s: finite numbers above %g are needed",
                        option, text, (double)bound);
  return 0;
}

static int read_clip(const char *text, source_options *out,
                     image_error *error) {
  if (option_floats("--clip", text, out->clip, 2, error) != 0)
    return -1;
  if (out->clip[0] >= 0.0f && out->clip[1] > out->clip[0])
    return 0;
  return image_fail(error,
                    "--clip %s: NEAR,FAR, the first not below 0 and below the "
                    "second, are needed",
                    text);
}

/* One lens or the other. */
static int check_lens(const source_options *o, image_error *error) {
  return o->fov > 0.0f && o->orthographic > 0.0f
             ? image_fail(error, "--fov and --orthographic: one of both is "
                                 "needed")
             : 0;
}

static int read_fov(const char *text, source_options *out, image_error *error) {
  if (read_above("--fov", text, 0.0f, &out->fov, 1, error) != 0)
    return -1;
  if (out->fov < 180.0f)
    return check_lens(out, error);
  return image_fail(error,
                    "--fov %s: the angle across the picture's width, in "
                    "degrees below 180, is needed",
                    text);
}

static int read_orthographic(const char *text, source_options *out,
                             image_error *error) {
  return read_above("--orthographic", text, 0.0f, &out->orthographic, 1,
                    error) != 0
             ? -1
             : check_lens(out, error);
}

int source_option(int option, const char *text, source_options *out,
                  image_error *error) {
  switch (option) {
  case SOURCE_OPTION:
    if (option_choice("--source", text, source_words, &out->source, error))
      return -1;
    if (out->source == DUMP_KINDS)
      out->source = -1;
    return 0;
  case SOURCE_MAP:
    out->map = text;
    return 0;
  case SOURCE_DEPTH:
    return option_choice("--depth", text, depth_words, &out->depth, error);
  case SOURCE_NORMALS:
    return read_normals(text, out, error);
  case SOURCE_POSITIONS:
    return option_choice("--positions", text, space_words, &out->positions,
                         error);
  case SOURCE_DIRECT:
    return option_choice("--direct", text, direct_words, &out->direct, error);
  case SOURCE_COLOURS:
    return option_choice("--colours", text, colour_words, &out->gamma, error);
  case SOURCE_FLIP:
    return read_flips(text, out, error);
  case SOURCE_UNIT:
    return read_above("--unit-scale", text, 0.0f, &out->unit, 1, error);
  case SOURCE_BACKGROUND:
    return option_floats("--background", text, &out->background, 1, error);
  case SOURCE_CLIP:
    return read_clip(text, out, error);
  case SOURCE_FOV:
    return read_fov(text, out, error);
  case SOURCE_ORTHOGRAPHIC:
    return read_orthographic(text, out, error);
  default:
    return option_floats("--motion-scale", text, out->motion_scale, 2, error);
  }
}

void source_usage(void) {
  puts("\n"
       "Where frames come from; what isn't said is guessed (hbil info tells):\n"
       "  --source "
       "auto|blender|pbrt|mitsuba|arnold|vray|renderman|unreal|generic\n"
       "                        names and meanings of the channels (auto)\n"
       "  --map ROLE=[FILE:]LAYER,...\n"
       "                        depth, normal, albedo, direct, emission,\n"
       "                        background, motion, position: layer or "
       "channel.\n"
       "                        FILE (EXR, TIFF, PNG, HDR) lies beside FRAME; "
       "#\n"
       "                        stands for FRAME's number.  ROLE= leaves it "
       "out\n"
       "  --depth planar|ray|position|device|reversed\n"
       "                        along the camera's axis, from the eye, taken\n"
       "                        from positions, 0..1, 1..0 (both with --clip)\n"
       "  --normals world|camera|encoded\n"
       "                        space (camera: y up, z backwards); encoded:\n"
       "                        stored as (n+1)/2; two words with a comma\n"
       "  --positions world|camera\n"
       "                        their space\n"
       "  --direct irradiance|light|radiance\n"
       "                        direct light: E, E/pi, E albedo/pi\n"
       "  --colours linear|srgb\n"
       "                        of albedo, direct, emission, background (as\n"
       "                        their file says, else linear)\n"
       "  --flip x,y,z          turn these axes of normals and positions\n"
       "  --unit-scale F        camera units in a unit of depth and position "
       "(1)\n"
       "  --background VALUE    depths from VALUE on are sky, as all of 0 are\n"
       "  --clip NEAR,FAR       clipping planes\n"
       "  --fov DEGREES         across the picture's width; also without a\n"
       "                        camera file, for normals in camera space\n"
       "  --orthographic WIDTH  the same for parallel rays: camera units "
       "across\n"
       "                        the picture's width\n"
       "  --motion-scale X,Y    pixels, right and down, in a unit of motion\n"
       "                        towards the last frame");
}
