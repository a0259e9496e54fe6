/* The light that a frame's planes don't contain: the far field of a job, and
 * whether emission is gathered. */
#ifndef HBIL_TOOL_JOB_LIGHT_H
#define HBIL_TOOL_JOB_LIGHT_H

#include "tool/first_frame.h"
#include "tool/job.h"
#include "image/error.h"

/* Reads --environment into j->far.environment and j->config.model.far_field. 0,
 * or -1 with `error` filled. */
int job_environment_read(job *j, image_error *error);

/* Decides by the first frame what the user left open (hbil_config_suggest()),
 * and prints a line for each decision.  Sets j->hidden, which follows from it.
 * Reads the frame, if it decides anything, and leaves it in `first`.  0, or -1
 * with `error` filled. */
int job_light_decide(job *j, first_frame *first, image_error *error);

#endif
