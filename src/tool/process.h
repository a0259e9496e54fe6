/* Does a job from its settings to the last file. */
#ifndef HBIL_TOOL_PROCESS_H
#define HBIL_TOOL_PROCESS_H

#include "image/error.h"
#include "tool/settings.h"

/* Computes the frames in order and writes the results.  Returns 0, or -1 with
 * `error` filled. */
int process_run(const process_settings *settings, char *const *files, int count,
                image_error *error);

#endif
