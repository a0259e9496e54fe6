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
/* What the first frame's pixels decide                                      */

/* Reads the frame and does the same. */
int light_choice_make(const char *path, const channel_map *map,
                      hbil_config *config, hbil_frame *frame,
                      hbil_sources *found, image_error *error);

/* What the decision says about unblocked directions. */
const char *light_choice_far_text(const hbil_sources *found);

/* The same about emission; NULL if there is nothing to say. */
const char *light_choice_emission_text(const hbil_sources *found);

/* ------------------------------------------------------------------------ */
/* The light of a job                                                        */

/* Reads --environment into j->far.environment and j->config.model.far_field. 0,
 * or -1 with `error` filled. */
int job_environment_read(job *j, image_error *error);

/* Decides by the first frame what the user left open (hbil_config_suggest()),
 * and prints a line for each decision.  Sets j->hidden, which follows from it.
 * Reads the frame, if it decides anything, and leaves it in `first`.  0, or -1
 * with `error` filled. */
int job_light_decide(job *j, first_frame *first, image_error *error);

#endif
