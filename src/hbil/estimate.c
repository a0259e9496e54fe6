/* The estimate of unseen light, from what the gather has found. */
#include "passes.h"

#include "hbil/hbil_stages.h"

#include "lib/estimate_args.h"
#include "planes.h"

hbil_status enqueue_estimate(hbil_plan *plan, commands *chain,
                             const hbil_frame *frame) {
  const hbil_config *c = &plan->config;
  if (!plan->layout.estimate)
    return HBIL_SUCCESS;
  hbil_estimate_args args = {.split = plan->layout.split,
                             .light = plan->layout.light,
                             .width = (cl_int)c->width,
                             .height = (cl_int)c->height,
                             .unseen_light = c->model.offscreen_light,
                             .is_static = may_rest(plan, frame),
                             .bounces = (cl_int)plan_bounces(plan)};
  if (plan->layout.far_field == HBIL_FAR_FRAME) {
    args.sky_share = frame->sky_share;
    for (int i = 0; i < 3; ++i)
      args.sky[i] = frame->environment[0][i];
  }
  const surface_buffers in = bind_surface(plan, frame, &args.surface);
  const argument part[] = {ARG(args),
                           BUFFER_ARG(plan, BUFFER_SPLIT),
                           BUFFER_ARG(plan, BUFFER_LIGHT),
                           ARG(in.albedo),
                           ARG(in.f0),
                           ARG(in.direct),
                           ARG(in.emission),
                           BUFFER_ARG(plan, BUFFER_FLAGS),
                           BUFFER_ARG(plan, BUFFER_ESTIMATE)};
  const cl_int lane_count = (cl_int)plan->layout.estimate_lanes;
  const argument lanes[] = {ARG(lane_count), BUFFER_ARG(plan, BUFFER_ESTIMATE)};
  const argument sum[] = {BUFFER_ARG(plan, BUFFER_ESTIMATE)};
  const argument fill[] = {ARG(args), BUFFER_ARG(plan, BUFFER_ESTIMATE)};
  hbil_status status =
      LAUNCH(chain, KERNEL_ESTIMATE_PART, part, plan->layout.estimate_lanes,
             HBIL_ESTIMATE_PARTS, 1);
  if (status == HBIL_SUCCESS && lane_count > 1)
    status = LAUNCH(chain, KERNEL_ESTIMATE_LANES, lanes, HBIL_ESTIMATE_SUMS,
                    HBIL_ESTIMATE_PARTS, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_ESTIMATE_SUM, sum, HBIL_ESTIMATE_SUMS, 1, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_ESTIMATE_FILL, fill, 1, 1, 1);
  return status;
}
