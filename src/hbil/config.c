/* Defaults and presets, and the rejection of what is out of range. */
#include "config.h"

#include "planes.h"
#include "searches.h"
#include "sized.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

bool config_rejects_back_faces(const hbil_config *config) {
  return config->model.facing_fade[1] > -1.0f;
}

bool config_has_thickness(const hbil_config *config) {
  return !isinf(config->model.thickness) ||
         !isinf(near_thickness_share(config));
}

const char *cache_method_name(hbil_cache_method method) {
  static const char *const names[] = {
      [HBIL_CACHE_METHOD_NONE] = "HBIL_CACHE_METHOD_NONE",
      [HBIL_CACHE_METHOD_RAYS] = "HBIL_CACHE_METHOD_RAYS",
      [HBIL_CACHE_METHOD_CONES] = "HBIL_CACHE_METHOD_CONES",
      [HBIL_CACHE_METHOD_LPV] = "HBIL_CACHE_METHOD_LPV",
      [HBIL_CACHE_METHOD_RSM] = "HBIL_CACHE_METHOD_RSM"};
  return names[method];
}

/* Bytes in version 0.1, the least that a caller's struct may have.  Fields of
 * later versions follow these (configure.ac has the rules). */
enum {
  FIRST_CONFIG_SIZE = SIZE_UP_TO(hbil_config, execution),
  FIRST_FRAME_SIZE = SIZE_UP_TO(hbil_frame, exposure)
};

void hbil_config_init_sized(hbil_config *config, size_t struct_size) {
  hbil_config defaults = {
      .inputs.sky_depth = INFINITY,
      .inputs.direct_scale = 1.0f,
      .inputs.motion_scale = {1.0f, 1.0f},
      .inputs.depth_scale = 1.0f,
      .inputs.normal_scale = {1.0f, 1.0f, 1.0f},
      .model.radius = INFINITY,
      .model.ao_radius = INFINITY,
      .model.near_relative_thickness = INFINITY,
      .sampling.slices = 4,
      .sampling.steps_per_side = 40,
      .sampling.step_growth = 3.0f,
      .sampling.sample_grid = HBIL_GRID_FULL_RESOLUTION,
      .model.gather_emission = CL_TRUE,
      .model.offscreen_light = 0.76f,
      .model.roughness = 0.5f,
      .history.reprojection = HBIL_REPROJECTION_CAMERA,
      .history.disocclusion_threshold = 0.05f,
      .execution.skip = HBIL_SKIP_ALL,
  };
  hbil_model_set(&defaults.model, HBIL_MODEL_DEFAULT);
  init_sized(config, struct_size, &defaults, sizeof defaults);
}

hbil_status hbil_model_set(hbil_model *model, hbil_model_name name) {
  if (!model)
    return fail_null(NULL, __func__, "model");
  if ((unsigned)name > HBIL_MODEL_PAPER)
    return fail(NULL, HBIL_INVALID_ARGUMENT,
                "hbil_model_set: name: %d; must be one of hbil_model_name",
                (int)name);
  const bool paper = name == HBIL_MODEL_PAPER;
  model->far_field = paper ? HBIL_FAR_NONE : HBIL_FAR_AUTO;
  model->thickness = INFINITY;
  model->relative_thickness = paper ? INFINITY : DEFAULT_RELATIVE_THICKNESS;
  model->facing_fade[0] = paper ? -0.1f : -1.0f;
  model->facing_fade[1] = paper ? 0.0f : -1.0f;
  model->back_facing_fallback =
      paper ? HBIL_FALLBACK_LAST_ACCEPTED : HBIL_FALLBACK_FRAME_MEAN;
  model->feedback = paper ? HBIL_FEEDBACK_RADIANCE : HBIL_FEEDBACK_IRRADIANCE;
  model->extrapolate = paper ? CL_FALSE : CL_TRUE;
  return HBIL_SUCCESS;
}

/* The presets, chosen from the plot of error against time
 * (doc/measurements.md). */
static const struct {
  const char *name;
  cl_uint slices, steps_per_side;
  float step_growth;
  cl_bool unfiltered;
} qualities[] = {
    [HBIL_QUALITY_FAST] = {"fast", 2, 20, 3.0f, CL_FALSE},
    [HBIL_QUALITY_BALANCED] = {"balanced", 2, 56, 3.0f, CL_FALSE},
    [HBIL_QUALITY_HIGH] = {"high", 6, 56, 3.0f, CL_FALSE},
    [HBIL_QUALITY_REFERENCE] = {"reference", 32, 256, 0.0f, CL_TRUE},
};

hbil_status hbil_sampling_set(hbil_sampling *sampling, hbil_quality quality) {
  if (!sampling)
    return fail_null(NULL, __func__, "sampling");
  if ((unsigned)quality > HBIL_QUALITY_REFERENCE)
    return fail(NULL, HBIL_INVALID_ARGUMENT,
                "hbil_sampling_set: quality: %d; must be one of hbil_quality",
                (int)quality);
  sampling->slices = qualities[quality].slices;
  sampling->slice_frames = 0;
  sampling->steps_per_side = qualities[quality].steps_per_side;
  sampling->step_growth = qualities[quality].step_growth;
  sampling->sample_grid = HBIL_GRID_FULL_RESOLUTION;
  sampling->resolution = HBIL_RESOLUTION_AUTO;
  sampling->unfiltered = qualities[quality].unfiltered;
  /* packed storage dithers over the layers, so it needs the filter */
  sampling->storage = qualities[quality].unfiltered ? HBIL_STORAGE_FLOAT32
                                                    : HBIL_STORAGE_PACKED;
  return HBIL_SUCCESS;
}

hbil_resolution hbil_config_resolution(const hbil_config *config) {
  if (!config)
    return HBIL_RESOLUTION_AUTO;
  if (config->sampling.resolution != HBIL_RESOLUTION_AUTO)
    return config->sampling.resolution;
  const bool large =
      (uint64_t)config->width * config->height >= HBIL_HALF_RESOLUTION_PIXELS;
  return large && !config->sampling.unfiltered ? HBIL_RESOLUTION_HALF
                                               : HBIL_RESOLUTION_FULL;
}

cl_uint hbil_config_slice_frames(const hbil_config *config) {
  if (!config)
    return 0;
  const hbil_sampling *s = &config->sampling;
  if (config->outputs.glossy.component != HBIL_NONE)
    return 1;
  if (s->slice_frames)
    return s->slice_frames;
  const bool independent =
      config->history.reprojection == HBIL_REPROJECTION_NONE;
  return s->slices % 2 || s->unfiltered || independent ? 1 : 2;
}

const char *hbil_quality_name(hbil_quality quality) {
  return (unsigned)quality > HBIL_QUALITY_REFERENCE ? NULL
                                                    : qualities[quality].name;
}

void hbil_frame_init_sized(hbil_frame *frame, size_t struct_size) {
  static const hbil_frame nothing;
  init_sized(frame, struct_size, &nothing, sizeof nothing);
}

hbil_status frame_take(hbil_context *context, const hbil_frame *given,
                       hbil_frame *own) {
  hbil_frame_init(own);
  return take_sized(context, HBIL_INVALID_FRAME, "hbil_frame", given,
                    FIRST_FRAME_SIZE, own);
}

/* Accepts values in [least, most], and not NaN. */
static hbil_status in_range(hbil_context *context, const char *field,
                            double value, double least, double most) {
  if (value >= least && value <= most)
    return HBIL_SUCCESS;
  return fail(context, HBIL_INVALID_CONFIG, "%s: %g is outside %g .. %g", field,
              value, least, most);
}

/* Accepts positive numbers and infinity. */
static hbil_status positive(hbil_context *context, const char *field,
                            double value) {
  if (value > 0)
    return HBIL_SUCCESS;
  return fail(context, HBIL_INVALID_CONFIG,
              "%s: %g; must be positive (infinity: no limit)", field, value);
}

static const char *component_name(hbil_component component) {
  return (unsigned)component < COMPONENT_COUNT ? component_kinds[component].name
                                               : "unknown";
}

/* Rejects a component with the list of those that the plane can have. */
static hbil_status wrong_component(hbil_context *context,
                                   const hbil_config *config, int plane,
                                   unsigned allowed) {
  const hbil_component given = plane_format(config, plane)->component;
  char list[256] = "";
  size_t length = 0;
  for (int i = 0; i < COMPONENT_COUNT && length < sizeof list; ++i)
    if (allowed & (1u << i))
      length += (size_t)snprintf(list + length, sizeof list - length, "%s%s",
                                 length ? ", " : "", component_kinds[i].name);
  const bool other_kind = plane == PLANE_DEPTH &&
                          config->inputs.depth_kind != HBIL_DEPTH_HARDWARE &&
                          (given == HBIL_UNORM16 || given == HBIL_UNORM24);
  return fail(context, HBIL_INVALID_CONFIG,
              "%s.%s.component: %d (%s); must be one of %s%s",
              plane >= PLANE_FIRST_OUTPUT ? "outputs" : "inputs",
              plane_kinds[plane].name, (int)given, component_name(given), list,
              other_kind ? ", or depth_kind HBIL_DEPTH_HARDWARE" : "");
}

static hbil_status check_format(hbil_context *context,
                                const hbil_config *config, int plane) {
  const hbil_plane_format *format = plane_format(config, plane);
  if (format->component == HBIL_NONE)
    return HBIL_SUCCESS;
  const unsigned allowed = plane_components_allowed(config, plane);
  if ((unsigned)format->component >= COMPONENT_COUNT ||
      !(allowed & (1u << format->component)))
    return wrong_component(context, config, plane, allowed);
  if (format->component == HBIL_IMAGE)
    return HBIL_SUCCESS;
  const cl_uint size = (cl_uint)component_size(format->component);
  const cl_uint stride = format_stride(config, plane);
  const cl_uint components = plane_components(config, plane);
  if (format->pixel_pitch % size == 0 && stride <= 64 &&
      (stride == 1 || stride >= components))
    return HBIL_SUCCESS;
  char planar[32] = "";
  if (components > 1)
    snprintf(planar, sizeof planar, "%u (planar) or ", (unsigned)size);
  return fail(context, HBIL_INVALID_CONFIG,
              "%s.%s.pixel_pitch: %u bytes; must be %s%u .. %u%s, a multiple "
              "of %u",
              plane >= PLANE_FIRST_OUTPUT ? "outputs" : "inputs",
              plane_kinds[plane].name, (unsigned)format->pixel_pitch, planar,
              (unsigned)(components * size), (unsigned)(64 * size),
              components > 1 ? " (interleaved)" : "", (unsigned)size);
}

static hbil_status check_formats(hbil_context *context,
                                 const hbil_config *config) {
  for (int i = 0; i < PLANE_COUNT; ++i) {
    const hbil_status status = check_format(context, config, i);
    if (status != HBIL_SUCCESS)
      return status;
  }
  if (config->inputs.depth.component == HBIL_NONE)
    return fail(context, HBIL_INVALID_CONFIG,
                "inputs.depth.component: HBIL_NONE; depth is needed");
  if (config->inputs.normal.component == HBIL_NONE &&
      component_size(config->inputs.depth.component) == 2)
    return fail(context, HBIL_INVALID_CONFIG,
                "inputs.normal.component: HBIL_NONE; normals can't be rebuilt "
                "from depths of 16 bits (inputs.depth.component)");
  if (config->history.reprojection == HBIL_REPROJECTION_MOTION &&
      config->inputs.motion.component == HBIL_NONE)
    return fail(
        context, HBIL_INVALID_CONFIG,
        "inputs.motion.component: HBIL_NONE; HBIL_REPROJECTION_MOTION needs "
        "motion vectors");
  for (int i = PLANE_FIRST_OUTPUT; i < PLANE_COUNT; ++i)
    if (plane_format(config, i)->component != HBIL_NONE)
      return HBIL_SUCCESS;
  return fail(context, HBIL_INVALID_CONFIG,
              "no output has a format: there is nothing to compute");
}

/* Outputs and far fields that a mode doesn't have. */
static hbil_status check_mode(hbil_context *context,
                              const hbil_config *config) {
  static const struct {
    int plane;
    hbil_mode most; /* the last mode that has it */
  } only[] = {{PLANE_NEAR, HBIL_MODE_HBIL},   {PLANE_UNKNOWN, HBIL_MODE_HBIL},
              {PLANE_GLOSSY, HBIL_MODE_HBIL}, {PLANE_BENT, HBIL_MODE_GTAO},
              {PLANE_ERROR, HBIL_MODE_GTAO},  {PLANE_CONE, HBIL_MODE_GTAO}};
  const char *mode = config->model.mode == HBIL_MODE_GTAO ? "GTAO" : "HBAO";
  for (size_t i = 0; i < sizeof only / sizeof *only; ++i)
    if (config->model.mode > only[i].most &&
        plane_format(config, only[i].plane)->component != HBIL_NONE)
      return fail(
          context, HBIL_INVALID_CONFIG,
          "outputs.%s.component: must be HBIL_NONE, HBIL_MODE_%s has no such "
          "output",
          plane_kinds[only[i].plane].name, mode);
  if (config->model.mode != HBIL_MODE_HBIL &&
      config->model.far_field == HBIL_FAR_FRAME)
    return fail(
        context, HBIL_INVALID_CONFIG,
        "model.far_field: HBIL_FAR_FRAME; HBIL_MODE_%s reads no radiance",
        mode);
  if (config->model.cache_method > HBIL_CACHE_METHOD_RAYS &&
      plane_format(config, PLANE_GLOSSY)->component != HBIL_NONE)
    return fail(
        context, HBIL_INVALID_CONFIG,
        "outputs.glossy.component: must be HBIL_NONE, or model.cache_method "
        "HBIL_CACHE_METHOD_NONE or HBIL_CACHE_METHOD_RAYS");
  if (config->model.mode != HBIL_MODE_HBIL && config->model.cache_method)
    return fail(
        context, HBIL_INVALID_CONFIG,
        "model.cache_method: %s; must be HBIL_CACHE_METHOD_NONE, HBIL_MODE_%s "
        "reads no radiance",
        cache_method_name(config->model.cache_method), mode);
  if (config->model.mode == HBIL_MODE_HBAO &&
      config->model.far_field == HBIL_FAR_SH)
    return fail(
        context, HBIL_INVALID_CONFIG,
        "model.far_field: HBIL_FAR_SH; HBIL_MODE_HBAO has no bent cone, "
        "HBIL_FAR_CONSTANT is possible");
  return HBIL_SUCCESS;
}

/* Accepts numbers that must be positive, and may be infinite. */
static hbil_status check_limits(hbil_context *context,
                                const hbil_config *config) {
  const struct {
    const char *field;
    double value;
  } limits[] = {
      {"model.radius", (double)config->model.radius},
      {"model.thickness", (double)config->model.thickness},
      {"model.relative_thickness", (double)config->model.relative_thickness},
      {"model.ao_radius", (double)config->model.ao_radius},
      {"model.near_relative_thickness",
       (double)config->model.near_relative_thickness},
      {"inputs.sky_depth", (double)config->inputs.sky_depth},
      {"history.disocclusion_threshold",
       (double)config->history.disocclusion_threshold},
  };
  hbil_status status = HBIL_SUCCESS;
  for (size_t i = 0; i < sizeof limits / sizeof *limits; ++i)
    if ((status = positive(context, limits[i].field, limits[i].value)) !=
        HBIL_SUCCESS)
      break;
  return status;
}

/* Accepts factors that lose nothing of what they scale. */
static hbil_status check_factors(hbil_context *context,
                                 const hbil_config *config) {
  const float *normal = config->inputs.normal_scale;
  const struct {
    const char *field;
    double value;
  } factors[] = {
      {"inputs.depth_scale", (double)config->inputs.depth_scale},
      {"inputs.normal_scale[0]", (double)normal[0]},
      {"inputs.normal_scale[1]", (double)normal[1]},
      {"inputs.normal_scale[2]", (double)normal[2]},
  };
  for (size_t i = 0; i < sizeof factors / sizeof *factors; ++i)
    if (!(fabs(factors[i].value) <= 1e6) || factors[i].value == 0)
      return fail(context, HBIL_INVALID_CONFIG,
                  "%s: %g; must be in -1e6 .. 1e6 and not 0", factors[i].field,
                  factors[i].value);
  return HBIL_SUCCESS;
}

/* Accepts values that no range describes. */
static hbil_status check_values(hbil_context *context,
                                const hbil_config *config) {
  if (config->model.facing_fade[0] > config->model.facing_fade[1])
    return fail(
        context, HBIL_INVALID_CONFIG,
        "model.facing_fade: %g, %g; the first must not be above the second",
        (double)config->model.facing_fade[0],
        (double)config->model.facing_fade[1]);
  if (config->sampling.resolution == HBIL_RESOLUTION_HALF &&
      config->sampling.unfiltered)
    return fail(
        context, HBIL_INVALID_CONFIG,
        "sampling.resolution: HALF needs the filter, which fills in the "
        "other pixels; set FULL or AUTO, or sampling.unfiltered to "
        "CL_FALSE");
  const cl_uint width = config->execution.vector_width;
  if (width != 0 && width != 1 && width != 4 && width != 8 && width != 16)
    return fail(
        context, HBIL_INVALID_CONFIG,
        "execution.vector_width: %u; must be 0 (automatic), 1, 4, 8 or 16",
        (unsigned)width);
  return HBIL_SUCCESS;
}

/* Accepts the enumerators of each type. */
static hbil_status check_choices(hbil_context *context,
                                 const hbil_config *config) {
#define CHOICE(member, type, last)                                             \
  { #member, #type, (int)config->member, last }
  const struct {
    const char *field, *type;
    int value, last; /* the first one is 0 */
  } choices[] = {
      CHOICE(inputs.projection, hbil_projection, HBIL_PROJECTION_ORTHOGRAPHIC),
      CHOICE(inputs.depth_kind, hbil_depth_kind, HBIL_DEPTH_HARDWARE),
      CHOICE(inputs.normal_encoding, hbil_normal_encoding,
             HBIL_NORMAL_OCTAHEDRAL),
      CHOICE(inputs.normal_space, hbil_space, HBIL_SPACE_WORLD),
      CHOICE(outputs.bent_normal_space, hbil_space, HBIL_SPACE_WORLD),
      CHOICE(inputs.direct_kind, hbil_direct_kind, HBIL_DIRECT_RADIANCE),
      CHOICE(model.mode, hbil_mode, HBIL_MODE_HBAO),
      CHOICE(model.falloff, hbil_falloff, HBIL_FALLOFF_NONE),
      CHOICE(sampling.sample_grid, hbil_sample_grid, HBIL_GRID_FULL_RESOLUTION),
      CHOICE(sampling.resolution, hbil_resolution, HBIL_RESOLUTION_HALF),
      CHOICE(model.back_facing_fallback, hbil_back_facing_fallback,
             HBIL_FALLBACK_FRAME_MEAN),
      CHOICE(model.cache_method, hbil_cache_method, HBIL_CACHE_METHOD_RSM),
      CHOICE(model.ao_bounces, hbil_ao_bounces, HBIL_AO_BOUNCES_ALBEDO),
      CHOICE(history.reprojection, hbil_reprojection, HBIL_REPROJECTION_MOTION),
      CHOICE(model.feedback, hbil_feedback, HBIL_FEEDBACK_RADIANCE),
      CHOICE(model.far_field, hbil_far_field, HBIL_FAR_AUTO),
      CHOICE(sampling.storage, hbil_storage, HBIL_STORAGE_FLOAT32),
  };
#undef CHOICE
  for (size_t i = 0; i < sizeof choices / sizeof *choices; ++i)
    if (choices[i].value < 0 || choices[i].value > choices[i].last)
      return fail(context, HBIL_INVALID_CONFIG, "%s: %d; must be one of %s",
                  choices[i].field, choices[i].value, choices[i].type);
  return HBIL_SUCCESS;
}

/* Names the first field that is out of range. */
static hbil_status config_check(hbil_context *context,
                                const hbil_config *config) {
  /* Every number with its range. */
  const struct {
    const char *field;
    double value, least, most;
  } ranges[] = {
      {"width", config->width, 1, HBIL_MAX_SIZE},
      {"height", config->height, 1, HBIL_MAX_SIZE},
      {"inputs.direct_scale", (double)config->inputs.direct_scale, 0, 1e30},
      {"inputs.motion_scale[0]", (double)config->inputs.motion_scale[0], -1e6,
       1e6},
      {"inputs.motion_scale[1]", (double)config->inputs.motion_scale[1], -1e6,
       1e6},
      {"sampling.slices", config->sampling.slices, 1, 32},
      {"sampling.slice_frames", config->sampling.slice_frames, 0, 4},
      {"sampling.steps_per_side", config->sampling.steps_per_side, 1, 256},
      {"sampling.step_growth", (double)config->sampling.step_growth, 0, 64},
      {"model.extrapolate", config->model.extrapolate, 0, 1},
      {"model.facing_fade[0]", (double)config->model.facing_fade[0], -1, 1},
      {"model.facing_fade[1]", (double)config->model.facing_fade[1], -1, 1},
      {"model.gather_emission", config->model.gather_emission, 0, 1},
      {"model.offscreen_light", (double)config->model.offscreen_light, 0, 1},
      /* as floats: 0.3f is above 0.3 */
      {"model.roughness", (double)config->model.roughness, (double)0.3f, 1},
      {"sampling.unfiltered", config->sampling.unfiltered, 0, 1},
      {"execution.skip", config->execution.skip, 0, HBIL_SKIP_ALL},
      {"execution.profiling", config->execution.profiling, 0, 1},
  };
  hbil_status status = HBIL_SUCCESS;
  for (size_t i = 0; i < sizeof ranges / sizeof *ranges; ++i)
    if ((status = in_range(context, ranges[i].field, ranges[i].value,
                           ranges[i].least, ranges[i].most)) != HBIL_SUCCESS)
      return status;
  if ((status = check_choices(context, config)) != HBIL_SUCCESS ||
      (status = check_values(context, config)) != HBIL_SUCCESS ||
      (status = check_factors(context, config)) != HBIL_SUCCESS ||
      (status = check_limits(context, config)) != HBIL_SUCCESS ||
      (status = check_formats(context, config)) != HBIL_SUCCESS)
    return status;
  if (config->sampling.slice_frames &&
      config->sampling.slices % config->sampling.slice_frames)
    return fail(context, HBIL_INVALID_CONFIG,
                "sampling.slice_frames: %u; sampling.slices, %u, must be a "
                "multiple of it",
                (unsigned)config->sampling.slice_frames,
                (unsigned)config->sampling.slices);
  return check_mode(context, config);
}

hbil_status config_take(hbil_context *context, const hbil_config *given,
                        hbil_config *own) {
  hbil_config_init(own);
  hbil_status status = take_sized(context, HBIL_INVALID_CONFIG, "hbil_config",
                                  given, FIRST_CONFIG_SIZE, own);
  if (status == HBIL_SUCCESS)
    status = config_check(context, own);
  own->sampling.slice_frames = hbil_config_slice_frames(own);
  if (own->model.far_field == HBIL_FAR_AUTO)
    own->model.far_field =
        own->model.mode == HBIL_MODE_HBIL ? HBIL_FAR_FRAME : HBIL_FAR_NONE;
  return status;
}
