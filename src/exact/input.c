/* A frame's inputs as the passes use them. */
#include "exact/input.h"

#include "exact/camera.h"
#include "shared.h"

float exact_input(const exact_frame *frame, int plane, int x, int y) {
  return frame->input[plane][(size_t)y * frame->config->width + (size_t)x];
}

float exact_scaled_depth(const exact_frame *frame, int x, int y) {
  const float depth = exact_input(frame, EXACT_DEPTH, x, y);
  return frame->config->inputs.depth_kind == HBIL_DEPTH_HARDWARE
             ? depth
             : depth * frame->config->inputs.depth_scale;
}

bool exact_is_sky(const exact_frame *frame, int x, int y) {
  const float depth = exact_scaled_depth(frame, x, y);
  return !(depth >= HBIL_NEAREST_DEPTH) || depth >= HBIL_FARTHEST_DEPTH ||
         depth >= frame->config->inputs.sky_depth;
}

double exact_planar_depth(const exact_frame *frame, int x, int y) {
  const double along = frame->config->inputs.depth_kind != HBIL_DEPTH_RAY
                           ? 1.0
                           : vec_length(exact_ray(frame, x, y));
  return (double)exact_scaled_depth(frame, x, y) / along;
}

/* The product is a float, as it is in the kernels: it decides what is too
 * bright. */
static double scaled_light(const exact_frame *frame, int plane, int x, int y,
                           float scale) {
  if (!frame->input[plane])
    return 0.0;
  const float v = exact_input(frame, plane, x, y) * scale;
  return v > 0.0f && v <= HBIL_BRIGHTEST ? (double)v : 0.0;
}

double exact_light(const exact_frame *frame, int plane, int x, int y) {
  return scaled_light(frame, plane, x, y, 1.0f);
}

double exact_albedo(const exact_frame *frame, int channel, int x, int y) {
  return frame->input[EXACT_ALBEDO]
             ? clamp(exact_light(frame, EXACT_ALBEDO + channel, x, y), 0.0, 1.0)
             : 1.0;
}

double exact_transmittance(const exact_frame *frame, int channel, int x,
                           int y) {
  return 1.0 - clamp(exact_light(frame, EXACT_F0 + channel, x, y), 0.0, 1.0);
}

double exact_direct(const exact_frame *frame, int channel, int x, int y) {
  const hbil_inputs *in = &frame->config->inputs;
  const double light =
      scaled_light(frame, EXACT_DIRECT + channel, x, y, in->direct_scale);
  if (in->direct_kind == HBIL_DIRECT_IRRADIANCE)
    return light;
  const double albedo = exact_albedo(frame, channel, x, y);
  return albedo >= (double)HBIL_LEAST_ALBEDO
             ? fmin(PI * light / albedo, (double)HBIL_BRIGHTEST)
             : 0.0;
}

double exact_exposure(const exact_frame *frame) {
  return frame->exposure > 0.0f ? (double)frame->exposure : 1.0;
}

double exact_gathered_emission(const exact_frame *frame, int channel, int x,
                               int y) {
  return frame->config->model.gather_emission
             ? exact_light(frame, EXACT_EMISSION + channel, x, y)
             : 0.0;
}
