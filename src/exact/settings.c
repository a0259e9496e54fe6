/* What follows from the settings. */
#include "exact/settings.h"

#include "exact/passes.h"
#include "lib/sampling_pattern.h"

bool exact_gathers_light(const hbil_config *config) {
  return config->model.mode == HBIL_MODE_HBIL;
}

bool exact_has_bent_normal(const hbil_config *config) {
  return config->model.mode != HBIL_MODE_HBAO;
}

bool exact_fills_unknown(const hbil_config *config) {
  return exact_gathers_light(config) &&
         config->model.back_facing_fallback == HBIL_FALLBACK_FRAME_MEAN &&
         config->model.facing_fade[1] > -1.0f;
}

int exact_gathered_layers(const hbil_config *config) {
  return hbil_config_resolution(config) == HBIL_RESOLUTION_HALF ? 4
                                                                : HBIL_LAYERS;
}

bool exact_is_gathered(const hbil_config *config, int x, int y) {
  return hbil_is_gathered(4 * (y & 3) + (x & 3), exact_gathered_layers(config));
}

int exact_site(const hbil_config *config, int x, int y) {
  return hbil_site(4 * (y & 3) + (x & 3), y >> 2,
                   exact_gathered_layers(config));
}

bool exact_weighs_slices(const hbil_config *config) {
  return config->sampling.slices == 1 && !config->sampling.unfiltered;
}
