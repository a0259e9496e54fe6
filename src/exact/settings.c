/* What follows from the settings. */
#include "exact/settings.h"

#include <math.h>

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
  return hbil_config_slice_frames(config) > 1 ||
         (config->sampling.slices == 1 && !config->sampling.unfiltered);
}

static bool is_asked(hbil_plane_format format) {
  return format.component != HBIL_NONE;
}

static bool shows_occlusion(const hbil_outputs *o) {
  return is_asked(o->ao) || is_asked(o->bent_normal) ||
         is_asked(o->cone_cosine) || is_asked(o->error_estimate);
}

/* Without a far field, the modes without near light have no light. */
static bool shows_light(const hbil_config *config) {
  const hbil_outputs *o = &config->outputs;
  const bool far = config->model.far_field == HBIL_FAR_CONSTANT ||
                   config->model.far_field == HBIL_FAR_SH;
  return (exact_gathers_light(config) || far) &&
         (is_asked(o->near_irradiance) || is_asked(o->far_irradiance) ||
          is_asked(o->indirect) || is_asked(o->beauty) ||
          is_asked(o->unknown) || is_asked(o->glossy));
}

/* Whether a search is that of the outputs. */
static bool is_of_ao(const hbil_config *config) {
  return config->model.mode != HBIL_MODE_HBAO &&
         shows_occlusion(&config->outputs) && !shows_light(config);
}

double exact_radius(const hbil_config *config) {
  return (double)(is_of_ao(config) ? config->model.ao_radius
                                   : config->model.radius);
}

double exact_relative_thickness(const hbil_config *config) {
  const hbil_model *m = &config->model;
  return m->mode == HBIL_MODE_HBAO || is_of_ao(config)
             ? (double)m->relative_thickness
             : fmin((double)m->relative_thickness,
                    (double)m->near_relative_thickness);
}

bool exact_searches_ao(const hbil_config *config, hbil_config *ao) {
  const hbil_outputs *o = &config->outputs;
  *ao = *config;
  ao->model.mode = HBIL_MODE_GTAO;
  ao->outputs = (hbil_outputs){.ao = o->ao,
                               .bent_normal = o->bent_normal,
                               .cone_cosine = o->cone_cosine,
                               .error_estimate = o->error_estimate,
                               .bent_normal_space = o->bent_normal_space};
  return config->model.mode != HBIL_MODE_HBAO && shows_occlusion(o) &&
         (exact_radius(config) != exact_radius(ao) ||
          exact_relative_thickness(config) != exact_relative_thickness(ao));
}

/* Near light beside a cache has three fifths of the steps, unless outputs of
 * occlusion have the same search. */
uint32_t exact_steps(const hbil_config *config) {
  const uint32_t steps = config->sampling.steps_per_side;
  hbil_config ao;
  const bool alone =
      shows_light(config) &&
      (!shows_occlusion(&config->outputs) || exact_searches_ao(config, &ao));
  return alone && config->model.cache_method != HBIL_CACHE_METHOD_NONE &&
                 !isinf(config->model.radius)
             ? (3 * steps + 4) / 5
             : steps;
}
