/* The options that say how dumps are to be read. */
#include "tool/source_arguments.h"

#include "dump/source.h"
#include "image/error.h"

#include <stdio.h>
#include <string.h>

static int set_source(const char *text, void *arguments, image_error *error) {
  source_options *o = arguments;
  (void)text, (void)error;
  if (o->source == DUMP_KINDS) /* auto */
    o->source = -1;
  return 0;
}

/* A space, "encoded", or both; or "from-depth". */
static int set_normals(const char *text, void *arguments, image_error *error) {
  static const char *const words[] = {"world", "camera", "encoded",
                                      "from-depth", NULL};
  source_options *out = arguments;
  char word[16];
  for (const char *next = text;; next++) {
    const size_t length = strcspn(next, ",");
    int value;
    snprintf(word, sizeof word, "%.*s", length < 15 ? (int)length : 15, next);
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
    next += length;
    if (!*next)
      return 0;
  }
}

static int set_flips(const char *text, void *arguments, image_error *error) {
  source_options *out = arguments;
  for (const char *axis = text; *axis; axis++) {
    if (*axis >= 'x' && *axis <= 'z')
      out->flips |= 1u << (*axis - 'x');
    else if (*axis != ',')
      return image_fail(error, "--flip %s: some of x, y, z are needed", text);
  }
  return 0;
}

static int check_clip(const char *text, void *arguments, image_error *error) {
  const source_options *o = arguments;
  return o->clip[0] >= 0.0f && o->clip[1] > o->clip[0]
             ? 0
             : image_fail(
                   error,
                   "--clip %s: NEAR,FAR are needed, with 0 <= NEAR < FAR",
                   text);
}

static int check_fov(const char *text, void *arguments, image_error *error) {
  const source_options *o = arguments;
  return o->fov < 180.0f
             ? 0
             : image_fail(error,
                          "--fov %s: the angle across the picture's width is "
                          "needed, below 180 degrees",
                          text);
}

static const char *const colours[] = {"linear", "srgb", NULL};

#define AT(field) offsetof(source_options, field)
#define ROW_ABOVE_0(option, offset, text)                                      \
  .name = option, .kind = OPTION_ABOVE, .member = offset, .high = 1,           \
  .value = text

const option_row source_rows[SOURCE_ROWS] = {
    {ROW_CHOICE("source", AT(source), source_words), .set = set_source,
     .help = "names and meanings of the channels (auto)"},
    {ROW_TEXT("map", AT(map), "ROLE=[FILE:]LAYER,..."),
     .help =
         "layer or channel of a role: depth, normal, albedo, direct, emission, "
         "background, motion, position, indirect, coverage, picture, alpha.  "
         "FILE (EXR, TIFF, PNG, HDR) lies beside FRAME; # stands for FRAME's "
         "number.  ROLE= leaves the role out; ROLE=C1,C2,C3 takes single "
         "channels"},
    {ROW_TEXT("view-layer", AT(view_layer), "NAME"),
     .help = "which of several view layers in one file (the one with the most "
             "passes)"},
    {ROW_TEXT("eye", AT(eye), "NAME"),
     .help = "which eye of a multi-view file, such as left (the first); its "
             "camera is FRAME.NAME.json, or else FRAME.json"},
    {ROW_TEXT("exposure", AT(exposure), "ATTRIBUTE"),
     .help = "the number in each frame's header by which its light has been "
             "multiplied; results have the same factor (`exposure` of the "
             "camera file, or else none)"},
    {ROW_CHOICE("depth", AT(depth), depth_words),
     .help = "distance along the camera's axis, distance from the eye, "
             "computed from positions, 0..1, 1..0 (the last two with --clip)"},
    {ROW_OTHER("normals", AT(normals), set_normals,
               "world|camera|encoded|from-depth"),
     .help =
         "space (camera: y up, z backwards); encoded: stored as (n+1)/2; two "
         "words with a comma; from-depth: none are read, they are rebuilt"},
    {ROW_CHOICE("positions", AT(positions), space_words),
     .help = "their space"},
    {ROW_CHOICE("direct", AT(direct), direct_words),
     .help = "direct light is E, E/pi or E albedo/pi"},
    {ROW_CHOICE("colours", AT(gamma), colours),
     .help = "encoding of colours in files of integers and of albedo in any "
             "file; light in floats is linear (as the file says, or sRGB for "
             "8 bits and else linear)"},
    {ROW_OTHER("flip", AT(flips), set_flips, "x,y,z"),
     .help = "change the sign of these axes of normals and positions"},
    {ROW_ABOVE_0("unit-scale", AT(unit), "F"), .library = "inputs.depth_scale",
     .help = "camera units in a unit of depth and position (1)"},
    {ROW_FLOATS("sky-depth", AT(sky_depth), 1, "VALUE"),
     .library = "inputs.sky_depth",
     .help = "depths from VALUE on are sky; a depth of 0 always is"},
    {ROW_FLOATS("clip", AT(clip), 2, "NEAR,FAR"), .set = check_clip,
     .help = "clipping planes"},
    {ROW_ABOVE_0("fov", AT(fov), "DEGREES"), .set = check_fov,
     .help = "angle across the picture's width, in place of the camera's; "
             "also for frames without a camera whose normals are in camera "
             "space",
     .relations = {NOT_WITH(AT(orthographic), 0, "whose rays are parallel")}},
    {ROW_ABOVE_0("orthographic", AT(orthographic), "WIDTH"),
     .help =
         "the same for parallel rays: camera units across the picture's width"},
    {ROW_FLOATS("motion-scale", AT(motion_scale), 2, "X,Y"),
     .library = "inputs.motion_scale",
     .help = "pixels, right and down, in a unit of motion towards the previous "
             "frame"},
};
