/* The caller's planes: their names, formats and places in the public structs.
 */
#include "planes.h"

#include <stdbool.h>
#include <string.h>

#define KIND(id, group, field, channels)                                       \
  {#field, #id, channels, offsetof(hbil_config, group.field),                  \
   offsetof(hbil_frame, field)},

const plane_kind plane_kinds[PLANE_COUNT] = {PLANE_LIST(KIND)};

const component_kind component_kinds[COMPONENT_COUNT] = {
    [HBIL_NONE] = {"HBIL_NONE", "none", 1, false, 0.0f},
    [HBIL_FLOAT32] = {"HBIL_FLOAT32", "f32", 4, false, 0.0f},
    [HBIL_FLOAT16] = {"HBIL_FLOAT16", "f16", 2, false, ROUNDING_OF_HALF},
    [HBIL_UNORM8] = {"HBIL_UNORM8", "u8", 1, false, ROUNDING_OF_BITS(8)},
    [HBIL_UNORM16] = {"HBIL_UNORM16", "u16", 2, false, ROUNDING_OF_BITS(16)},
    [HBIL_SNORM8] = {"HBIL_SNORM8", "s8", 1, false, ROUNDING_OF_BITS(8)},
    [HBIL_SNORM16] = {"HBIL_SNORM16", "s16", 2, false, ROUNDING_OF_BITS(16)},
    [HBIL_UNORM24] = {"HBIL_UNORM24", "code24", 4, false, ROUNDING_OF_BITS(24)},
    [HBIL_RGB10A2_UNORM] = {"HBIL_RGB10A2_UNORM", "u10", 4, true,
                            ROUNDING_OF_BITS(10)},
    [HBIL_R11G11B10_FLOAT] = {"HBIL_R11G11B10_FLOAT", "f11", 4, true, 0.0f},
    [HBIL_RGB9E5_FLOAT] = {"HBIL_RGB9E5_FLOAT", "e5", 4, true, 0.0f},
    [HBIL_SRGB8] = {"HBIL_SRGB8", "srgb8", 1, false, ROUNDING_OF_BITS(8)},
    /* staged (staging.h), so kernels never see it */
    [HBIL_IMAGE] = {"HBIL_IMAGE", "none", 1, false, 0.0f},
};

#define BIT(component) (1u << (component))

unsigned plane_components_allowed(const hbil_config *config, int plane) {
  const unsigned floats =
      BIT(HBIL_FLOAT32) | BIT(HBIL_FLOAT16) | BIT(HBIL_IMAGE);
  const unsigned unorms = BIT(HBIL_UNORM8) | BIT(HBIL_UNORM16);
  const unsigned snorms = BIT(HBIL_SNORM8) | BIT(HBIL_SNORM16);
  if (plane >= PLANE_FIRST_OUTPUT)
    return floats;
  switch (plane) {
  case PLANE_DEPTH:
    return config->inputs.depth_kind == HBIL_DEPTH_HARDWARE
               ? floats | BIT(HBIL_UNORM16) | BIT(HBIL_UNORM24)
               : floats;
  case PLANE_NORMAL:
    return config->inputs.normal_encoding == HBIL_NORMAL_OCTAHEDRAL
               ? floats | unorms | snorms
               : floats | unorms | snorms | BIT(HBIL_RGB10A2_UNORM);
  case PLANE_MOTION:
    return floats | BIT(HBIL_SNORM16);
  default: /* colours */
    return floats | unorms | BIT(HBIL_RGB10A2_UNORM) |
           BIT(HBIL_R11G11B10_FLOAT) | BIT(HBIL_RGB9E5_FLOAT) | BIT(HBIL_SRGB8);
  }
}

const hbil_plane_format *plane_format(const hbil_config *config, int plane) {
  return (
      const hbil_plane_format *)(const void *)((const char *)config +
                                               plane_kinds[plane].format_at);
}

const hbil_plane *frame_plane(const hbil_frame *frame, int plane) {
  return (const hbil_plane *)(const void *)((const char *)frame +
                                            plane_kinds[plane].plane_at);
}

/* Whether a pixel is one word that holds all channels. */
static bool is_word(const hbil_config *config, int plane) {
  return component_kinds[plane_format(config, plane)->component].is_word;
}

cl_uint plane_components(const hbil_config *config, int plane) {
  if (is_word(config, plane))
    return 1;
  return plane == PLANE_NORMAL &&
                 config->inputs.normal_encoding == HBIL_NORMAL_OCTAHEDRAL
             ? 2
             : plane_kinds[plane].channels;
}

cl_uint format_stride(const hbil_config *config, int plane) {
  const hbil_plane_format *format = plane_format(config, plane);
  return format->pixel_pitch
             ? format->pixel_pitch / (cl_uint)component_size(format->component)
             : plane_components(config, plane);
}

size_t component_size(hbil_component component) {
  return component_kinds[component].size;
}

plane_shape plane_shape_of(const hbil_config *config, int plane,
                           const hbil_plane *given) {
  const size_t size = component_size(plane_format(config, plane)->component);
  const size_t stride = format_stride(config, plane);
  const size_t channels = plane_components(config, plane);
  const bool planar = stride == 1;
  plane_shape s = {.images = planar ? channels : 1,
                   .rows = config->height,
                   .pixels = config->width,
                   .pixel = size * stride,
                   .run = planar ? size : size * channels};
  s.row = given->row_pitch ? given->row_pitch : s.pixel * s.pixels;
  s.image = given->plane_pitch ? given->plane_pitch : s.row * s.rows;
  return s;
}

size_t plane_row_extent(const plane_shape *shape) {
  return (shape->pixels - 1) * shape->pixel + shape->run;
}

size_t plane_extent(const plane_shape *shape) {
  return (shape->images - 1) * shape->image + (shape->rows - 1) * shape->row +
         plane_row_extent(shape);
}

cl_mem plane_bind(const hbil_config *config, const hbil_frame *frame, int plane,
                  hbil_external_plane_args *args) {
  const hbil_plane_format *format = plane_format(config, plane);
  const hbil_plane *given = frame_plane(frame, plane);
  memset(args, 0, sizeof *args);
  if (format->component == HBIL_NONE)
    return NULL;
  const size_t size = component_size(format->component);
  const plane_shape shape = plane_shape_of(config, plane, given);
  args->offset = (cl_uint)(given->offset / size);
  args->row = (cl_uint)(shape.row / size);
  /* interleaved channels are neighbours, those of words at the same place */
  args->plane = is_word(config, plane) ? 0
                : format_stride(config, plane) == 1
                    ? (cl_uint)(shape.image / size)
                    : 1;
  return given->buffer;
}

float normal_rounding(const hbil_config *config, float component) {
  /* Octahedral u and v that are off by d each turn the normal by sqrt(18) d at
   * most, in the middle of an octant; three components that are off by d by
   * sqrt(3) d.  4 as the packed normal's (gather.c). */
  return config->inputs.normal_encoding == HBIL_NORMAL_OCTAHEDRAL
             ? 4.0f * component
             : component;
}

hbil_depth_args depth_args(const hbil_config *config, const hbil_frame *frame) {
  hbil_depth_args args = {.sky_depth = config->inputs.sky_depth,
                          .scale = config->inputs.depth_scale};
  if (config->inputs.depth_kind != HBIL_DEPTH_HARDWARE)
    return args;
  const bool orthographic =
      config->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  /* d = a + b w, where w is 1/z, or -z in an orthographic view */
  const double a = frame->hardware_depth[0];
  const double b = (orthographic ? -1.0 : 1.0) * frame->hardware_depth[1];
  const double far = b < 0.0 ? 1.0 : 0.0; /* d of the far end */
  /* the kernels read codes of unorm depth as integers */
  const hbil_component component = config->inputs.depth.component;
  const double largest = component == HBIL_UNORM24   ? 0xffffff
                         : component == HBIL_UNORM16 ? 0xffff
                                                     : 1.0;
  args.end = (cl_float)(far * largest);
  args.base = (cl_float)(((orthographic ? 0.0 : far) - a) / b);
  args.scale = (cl_float)(1.0 / (b * largest));
  return args;
}
