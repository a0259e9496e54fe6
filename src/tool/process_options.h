/* The options of `hbil process`. */
#ifndef HBIL_TOOL_PROCESS_OPTIONS_H
#define HBIL_TOOL_PROCESS_OPTIONS_H

#include "tool/options.h"

enum { PROCESS_GROUPS = 5 };

/* Their members are those of process_arguments. */
extern const option_group process_groups[PROCESS_GROUPS];

/* The option whose member the library's message begins with, without dashes;
 * NULL: there is none. */
const char *process_option_of(const char *message);

#endif
