/* Checks the frames of a job and its views: their headers, cameras and sizes.
 */
#ifndef HBIL_TOOL_JOB_FRAMES_H
#define HBIL_TOOL_JOB_FRAMES_H

#include "image/error.h"
#include "tool/job.h"

/* ------------------------------------------------------------------------ */
/* Frames                                                                    */

/* Fills in j->frames, which is zeroed, and the windows.  Every frame must have
 * the channels and the size of the first one, and a camera.  Returns 0, or -1
 * with `error` filled. */
int job_frames_check(job *j, char *const *files, image_error *error);

/* ------------------------------------------------------------------------ */
/* Views: pictures of the place, for the radiance cache                      */

/* Reads the headers and the cameras of settings->views into j->views, after the
 * frames have been checked.  0, or -1 with `error` filled. */
int views_check(job *j, image_error *error);

#endif
