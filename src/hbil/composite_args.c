/* What composite and glossy take of a frame. */
#include "passes.h"

#include "camera.h"
#include "checks.h"
#include "far_field.h"
#include "planes.h"

hbil_composite_args composite_args(const hbil_plan *plan,
                                   const hbil_frame *frame,
                                   cl_mem plane[PLANE_COUNT]) {
  const hbil_config *c = &plan->config;
  hbil_composite_args args = {
      .view = camera_view(&frame->camera, c),
      .to_world = camera_to_world(&frame->camera),
      .planes = plan->layout.planes,
      .environment = far_field_args(c, frame->environment),
      .decode = depth_args(c, frame),
      .surface.direct_scale = c->inputs.direct_scale,
      .sky_share = frame->sky_share,
      .exposure = light_exposure(frame->exposure),
      .per_exposure = 1.0f / light_exposure(frame->exposure)};
  if (frame->cache)
    args.probes = plan->layout.probe_grid;
  hbil_external_plane_args *const plane_args[PLANE_COUNT] = {
      [PLANE_DEPTH] = &args.depth,
      [PLANE_ALBEDO] = &args.surface.albedo,
      [PLANE_F0] = &args.surface.f0,
      [PLANE_DIRECT] = &args.surface.direct,
      [PLANE_EMISSION] = &args.surface.emission,
      [PLANE_NEAR] = &args.near_irradiance,
      [PLANE_FAR] = &args.far_irradiance,
      [PLANE_AO] = &args.ao,
      [PLANE_BENT] = &args.bent_normal,
      [PLANE_CONE] = &args.cone_cosine,
      [PLANE_INDIRECT] = &args.indirect,
      [PLANE_BEAUTY] = &args.beauty,
      [PLANE_ERROR] = &args.error_estimate,
      [PLANE_UNKNOWN] = &args.unknown};
  for (int i = 0; i < PLANE_COUNT; ++i)
    plane[i] = plane_args[i] ? bind_plane(plan, frame, i, plane_args[i]) : NULL;
  return args;
}
