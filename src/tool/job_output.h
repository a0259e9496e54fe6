/* Checks where a job writes, before hours of work. */
#ifndef HBIL_TOOL_JOB_OUTPUT_H
#define HBIL_TOOL_JOB_OUTPUT_H

#include "tool/job.h"
#include "image/error.h"

/* Makes the output folder and its parents if they are missing, and checks that
 * results and the contact sheet can be written.  A dry run only looks.  Returns
 * 0, or -1 with `error` filled. */
int job_output_prepare(job *j, image_error *error);

#endif
