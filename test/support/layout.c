#include "test/support/layout.h"

#include <math.h>
#include <string.h>

#include "scene/store.h"

typedef struct plane_info {
  const char *name;
  int channels;
  size_t format, slot; /* offsets in hbil_config and hbil_frame */
} plane_info;

#define INFO(id, group, field, channels)                                       \
  {#field, channels, offsetof(hbil_config, group.field),                       \
   offsetof(hbil_frame, field)},

static const plane_info infos[PLANE_COUNT] = {PLANE_LIST(INFO)};

const char *plane_name(plane_id id) {
  return infos[id].name;
}

int plane_channels(plane_id id) {
  return infos[id].channels;
}

int plane_first(plane_id id) {
  int first = 0;
  for (plane_id i = id < PLANE_FIRST_OUTPUT ? 0 : PLANE_FIRST_OUTPUT; i < id;
       ++i)
    first += infos[i].channels;
  return first;
}

hbil_plane_format *plane_format(hbil_config *config, plane_id id) {
  return (hbil_plane_format *)((char *)config + infos[id].format);
}

hbil_plane *plane_slot(hbil_frame *frame, plane_id id) {
  return (hbil_plane *)((char *)frame + infos[id].slot);
}

static bool is_octahedral(const hbil_config *config, plane_id id) {
  return id == PLANE_NORMAL &&
         config->inputs.normal_encoding == HBIL_NORMAL_OCTAHEDRAL;
}

static bool is_hardware_depth(const hbil_config *config, plane_id id) {
  return id == PLANE_DEPTH && config->inputs.depth_kind == HBIL_DEPTH_HARDWARE;
}

/* What a pixel is stored as. */
static int stored_channels(const hbil_config *config, plane_id id) {
  return is_octahedral(config, id) ? 2 : infos[id].channels;
}

hbil_plane_format pitched_format(hbil_component component, cl_uint stride) {
  return (hbil_plane_format){component,
                             stride * (cl_uint)scene_component_size(component)};
}

placement place_plane(const hbil_config *config, plane_id id,
                      const plane_layout *layout) {
  hbil_config copy = *config;
  const hbil_plane_format *format = plane_format(&copy, id);
  size_t components = scene_is_word(format->component)
                          ? 1
                          : (size_t)stored_channels(config, id);
  placement p;
  p.component = format->component;
  p.size = scene_component_size(format->component);
  p.offset = layout->offset * p.size;
  p.pixel = format->pixel_pitch ? format->pixel_pitch : components * p.size;
  p.row = config->width * p.pixel + layout->row_extra * p.size;
  p.plane = p.size;
  if (p.pixel == p.size)
    p.plane = p.row * config->height + layout->plane_extra * p.size;
  p.end = p.offset + p.row * config->height +
          (p.pixel == p.size ? p.plane * (components - 1) : 0);
  return p;
}

size_t placement_of(const placement *p, int channel, size_t x, size_t y) {
  return p->offset + (size_t)channel * p->plane + y * p->row + x * p->pixel;
}

/* ------------------------------------------------------------------------ */
/* Values of codes, from their definitions in hbil_formats.h                 */

static double snorm_value(int code, int largest) {
  return fmax((double)code / largest, -1.0);
}

/* A float without sign: 5 bits of exponent, so many of mantissa. */
static double small_float_value(uint32_t code, int bits) {
  const int exponent = (int)(code >> bits);
  const double mantissa = code & ((1u << bits) - 1u);
  if (exponent == 31)
    return mantissa > 0.0 ? (double)NAN : (double)INFINITY;
  if (exponent == 0)
    return ldexp(mantissa, -14 - bits);
  return ldexp(mantissa + (1 << bits), exponent - 15 - bits);
}

static double half_value(uint16_t half) {
  return (half & 0x8000 ? -1.0 : 1.0) * small_float_value(half & 0x7fff, 10);
}

static double word_value(hbil_component component, uint32_t word, int channel) {
  if (component == HBIL_RGB10A2_UNORM)
    return (word >> (10 * channel) & 1023) / 1023.0;
  if (component == HBIL_RGB9E5_FLOAT)
    return ldexp(word >> (9 * channel) & 511, (int)(word >> 27) - 24);
  return channel < 2 ? small_float_value(word >> (11 * channel) & 2047, 6)
                     : small_float_value(word >> 22, 5);
}

double component_value(hbil_component component, const unsigned char *at,
                       int channel) {
  uint16_t two;
  uint32_t four;
  float real;
  if (component == HBIL_FLOAT32) { /* first, since nearly all planes have it */
    memcpy(&real, at, 4);
    return (double)real;
  }
  memcpy(&two, at, scene_component_size(component) > 1 ? 2 : 1);
  memcpy(&four, at, scene_component_size(component) > 2 ? 4 : 1);
  switch (component) {
  case HBIL_FLOAT16:
    return half_value(two);
  case HBIL_UNORM8:
    return *at / 255.0;
  case HBIL_SRGB8:
    return *at <= 10 ? *at / 255.0 / 12.92
                     : pow((*at / 255.0 + 0.055) / 1.055, 2.4);
  case HBIL_UNORM16:
    return two / 65535.0;
  case HBIL_UNORM24:
    return (four & 0xffffff) / 16777215.0;
  case HBIL_SNORM8:
    return snorm_value((int8_t)*at, 127);
  case HBIL_SNORM16:
    return snorm_value((int16_t)two, 32767);
  default:
    return word_value(component, four, channel);
  }
}

void octahedral_normal(const double uv[2], double normal[3]) {
  normal[2] = 1.0 - fabs(uv[0]) - fabs(uv[1]);
  for (int c = 0; c < 2; ++c)
    normal[c] =
        normal[2] < 0.0 ? copysign(1.0 - fabs(uv[1 - c]), uv[c]) : uv[c];
}

double hardware_depth_w(const hbil_config *config, const hbil_frame *frame,
                        double d) {
  const double a = frame->hardware_depth[0];
  const double b = frame->hardware_depth[1];
  return config->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC
             ? -((d - a) / b)
             : (d - a) / b;
}

/* ------------------------------------------------------------------------ */
/* Pixels                                                                    */

/* Planar depth of a hardware depth; 0: the far end, or beyond. */
static double planar_value(const hbil_config *config, const hbil_frame *frame,
                           double d) {
  const bool flat = config->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const double end = scene_hardware_depth(frame->hardware_depth, flat, 0.0);
  const double w = hardware_depth_w(config, frame, d);
  if (end > 0.5 ? d >= end : d <= end)
    return 0.0;
  return flat ? -w : w > 0.0 ? 1.0 / w : 0.0;
}

bool stores_its_values(const hbil_config *config, plane_id id,
                       const placement *p) {
  return p->component == HBIL_FLOAT32 && !is_octahedral(config, id) &&
         !is_hardware_depth(config, id);
}

void store_pixel(const hbil_config *config, const hbil_frame *frame,
                 plane_id id, const placement *p, unsigned char *bytes,
                 size_t x, size_t y, float values[3]) {
  const bool flat = config->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const bool unorm = p->component == HBIL_UNORM8 ||
                     p->component == HBIL_UNORM16 ||
                     p->component == HBIL_RGB10A2_UNORM;
  const bool biased = id == PLANE_NORMAL && unorm;
  const int channels = stored_channels(config, id);
  double v[3] = {0, 0, 0}, stored[3];
  for (int c = 0; c < infos[id].channels; ++c)
    v[c] = (double)values[c];
  if (is_octahedral(config, id))
    scene_octahedral((const double[3]){v[0], v[1], v[2]}, v);
  if (is_hardware_depth(config, id))
    v[0] = scene_hardware_depth(frame->hardware_depth, flat, v[0]);
  scene_store(p->component, biased, v, channels, p->plane,
              bytes + placement_of(p, 0, x, y));
  for (int c = 0; c < channels; ++c) {
    const int at = scene_is_word(p->component) ? 0 : c;
    stored[c] =
        component_value(p->component, bytes + placement_of(p, at, x, y), c);
    if (biased)
      stored[c] = 2.0 * stored[c] - 1.0;
  }
  if (is_octahedral(config, id))
    octahedral_normal((const double[2]){stored[0], stored[1]}, stored);
  if (is_hardware_depth(config, id))
    stored[0] = planar_value(config, frame, stored[0]);
  for (int c = 0; c < infos[id].channels; ++c)
    values[c] = (float)stored[c];
}
