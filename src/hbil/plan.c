/* A plan's state: what a frame leaves to the next one, and its stages. */
#include "plan.h"

#include <string.h>

#include "camera.h"
#include "hbil/hbil_stages.h"

/* --- what passes use of it --- */

commands commands_of_plan(hbil_plan *plan, cl_command_queue queue) {
  return (commands){.context = plan->context,
                    .kernels = &plan->kernels,
                    .line = {&plan->line, NULL},
                    .times =
                        plan->config.execution.profiling ? &plan->times : NULL,
                    .queue = queue};
}

cl_mem bind_plane(const hbil_plan *plan, const hbil_frame *frame, int plane,
                  hbil_external_plane_args *args) {
  if (!(plan->layout.staged.planes & PLANE_BIT(plane)))
    return plane_bind(&plan->config, frame, plane, args);
  *args = (hbil_external_plane_args){.row = plan->layout.planes.row,
                                     .plane = plan->layout.planes.plane};
  return plan->buffers[BUFFER_STAGED + plane];
}

surface_buffers bind_surface(const hbil_plan *plan, const hbil_frame *frame,
                             hbil_surface_args *args) {
  args->direct_scale = plan->config.inputs.direct_scale;
  return (surface_buffers){
      bind_plane(plan, frame, PLANE_ALBEDO, &args->albedo),
      bind_plane(plan, frame, PLANE_F0, &args->f0),
      bind_plane(plan, frame, PLANE_DIRECT, &args->direct),
      bind_plane(plan, frame, PLANE_EMISSION, &args->emission)};
}

hbil_status set_flag(const hbil_plan *plan, commands *chain, int flag,
                     cl_uint value) {
  return fill_memory(chain, plan->buffers[BUFFER_FLAGS], value,
                     (size_t)flag * sizeof value, sizeof value);
}

hbil_status clear_counts(const hbil_plan *plan, commands *chain, int first,
                         int words) {
  return fill_memory(chain, plan->buffers[BUFFER_SANITIZED], 0,
                     (size_t)first * sizeof(cl_uint),
                     (size_t)words * sizeof(cl_uint));
}

/* --- the last frame --- */

int next_history(const hbil_plan *plan) {
  return plan->layout.bytes[BUFFER_HISTORY_NEXT]
             ? BUFFER_HISTORY + !plan->history
             : BUFFER_HISTORY;
}

void remember_frame(hbil_plan *plan, const hbil_frame *frame) {
  plan->has_last = true;
  plan->last_camera = frame->camera;
  plan->last_index = frame->frame_index;
  if (plan->layout.history) {
    const cl_uint bounces = hbil_plan_bounces(plan);
    plan->bounces = bounces < MOST_BOUNCES ? bounces + 1 : MOST_BOUNCES;
    plan->has_history = true;
    plan->history = next_history(plan) - BUFFER_HISTORY;
    plan->history_camera = frame->camera;
  }
  if (plan->temporal_written) {
    plan->temporal_written = false;
    plan->temporal = !plan->temporal;
    plan->has_temporal = true;
    plan->temporal_camera = frame->camera;
  }
}

void hbil_plan_reset(hbil_plan *plan) {
  if (plan)
    plan->has_history = plan->has_last = plan->has_temporal = false;
}

cl_uint hbil_plan_bounces(const hbil_plan *plan) {
  return plan && plan->has_history ? plan->bounces : 0;
}

hbil_status hbil_plan_adopt_history(hbil_plan *plan, const hbil_camera *camera,
                                    cl_uint bounces) {
  if (!plan || !camera)
    return fail_null(plan ? plan->context : NULL, __func__,
                     plan ? "camera" : "plan");
  const hbil_status status = camera_check(plan->context, camera);
  if (status != HBIL_SUCCESS)
    return status;
  hbil_plan_reset(plan);
  plan->has_history = plan->layout.history && bounces > 0;
  plan->bounces = bounces < MOST_BOUNCES ? bounces : MOST_BOUNCES;
  plan->history_camera = *camera;
  plan->has_temporal = plan->config.history.max_frames > 0;
  plan->temporal_written = false;
  plan->temporal_camera = *camera;
  return HBIL_SUCCESS;
}

hbil_status hbil_plan_buffer(const hbil_plan *plan, hbil_stage stage,
                             hbil_buffer *out) {
  static const int of_stage[] = {
      [HBIL_STAGE_HISTORY] = BUFFER_HISTORY,
      [HBIL_STAGE_CARRIED] = BUFFER_CARRIED,
      [HBIL_STAGE_SPLIT] = BUFFER_SPLIT,
      [HBIL_STAGE_GATHERED] = BUFFER_LIGHT,
      [HBIL_STAGE_RESOLVED] = BUFFER_RESOLVED,
      [HBIL_STAGE_TEMPORAL_HISTORY] = BUFFER_TEMPORAL,
      [HBIL_STAGE_AO_GATHERED] = BUFFER_AO_LIGHT,
      [HBIL_STAGE_AO_RESOLVED] = BUFFER_AO_RESOLVED,
      [HBIL_STAGE_AO_TEMPORAL_HISTORY] = BUFFER_AO_TEMPORAL};
  if (!plan || !out)
    return fail_null(plan ? plan->context : NULL, __func__,
                     plan ? "out" : "plan");
  if ((unsigned)stage > HBIL_STAGE_AO_TEMPORAL_HISTORY)
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "stage: %d; must be one of hbil_stage, 0 to %d", (int)stage,
                (int)HBIL_STAGE_AO_TEMPORAL_HISTORY);
  const bool of_ao = stage >= HBIL_STAGE_AO_GATHERED;
  const bool averaged = stage == HBIL_STAGE_TEMPORAL_HISTORY ||
                        stage == HBIL_STAGE_AO_TEMPORAL_HISTORY;
  const layout *l = of_ao ? &plan->ao.layout : &plan->layout;
  const int buffer =
      of_stage[stage] + (averaged                      ? plan->temporal
                         : stage == HBIL_STAGE_HISTORY ? plan->history
                                                       : 0);
  memset(out, 0, sizeof *out);
  if (!plan->buffers[buffer])
    return fail(
        plan->context, HBIL_INVALID_ARGUMENT, "stage: this plan has no %s",
        of_ao && !plan->layout.ao_search
            ? "search of its own for ao, bent_normal and cone_cosine"
        : averaged ? "HBIL_STAGE_TEMPORAL_HISTORY (history.max_frames is 0)"
        : stage == HBIL_STAGE_CARRIED
            ? "HBIL_STAGE_CARRIED (no light is carried over)"
            : "HBIL_STAGE_HISTORY (no light is carried over)");
  out->buffer = plan->buffers[buffer];
  if (stage == HBIL_STAGE_SPLIT || stage == HBIL_STAGE_GATHERED ||
      stage == HBIL_STAGE_AO_GATHERED) {
    const hbil_layer_args *layers =
        stage == HBIL_STAGE_SPLIT ? &l->split : &l->light;
    out->plane_pitch = layers->plane;
    out->row_pitch = layers->row;
    out->layer_pitch = layers->layer;
    out->origin = layers->origin;
    out->values = layers->layer / layers->plane;
    return HBIL_SUCCESS;
  }
  out->plane_pitch = l->planes.plane;
  out->row_pitch = l->planes.row;
  if (stage == HBIL_STAGE_RESOLVED || stage == HBIL_STAGE_AO_RESOLVED) {
    out->values = l->resolved_planes;
    return HBIL_SUCCESS;
  }
  if (stage != HBIL_STAGE_CARRIED)
    out->origin = hbil_history_origin(l->planes);
  out->values = (cl_uint)((plan->layout.bytes[buffer] / sizeof(cl_float) -
                           2 * out->origin) /
                          out->plane_pitch);
  if (stage == HBIL_STAGE_CARRIED) /* coarser levels follow */
    out->values = l->carried_planes;
  return HBIL_SUCCESS;
}
