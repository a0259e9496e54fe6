/* What follows from the settings, and several passes need to know. */
#ifndef HBIL_EXACT_SETTINGS_H
#define HBIL_EXACT_SETTINGS_H

#include <stdbool.h>

#include "hbil/hbil.h"

static inline bool exact_is_orthographic(const hbil_config *config) {
  return config->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
}
/* Whether the mode computes near irradiance. */
bool exact_gathers_light(const hbil_config *config);
/* Whether the mode computes bent normals. */
bool exact_has_bent_normal(const hbil_config *config);
/* The layers that are gathered, and whether a pixel lies in one. */
int exact_gathered_layers(const hbil_config *config);
bool exact_is_gathered(const hbil_config *config, int x, int y);
/* Where the pixel stands in the sampling pattern (hbil_site()). */
int exact_site(const hbil_config *config, int x, int y);
/* Whether light of back-facing samples is replaced by the frame's mean. */
bool exact_fills_unknown(const hbil_config *config);
/* Limits of the search that a configuration has: those of the near field, or,
 * where its outputs show what is blocked and no light, those of ao. */
double exact_radius(const hbil_config *config);
double exact_relative_thickness(const hbil_config *config);
uint32_t exact_steps(const hbil_config *config);
/* Whether ao, bent_normal and cone_cosine need a search of their own.  *ao: a
 * configuration that has that search. */
bool exact_searches_ao(const hbil_config *config, hbil_config *ao);

#endif
