/* Whether a job's camera moves. */
#ifndef HBIL_TOOL_JOB_CAMERA_H
#define HBIL_TOOL_JOB_CAMERA_H

#include "dump/gbuffer.h"
#include "image/error.h"
#include "tool/camera_motion.h"
#include "tool/job.h"

/* The depths of a frame whose depth is read. */
depth_range job_camera_depths(const gbuffer *g);

/* Decides once for all frames whether they are seen by a camera that moves
 * (camera_motion.h), by all their cameras, that of the frame of --decide-by,
 * and the depths of the first frame that shows a surface.  Tells it unless it
 * moves, which the line about the radiance cache tells.  Returns 0, or -1 with
 * `error` filled. */
int job_camera_moves(const job *j, int *moves, image_error *error);

#endif
