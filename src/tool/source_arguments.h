/* The options that say how dumps are to be read. */
#ifndef HBIL_TOOL_SOURCE_ARGUMENTS_H
#define HBIL_TOOL_SOURCE_ARGUMENTS_H

#include "tool/options.h"

enum { SOURCE_ROWS = 16 };

/* Their members are those of source_options. */
extern const option_row source_rows[SOURCE_ROWS];

/* These rows as a group of a command's options.  options: the offset of the
 * source_options in its arguments. */
#define SOURCE_GROUP(options)                                                  \
  {                                                                            \
    .heading = "Where frames come from; what isn't said is guessed (hbil "     \
               "info tells)",                                                  \
    .rows = source_rows, .count = SOURCE_ROWS, .base = options                 \
  }

#endif
