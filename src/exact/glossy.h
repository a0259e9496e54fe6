/* The output `glossy`: passes that it has of its own. */
#ifndef HBIL_EXACT_GLOSSY_H
#define HBIL_EXACT_GLOSSY_H

#include "exact/cache.h"
#include "lib/glossy_args.h"

/* Planes of GATHERED and RESOLVED, behind all others. */
enum { EXACT_GLOSSY_PLANES = HBIL_GATHERED_PLANES };
enum {
  EXACT_GLOSSY_GATHERED = EXACT_GLOSSY_PLANES + HBIL_GATHERED_GLOSSY_PLANES,
  EXACT_GLOSSY_RESOLVED = EXACT_GLOSSY_PLANES + HBIL_GLOSSY_PLANES,
  /* The estimated errors of AO and of E_near. */
  EXACT_RESOLVED_ERRORS = EXACT_GLOSSY_RESOLVED,
  EXACT_RESOLVED_PLANES = EXACT_RESOLVED_ERRORS + 2
};

/* A probe's lobe: its axis in view space, and means over its rays. */
typedef struct exact_glossy_probe {
  vec3 axis;
  double known, unknown, light[3];
} exact_glossy_probe;

/* One for each of the probes, whose places exact_place_probes() sets. */
void exact_make_glossy_probes(const exact_frame *frame,
                              const exact_cache *cache,
                              const exact_planes *split,
                              const exact_probes *probes,
                              exact_glossy_probe *glossy);

/* SPLIT, RESOLVED and probes -> EXACT_GLOSSY of the outputs.  Where `glossy` is
 * NULL, there is no radiance cache; else frame->probes are its probes. */
void exact_glossy(const exact_frame *frame, const exact_planes *split,
                  const exact_planes *resolved,
                  const exact_glossy_probe *glossy, exact_planes *out);

#endif
