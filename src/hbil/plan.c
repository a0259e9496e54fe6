/* A plan's state: what a frame leaves to the next one, and its stages. */
#include "plan.h"

#include <stdlib.h>
#include <string.h>

#include "camera.h"
#include "checks.h"
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

void plan_retain(hbil_plan *plan) {
  if (plan)
    ++plan->references;
}

void plan_release(hbil_plan *plan) {
  if (!plan || --plan->references)
    return;
  forget_times(&plan->times);
  kernels_release(&plan->kernels);
  kernels_release(&plan->ao.kernels);
  buffers_release(plan->buffers, BUFFER_COUNT);
  timeline_end(&plan->line);
  context_release(plan->context);
  free(plan);
}

/* --- the last frame --- */

/* other: NULL: the next frame goes on with the plan's own light. */
static void follow(hbil_plan *plan, hbil_plan *other) {
  plan_retain(other);
  plan_release(plan->followed);
  plan->followed = other;
}

int next_history(const hbil_plan *plan) {
  return plan->layout.bytes[BUFFER_HISTORY_NEXT]
             ? BUFFER_HISTORY + !plan->history
             : BUFFER_HISTORY;
}

/* Whether a frame may have anything of the last one. */
static bool carries_over(const hbil_plan *plan) {
  return plan->config.history.reprojection != HBIL_REPROJECTION_NONE;
}

/* needed: a frame without it has no history either. */
static void alternate(alternating *a, const hbil_frame *frame, bool needed) {
  if (a->written) {
    a->last = !a->last;
    a->has = true;
    a->camera = frame->camera;
  }
  a->has &= needed;
  a->written = false;
}

static void adopt(alternating *a, const hbil_camera *camera, bool has) {
  a->has = has;
  a->written = false;
  a->camera = *camera;
}

void remember_frame(hbil_plan *plan, const hbil_frame *frame) {
  plan->has_last = true;
  plan->last_searched_all = plan->searched_all;
  plan->last_camera = frame->camera;
  plan->last_index = frame->frame_index;
  plan->last_exposure = light_exposure(frame->exposure);
  if (plan->layout.history) {
    const cl_uint bounces = plan_bounces(plan);
    plan->bounces = bounces < MOST_BOUNCES ? bounces + 1 : MOST_BOUNCES;
    plan->has_history = true;
    plan->history = next_history(plan) - BUFFER_HISTORY;
    plan->history_camera = frame->camera;
  }
  follow(plan, NULL);
  plan->adopted = false;
  alternate(&plan->slices, frame, !plan->searched_all);
  alternate(&plan->probes, frame, frame->cache && carries_over(plan));
}

void hbil_plan_reset(hbil_plan *plan) {
  if (!plan)
    return;
  plan->has_history = plan->has_last = plan->slices.has = plan->probes.has =
      plan->adopted = false;
  follow(plan, NULL);
}

/* Why a plan's light means nothing to another plan; NULL: it does. */
static const char *difference(const hbil_plan *plan, const hbil_plan *last) {
  const hbil_config *a = &plan->config, *b = &last->config;
  return plan->context != last->context                 ? "contexts"
         : a->inputs.projection != b->inputs.projection ? "inputs.projection"
         : a->sampling.storage != b->sampling.storage   ? "sampling.storage"
         : a->model.feedback != b->model.feedback       ? "model.feedback"
         : plan->layout.history != last->layout.history
             ? "history.reprojection, or outputs that show light"
             : NULL;
}

hbil_status hbil_plan_follow(hbil_plan *plan, hbil_plan *last) {
  if (!plan || !last)
    return fail_null(plan ? plan->context : NULL, __func__,
                     plan ? "last" : "plan");
  const char *differs = difference(plan, last);
  if (differs)
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "last: a plan of other %s; plans that differ in size, sampling "
                "and outputs can follow one another",
                differs);
  if (plan == last)
    return HBIL_SUCCESS;
  hbil_plan_reset(plan);
  if (last->has_history) {
    /* without a frame of its own, it has the light of the plan that it follows,
     * which may be this one */
    hbil_plan *const owner = last->followed ? last->followed : last;
    plan->has_history = true;
    plan->bounces = last->bounces;
    plan->history_camera = last->history_camera;
    follow(plan, owner == plan ? NULL : owner);
    plan->adopted = last->adopted;
  }
  return HBIL_SUCCESS;
}

cl_uint plan_bounces(const hbil_plan *plan) {
  return plan->has_history ? plan->bounces : 0;
}

hbil_status hbil_plan_last_frame(const hbil_plan *plan, hbil_last_frame *out) {
  if (!plan || !out)
    return fail_null(plan ? plan->context : NULL, __func__,
                     plan ? "out" : "plan");
  memset(out, 0, sizeof *out); /* its padding too: it may go into a file */
  if (plan->has_history)
    out->camera = plan->history_camera;
  else if (plan->has_last || plan->slices.has || plan->probes.has)
    out->camera = plan->last_camera;
  out->bounces = plan_bounces(plan);
  out->has_slices = plan->slices.has;
  out->has_probes = plan->probes.has;
  return HBIL_SUCCESS;
}

hbil_status hbil_plan_adopt_history(hbil_plan *plan,
                                    const hbil_last_frame *last) {
  if (!plan || !last)
    return fail_null(plan ? plan->context : NULL, __func__,
                     plan ? "last" : "plan");
  static const hbil_camera none = {.fx = 0.0};
  const bool is_none = !last->bounces && !last->has_slices &&
                       !last->has_probes &&
                       !memcmp(&last->camera, &none, sizeof none);
  const hbil_status status =
      is_none ? HBIL_SUCCESS : camera_check(plan->context, &last->camera);
  if (status != HBIL_SUCCESS)
    return status;
  hbil_plan_reset(plan);
  plan->has_history = plan->layout.history && last->bounces > 0;
  plan->bounces = last->bounces < MOST_BOUNCES ? last->bounces : MOST_BOUNCES;
  plan->history_camera = plan->last_camera = last->camera;
  plan->adopted = true;
  adopt(&plan->slices, &last->camera,
        last->has_slices && plan->layout.slice_frames > 1);
  adopt(&plan->probes, &last->camera,
        last->has_probes && plan->layout.probes && carries_over(plan));
  return HBIL_SUCCESS;
}

static int buffer_of_stage(const hbil_plan *plan, hbil_stage stage) {
  static const int first[] = {[HBIL_STAGE_HISTORY] = BUFFER_HISTORY,
                              [HBIL_STAGE_CARRIED] = BUFFER_CARRIED,
                              [HBIL_STAGE_SPLIT] = BUFFER_SPLIT,
                              [HBIL_STAGE_GATHERED] = BUFFER_LIGHT,
                              [HBIL_STAGE_RESOLVED] = BUFFER_RESOLVED,
                              [HBIL_STAGE_SLICES] = BUFFER_SLICES,
                              [HBIL_STAGE_AO_GATHERED] = BUFFER_AO_LIGHT,
                              [HBIL_STAGE_AO_RESOLVED] = BUFFER_AO_RESOLVED,
                              [HBIL_STAGE_AO_SLICES] = BUFFER_AO_SLICES,
                              [HBIL_STAGE_PROBE_HISTORY] =
                                  BUFFER_PROBE_HISTORY};
  switch (stage) {
  case HBIL_STAGE_HISTORY:
    return first[stage] + plan->history;
  case HBIL_STAGE_SLICES:
  case HBIL_STAGE_AO_SLICES:
    return first[stage] + plan->slices.last;
  case HBIL_STAGE_PROBE_HISTORY:
    return first[stage] + plan->probes.last;
  default:
    return first[stage];
  }
}

/* What a plan must have for the stage. */
static const char *missing_stage(const hbil_plan *plan, hbil_stage stage) {
  const bool of_ao = stage == HBIL_STAGE_AO_GATHERED ||
                     stage == HBIL_STAGE_AO_RESOLVED ||
                     stage == HBIL_STAGE_AO_SLICES;
  if (of_ao && !plan->layout.ao_search)
    return "search of its own for ao, bent_normal and cone_cosine";
  switch (stage) {
  case HBIL_STAGE_SLICES:
  case HBIL_STAGE_AO_SLICES:
    return "HBIL_STAGE_SLICES (sampling.slice_frames is 1, or glossy an "
           "output)";
  case HBIL_STAGE_PROBE_HISTORY:
    return "HBIL_STAGE_PROBE_HISTORY (no light of a radiance cache is shown)";
  case HBIL_STAGE_CARRIED:
    return "HBIL_STAGE_CARRIED (no light is carried over)";
  default:
    return "HBIL_STAGE_HISTORY (no light is carried over)";
  }
}

hbil_status hbil_plan_buffer(const hbil_plan *plan, hbil_stage stage,
                             hbil_buffer *out) {
  if (!plan || !out)
    return fail_null(plan ? plan->context : NULL, __func__,
                     plan ? "out" : "plan");
  if ((unsigned)stage > HBIL_STAGE_PROBE_HISTORY)
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "stage: %d; must be one of hbil_stage, 0 to %d", (int)stage,
                (int)HBIL_STAGE_PROBE_HISTORY);
  const layout *l =
      stage == HBIL_STAGE_AO_GATHERED || stage == HBIL_STAGE_AO_RESOLVED
          ? &plan->ao.layout
          : &plan->layout;
  const int buffer = buffer_of_stage(plan, stage);
  memset(out, 0, sizeof *out);
  if (!plan->buffers[buffer])
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "stage: this plan has no %s", missing_stage(plan, stage));
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
  if (stage == HBIL_STAGE_SLICES || stage == HBIL_STAGE_AO_SLICES) {
    out->plane_pitch = out->row_pitch =
        plan->layout.bytes[buffer] / sizeof(cl_float);
    out->values = 1;
    return HBIL_SUCCESS;
  }
  if (stage == HBIL_STAGE_PROBE_HISTORY) {
    const hbil_probe_grid_args *grid = &l->probe_grid;
    out->row_pitch = HBIL_PROBE_FLOATS * (size_t)grid->columns;
    out->plane_pitch = out->row_pitch * (size_t)grid->lines;
    out->values = 1;
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
