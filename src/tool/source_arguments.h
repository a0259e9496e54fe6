/* The options that say how dumps are to be read. */
#ifndef HBIL_TOOL_SOURCE_ARGUMENTS_H
#define HBIL_TOOL_SOURCE_ARGUMENTS_H

#include "tool/options.h"

enum { SOURCE_ROWS = 17 };

/* Their members are those of a source_options with which the arguments of the
 * command begin. */
extern const option_row source_rows[SOURCE_ROWS];

#define SOURCE_GROUP                                                           \
  {                                                                            \
    .heading = "Where frames come from; what isn't said is guessed (hbil "     \
               "info tells)",                                                  \
    .rows = source_rows, .count = SOURCE_ROWS                                  \
  }

#endif
