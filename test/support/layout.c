#include "test/support/layout.h"

#include <math.h>
#include <string.h>

#include "test/support/checked_exact.h"

typedef struct plane_info {
  const char *name;
  int channels, first;
  size_t format, slot; /* offsets in hbil_config and hbil_frame */
} plane_info;

#define PLANE(group, field, channels, first)                                   \
  {                                                                            \
#field, channels, first, offsetof(hbil_config, group.field),               \
        offsetof(hbil_frame, field)                                            \
  }

static const plane_info infos[PLANE_COUNT] = {
    PLANE(inputs, depth, 1, EXACT_DEPTH),
    PLANE(inputs, normal, 3, EXACT_NORMAL),
    PLANE(inputs, albedo, 3, EXACT_ALBEDO),
    PLANE(inputs, f0, 3, EXACT_F0),
    PLANE(inputs, direct, 3, EXACT_DIRECT),
    PLANE(inputs, emission, 3, EXACT_EMISSION),
    PLANE(inputs, motion, 2, EXACT_MOTION),
    PLANE(outputs, near_irradiance, 3, EXACT_NEAR_IRRADIANCE),
    PLANE(outputs, far_irradiance, 3, EXACT_FAR_IRRADIANCE),
    PLANE(outputs, ao, 1, EXACT_AO),
    PLANE(outputs, bent_normal, 3, EXACT_BENT_NORMAL),
    PLANE(outputs, cone_cosine, 1, EXACT_CONE_COSINE),
    PLANE(outputs, indirect, 3, EXACT_INDIRECT),
    PLANE(outputs, beauty, 3, EXACT_BEAUTY)};

const char *plane_name(plane_id id) {
  return infos[id].name;
}

int plane_channels(plane_id id) {
  return infos[id].channels;
}

int plane_first(plane_id id) {
  return infos[id].first;
}

hbil_plane_format *plane_format(hbil_config *config, plane_id id) {
  return (hbil_plane_format *)((char *)config + infos[id].format);
}

hbil_plane *plane_slot(hbil_frame *frame, plane_id id) {
  return (hbil_plane *)((char *)frame + infos[id].slot);
}

static size_t component_size(hbil_component component) {
  return component == HBIL_FLOAT32 ? 4 : component == HBIL_FLOAT16 ? 2 : 1;
}

placement place_plane(const hbil_config *config, plane_id id,
                      const plane_layout *layout) {
  hbil_config copy = *config;
  const hbil_plane_format *format = plane_format(&copy, id);
  size_t channels = (size_t)infos[id].channels;
  size_t stride = format->stride ? format->stride : channels;
  placement p;
  p.component = format->component;
  p.size = component_size(format->component);
  p.offset = layout->offset * p.size;
  p.pixel = stride * p.size;
  p.row = config->width * p.pixel + layout->row_extra * p.size;
  p.plane = p.size;
  if (stride == 1)
    p.plane = p.row * config->height + layout->plane_extra * p.size;
  p.end = p.offset + p.row * config->height +
          (stride == 1 ? p.plane * (channels - 1) : 0);
  return p;
}

size_t placement_of(const placement *p, int channel, size_t x, size_t y) {
  return p->offset + (size_t)channel * p->plane + y * p->row + x * p->pixel;
}

void encode_component(const placement *p, unsigned char *at, float value) {
  uint16_t half = float_to_half(value);
  if (p->component == HBIL_FLOAT32)
    memcpy(at, &value, 4);
  else if (p->component == HBIL_FLOAT16)
    memcpy(at, &half, 2);
  else
    *at = (unsigned char)lrintf(fminf(fmaxf(value, 0.0f), 1.0f) * 255.0f);
}

float decode_component(const placement *p, const unsigned char *at) {
  float value;
  uint16_t half;
  if (p->component == HBIL_UNORM8)
    return (float)*at / 255.0f;
  if (p->component == HBIL_FLOAT16) {
    memcpy(&half, at, 2);
    return half_to_float(half);
  }
  memcpy(&value, at, 4);
  return value;
}

float half_to_float(uint16_t half) {
  int exponent = half >> 10 & 31, mantissa = half & 1023;
  float sign = half & 0x8000 ? -1.0f : 1.0f;
  if (exponent == 31)
    return mantissa ? NAN : sign * INFINITY;
  if (exponent == 0)
    return sign * ldexpf((float)mantissa, -24);
  return sign * ldexpf((float)(mantissa + 1024), exponent - 25);
}

uint16_t float_to_half(float value) {
  uint16_t sign = signbit(value) ? 0x8000 : 0;
  float size = fabsf(value);
  int exponent;
  if (isnan(value))
    return 0x7e00;
  if (size >= 65520.0f)
    return sign | 0x7c00;
  if (size < ldexpf(1.0f, -14))
    return (uint16_t)(sign | (int)rintf(ldexpf(size, 24)));
  frexpf(size, &exponent);
  /* a mantissa that rounds up to 2048 carries into the exponent by itself */
  return (uint16_t)(sign + ((exponent + 13) << 10) +
                    (int)rintf(ldexpf(size, 11 - exponent)));
}
