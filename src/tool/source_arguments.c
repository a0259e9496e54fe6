/* The options that say how dumps are to be read. */
#include "tool/source_arguments.h"

#include "image/error.h"
#include "tool/options.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define ROW(name, value)                                                       \
  { name, required_argument, NULL, value }

const struct option source_option_rows[SOURCE_OPTION_COUNT] = {
    ROW("source", SOURCE_OPTION),
    ROW("map", SOURCE_MAP),
    ROW("view-layer", SOURCE_VIEW_LAYER),
    ROW("eye", SOURCE_EYE),
    ROW("depth", SOURCE_DEPTH),
    ROW("normals", SOURCE_NORMALS),
    ROW("positions", SOURCE_POSITIONS),
    ROW("direct", SOURCE_DIRECT),
    ROW("colours", SOURCE_COLOURS),
    ROW("flip", SOURCE_FLIP),
    ROW("unit-scale", SOURCE_UNIT),
    ROW("sky-depth", SOURCE_SKY_DEPTH),
    ROW("clip", SOURCE_CLIP),
    ROW("fov", SOURCE_FOV),
    ROW("orthographic", SOURCE_ORTHOGRAPHIC),
    ROW("motion-scale", SOURCE_MOTION),
};

static const char *const colour_words[] = {"linear", "srgb", NULL};

/* A space, "encoded", or both; or "from-depth". */
static int read_normals(const char *text, source_options *out,
                        image_error *error) {
  static const char *const words[] = {"world", "camera", "encoded",
                                      "from-depth", NULL};
  char word[16];
  for (const char *at = text;; at++) {
    const size_t length = strcspn(at, ",");
    int value;
    snprintf(word, sizeof word, "%.*s", length < 15 ? (int)length : 15, at);
    if (option_choice("--normals", word, words, &value, error) != 0)
      return -1;
    if (value == 3)
      out->from_depth = 1;
    else if (value == 2)
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

/* `count` finite numbers above a bound. */
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
  return image_fail(
      error, "--clip %s: NEAR,FAR are needed, with 0 <= NEAR < FAR", text);
}

static int check_lens(const source_options *o, image_error *error) {
  return o->fov > 0.0f && o->orthographic > 0.0f
             ? image_fail(
                   error,
                   "--fov and --orthographic: one of both is needed; they "
                   "exclude each other")
             : 0;
}

static int read_fov(const char *text, source_options *out, image_error *error) {
  if (read_above("--fov", text, 0.0f, &out->fov, 1, error) != 0)
    return -1;
  if (out->fov < 180.0f)
    return check_lens(out, error);
  return image_fail(error,
                    "--fov %s: the angle across the picture's width is needed, "
                    "below 180 degrees",
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
  case SOURCE_VIEW_LAYER:
    out->view_layer = text;
    return 0;
  case SOURCE_EYE:
    out->eye = text;
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
  case SOURCE_SKY_DEPTH:
    return option_floats("--sky-depth", text, &out->sky_depth, 1, error);
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
       "auto|blender|pbrt|mitsuba|luxcore|arnold|vray|renderman|unreal|"
       "generic\n"
       "                        names and meanings of the channels (auto)\n"
       "  --map ROLE=[FILE:]LAYER,...\n"
       "                        layer or channel of a role: depth, normal,\n"
       "                        albedo, direct, emission, background, motion,\n"
       "                        position, indirect, coverage.  FILE (EXR,\n"
       "                        TIFF, PNG, HDR) lies beside FRAME; # stands\n"
       "                        for FRAME's number.  ROLE= leaves the role\n"
       "                        out; ROLE=C1,C2,C3 takes single channels\n"
       "  --view-layer NAME     which of several view layers in one file (the "
       "one\n"
       "                        with the most passes)\n"
       "  --eye NAME            which eye of a multi-view file, such as left "
       "(the\n"
       "                        first); its camera is FRAME.NAME.json, or "
       "else\n"
       "                        FRAME.json\n"
       "  --depth planar|ray|position|device|reversed\n"
       "                        distance along the camera's axis, distance "
       "from\n"
       "                        the eye, computed from positions, 0..1, 1..0\n"
       "                        (the last two with --clip)\n"
       "  --normals world|camera|encoded|from-depth\n"
       "                        space (camera: y up, z backwards); encoded:\n"
       "                        stored as (n+1)/2; two words with a comma;\n"
       "                        from-depth: none are read, they are rebuilt\n"
       "  --positions world|camera\n"
       "                        their space\n"
       "  --direct irradiance|light|radiance\n"
       "                        direct light is E, E/pi or E albedo/pi\n"
       "  --colours linear|srgb\n"
       "                        encoding of albedo, direct, emission and\n"
       "                        background (as their file says, or linear)");
  puts("  --flip x,y,z          change the sign of these axes of normals and\n"
       "                        positions\n"
       "  --unit-scale F        camera units in a unit of depth and position "
       "(1)\n"
       "  --sky-depth VALUE     depths from VALUE on are sky; a depth of 0\n"
       "                        always is\n"
       "  --clip NEAR,FAR       clipping planes\n"
       "  --fov DEGREES         angle across the picture's width; also for\n"
       "                        frames without a camera whose normals are in\n"
       "                        camera space\n"
       "  --orthographic WIDTH  the same for parallel rays: camera units "
       "across\n"
       "                        the picture's width\n"
       "  --motion-scale X,Y    pixels, right and down, in a unit of motion\n"
       "                        towards the previous frame");
}
