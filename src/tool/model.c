/* Models: named sets of what is computed. */
#include "tool/model.h"

const char *const model_words[] = {"default", "paper", NULL};

void model_set(hbil_config *config, hbil_model_name model) {
  hbil_config defaults;
  hbil_config_init(&defaults);
  hbil_model_set(&config->model, model);
  config->sampling.steps_per_side = model == HBIL_MODEL_PAPER
                                        ? 8 /* the paper's number of samples */
                                        : defaults.sampling.steps_per_side;
}

unsigned model_warm_up(hbil_model_name model) {
  /* three more bounces; the fourth adds a few per cent */
  return model == HBIL_MODEL_PAPER ? 0 : 3;
}
