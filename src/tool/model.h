/* Models: named sets of what is computed, as opposed to how well. */
#ifndef HBIL_TOOL_MODEL_H
#define HBIL_TOOL_MODEL_H

#include "hbil/hbil.h"

typedef enum model { MODEL_DEFAULT = 0, MODEL_PAPER } model;

/* The words of --model, in the order of the enum; ends with NULL. */
extern const char *const model_words[];

/* Sets thickness, facing_fade, back_facing_fallback, feedback, extrapolate and
 * steps_per_side.  The far field is not part of hbil_config's model: the paper
 * has none, the default chooses one by the first frame. */
void model_set(hbil_config *config, model m);

/* How often a first frame is run once more before its result is taken. */
unsigned model_warm_up(model m);

#endif
