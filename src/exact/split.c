/*
 * Split: inputs and reprojected light -> what the gather reads of a pixel: w,
 * the view-space normal and the radiance that the surface sends.
 *
 * Radiance follows from the irradiance E of a diffuse surface:
 *   L = (1 - F0) albedo / pi (E_direct + E_carried) + emission.
 * With HBIL_FEEDBACK_RADIANCE, CARRIED has that radiance itself, and the direct
 * light stands in where nothing was carried over.
 *
 * Normals face the eye: n.wo >= HBIL_MIN_COSINE.  One that does not is bent
 * towards the eye until it does.
 */
#include "exact/camera.h"
#include "exact/input.h"
#include "exact/passes.h"
#include "exact/planes.h"

/* The unit view-space normal, which faces the eye. */
static vec3 normal_towards_eye(const exact_frame *frame, int x, int y) {
  const double least = (double)HBIL_MIN_COSINE;
  const vec3 wo = vec_scale(-1.0, vec_normalize(exact_ray(frame, x, y)));
  const float *scale = frame->config->inputs.normal_scale;
  vec3 n = vec(
      (double)exact_input(frame, EXACT_NORMAL, x, y) * (double)scale[0],
      (double)exact_input(frame, EXACT_NORMAL + 1, x, y) * (double)scale[1],
      (double)exact_input(frame, EXACT_NORMAL + 2, x, y) * (double)scale[2]);
  if (frame->config->inputs.normal_space == HBIL_SPACE_WORLD)
    n = exact_to_view(&frame->camera, n);
  /* the kernels need the squared length as a float */
  if (!isfinite((float)vec_dot(n, n)) || vec_dot(n, n) < 1e-20)
    return wo;
  n = vec_normalize(n);
  if (vec_dot(n, wo) < least)
    n = vec_normalize(vec_add(n, least - vec_dot(n, wo), wo));
  return n;
}

/* carried: may be NULL. */
static double radiance(const exact_frame *frame, const exact_planes *carried,
                       int c, int x, int y) {
  const bool is_radiance =
      frame->config->model.feedback == HBIL_FEEDBACK_RADIANCE;
  const double value = carried
                           ? exact_exposure(frame) *
                                 *exact_at(carried, HBIL_CARRIED_RED + c, x, y)
                           : 0.0;
  const double diffuse =
      exact_transmittance(frame, c, x, y) * exact_albedo(frame, c, x, y) / PI;
  if (is_radiance && carried &&
      *exact_at(carried, HBIL_CARRIED_WEIGHT, x, y) > 0.0)
    return value;
  return diffuse *
             (exact_direct(frame, c, x, y) + (is_radiance ? 0.0 : value)) +
         exact_gathered_emission(frame, c, x, y);
}

static void split_pixel(const exact_frame *frame, const exact_planes *carried,
                        int x, int y, exact_planes *split) {
  const vec3 n = normal_towards_eye(frame, x, y);
  const double w =
      exact_w_of_depth(frame->config, exact_planar_depth(frame, x, y));
  /* A float, because the plan stores one: it decides about sampling levels. */
  *exact_at(split, HBIL_SPLIT_W, x, y) = (float)w;
  *exact_at(split, HBIL_SPLIT_NORMAL, x, y) = n.x;
  *exact_at(split, HBIL_SPLIT_NORMAL + 1, x, y) = n.y;
  *exact_at(split, HBIL_SPLIT_NORMAL + 2, x, y) = n.z;
  for (int c = 0; c < 3; ++c)
    *exact_at(split, HBIL_SPLIT_RED + c, x, y) =
        radiance(frame, carried, c, x, y);
}

void exact_split(const exact_frame *frame, const exact_planes *carried,
                 exact_planes *split) {
  for (int y = 0; y < split->height; ++y)
    for (int x = 0; x < split->width; ++x) {
      exact_planes_clear(split, x, y);
      if (exact_is_sky(frame, x, y))
        *exact_at(split, HBIL_SPLIT_W, x, y) = (double)HBIL_NOTHING;
      else
        split_pixel(frame, carried, x, y, split);
    }
}
