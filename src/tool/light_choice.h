/* What the first frame's pixels decide about its light. */
#ifndef HBIL_TOOL_LIGHT_CHOICE_H
#define HBIL_TOOL_LIGHT_CHOICE_H

#include "dump/channel_map.h"
#include "dump/gbuffer.h"
#include "hbil/hbil.h"
#include "image/error.h"

/* Lets the library decide by a frame (hbil_suggest.h), of which depth, normals,
 * direct light, emission and background count.  Of config, model.mode counts;
 * config and frame receive the decision.  Returns 0, or -1 with `error` filled.
 */
int light_choice_by(const char *path, const gbuffer *g, hbil_config *config,
                    hbil_frame *frame, hbil_sources *found, image_error *error);

/* Reads the frame and does the same. */
int light_choice_make(const char *path, const channel_map *map,
                      hbil_config *config, hbil_frame *frame,
                      hbil_sources *found, image_error *error);

/* What the decision says about unblocked directions. */
const char *light_choice_far_text(const hbil_sources *found);

/* The same about emission; NULL if there is nothing to say. */
const char *light_choice_emission_text(const hbil_sources *found);

#endif
