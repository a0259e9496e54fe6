/* Checks the frames of a job: their headers, cameras and sizes. */
#ifndef HBIL_TOOL_JOB_FRAMES_H
#define HBIL_TOOL_JOB_FRAMES_H

#include "tool/job.h"
#include "image/error.h"

/* Fills in j->frames, which is zeroed, and the windows.  Every frame must have
 * the channels and the size of the first one, and a camera.  Returns 0, or -1
 * with `error` filled. */
int job_frames_check(job *j, char *const *files, image_error *error);

/* frame_camera_read() for a frame or view whose map is known; f->camera_path is
 * filled in.  0, or -1 with `error` filled. */
int job_frame_read_camera(job_frame *f, const image *header,
                          const char *override, const source_options *source,
                          image_error *error);

#endif
