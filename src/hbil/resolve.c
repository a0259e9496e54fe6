/* recompose, composite: from layers to the caller's outputs. */
#include "passes.h"

#include "hbil/hbil_stages.h"

#include "camera.h"
#include "checks.h"
#include "planes.h"

hbil_status enqueue_recompose(hbil_plan *plan, commands *chain,
                              const hbil_frame *frame) {
  const layout *l = &plan->layout;
  const bool rest = may_rest(plan, frame);
  if (rest && !l->history)
    return leave_out(plan, HBIL_PASS_RECOMPOSE);
  plan->may_leave_out[HBIL_PASS_RECOMPOSE] = rest;
  const hbil_recompose_args args = {camera_view(&frame->camera, &plan->config),
                                    l->split,
                                    l->light,
                                    l->planes,
                                    l->errors,
                                    rest};
  const argument list[] = {ARG(args),
                           BUFFER_ARG(plan, BUFFER_SPLIT),
                           BUFFER_ARG(plan, BUFFER_LIGHT),
                           BUFFER_ARG(plan, BUFFER_ESTIMATE),
                           BUFFER_ARG(plan, BUFFER_RESOLVED),
                           BUFFER_ARG(plan, BUFFER_FLAGS)};
  const size_t rows = plan->config.execution.vector_width == 1
                          ? 1
                          : (size_t)HBIL_RECOMPOSE_ROWS;
  return LAUNCH(chain, KERNEL_RECOMPOSE, list, l->spans,
                (plan->config.height + rows - 1) / rows, 1);
}

hbil_status enqueue_composite(hbil_plan *plan, commands *chain,
                              const hbil_frame *frame) {
  const hbil_config *c = &plan->config;
  cl_mem plane[PLANE_COUNT];
  const hbil_composite_args args = composite_args(plan, frame, plane);
  const argument list[] = {
      ARG(args),
      BUFFER_ARG(plan, BUFFER_RESOLVED),
      BUFFER_ARG(plan, BUFFER_AO_RESOLVED),
      BUFFER_ARG(plan, BUFFER_ESTIMATE),
      BUFFER_ARG(plan, next_history(plan)),
      ARG(plane[PLANE_DEPTH]),
      ARG(plane[PLANE_ALBEDO]),
      ARG(plane[PLANE_F0]),
      ARG(plane[PLANE_DIRECT]),
      ARG(plane[PLANE_EMISSION]),
      ARG(plane[PLANE_NEAR]),
      ARG(plane[PLANE_FAR]),
      ARG(plane[PLANE_AO]),
      ARG(plane[PLANE_BENT]),
      ARG(plane[PLANE_CONE]),
      ARG(plane[PLANE_INDIRECT]),
      ARG(plane[PLANE_BEAUTY]),
      ARG(plane[PLANE_ERROR]),
      ARG(plane[PLANE_UNKNOWN]),
      BUFFER_ARG(plan, BUFFER_PROBE_HISTORY + !plan->probes.last),
      BUFFER_ARG(plan, BUFFER_SANITIZED)};
  const cl_uint line = plan->layout.line;
  hbil_status status = enqueue_probes(plan, chain, frame);
  if (status == HBIL_SUCCESS)
    status = enqueue_glossy(plan, chain, frame);
  if (status == HBIL_SUCCESS && plan->layout.late_counts)
    status =
        clear_counts(plan, chain, HBIL_SANITIZED_LATE, HBIL_SURFACE_INPUTS);
  return status == HBIL_SUCCESS
             ? LAUNCH(chain, KERNEL_COMPOSITE, list,
                      (c->width + line - 1) / line, c->height, 1)
             : status;
}
