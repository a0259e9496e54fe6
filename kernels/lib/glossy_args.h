/*
 * glossy_args: the output `glossy`, as the host, the kernels and the exact
 * passes need it.
 */
#ifndef HBIL_GLOSSY_ARGS_H
#define HBIL_GLOSSY_ARGS_H

#include "shared.h"

/* The largest 1 / n.wo that counts for a glossy lobe (lib/lobe.clh). */
#define HBIL_LOBE_STEEPEST 10.0f

/* What the output `glossy` adds, as floats in either storage.  Gathered, behind
 * all other planes: sums over the lobe, which recompose divides by the last
 * one. Resolved, behind the bent normal: means. */
enum {
  HBIL_GLOSSY_RED = 0,   /* 1: green, 2: blue; radiance */
  HBIL_GLOSSY_KNOWN = 3, /* the part of the lobe whose light is known */
  HBIL_GLOSSY_PLANES = 4,
  HBIL_GLOSSY_WHOLE = 4, /* gathered: the whole lobe */
  HBIL_GATHERED_GLOSSY_PLANES = 5
};

/* glossy, beside what composite takes.  bands: what the lobe leaves of an
 * environment's orders 1 and 2. */
typedef struct hbil_glossy_args {
  hbil_layer_args split;
  hbil_external_plane_args glossy;
  hbil_float lobe; /* as in hbil_gather_args */
  hbil_float bands[2];
} hbil_glossy_args;
HBIL_ASSERT_LAYOUT(hbil_glossy_args, bands, 12, 14)

#endif
