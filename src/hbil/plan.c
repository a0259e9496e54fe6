/* A plan: the kernels and buffers of one configuration. */
#include "plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "config.h"
#include "hbil/hbil_stages.h"
#include "import.h"
#include "kernel_table.h"
#include "memory.h"
#include "camera.h"
#include "trial.h"

/* --- programs and kernels --- */

/* The gather waits for its samples, so many work-items that spill some of their
 * registers are faster than few that spill none: 1.00 ms with 64 on an H200,
 * 1.03 with 80, 1.09 with 96 and 1.23 with 110, which it would take. */
enum { GATHER_REGISTERS = 64 };

static const program_kind programs[PROGRAM_COUNT] = {
    [PROGRAM_REPROJECT] = {"reproject", .defines = ""},
    [PROGRAM_PUSH_PULL] = {"push_pull", .defines = ""},
    [PROGRAM_LAYERS] = {"layers", .defines = ""},
    [PROGRAM_SPLIT] = {"split", .defines = ""},
    [PROGRAM_ESTIMATE] = {"estimate", .defines = ""},
    [PROGRAM_GATHER] = {"gather", .relaxed = true,
                        .defines = "-DCACHE_HORIZONS=0",
                        .registers = GATHER_REGISTERS},
    [PROGRAM_GATHER_AND_CACHE] = {"gather", .relaxed = true,
                                  .defines = "-DCACHE_HORIZONS=1",
                                  .registers = GATHER_REGISTERS},
    [PROGRAM_REGATHER] = {"regather", .relaxed = true, .defines = ""},
    [PROGRAM_RECOMPOSE] = {"recompose", .relaxed = true, .defines = ""},
    [PROGRAM_TEMPORAL] = {"temporal", .defines = ""},
    [PROGRAM_PROBE_RAYS] = {"cache/probe_rays", .relaxed = true, .defines = ""},
    [PROGRAM_PROBE_CONES] = {"cache/probe_cones", .relaxed = true,
                             .defines = "-DHBIL_WIDTH=1"},
    [PROGRAM_PROBE_LPV] = {"cache/probe_lpv", .defines = "-DHBIL_WIDTH=1"},
    [PROGRAM_PROBE_RSM] = {"cache/probe_rsm", .relaxed = true,
                           .defines = "-DHBIL_WIDTH=1"},
    [PROGRAM_FILTER_PROBES] = {"cache/filter_probes", .relaxed = true,
                               .defines = ""},
    [PROGRAM_PROBE_GLOSSY] = {"cache/probe_glossy", .relaxed = true,
                              .defines = ""},
    [PROGRAM_GLOSSY] = {"glossy", .defines = ""},
    [PROGRAM_COMPOSITE] = {"composite", .defines = ""},
    [PROGRAM_IMPORT] = {"import", .defines = ""},
    [PROGRAM_EXPORT] = {"export", .defines = ""},
    [PROGRAM_NORMALS_FROM_DEPTH] = {"normals_from_depth", .defines = ""},
};

static const kernel_kind kernels[KERNEL_COUNT] = {
    [KERNEL_REPROJECT] = {"reproject", PROGRAM_REPROJECT},
    [KERNEL_FIND_HOLES] = {"find_holes", PROGRAM_PUSH_PULL},
    [KERNEL_PUSH] = {"push", PROGRAM_PUSH_PULL},
    [KERNEL_PULL] = {"pull", PROGRAM_PUSH_PULL},
    [KERNEL_CLEAR_PADDING] = {"clear_padding", PROGRAM_LAYERS},
    [KERNEL_SPLIT] = {"split", PROGRAM_SPLIT},
    [KERNEL_RELIGHT] = {"relight", PROGRAM_SPLIT},
    [KERNEL_BOUND_CELLS] = {"bound_cells", PROGRAM_LAYERS},
    [KERNEL_BOUND_QUADRANTS] = {"bound_quadrants", PROGRAM_LAYERS},
    [KERNEL_ESTIMATE_PART] = {"estimate_part", PROGRAM_ESTIMATE},
    [KERNEL_ESTIMATE_LANES] = {"estimate_lanes", PROGRAM_ESTIMATE},
    [KERNEL_ESTIMATE_SUM] = {"estimate_sum", PROGRAM_ESTIMATE},
    [KERNEL_ESTIMATE_FILL] = {"estimate_fill", PROGRAM_ESTIMATE},
    [KERNEL_PATTERN] = {"make_pattern", PROGRAM_LAYERS},
    [KERNEL_GATHER] = {"gather", PROGRAM_GATHER},
    [KERNEL_GATHER_AND_CACHE] = {"gather", PROGRAM_GATHER_AND_CACHE},
    [KERNEL_REGATHER] = {"regather", PROGRAM_REGATHER},
    [KERNEL_RECOMPOSE] = {"recompose", PROGRAM_RECOMPOSE},
    [KERNEL_TEMPORAL] = {"temporal", PROGRAM_TEMPORAL},
    [KERNEL_PROBE_RAYS] = {"probe_rays", PROGRAM_PROBE_RAYS},
    [KERNEL_PROBE_CONES] = {"probe_cones", PROGRAM_PROBE_CONES},
    [KERNEL_PROBE_LPV] = {"probe_lpv", PROGRAM_PROBE_LPV},
    [KERNEL_PROBE_RSM] = {"probe_rsm", PROGRAM_PROBE_RSM},
    [KERNEL_FILTER_PROBES] = {"filter_probes", PROGRAM_FILTER_PROBES},
    [KERNEL_PROBE_GLOSSY] = {"probe_glossy", PROGRAM_PROBE_GLOSSY},
    [KERNEL_GLOSSY] = {"glossy", PROGRAM_GLOSSY},
    [KERNEL_COMPOSITE] = {"composite", PROGRAM_COMPOSITE},
    [KERNEL_IMPORT_IMAGE] = {"import_image", PROGRAM_IMPORT},
    [KERNEL_EXPORT_IMAGE] = {"export_image", PROGRAM_EXPORT},
    [KERNEL_NORMALS_FROM_DEPTH] = {"normals_from_depth",
                                   PROGRAM_NORMALS_FROM_DEPTH},
};

static const kernel_table table = {programs, kernels, PROGRAM_COUNT,
                                   KERNEL_COUNT};

static bool program_needed(const hbil_plan *plan, int program) {
  const layout *l = &plan->layout;
  const unsigned inputs = PLANE_BIT(PLANE_FIRST_OUTPUT) - 1;
  switch (program) {
  case PROGRAM_REPROJECT:
  case PROGRAM_PUSH_PULL:
    return l->history;
  case PROGRAM_ESTIMATE:
    return l->estimate;
  case PROGRAM_GATHER_AND_CACHE:
  case PROGRAM_REGATHER:
    return l->bytes[BUFFER_HORIZON_CACHE] > 0;
  case PROGRAM_TEMPORAL:
    return plan->config.history.max_frames > 0;
  case PROGRAM_PROBE_RAYS:
  case PROGRAM_PROBE_CONES:
  case PROGRAM_PROBE_LPV:
  case PROGRAM_PROBE_RSM:
    return l->probes && program - PROGRAM_PROBE_RAYS + HBIL_PROVIDER_RAYS ==
                            (int)plan->config.model.provider;
  case PROGRAM_FILTER_PROBES:
    return l->probes;
  case PROGRAM_PROBE_GLOSSY:
    return l->probes && l->glossy;
  case PROGRAM_GLOSSY:
    return l->glossy;
  case PROGRAM_IMPORT:
    return (l->staged.images & inputs) != 0;
  case PROGRAM_EXPORT:
    return (l->staged.images & ~inputs) != 0;
  case PROGRAM_NORMALS_FROM_DEPTH:
    return l->staged.planes != l->staged.images;
  }
  return true;
}

static bool kernel_needed(const hbil_plan *plan, int kernel) {
  if (!program_needed(plan, kernels[kernel].program))
    return false;
  if (kernel == KERNEL_RELIGHT)
    return plan->layout.history && plan->layout.skip & HBIL_SKIP_STATIC;
  if (kernel == KERNEL_ESTIMATE_LANES)
    return plan->layout.estimate_lanes > 1;
  if (kernel == KERNEL_BOUND_CELLS || kernel == KERNEL_BOUND_QUADRANTS)
    return plan->layout.bytes[BUFFER_BOUNDS] > 0;
  return true;
}

/* identity: of each program that the plan needs. */
static hbil_status build_kernels(hbil_plan *plan,
                                 binary_identity identity[PROGRAM_COUNT]) {
  bool needed[KERNEL_COUNT];
  for (int i = 0; i < KERNEL_COUNT; ++i)
    needed[i] = kernel_needed(plan, i);
  program_report_folder(plan->context);
  return kernels_build(plan->context, &table, needed, &plan->config,
                       &plan->layout, plan->programs, plan->kernels, identity);
}

/* --- the first commands --- */

/* Writes what no kernel writes: counts of inputs that this plan never reads,
 * and the padding, which frames clear in scratch memory of the caller's. */
static hbil_status write_first(hbil_plan *plan, cl_command_queue queue) {
  commands chain = commands_of_plan(plan, queue);
  chain.in_order = true;
  const hbil_status status = enqueue_fill(&chain, BUFFER_SANITIZED, 0);
  return status == HBIL_SUCCESS && !plan->lent.memory ? clear_padding(&chain)
                                                      : status;
}

/* Makes the plan ready for its first frame. */
static hbil_status prepare(void *object, cl_command_queue queue) {
  hbil_plan *plan = object;
  const hbil_status status = write_first(plan, queue);
  return status == HBIL_SUCCESS ? launch_every_kernel(plan, queue) : status;
}

/* --- public --- */

/* What a plan of the caller's config is: the config, checked and without
 * defaults, and the sizes.  If vector_width is 0, it is chosen for the device.
 * sky_depth is limited to HBIL_FARTHEST_DEPTH, and the horizon cache to the
 * largest buffer. */
static hbil_status lay_out(hbil_context *context, const hbil_config *given,
                           hbil_config *resolved, layout *sizes) {
  buffer_limits limits;
  staging staged;
  hbil_status status = config_take(context, given, resolved);
  if (status == HBIL_SUCCESS)
    status = stage_planes(context, resolved, &staged);
  if (status == HBIL_SUCCESS)
    status = memory_limits(context, &limits);
  if (status != HBIL_SUCCESS)
    return status;
  if (!resolved->execution.vector_width)
    resolved->execution.vector_width = context->vector_width;
  if (resolved->execution.horizon_cache_bytes > limits.largest)
    resolved->execution.horizon_cache_bytes = limits.largest;
  resolved->inputs.sky_depth =
      fminf(resolved->inputs.sky_depth, HBIL_FARTHEST_DEPTH);
  layout_compute(resolved, &staged, limits.alignment, sizes);
  for (int i = 0; i < BUFFER_COUNT; ++i)
    if (sizes->bytes[i] > limits.largest)
      return fail(context, HBIL_OUT_OF_DEVICE_MEMORY,
                  "width, height: %u x %u pixels need a buffer of %zu bytes, "
                  "the device allows %zu",
                  (unsigned)resolved->width, (unsigned)resolved->height,
                  sizes->bytes[i], limits.largest);
  return HBIL_SUCCESS;
}

hbil_status hbil_plan_memory(hbil_context *context, const hbil_config *config,
                             hbil_memory *out) {
  layout sizes;
  hbil_config resolved;
  if (!context || !config || !out)
    return fail_null(context, __func__,
                     !context  ? "context"
                     : !config ? "config"
                               : "out");
  const hbil_status status = lay_out(context, config, &resolved, &sizes);
  if (status == HBIL_SUCCESS)
    *out = sizes.memory;
  return status;
}

/* scratch: null, or the caller's */
static hbil_status create(hbil_context *context, const hbil_config *config,
                          cl_mem scratch, hbil_plan **out) {
  layout sizes;
  hbil_config resolved;
  memory_range lent = {NULL, 0, 0};
  hbil_status status = lay_out(context, config, &resolved, &sizes);
  if (status == HBIL_SUCCESS && scratch)
    status = check_lent(context, scratch, sizes.memory.scratch, &lent);
  if (status != HBIL_SUCCESS)
    return status;
  hbil_plan *plan = calloc(1, sizeof *plan);
  if (!plan)
    return fail(context, HBIL_OUT_OF_HOST_MEMORY, "no memory for a plan");
  plan->context = context;
  context_retain(context);
  plan->config = resolved;
  plan->layout = sizes;
  plan->lent = lent;
  binary_identity identity[PROGRAM_COUNT];
  if ((status = build_kernels(plan, identity)) != HBIL_SUCCESS ||
      (status = allocate(plan)) != HBIL_SUCCESS ||
      (status = run_first_commands(context, prepare, plan)) != HBIL_SUCCESS) {
    hbil_plan_destroy(plan);
    return status;
  }
  kernels_store(context, &table, plan->programs, identity);
  *out = plan;
  return HBIL_SUCCESS;
}

hbil_status hbil_plan_create(hbil_context *context, const hbil_config *config,
                             hbil_plan **out) {
  if (out)
    *out = NULL;
  if (!context || !config || !out)
    return fail_null(context, __func__,
                     !context  ? "context"
                     : !config ? "config"
                               : "out");
  return create(context, config, NULL, out);
}

hbil_status hbil_plan_create_in(hbil_context *context,
                                const hbil_config *config, cl_mem scratch,
                                hbil_plan **out) {
  if (out)
    *out = NULL;
  if (!context || !config || !scratch || !out)
    return fail_null(context, __func__,
                     !context   ? "context"
                     : !config  ? "config"
                     : !scratch ? "scratch"
                                : "out");
  return create(context, config, scratch, out);
}

void hbil_plan_destroy(hbil_plan *plan) {
  if (!plan)
    return;
  for (int i = 0; i < plan->launches; ++i)
    clReleaseEvent(plan->events[i]);
  kernels_release(&table, plan->programs, plan->kernels);
  for (int i = 0; i < BUFFER_COUNT; ++i)
    if (plan->buffers[i])
      clReleaseMemObject(plan->buffers[i]);
  timeline_end(&plan->line);
  context_release(plan->context);
  free(plan);
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
  static const int of_stage[] = {BUFFER_HISTORY,  BUFFER_CARRIED,
                                 BUFFER_SPLIT,    BUFFER_LIGHT,
                                 BUFFER_RESOLVED, BUFFER_TEMPORAL};
  if (!plan || !out)
    return fail_null(plan ? plan->context : NULL, __func__,
                     plan ? "out" : "plan");
  if ((unsigned)stage > HBIL_STAGE_TEMPORAL_HISTORY)
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "stage: %d; must be one of hbil_stage, 0 to %d", (int)stage,
                (int)HBIL_STAGE_TEMPORAL_HISTORY);
  const layout *l = &plan->layout;
  const int buffer =
      of_stage[stage] + (stage == HBIL_STAGE_TEMPORAL_HISTORY ? plan->temporal
                         : stage == HBIL_STAGE_HISTORY        ? plan->history
                                                              : 0);
  memset(out, 0, sizeof *out);
  if (!plan->buffers[buffer])
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "stage: this plan has no %s",
                stage == HBIL_STAGE_TEMPORAL_HISTORY
                    ? "HBIL_STAGE_TEMPORAL_HISTORY (history.max_frames is 0)"
                : stage == HBIL_STAGE_CARRIED
                    ? "HBIL_STAGE_CARRIED (no light is carried over)"
                    : "HBIL_STAGE_HISTORY (no light is carried over)");
  out->buffer = plan->buffers[buffer];
  if (stage == HBIL_STAGE_SPLIT || stage == HBIL_STAGE_GATHERED) {
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
  if (stage == HBIL_STAGE_RESOLVED) {
    out->values = l->resolved_planes;
    return HBIL_SUCCESS;
  }
  if (stage != HBIL_STAGE_CARRIED)
    out->origin = hbil_history_origin(l->planes);
  out->values =
      (cl_uint)((l->bytes[buffer] / sizeof(cl_float) - 2 * out->origin) /
                out->plane_pitch);
  if (stage == HBIL_STAGE_CARRIED) /* coarser levels follow */
    out->values = l->carried_planes;
  return HBIL_SUCCESS;
}
