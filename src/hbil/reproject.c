/* reproject and push_pull: the light of the last frame, seen from this one. */
#include "passes.h"

#include "camera.h"
#include "planes.h"

/* On CPUs each band of this frame is projected by itself.  On GPUs the nearest
 * source of each pixel is found first, among all pixels of the last frame at
 * once; then it is read. */
static hbil_status scatter(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  const layout *l = &plan->layout;
  const size_t x = vectors_across(plan), y = plan->config.height;
  const size_t band = (size_t)l->runs.band;
  hbil_scatter_args args = {
      .from = camera_view(&plan->history_camera, &plan->config),
      .to = camera_view(&frame->camera, &plan->config),
      .motion = camera_between(&plan->history_camera, &frame->camera),
      .planes = l->planes,
      .runs = l->runs,
      .decode = depth_args(&plan->config, frame),
      .disocclusion_threshold = plan->config.history.disocclusion_threshold};
  const cl_mem depth =
      plane_bind(&plan->config, frame, PLANE_DEPTH, &args.depth);
  const argument rows[] = {ARG(args),
                           BUFFER_ARG(plan, BUFFER_HISTORY + plan->history),
                           BUFFER_ARG(plan, BUFFER_LANDING)};
  const argument bands[] = {ARG(args),
                            BUFFER_ARG(plan, BUFFER_HISTORY + plan->history),
                            BUFFER_ARG(plan, BUFFER_CARRIED),
                            ARG(depth),
                            BUFFER_ARG(plan, BUFFER_FLAGS),
                            BUFFER_ARG(plan, BUFFER_LANDING)};
  const argument nearest[] = {ARG(args),
                              BUFFER_ARG(plan, BUFFER_HISTORY + plan->history),
                              BUFFER_ARG(plan, BUFFER_NEAREST)};
  const argument fetch[] = {ARG(args),
                            BUFFER_ARG(plan, BUFFER_HISTORY + plan->history),
                            BUFFER_ARG(plan, BUFFER_CARRIED),
                            BUFFER_ARG(plan, BUFFER_NEAREST),
                            ARG(depth),
                            BUFFER_ARG(plan, BUFFER_FLAGS)};
  hbil_status status;
  if (layout_has_bands(&plan->config)) {
    status =
        LAUNCH(chain, KERNEL_SCATTER_ROWS, rows, (size_t)l->runs.row, y, 1);
    return status == HBIL_SUCCESS ? LAUNCH(chain, KERNEL_SCATTER_BANDS, bands,
                                           1, (y + band - 1) / band, 1)
                                  : status;
  }
  status = enqueue_fill(chain, BUFFER_NEAREST, 0xffffffffu);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_SCATTER_DEPTH, nearest, x, y, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_SCATTER_INDEX, nearest, x, y, 1);
  return status == HBIL_SUCCESS
             ? LAUNCH(chain, KERNEL_SCATTER_FETCH, fetch, x, y, 1)
             : status;
}

static hbil_status follow_motion(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  hbil_follow_motion_args args = {
      .view = camera_view(&frame->camera, &plan->config),
      .back = camera_between(&frame->camera, &plan->history_camera),
      .planes = plan->layout.planes,
      .motion_scale = {plan->config.inputs.motion_scale[0],
                       plan->config.inputs.motion_scale[1]},
      .decode = depth_args(&plan->config, frame),
      .disocclusion_threshold = plan->config.history.disocclusion_threshold};
  const cl_mem depth =
      plane_bind(&plan->config, frame, PLANE_DEPTH, &args.depth);
  const cl_mem motion =
      plane_bind(&plan->config, frame, PLANE_MOTION, &args.motion);
  const argument list[] = {ARG(args),
                           BUFFER_ARG(plan, BUFFER_HISTORY + plan->history),
                           BUFFER_ARG(plan, BUFFER_CARRIED),
                           ARG(depth),
                           ARG(motion),
                           BUFFER_ARG(plan, BUFFER_FLAGS),
                           BUFFER_ARG(plan, BUFFER_SANITIZED)};
  const hbil_status status = clear_counts(chain, HBIL_SANITIZED_MOTION, 1);
  return status == HBIL_SUCCESS
             ? LAUNCH(chain, KERNEL_FOLLOW_MOTION, list, vectors_across(plan),
                      plan->config.height, 1)
             : status;
}

hbil_status enqueue_reproject(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  if (!plan->has_history || is_static(plan, frame))
    return leave_out(chain);
  const hbil_status status = set_flag(chain, HBIL_FLAG_HOLES, 0);
  if (status != HBIL_SUCCESS)
    return status;
  chain->reprojected = true;
  return plan->config.history.reprojection == HBIL_REPROJECTION_MOTION
             ? follow_motion(chain, frame)
             : scatter(chain, frame);
}

/* Raises HBIL_FLAG_HOLES if there are holes.  The reprojections do that
 * themselves; this is for callers who replaced them by a pass of their own. */
static hbil_status find_holes(commands *chain) {
  hbil_plan *plan = chain->plan;
  const hbil_push_pull_args args = {.fine = plan->layout.chain[0]};
  const argument list[] = {ARG(args), BUFFER_ARG(plan, BUFFER_CARRIED),
                           BUFFER_ARG(plan, BUFFER_FLAGS)};
  if (!(plan->layout.skip & HBIL_SKIP_HOLES))
    return set_flag(chain, HBIL_FLAG_HOLES, 1);
  plan->may_leave_out[HBIL_PASS_PUSH_PULL] = true;
  if (chain->reprojected)
    return HBIL_SUCCESS;
  const hbil_status status = set_flag(chain, HBIL_FLAG_HOLES, 0);
  return status == HBIL_SUCCESS
             ? LAUNCH(chain, KERNEL_FIND_HOLES, list, vectors_across(plan),
                      plan->config.height, 1)
             : status;
}

hbil_status enqueue_push_pull(commands *chain, const hbil_frame *frame) {
  hbil_plan *plan = chain->plan;
  const hbil_chain_args *levels = plan->layout.chain;
  const int last = plan->layout.chain_count - 1;
  const size_t width = plan->config.execution.vector_width;
  if (!plan->has_history || is_static(plan, frame))
    return leave_out(chain);
  hbil_status status = find_holes(chain);
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
