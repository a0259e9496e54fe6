/* The options that say how dumps are to be read. */
#ifndef HBIL_TOOL_SOURCE_ARGUMENTS_H
#define HBIL_TOOL_SOURCE_ARGUMENTS_H

#include "dump/source.h"
#include "image/error.h"

#include <getopt.h>

/* Values of a getopt table for source_option(); they lie above the values that
 * the commands use for their own options. */
enum {
  SOURCE_OPTION = 512,
  SOURCE_MAP,
  SOURCE_VIEW_LAYER,
  SOURCE_EYE,
  SOURCE_DEPTH,
  SOURCE_NORMALS,
  SOURCE_POSITIONS,
  SOURCE_DIRECT,
  SOURCE_COLOURS,
  SOURCE_FLIP,
  SOURCE_UNIT,
  SOURCE_SKY_DEPTH,
  SOURCE_CLIP,
  SOURCE_FOV,
  SOURCE_ORTHOGRAPHIC,
  SOURCE_MOTION,
  SOURCE_END
};

enum { SOURCE_OPTION_COUNT = SOURCE_END - SOURCE_OPTION };

/* The rows of a getopt table. */
extern const struct option source_option_rows[SOURCE_OPTION_COUNT];

/* Reads the value of an option.  0, or -1 with `error` filled. */
int source_option(int option, const char *text, source_options *out,
                  image_error *error);

/* Prints these options' part of a help text. */
void source_usage(void);

#endif
