/*
 * composite_args: what composite and glossy take of a frame.
 */
#ifndef HBIL_COMPOSITE_ARGS_H
#define HBIL_COMPOSITE_ARGS_H

#include "shared.h"

typedef struct hbil_composite_args {
  hbil_view_args view;
  hbil_transform_args to_world;
  hbil_plane_args planes; /* of the resolved light and the history */
  hbil_environment_args environment;
  hbil_surface_args surface;
  hbil_external_plane_args depth;
  hbil_external_plane_args near_irradiance, far_irradiance, ao, bent_normal;
  hbil_external_plane_args cone_cosine, indirect, beauty, error_estimate;
  hbil_external_plane_args unknown;
  hbil_depth_args decode;
  hbil_float sky_share; /* as in hbil_frame */
  /* the frame's light over that of the history and the cache, and 1 over it */
  hbil_float exposure, per_exposure;
  hbil_probe_grid_args probes;
} hbil_composite_args;
HBIL_ASSERT_LAYOUT(hbil_composite_args, probes, 113, 116)

#endif
