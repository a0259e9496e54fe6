/* Does a job from its settings to the last file. */
#ifndef HBIL_TOOL_PROCESS_H
#define HBIL_TOOL_PROCESS_H

#include "tool/settings.h"

/* Computes the frames in order and writes the results.  Prints errors itself.
 * Returns the exit status. */
int process_run(const process_settings *settings, char *const *files,
                int count);

#endif
