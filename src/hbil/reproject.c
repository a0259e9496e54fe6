/* reproject and push_pull: the light of the last frame, seen from this one. */
#include "passes.h"

#include "camera.h"
#include "planes.h"

static bool follows_motion(const hbil_config *config) {
  return config->history.reprojection == HBIL_REPROJECTION_MOTION;
}

hbil_status enqueue_reproject(hbil_plan *plan, commands *chain,
                              const hbil_frame *frame) {
  if (!plan->has_history || is_static(plan, frame))
    return leave_out(plan, HBIL_PASS_REPROJECT);
  const hbil_config *c = &plan->config;
  const hbil_plan *last = plan->followed ? plan->followed : plan;
  const hbil_config *past = &last->config;
  hbil_reproject_args args = {
      .view = camera_view(&frame->camera, c),
      .before = camera_view(&plan->history_camera, past),
      .back = camera_between(&frame->camera, &plan->history_camera),
      .planes = plan->layout.planes,
      .history = last->layout.planes,
      .ratio = {(float)past->width / (float)c->width,
                (float)past->height / (float)c->height},
      .motion_scale = {c->inputs.motion_scale[0], c->inputs.motion_scale[1]},
      .decode = depth_args(c, frame),
      .disocclusion_threshold = c->history.disocclusion_threshold};
  const cl_mem depth = bind_plane(plan, frame, PLANE_DEPTH, &args.depth);
  const cl_mem motion = bind_plane(plan, frame, PLANE_MOTION, &args.motion);
  const argument list[] = {ARG(args),
                           BUFFER_ARG(last, BUFFER_HISTORY + last->history),
                           BUFFER_ARG(plan, BUFFER_CARRIED),
                           ARG(depth),
                           ARG(motion),
                           BUFFER_ARG(plan, BUFFER_FLAGS),
                           BUFFER_ARG(plan, BUFFER_SANITIZED)};
  hbil_status status = set_flag(plan, chain, HBIL_FLAG_HOLES, 0);
  if (status == HBIL_SUCCESS && follows_motion(c))
    status = clear_counts(plan, chain, HBIL_SANITIZED_MOTION, 1);
  plan->reprojected = true;
  return status == HBIL_SUCCESS ? LAUNCH(chain, KERNEL_REPROJECT, list,
                                         vectors_across(plan), c->height, 1)
                                : status;
}

/* Raises HBIL_FLAG_HOLES if there are holes.  The kernel reproject does
 * that itself; this is for callers who replaced it by a pass of their own. */
static hbil_status find_holes(hbil_plan *plan, commands *chain) {
  const hbil_push_pull_args args = {.fine = plan->layout.chain[0]};
  const argument list[] = {ARG(args), BUFFER_ARG(plan, BUFFER_CARRIED),
                           BUFFER_ARG(plan, BUFFER_FLAGS)};
  if (!(plan->layout.skip & HBIL_SKIP_HOLES))
    return set_flag(plan, chain, HBIL_FLAG_HOLES, 1);
  plan->may_leave_out[HBIL_PASS_PUSH_PULL] = true;
  if (plan->reprojected)
    return HBIL_SUCCESS;
  const hbil_status status = set_flag(plan, chain, HBIL_FLAG_HOLES, 0);
  return status == HBIL_SUCCESS
             ? LAUNCH(chain, KERNEL_FIND_HOLES, list, vectors_across(plan),
                      plan->config.height, 1)
             : status;
}

hbil_status enqueue_push_pull(hbil_plan *plan, commands *chain,
                              const hbil_frame *frame) {
  const hbil_chain_args *levels = plan->layout.chain;
  const int last = plan->layout.chain_count - 1;
  const size_t width = plan->config.execution.vector_width;
  if (!plan->has_history || is_static(plan, frame))
    return leave_out(plan, HBIL_PASS_PUSH_PULL);
  hbil_status status = find_holes(plan, chain);
  /* from the finest level to the coarsest, and back */
  for (int step = 0; step < 2 * last && status == HBIL_SUCCESS; ++step) {
    const bool down = step < last;
    const int fine = down ? step : 2 * last - 1 - step;
    const hbil_chain_args *written = &levels[down ? fine + 1 : fine];
    const hbil_push_pull_args args = {levels[fine], levels[fine + 1]};
    const argument list[] = {ARG(args), BUFFER_ARG(plan, BUFFER_CARRIED),
                             BUFFER_ARG(plan, BUFFER_FLAGS)};
    status = LAUNCH(chain, down ? KERNEL_PUSH : KERNEL_PULL, list,
                    ((size_t)written->width + width - 1) / width,
                    (size_t)written->height, 1);
  }
  return status;
}
