/* Models: named sets of what is computed. */
#include "tool/model.h"

const char *const model_words[] = {"default", "paper", NULL};

void model_set(hbil_config *config, hbil_model_name model) {
  hbil_config defaults;
  hbil_config_init(&defaults);
  hbil_model_set(&config->model, model);
  config->sampling.slices = defaults.sampling.slices;
  config->sampling.steps_per_side = defaults.sampling.steps_per_side;
  config->sampling.step_growth = defaults.sampling.step_growth;
  config->sampling.resolution = defaults.sampling.resolution;
  if (model == HBIL_MODEL_PAPER) { /* the paper's own numbers */
    config->sampling.slices = 2;
    config->sampling.steps_per_side = 8;
    config->sampling.step_growth = 0.0f;
    config->sampling.resolution = HBIL_RESOLUTION_FULL;
  }
}

unsigned model_warm_up(hbil_model_name model) {
  /* three more bounces; the fourth adds a few per cent */
  return model == HBIL_MODEL_PAPER ? 0 : 3;
}
