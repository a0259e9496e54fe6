/* The caller's planes: their names, formats and places in the public structs.
 */
#include "planes.h"

#include <stdbool.h>
#include <string.h>

#define KIND(group, field, define, channels)                                   \
  {                                                                            \
#field, define, channels, offsetof(hbil_config, group.field),              \
        offsetof(hbil_frame, field)                                            \
  }

const plane_kind plane_kinds[PLANE_COUNT] = {
    [PLANE_DEPTH] = KIND(inputs, depth, "DEPTH", 1),
    [PLANE_NORMAL] = KIND(inputs, normal, "NORMAL", 3),
    [PLANE_ALBEDO] = KIND(inputs, albedo, "ALBEDO", 3),
    [PLANE_F0] = KIND(inputs, f0, "F0", 3),
    [PLANE_DIRECT] = KIND(inputs, direct, "DIRECT", 3),
    [PLANE_EMISSION] = KIND(inputs, emission, "EMISSION", 3),
    [PLANE_MOTION] = KIND(inputs, motion, "MOTION", 2),
    [PLANE_NEAR] = KIND(outputs, near_irradiance, "NEAR", 3),
    [PLANE_FAR] = KIND(outputs, far_irradiance, "FAR", 3),
    [PLANE_AO] = KIND(outputs, ao, "AO", 1),
    [PLANE_BENT] = KIND(outputs, bent_normal, "BENT", 3),
    [PLANE_CONE] = KIND(outputs, cone_cosine, "CONE", 1),
    [PLANE_INDIRECT] = KIND(outputs, indirect, "INDIRECT", 3),
    [PLANE_BEAUTY] = KIND(outputs, beauty, "BEAUTY", 3),
    [PLANE_ERROR] = KIND(outputs, error_estimate, "ERROR", 2),
};

const hbil_plane_format *plane_format(const hbil_config *config, int plane) {
  return (
      const hbil_plane_format *)(const void *)((const char *)config +
                                               plane_kinds[plane].format_at);
}

const hbil_plane *frame_plane(const hbil_frame *frame, int plane) {
  return (const hbil_plane *)(const void *)((const char *)frame +
                                            plane_kinds[plane].plane_at);
}

cl_uint format_stride(const hbil_config *config, int plane) {
  const cl_uint stride = plane_format(config, plane)->stride;
  return stride ? stride : plane_kinds[plane].channels;
}

size_t component_size(hbil_component component) {
  return component == HBIL_FLOAT32 ? 4 : component == HBIL_FLOAT16 ? 2 : 1;
}

plane_shape plane_shape_of(const hbil_config *config, int plane,
                           const hbil_plane *given) {
  const size_t size = component_size(plane_format(config, plane)->component);
  const size_t stride = format_stride(config, plane);
  const size_t channels = plane_kinds[plane].channels;
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
  /* interleaved channels are neighbours */
  args->plane =
      format_stride(config, plane) == 1 ? (cl_uint)(shape.image / size) : 1;
  return given->buffer;
}
