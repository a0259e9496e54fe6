/* The lobe of the output `glossy` (kernels/lib/lobe.clh). */
#ifndef HBIL_GLOSSY_H
#define HBIL_GLOSSY_H

#include "names.h"
#include "hbil/hbil.h"

/* k of its lobe at normal view. */
float glossy_lobe(const hbil_config *config);

/* What that lobe leaves of the orders 1 and 2 of an environment. */
void glossy_bands(float k, float bands[2]);

#endif
