/* The build defines of a plan's kernels.  The kernels' files check that each
 * has one of its values. */
#include "defines.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "config.h"
#include "planes.h"
#include "searches.h"

typedef struct text {
  char *chars;
  size_t length, size; /* a length of size or more: it didn't fit */
} text;

static void add(text *t, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;
static void add(text *t, const char *format, ...) {
  if (t->length >= t->size)
    return;
  va_list args;
  va_start(args, format);
  const int n =
      vsnprintf(t->chars + t->length, t->size - t->length, format, args);
  va_end(args);
  t->length = n < 0 ? t->size : t->length + (size_t)n;
}

static void define(text *t, const char *name, int value) {
  add(t, " -D%s=%d", name, value);
}

/* The format that kernels read or write (kernels/lib/components.clh). */
static const char *plane_type(const hbil_config *c, int plane) {
  const hbil_component component = plane_format(c, plane)->component;
  if (plane == PLANE_DEPTH && component == HBIL_UNORM16)
    return "code16";
  if (plane == PLANE_NORMAL && component == HBIL_UNORM8)
    return "biased_u8";
  if (plane == PLANE_NORMAL && component == HBIL_UNORM16)
    return "biased_u16";
  if (plane == PLANE_NORMAL && component == HBIL_RGB10A2_UNORM)
    return "biased_u10";
  return component_kinds[component].type;
}

static void define_planes(const hbil_config *c, text *t) {
  for (int i = 0; i < PLANE_COUNT; ++i) {
    const hbil_plane_format *format = plane_format(c, i);
    const char *name = plane_kinds[i].define;
    add(t, " -D%s_%s=%d -D%s_TYPE=%s -D%s_STRIDE=%uu",
        i < PLANE_FIRST_OUTPUT ? "HAS" : "OUT", name,
        format->component != HBIL_NONE, name, plane_type(c, i), name,
        (unsigned)format_stride(c, i));
  }
}

/* Whether normals, once decoded, are what the kernels need. */
static bool normals_are_in_view(const hbil_config *c) {
  const float *scale = c->inputs.normal_scale;
  return c->inputs.normal_space == HBIL_SPACE_VIEW && scale[0] == 1.0f &&
         scale[1] == 1.0f && scale[2] == 1.0f;
}

static void define_inputs(const hbil_config *c, text *t) {
  define(t, "ORTHOGRAPHIC",
         c->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC);
  define(t, "WHOLE_GROUPS", c->width % (4 * c->execution.vector_width) == 0);
  define(t, "DEPTH_IS_RAY", c->inputs.depth_kind == HBIL_DEPTH_RAY);
  define(t, "DEPTH_IS_HARDWARE", c->inputs.depth_kind == HBIL_DEPTH_HARDWARE);
  define(t, "DIRECT_IS_RADIANCE",
         c->inputs.direct_kind == HBIL_DIRECT_RADIANCE);
  define(t, "NORMAL_IS_OCTAHEDRAL",
         c->inputs.normal_encoding == HBIL_NORMAL_OCTAHEDRAL);
  define(t, "NORMAL_IS_VIEW", normals_are_in_view(c));
  define(t, "BENT_IS_WORLD", c->outputs.bent_normal_space == HBIL_SPACE_WORLD);
}

static void define_model(const hbil_config *c, const layout *l, text *t) {
  const bool rejects = config_rejects_back_faces(c);
  const int relative = isinf(near_thickness_share(c)) ? 0 : 1;
  const int absolute = isinf(c->model.thickness) ? 0 : 2;
  define(t, "HBAO", c->model.mode == HBIL_MODE_HBAO);
  define(t, "LIMITED", !isinf(c->model.radius));
  define(t, "LEVELS", (int)l->pattern.levels);
  define(t, "FINITE", relative | absolute);
  define(t, "FACING_ALL", !rejects);
  define(t, "FACING_STEP", c->model.facing_fade[0] >= c->model.facing_fade[1]);
  define(t, "FALLBACK_LAST_ACCEPTED",
         rejects &&
             c->model.back_facing_fallback == HBIL_FALLBACK_LAST_ACCEPTED);
  define(t, "FALLBACK_FRAME_MEAN", l->unknown);
  define(t, "EXTRAPOLATE", c->model.extrapolate && (relative | absolute));
  define(t, "GATHER_EMISSION", c->model.gather_emission != 0);
  define(t, "FEEDBACK_RADIANCE", c->model.feedback == HBIL_FEEDBACK_RADIANCE);
  define(t, "REPROJECT_MOTION",
         c->history.reprojection == HBIL_REPROJECTION_MOTION);
  define(t, "DISOCCLUSION", !isinf(c->history.disocclusion_threshold));
  define(t, "FAR", (int)l->far_field);
  define(t, "AREAS", l->far_field == HBIL_FAR_FRAME);
  define(t, "PROBES", l->probes);
  define(t, "AO_BOUNCES", (int)l->ao_bounces);
  define(t, "UNFILTERED", c->sampling.unfiltered != 0);
}

static void define_work(const hbil_config *c, const layout *l, text *t) {
  static const struct {
    const char *name;
    cl_uint bit;
  } skips[] = {{"SKIP_SKY", HBIL_SKIP_SKY},
               {"SKIP_OPEN", HBIL_SKIP_OPEN},
               {"SKIP_DARK", HBIL_SKIP_DARK},
               {"SKIP_UNUSED", HBIL_SKIP_UNUSED},
               {"SKIP_RADIUS", HBIL_SKIP_RADIUS}};
  define(t, "HBIL_WIDTH", (int)c->execution.vector_width);
  define(t, "SPAN", (int)l->span);
  define(t, "STORAGE", (int)c->sampling.storage);
  define(t, "GATHERED", (int)l->pattern.gathered);
  define(t, "SLICE_FRAMES", (int)l->slice_frames);
  define(t, "GATHER_RADIANCE", l->radiance);
  define(t, "GATHER_BENT", l->bent);
  define(t, "HISTORY", l->history);
  define(t, "ERROR_PLANE", (int)l->error_plane);
  define(t, "AO_SEARCH", l->ao_search);
  define(t, "AO_ERROR_PLANE", (int)l->ao_error_plane);
  define(t, "UNKNOWN_PLANE", (int)l->unknown_plane);
  define(t, "WEIGHT_PLANE", (int)l->weight_plane);
  define(t, "GLOSSY_PLANE", (int)l->glossy_plane);
  define(t, "GLOSSY_RESOLVED", (int)l->glossy_resolved);
  define(t, "LINE", (int)l->line);
  for (size_t i = 0; i < sizeof skips / sizeof *skips; ++i)
    define(t, skips[i].name, (l->skip & skips[i].bit) != 0);
}

static hbil_status end(hbil_context *context, const text *t) {
  return t->length < t->size
             ? HBIL_SUCCESS
             : fail(context, HBIL_BUILD_FAILED,
                    "the build defines don't fit into %zu characters", t->size);
}

hbil_status write_defines(hbil_context *context, const hbil_config *config,
                          const layout *l, char *chars, size_t size) {
  text t = {.chars = chars, .size = size};
  define_planes(config, &t);
  define_inputs(config, &t);
  define_model(config, l, &t);
  define_work(config, l, &t);
  return end(context, &t);
}

hbil_status write_view_defines(hbil_context *context, const hbil_config *config,
                               char *chars, size_t size) {
  text t = {.chars = chars, .size = size};
  define_planes(config, &t);
  define_inputs(config, &t);
  define(&t, "HBIL_WIDTH", (int)config->execution.vector_width);
  define(&t, "GATHER_EMISSION", config->model.gather_emission != 0);
  return end(context, &t);
}
