/* The settings of a job. */
#include "tool/settings.h"

#include "image/exr_style.h"

#include <string.h>

/* ------------------------------------------------------------------------ */
/* Models: named sets of what is computed                                    */

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

/* ------------------------------------------------------------------------ */
/* Settings                                                                  */

const char *const mode_words[] = {"hbil", "gtao", "hbao", NULL};
const char *const falloff_words[] = {"linear", "soft", "none", NULL};
const char *const ao_bounces_words[] = {"none", "paper", "albedo", NULL};

void process_settings_init(process_settings *settings) {
  memset(settings, 0, sizeof *settings);
  hbil_config_init(&settings->config);
  source_options_init(&settings->source);
  settings->warm_up = model_warm_up(HBIL_MODEL_DEFAULT);
  settings->repeat = 1;
  /* Writing with piz takes 6 to 12 times as long, for .6 to .7 of the bytes:
   * at 1280x720, .4 to 1 s instead of .07 to .09 on two cores, which is longer
   * than lighting a frame takes (doc/measurements.md). */
  settings->compression = EXR_COMPRESSION_OF_NONE;
}
