/* split: the G-buffer in layers, and bounds of what is in them. */
#include "passes.h"

#include "camera.h"
#include "checks.h"
#include "fall.h"
#include "planes.h"

/* In kernels of single pixels a group is 4 pixels, so a cell of 64 x 64 pixels
 * has 1024 groups. That is too many for one work-item of a GPU, so the groups
 * of every 4 rows (a row block) are combined first. */
static hbil_status bound(hbil_plan *plan, commands *chain,
                         cl_int unchanged_is_done) {
  const hbil_bounds_args *b = &plan->layout.bounds;
  const hbil_grid_args *row_block = &plan->layout.row_block;
  const cl_int across = HBIL_CELL / (cl_int)plan->config.execution.vector_width;
  const cl_int down = HBIL_CELL * HBIL_SIDE;
  const bool row_blocks = row_block->width > 0;
  const hbil_bound_cells_args levels[] = {
      {b->group, *row_block, across, HBIL_ROW_BLOCK, unchanged_is_done},
      {row_blocks ? *row_block : b->group, b->cell, row_blocks ? 1 : across,
       row_blocks ? down / HBIL_ROW_BLOCK : down, unchanged_is_done},
      {b->cell, b->block, HBIL_BLOCK, HBIL_BLOCK, unchanged_is_done},
      {b->block, b->whole, b->block.width, b->block.height, unchanged_is_done}};
  const size_t count = sizeof levels / sizeof *levels;
  hbil_status status = HBIL_SUCCESS;
  for (size_t i = row_blocks ? 0 : 1; i < count && status == HBIL_SUCCESS;
       ++i) {
    const argument list[] = {ARG(levels[i]), BUFFER_ARG(plan, BUFFER_BOUNDS),
                             BUFFER_ARG(plan, BUFFER_FLAGS)};
    status =
        LAUNCH(chain, KERNEL_BOUND_CELLS, list, (size_t)levels[i].coarse.width,
               (size_t)levels[i].coarse.height, 1);
  }
  if (status != HBIL_SUCCESS || !plan->layout.quadrants)
    return status;
  const hbil_bound_quadrants_args args = {*b, unchanged_is_done};
  const argument list[] = {ARG(args), BUFFER_ARG(plan, BUFFER_BOUNDS),
                           BUFFER_ARG(plan, BUFFER_FLAGS)};
  return LAUNCH(chain, KERNEL_BOUND_QUADRANTS, list, (size_t)b->block.width,
                (size_t)b->block.height, 1);
}

/* Bounds of the layers, where skips need them. */
static hbil_status sum_up(hbil_plan *plan, commands *chain,
                          cl_int unchanged_is_done) {
  return plan->buffers[BUFFER_BOUNDS] ? bound(plan, chain, unchanged_is_done)
                                      : HBIL_SUCCESS;
}

/* --- the padding --- */

static hbil_status clear_layers(const hbil_plan *plan, commands *chain,
                                int buffer, const hbil_layer_args *layers,
                                float nothing) {
  const hbil_clear_args args = {*layers, plan->layout.span, nothing};
  const argument list[] = {ARG(args), BUFFER_ARG(plan, buffer)};
  const size_t rows = HBIL_LAYERS * ((size_t)layers->height + 2);
  return LAUNCH(chain, KERNEL_CLEAR_PADDING, list, rows, 1, 1);
}

hbil_status clear_padding(const hbil_plan *plan, commands *chain) {
  const layout *l = &plan->layout;
  hbil_status status =
      clear_layers(plan, chain, BUFFER_SPLIT, &l->split, HBIL_NOTHING);
  if (status == HBIL_SUCCESS)
    status = clear_layers(plan, chain, BUFFER_LIGHT, &l->light, 0.0f);
  return status == HBIL_SUCCESS && l->ao_search
             ? clear_layers(plan, chain, BUFFER_AO_LIGHT,
                            &plan->ao.layout.light, 0.0f)
             : status;
}

/* --- the layers --- */

/* The inputs, as split and relight take them. */
typedef struct inputs {
  cl_mem depth, normal;
  surface_buffers surface;
} inputs;

static inputs bind_inputs(const hbil_plan *plan, const hbil_frame *frame,
                          hbil_split_args *args) {
  return (inputs){bind_plane(plan, frame, PLANE_DEPTH, &args->depth),
                  bind_plane(plan, frame, PLANE_NORMAL, &args->normal),
                  bind_surface(plan, frame, &args->surface)};
}

static hbil_split_args split_args(const hbil_plan *plan,
                                  const hbil_frame *frame) {
  const hbil_split_args args = {
      .view = camera_view(&frame->camera, &plan->config),
      .to_view = camera_view_from_normals(&frame->camera, &plan->config),
      .layers = plan->layout.split,
      .planes = plan->layout.planes,
      .groups = plan->layout.bounds.group,
      .decode = depth_args(&plan->config, frame),
      .exposure = light_exposure(frame->exposure),
      .has_history = plan->has_history};
  return args;
}

/* Static frames: nothing but light is new. */
static hbil_status relight(hbil_plan *plan, commands *chain,
                           const hbil_frame *frame) {
  hbil_split_args args = split_args(plan, frame);
  const inputs in = bind_inputs(plan, frame, &args);
  args.steady =
      may_rest(plan, frame) && plan->static_frames == HBIL_EXACT_STATIC_FRAMES;
  plan->static_frames += plan->static_frames < HBIL_EXACT_STATIC_FRAMES;
  const hbil_fall_args fall = fall_args(plan, frame);
  const cl_mem ratios = fall_ratios(frame);
  const argument list[] = {ARG(args),
                           ARG(fall),
                           ARG(ratios),
                           BUFFER_ARG(plan, BUFFER_SPLIT),
                           BUFFER_ARG(plan, BUFFER_HISTORY + plan->history),
                           ARG(in.depth),
                           ARG(in.surface.albedo),
                           ARG(in.surface.f0),
                           ARG(in.surface.direct),
                           ARG(in.surface.emission),
                           BUFFER_ARG(plan, BUFFER_FLAGS),
                           BUFFER_ARG(plan, BUFFER_BOUNDS)};
  hbil_status status = set_flag(plan, chain, HBIL_FLAG_CHANGED, 0);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_RELIGHT, list, (vectors_across(plan) + 3) / 4,
                    plan->config.height, 1);
  return status == HBIL_SUCCESS ? sum_up(plan, chain, CL_TRUE) : status;
}

hbil_status enqueue_split(hbil_plan *plan, commands *chain,
                          const hbil_frame *frame) {
  if (is_static(plan, frame))
    return plan->layout.history ? relight(plan, chain, frame)
                                : leave_out(plan, HBIL_PASS_SPLIT);
  plan->static_frames = 0;
  hbil_split_args args = split_args(plan, frame);
  const inputs in = bind_inputs(plan, frame, &args);
  const hbil_fall_args fall = fall_args(plan, frame);
  const cl_mem ratios = fall_ratios(frame);
  const argument list[] = {ARG(args),
                           ARG(fall),
                           ARG(ratios),
                           BUFFER_ARG(plan, BUFFER_SPLIT),
                           BUFFER_ARG(plan, BUFFER_CARRIED),
                           ARG(in.depth),
                           ARG(in.normal),
                           ARG(in.surface.albedo),
                           ARG(in.surface.f0),
                           ARG(in.surface.direct),
                           ARG(in.surface.emission),
                           BUFFER_ARG(plan, BUFFER_USED_GROUPS),
                           BUFFER_ARG(plan, BUFFER_SANITIZED),
                           BUFFER_ARG(plan, BUFFER_BOUNDS)};
  hbil_status status = clear_counts(plan, chain, HBIL_SANITIZED_DEPTH,
                                    HBIL_SANITIZED_LATE - HBIL_SANITIZED_DEPTH);
  if (status == HBIL_SUCCESS && plan->lent.memory)
    status = clear_padding(plan, chain);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, KERNEL_SPLIT, list, (vectors_across(plan) + 3) / 4,
                    plan->config.height, 1);
  return status == HBIL_SUCCESS ? sum_up(plan, chain, CL_FALSE) : status;
}
