/* Settings of a cache: defaults, and the rejection of what is out of range. */
#include "cache_config.h"

#include <math.h>

#include "checks.h"
#include "config.h"
#include "far_field.h"
#include "lib/cache_args.h"
#include "planes.h"
#include "sized.h"

/* Bytes in version 0.1 (sized.h). */
enum {
  FIRST_CACHE_CONFIG_SIZE = SIZE_UP_TO(hbil_cache_config, method),
  FIRST_VIEW_SIZE = SIZE_UP_TO(hbil_view, static_view),
  FIRST_UPDATE_SIZE = SIZE_UP_TO(hbil_cache_update, exposure),
  FIRST_CHANGE_SIZE = SIZE_UP_TO(hbil_cache_change, light)
};

/* --- defaults --- */

void hbil_cache_config_init_sized(hbil_cache_config *config,
                                  size_t struct_size) {
  hbil_config inputs;
  hbil_config_init(&inputs);
  const hbil_cache_config defaults = {.voxels = 64,
                                      .levels = 2,
                                      .inputs = inputs.inputs,
                                      .gather_emission = CL_TRUE,
                                      .unseen_light = 0.8f,
                                      .method = HBIL_CACHE_METHOD_RAYS};
  init_sized(config, struct_size, &defaults, sizeof defaults);
}

void hbil_view_init_sized(hbil_view *view, size_t struct_size) {
  static const hbil_view nothing;
  init_sized(view, struct_size, &nothing, sizeof nothing);
}

void hbil_cache_update_init_sized(hbil_cache_update *update,
                                  size_t struct_size) {
  static const hbil_cache_update defaults = {
      .bounces = 4, .phases = 1, .far_field = HBIL_FAR_AUTO, .steps = 16};
  init_sized(update, struct_size, &defaults, sizeof defaults);
}

void hbil_cache_change_init_sized(hbil_cache_change *change,
                                  size_t struct_size) {
  static const hbil_cache_change everywhere = {
      .low = {-INFINITY, -INFINITY, -INFINITY},
      .high = {INFINITY, INFINITY, INFINITY}};
  init_sized(change, struct_size, &everywhere, sizeof everywhere);
}

/* --- a cache --- */

static hbil_status check_ranges(hbil_context *context,
                                const hbil_cache_config *c) {
  const cl_uint n = c->voxels;
  if (n < 16 || n > HBIL_CACHE_MOST_VOXELS || (n & (n - 1)))
    return fail(context, HBIL_INVALID_CONFIG,
                "voxels: %u; must be 16, 32, 64, 128 or 256", (unsigned)n);
  if (c->levels < 1 || c->levels > HBIL_CACHE_MAX_LEVELS)
    return fail(context, HBIL_INVALID_CONFIG, "levels: %u is outside 1 .. %d",
                (unsigned)c->levels, HBIL_CACHE_MAX_LEVELS);
  if (!(c->voxel_size >= 1e-6 && c->voxel_size <= 1e6))
    return fail(context, HBIL_INVALID_CONFIG,
                "voxel_size: %g is outside 1e-06 .. 1e+06 (world units across "
                "a voxel of the first level)",
                c->voxel_size);
  for (int i = 0; i < 3; ++i)
    if (!(fabs(c->centre[i]) / c->voxel_size < CACHE_FARTHEST_MIDDLE))
      return fail(context, HBIL_INVALID_CONFIG,
                  "centre[%d]: %g; must be finite and less than 2^52 voxels "
                  "away",
                  i, c->centre[i]);
  if (!(c->unseen_light >= 0.0f && c->unseen_light <= 1.0f))
    return fail(context, HBIL_INVALID_CONFIG,
                "unseen_light: %g is outside 0 .. 1", (double)c->unseen_light);
  if (c->method < HBIL_CACHE_METHOD_RAYS || c->method > HBIL_CACHE_METHOD_RSM)
    return fail(context, HBIL_INVALID_CONFIG,
                "method: %d; must be one of hbil_cache_method, and not "
                "HBIL_CACHE_METHOD_NONE",
                (int)c->method);
  return check_flag(context, HBIL_INVALID_CONFIG, "gather_emission",
                    c->gather_emission);
}

hbil_status cache_config_take(hbil_context *context,
                              const hbil_cache_config *given,
                              hbil_cache_config *own, hbil_config *views) {
  hbil_config asked;
  hbil_cache_config_init(own);
  hbil_status status =
      take_sized(context, HBIL_INVALID_CONFIG, "hbil_cache_config", given,
                 FIRST_CACHE_CONFIG_SIZE, own);
  if (status == HBIL_SUCCESS)
    status = check_ranges(context, own);
  if (status != HBIL_SUCCESS)
    return status;
  static const hbil_plane_format none = {HBIL_NONE, 0};
  own->inputs.motion = none;
  hbil_config_init(&asked);
  asked.width = asked.height = 1;
  asked.inputs = own->inputs;
  asked.outputs.ao.component = HBIL_FLOAT32; /* a config has an output */
  asked.model.gather_emission = own->gather_emission;
  asked.history.reprojection = HBIL_REPROJECTION_NONE;
  asked.execution.vector_width = 1;
  for (int i = 0; i < PLANE_FIRST_OUTPUT; ++i)
    if (plane_format(&asked, i)->component == HBIL_IMAGE)
      return fail(context, HBIL_INVALID_CONFIG,
                  "inputs.%s.component: HBIL_IMAGE; a cache reads buffers",
                  plane_kinds[i].name);
  if (asked.inputs.normal.component == HBIL_NONE)
    return fail(context, HBIL_INVALID_CONFIG,
                "inputs.normal.component: HBIL_NONE; a cache needs normals");
  status = config_take(context, &asked, views);
  views->inputs.sky_depth = fminf(views->inputs.sky_depth, HBIL_FARTHEST_DEPTH);
  return status;
}

hbil_status hbil_config_use_cache(hbil_config *config,
                                  hbil_cache_config *cache) {
  if (!config || !cache)
    return fail_null(NULL, __func__, config ? "cache" : "config");
  if (!(cache->voxel_size > 0))
    return fail(NULL, HBIL_INVALID_ARGUMENT,
                "hbil_config_use_cache: cache.voxel_size: %g; must be set "
                "before, to the world units across a voxel",
                cache->voxel_size);
  hbil_model *model = &config->model;
  cache->inputs = config->inputs;
  cache->gather_emission = model->gather_emission;
  model->cache_method = cache->method;
  model->radius = (float)(HBIL_CACHE_NEAR_VOXELS * cache->voxel_size);
  /* the cache knows what is behind thin things */
  if (model->relative_thickness == DEFAULT_RELATIVE_THICKNESS)
    model->near_relative_thickness = 0.02f;
  return HBIL_SUCCESS;
}

/* --- a view --- */

hbil_status view_take(hbil_context *context, const hbil_view *given,
                      hbil_view *own) {
  hbil_view_init(own);
  const hbil_status status = take_sized(
      context, HBIL_INVALID_FRAME, "hbil_view", given, FIRST_VIEW_SIZE, own);
  if (status != HBIL_SUCCESS)
    return status;
  if (own->width < 1 || own->width > HBIL_MAX_SIZE || own->height < 1 ||
      own->height > HBIL_MAX_SIZE)
    return fail(context, HBIL_INVALID_FRAME,
                "width, height: %u x %u pixels; a view has 1..%d each way",
                (unsigned)own->width, (unsigned)own->height, HBIL_MAX_SIZE);
  if ((unsigned)own->projection > HBIL_PROJECTION_ORTHOGRAPHIC)
    return fail(context, HBIL_INVALID_FRAME,
                "projection: %d; must be one of hbil_projection",
                (int)own->projection);
  if ((unsigned)own->light > HBIL_VIEW_FINISHED)
    return fail(context, HBIL_INVALID_FRAME,
                "light: %d; must be one of hbil_view_light", (int)own->light);
  return check_flag(context, HBIL_INVALID_FRAME, "static_view",
                    own->static_view);
}

hbil_status hbil_view_from_frame_sized(hbil_view *view, size_t struct_size,
                                       const hbil_config *config,
                                       const hbil_frame *frame) {
  if (!view || !config || !frame)
    return fail_null(NULL, __func__,
                     !view     ? "view"
                     : !config ? "config"
                               : "frame");
  const hbil_view filled = {
      .width = config->width,
      .height = config->height,
      .projection = config->inputs.projection,
      .camera = frame->camera,
      .depth = frame->depth,
      .normal = frame->normal,
      .albedo = frame->albedo,
      .f0 = frame->f0,
      .direct = frame->direct,
      .emission = frame->emission,
      .light = HBIL_VIEW_DIRECT,
      .exposure = frame->exposure,
      .hardware_depth = {frame->hardware_depth[0], frame->hardware_depth[1]}};
  init_sized(view, struct_size, &filled, sizeof filled);
  return HBIL_SUCCESS;
}

/* --- an update --- */

hbil_status cache_update_take(hbil_context *context,
                              const hbil_cache_update *given,
                              hbil_cache_update *own) {
  hbil_cache_update_init(own);
  hbil_status status = HBIL_SUCCESS;
  if (given)
    status = take_sized(context, HBIL_INVALID_ARGUMENT, "hbil_cache_update",
                        given, FIRST_UPDATE_SIZE, own);
  const struct {
    const char *field;
    cl_uint value, least, most;
  } ranges[] = {{"bounces", own->bounces, 0, 1024},
                {"phases", own->phases, 1, 4096},
                {"steps", own->steps, 0, 1024}};
  for (size_t i = 0;
       i < sizeof ranges / sizeof *ranges && status == HBIL_SUCCESS; ++i)
    if (ranges[i].value < ranges[i].least || ranges[i].value > ranges[i].most)
      status =
          fail(context, HBIL_INVALID_ARGUMENT, "%s: %u is outside %u .. %u",
               ranges[i].field, (unsigned)ranges[i].value,
               (unsigned)ranges[i].least, (unsigned)ranges[i].most);
  if (status == HBIL_SUCCESS && (unsigned)own->far_field > HBIL_FAR_AUTO)
    status = fail(context, HBIL_INVALID_ARGUMENT,
                  "far_field: %d; must be one of hbil_far_field",
                  (int)own->far_field);
  if (own->far_field == HBIL_FAR_AUTO)
    own->far_field = HBIL_FAR_FRAME;
  if (status == HBIL_SUCCESS)
    status = check_exposure(context, HBIL_INVALID_ARGUMENT, own->exposure);
  if (status == HBIL_SUCCESS)
    status = check_environment(context, HBIL_INVALID_ARGUMENT, own->far_field,
                               (const float(*)[3])own->environment);
  remove_exposure(own->exposure, own->environment);
  return status;
}

/* --- a change --- */

hbil_status cache_change_take(hbil_context *context,
                              const hbil_cache_change *given,
                              hbil_cache_change *own) {
  hbil_cache_change_init(own);
  const hbil_status status =
      take_sized(context, HBIL_INVALID_ARGUMENT, "hbil_cache_change", given,
                 FIRST_CHANGE_SIZE, own);
  if (status != HBIL_SUCCESS)
    return status;
  for (int i = 0; i < 3; ++i)
    if (!(own->high[i] > own->low[i]))
      return fail(context, HBIL_INVALID_ARGUMENT,
                  "high[%d]: %g; must be above low[%d], which is %g", i,
                  own->high[i], i, own->low[i]);
  const struct {
    const char *field;
    float value;
  } shares[] = {{"surfaces", own->surfaces}, {"light", own->light}};
  for (size_t i = 0; i < sizeof shares / sizeof *shares; ++i)
    if (!(shares[i].value >= 0.0f && shares[i].value <= 1.0f))
      return fail(context, HBIL_INVALID_ARGUMENT, "%s: %g is outside 0 .. 1",
                  shares[i].field, (double)shares[i].value);
  return HBIL_SUCCESS;
}
