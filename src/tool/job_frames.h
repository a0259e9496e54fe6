/* Checks the frames of a job: their headers, cameras, sizes and results. */
#ifndef HBIL_TOOL_JOB_FRAMES_H
#define HBIL_TOOL_JOB_FRAMES_H

#include "tool/job.h"
#include "image/error.h"

/* Fills in j->frames, which is zeroed, and the windows.  Every frame must have
 * the channels and the size of the first one, a camera, and a name for its
 * result that replaces nothing unasked.  Returns 0, or -1 with `error` filled.
 */
int job_frames_check(job *j, char *const *files, image_error *error);

#endif
