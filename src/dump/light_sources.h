/*
 * What the direct light of a first frame already contains: the light of the sky
 * and of the lamps that are in the picture.  This decides settings that the
 * user leaves open.
 */
#ifndef HBIL_DUMP_LIGHT_SOURCES_H
#define HBIL_DUMP_LIGHT_SOURCES_H

#include "dump/gbuffer.h"

/*
 * Chooses config->far_field, and the sky's radiance in environment[0].
 *
 * Unblocked directions end on surfaces outside the picture or in the sky.  For
 * the former, the mean of the frame's own surfaces is a better guess than
 * black.  The latter's light is already in the direct diffuse light of most
 * renderers.  If the picture shows a bright sky, its radiance tells the two
 * apart: where direct light is weaker than the sky's, the sky is hidden.
 * *reason: a phrase for the user, static storage.
 */
void far_field_choose(const gbuffer *first, hbil_config *config,
                      float environment[9][3], const char **reason);

/*
 * Chooses config->gather_emission: on if the first frame's direct light does
 * not contain the light of the lamps in the picture.  *reason: a phrase for the
 * user, static storage; NULL if no lamp is in the picture.
 */
void emission_choose(const gbuffer *first, const hbil_camera *camera,
                     hbil_config *config, const char **reason);

#endif
