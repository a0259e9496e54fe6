/* The ways to far light that are compared. */
#include "bench/far_provider.h"

static const struct {
  const char *name;
  hbil_provider provider;
} table[FAR_PROVIDERS] = {
    [FAR_NEAR] = {"near field alone", HBIL_PROVIDER_NONE},
    [FAR_ENVIRONMENT] = {"environment", HBIL_PROVIDER_NONE},
    [FAR_RAYS] = {"rays", HBIL_PROVIDER_RAYS},
    [FAR_CONES] = {"cones", HBIL_PROVIDER_CONES},
    [FAR_LPV] = {"lpv", HBIL_PROVIDER_LPV},
    [FAR_RSM] = {"rsm", HBIL_PROVIDER_RSM}};

const char *far_provider_name(far_provider p) {
  return table[p].name;
}

hbil_provider far_provider_of_library(far_provider p) {
  return table[p].provider;
}
