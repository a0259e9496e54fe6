/* Models: named sets of what is computed, as opposed to how well. */
#ifndef HBIL_TOOL_MODEL_H
#define HBIL_TOOL_MODEL_H

#include "hbil/hbil.h"

/* The words of --model, in the order of the enum; ends with NULL. */
extern const char *const model_words[];

/* hbil_model_set(), and the sampling that goes with the model: slices, steps
 * and resolution.
 * The far field is not part of it: the paper has none, the default chooses one
 * by the first frame. */
void model_set(hbil_config *config, hbil_model_name model);

/* How often a first frame is run once more before its result is taken. */
unsigned model_warm_up(hbil_model_name model);

#endif
