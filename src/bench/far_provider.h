/* The ways to far light that are compared, from none to a radiance cache. */
#ifndef HBIL_BENCH_FAR_PROVIDER_H
#define HBIL_BENCH_FAR_PROVIDER_H

#include "hbil/hbil.h"

typedef enum far_provider {
  FAR_NEAR = 0,    /* none: the near field alone */
  FAR_ENVIRONMENT, /* the environment, or the frame's own estimate */
  FAR_RAYS,        /* from here on a radiance cache */
  FAR_CONES,
  FAR_LPV,
  FAR_RSM,
  FAR_PROVIDERS
} far_provider;

/* "near field alone", "environment", or the word of hbil process --far. */
const char *far_provider_name(far_provider p);

/* The library's; HBIL_PROVIDER_NONE where there is no cache. */
hbil_provider far_provider_of_library(far_provider p);

#endif
