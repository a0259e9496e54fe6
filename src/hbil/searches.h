/* Which occluders count: for light, and for the outputs that show them. */
#ifndef HBIL_SEARCHES_H
#define HBIL_SEARCHES_H

#include <stdbool.h>

#include "hbil/hbil.h"
#include "names.h"

/* The relative thickness of occluders of the near field. */
float near_thickness_share(const hbil_config *config);

/* The steps of the search for near light, on each side of a slice. */
cl_uint near_steps(const hbil_config *config);

/* Gives the near field the occluders of ao, bent_normal and cone_cosine where
 * no output shows light that passes it; with HBIL_MODE_HBAO these outputs have
 * its occluders.  To be called before all else that reads the configuration. */
void searches_settle(hbil_config *config);

/* Whether these outputs, or an error estimate of AO, need another search than
 * light does.  *ao: that search, as a configuration whose near field it is. */
bool searches_differ(const hbil_config *config, hbil_config *ao);

#endif
