/* The light that a frame's planes don't contain: the far field of a job, and
 * whether emission is gathered. */
#ifndef HBIL_TOOL_JOB_LIGHT_H
#define HBIL_TOOL_JOB_LIGHT_H

#include "dump/channel_map.h"
#include "dump/gbuffer.h"
#include "hbil/hbil.h"
#include "image/error.h"
#include "tool/frame_source.h"
#include "tool/job.h"

/* ------------------------------------------------------------------------ */
/* What the pixels of frames and views decide                                */

enum { LIGHT_TEXT_SIZE = 256 };

/* Reads the frame or view and lets it decide with all that `found` has seen
 * before, which starts zeroed (hbil_suggest.h).  Of config, model.mode counts;
 * config and frame receive the decision.  0, or -1 with `error` filled. */
int light_choice_make(const char *path, const channel_map *map,
                      hbil_config *config, hbil_frame *frame,
                      hbil_sources *found, image_error *error);

/* What the decision says about unblocked directions, and why. */
void light_choice_far_text(const hbil_sources *found, float sky_share,
                           char out[LIGHT_TEXT_SIZE]);

/* The same about emission; NULL if there is nothing to say. */
const char *light_choice_emission_text(const hbil_sources *found);

/* ------------------------------------------------------------------------ */
/* The light of a job                                                        */

/* Reads --environment into j->far.environment and j->config.model.far_field. 0,
 * or -1 with `error` filled. */
int job_environment_read(job *j, image_error *error);

/* Decides what the user left open (hbil_config_suggest()) for all frames, by
 * the first one or that of --decide-by, by the views and, with --learn, by the
 * other frames; prints a line for each decision.  Sets j->hidden, which follows
 * from it.  Leaves the first frame in `first`, if it is read.  0, or -1 with
 * `error` filled. */
int job_light_decide(job *j, first_frame *first, image_error *error);

#endif
