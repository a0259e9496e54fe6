/* Sizes and layouts: what a configuration decides before any memory is touched.
 */
#ifndef HBIL_LAYOUT_H
#define HBIL_LAYOUT_H

#include <stdbool.h>

#include "hbil/hbil.h"
#include "lib/cache_args.h"
#include "lib/glossy_args.h"
#include "names.h"
#include "shared.h"
#include "staging.h"

/* The device buffers of a plan. */
enum {
  BUFFER_HISTORY,
  BUFFER_HISTORY_NEXT, /* the same of the other frame; see lay_out_history() */
  BUFFER_CARRIED, /* level 0 of the push/pull chain, then all coarser ones */
  BUFFER_FLAGS,   /* HBIL_FLAG_: what kernels tell later ones */
  BUFFER_SPLIT,
  BUFFER_LIGHT,
  BUFFER_RESOLVED,
  BUFFER_SLICES,      /* what slices found, of one frame, and of the other */
  BUFFER_SLICES_NEXT, /* (gather/past_slices.clh) */
  BUFFER_STEPS,
  BUFFER_ESTIMATE, /* the estimate of unseen light, its sums, those of lanes */
  BUFFER_PROBES,   /* HBIL_PROBE_FLOATS floats each */
  BUFFER_FILTERED_PROBES,
  BUFFER_PROBE_HISTORY, /* of one frame, and of the other one */
  BUFFER_PROBE_HISTORY_NEXT,
  BUFFER_GLOSSY_PROBES, /* HBIL_GLOSSY_PROBE_FLOATS floats each */
  BUFFER_BOUNDS,        /* grids of largest inverse depths and of light */
  BUFFER_USED_GROUPS,   /* where outputs show light */
  BUFFER_SPAN_STATES,   /* the work that the gather left out */
  BUFFER_AO_STEPS,      /* of the search for the outputs (ao_search.c): STEPS */
  BUFFER_AO_LIGHT,      /* of the search for the outputs (ao_search.c): LIGHT */
  BUFFER_AO_RESOLVED,
  BUFFER_AO_SLICES,
  BUFFER_AO_SLICES_NEXT,
  BUFFER_AO_SPAN_STATES,
  BUFFER_SANITIZED, /* HBIL_SANITIZED_: counts of unusable inputs */
  BUFFER_STAGED,    /* one for each plane, where it is staged */
  BUFFER_COUNT = BUFFER_STAGED + PLANE_COUNT
};

/* log2(HBIL_MAX_SIZE) + 1: levels of the largest push/pull chain. */
enum { MAX_CHAIN = 15 };
_Static_assert(1 << (MAX_CHAIN - 1) == HBIL_MAX_SIZE, "MAX_CHAIN");

typedef struct layout {
  size_t bytes[BUFFER_COUNT]; /* 0: not needed */
  size_t at[BUFFER_COUNT];    /* where scratch buffers begin in the caller's */
  hbil_memory memory;
  hbil_plane_args planes; /* full-resolution planes */
  hbil_layer_args split, light;
  cl_uint slice_frames; /* that share the slices of a pixel; 1: none do */
  hbil_layer_args past; /* of SLICES */
  int chain_count;
  hbil_chain_args chain[MAX_CHAIN];
  cl_uint estimate_lanes; /* work-items of each part of the estimate */
  /* what must be computed; unknown: the share that back-facing samples block */
  bool radiance, bent, history, unknown, estimate, probes, glossy;
  bool late_counts; /* composite shows inputs that split does not read */
  bool ao_search;   /* outputs show another search than the near field's */
  cl_uint skip;     /* the bits of hbil_config.skip that can have an effect */
  hbil_bounds_args bounds;
  hbil_grid_args
      row_block; /* groups side by side in a cell, HBIL_ROW_BLOCK rows of
                them; only without vectors, else of no width */
  hbil_probe_grid_args probe_grid;
  bool quadrants; /* whether the gather reads the quadrants of the bounds */
  cl_uint span;   /* pixels of a span */
  size_t taken;   /* of them, by one work-item of the gather */
  size_t spans;   /* work-items of the gather, in a row of a layer */
  hbil_far_field far_field;  /* NONE if no output shows it */
  hbil_pattern_args pattern; /* without turn, shift, reach */
  cl_uint line;              /* pixels that one work-item of composite takes */
  cl_uint carried_planes;    /* of CARRIED */
  cl_uint resolved_planes;   /* of RESOLVED */
  cl_uint error_plane;       /* of RESOLVED: where errors begin */
  cl_uint ao_error_plane;    /* the same of AO_RESOLVED */
  cl_uint unknown_plane;     /* of RESOLVED: the share `unknown`; 0: none */
  cl_uint weight_plane;      /* of GATHERED: weights of slices; 0: none */
  cl_uint glossy_plane;      /* of GATHERED: where glossy sums begin; 0: none */
  cl_uint glossy_resolved;   /* of RESOLVED: where glossy means begin */
  hbil_error_args errors;
  hbil_ao_bounces ao_bounces; /* NONE if no output shows far light */
  staging staged;
} layout;

/* The layout of the search for the outputs: ao is what searches_differ() made
 * of the plan's configuration, and whole is the plan's layout. */
void layout_of_ao_search(const hbil_config *ao, const layout *whole,
                         layout *out);

/* Whether a buffer has nothing that outlives a frame. */
bool layout_is_scratch(int buffer);
/* config has the formats that the passes see, and a vector_width above 0.
 * alignment: of buffers on the device, in bytes. */
void layout_compute(const hbil_config *config, const staging *staged,
                    size_t alignment, layout *out);

#endif
