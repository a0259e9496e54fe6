/* The views of a job: pictures of the place that tell the radiance cache what
 * the frames don't show. */
#ifndef HBIL_TOOL_VIEWS_H
#define HBIL_TOOL_VIEWS_H

#include "tool/job.h"
#include "image/error.h"

/* Reads the headers and the cameras of settings->views into j->views, after the
 * frames have been checked.  0, or -1 with `error` filled. */
int views_check(job *j, image_error *error);

#endif
