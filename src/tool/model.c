/* Models: named sets of what is computed. */
#include "tool/model.h"

#include <math.h>

const char *const model_words[] = {"default", "paper", NULL};

/*
 * The default is the model with the smallest error against path tracing on the
 * four public scenes (HACKING.md): occluders are 8 % of their depth thick, all
 * visible light counts, and light that the picture doesn't show is estimated.
 * The other model is that of B. Mayaux, "Horizon-Based Indirect Lighting".
 */
void model_set(hbil_config *config, model m) {
  const int paper = m == MODEL_PAPER;
  config->thickness = INFINITY;
  config->relative_thickness = paper ? INFINITY : 0.08f;
  config->facing_fade[0] = paper ? -0.1f : -1.0f;
  config->facing_fade[1] = paper ? 0.0f : -1.0f;
  config->back_facing_fallback =
      paper ? HBIL_FALLBACK_LAST_ACCEPTED : HBIL_FALLBACK_FRAME_MEAN;
  config->feedback = paper ? HBIL_FEEDBACK_RADIANCE : HBIL_FEEDBACK_IRRADIANCE;
  config->extrapolate = paper ? CL_FALSE : CL_TRUE;
  config->steps_per_side = paper ? 8 : 48;
}

unsigned model_warm_up(model m) {
  /* three more bounces; the fourth adds a few per cent */
  return m == MODEL_PAPER ? 0 : 3;
}
