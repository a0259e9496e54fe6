/* Trial launches: frames without pixels. */
#include "trial.h"

#include "import.h"
#include "passes.h"

/* Frames whose passes launch every kernel that a plan has: the first one,
 * another one with light to carry over, a static one, which fills the horizon
 * cache, and another static one, which reads it. */
enum { FRAMES = 4, FIRST_STATIC = 2 };

static commands trial_commands(hbil_plan *plan, cl_command_queue queue,
                               trial_launches *trial) {
  commands chain = commands_of_plan(plan, queue);
  chain.in_order = true;
  chain.trial = trial;
  return chain;
}

static hbil_status run_passes(hbil_plan *plan, cl_command_queue queue,
                              const hbil_frame *frame, trial_launches *trial) {
  static pass_function *const passes[] = {
      enqueue_reproject, enqueue_push_pull, enqueue_split,    enqueue_gather,
      enqueue_recompose, enqueue_temporal,  enqueue_composite};
  commands import = trial_commands(plan, queue, trial);
  hbil_status status = try_import(&import, frame);
  for (size_t i = 0; i < sizeof passes / sizeof *passes; ++i) {
    /* one by one, as callers may: push_pull looks for holes then */
    commands chain = trial_commands(plan, queue, trial);
    if (status == HBIL_SUCCESS)
      status = passes[i](&chain, frame);
  }
  if (status == HBIL_SUCCESS)
    remember_frame(plan, frame);
  return status;
}

hbil_status launch_every_kernel(hbil_plan *plan, cl_command_queue queue) {
  const hbil_plan before = *plan;
  trial_launches trial = {.launched = {{false}}};
  hbil_frame frame;
  hbil_status status = HBIL_SUCCESS;
  hbil_frame_init(&frame);
  frame.camera.fx = frame.camera.fy = 1.0;
  for (int i = 0; i < 4; ++i)
    frame.camera.world_from_view[5 * i] = 1.0;
  for (int i = 0; i < FRAMES && status == HBIL_SUCCESS; ++i) {
    frame.static_frame = i >= FIRST_STATIC;
    status = run_passes(plan, queue, &frame, &trial);
  }
  *plan = before;
  return status;
}
