/* The cuts of a job: where a sequence goes to another place. */
#ifndef HBIL_TOOL_JOB_CUTS_H
#define HBIL_TOOL_JOB_CUTS_H

#include "tool/job.h"
#include "image/error.h"

/*
 * Fills in j->places, which is one place if there is no cut: those of
 * settings->cuts, or else those that the cameras and what the frames show tell.
 *
 * A cut to another corner of the same place is none, because what earlier
 * frames have shown lights the later ones.  It is one where a radiance cache of
 * both sides would have much wider voxels than that of either.  What is known
 * beyond the frames (views, a cache's file, a frame that decides for chunks)
 * belongs to one place, and none is looked for then.
 *
 * Says each cut in a line.  0, or -1 with `error` filled.
 */
int job_cuts_find(job *j, image_error *error);

#endif
