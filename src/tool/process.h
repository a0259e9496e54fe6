/* Does a job from its settings to the last file. */
#ifndef HBIL_TOOL_PROCESS_H
#define HBIL_TOOL_PROCESS_H

#include "image/error.h"
#include "tool/job.h"
#include "tool/settings.h"

/* ------------------------------------------------------------------------ */
/* Making a job from settings and files                                      */

/*
 * Everything that can be known to be wrong is looked for here, before the first
 * pixel is read: all headers, all cameras, the names of the results, the output
 * folder.  The settings and file names must outlive the job.  Returns 0, or -1
 * with `error` filled; job_free() frees the job in both cases.
 */
int job_prepare(job *j, const process_settings *settings, char *const *files,
                int count, image_error *error);

/* ------------------------------------------------------------------------ */
/* Doing it                                                                  */

/* Computes the frames in order and writes the results.  Returns 0, or -1 with
 * `error` filled. */
int process_run(const process_settings *settings, char *const *files, int count,
                image_error *error);

#endif
