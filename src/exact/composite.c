/*
 * Composite: the outputs, and the history of the next frame.
 *
 *   indirect = (1 - F0) (E_near + E_far) / pi
 *   beauty   = albedo ((1 - F0) E_direct / pi + indirect) + emission
 * History is the irradiance E_near + E_far or, with HBIL_FEEDBACK_RADIANCE, the
 * radiance that surfaces send: beauty, with emission as far as it lights
 * others.
 *
 * Where no near light is computed, model.ao_bounces multiplies E_far by a
 * factor of AO and the albedo.
 *
 * With a radiance cache, E_far has what that knows of the open directions.
 *
 * unknown is the share of the hemisphere whose light is estimated: open
 * directions that end on a surface after all, and, where recompose fills them
 * in, those that back-facing samples block.
 */
#include "exact/camera.h"
#include "exact/far_field.h"
#include "exact/glossy.h"
#include "exact/input.h"
#include "exact/passes.h"
#include "exact/planes.h"
#include "exact/settings.h"
#include "exact/sky_light.h"

static void composite_sky(const exact_frame *frame, int x, int y,
                          exact_planes *out) {
  exact_planes_clear(out, x, y);
  *exact_at(out, EXACT_AO, x, y) = 1.0;
  for (int c = 0; c < 3; ++c)
    *exact_at(out, EXACT_BEAUTY + c, x, y) = exact_sky_radiance(frame, c, x, y);
}

static void composite_channel(const exact_frame *frame, int c, int x, int y,
                              double near_irradiance, double far_irradiance,
                              exact_planes *out, exact_planes *history) {
  const double transmittance = exact_transmittance(frame, c, x, y);
  const double indirect =
      transmittance * (near_irradiance + far_irradiance) / PI;
  const double diffuse =
      exact_albedo(frame, c, x, y) *
      (transmittance * exact_direct(frame, c, x, y) / PI + indirect);
  *exact_at(out, EXACT_NEAR_IRRADIANCE + c, x, y) = near_irradiance;
  *exact_at(out, EXACT_FAR_IRRADIANCE + c, x, y) = far_irradiance;
  *exact_at(out, EXACT_INDIRECT + c, x, y) = indirect;
  *exact_at(out, EXACT_BEAUTY + c, x, y) =
      diffuse + exact_light(frame, EXACT_EMISSION + c, x, y);
  const double carried =
      frame->config->model.feedback == HBIL_FEEDBACK_IRRADIANCE
          ? near_irradiance + far_irradiance
          : diffuse + exact_gathered_emission(frame, c, x, y);
  *exact_at(history, HBIL_HISTORY_RED + c, x, y) =
      carried / exact_exposure(frame);
}

/* F(AO) / AO, what occluders reflect of far light: Mayaux 2018, 2.2.3, or the
 * fit of Jimenez and others 2016, "Practical Realtime Strategies for Accurate
 * Indirect Occlusion". */
static double bounces(const exact_frame *frame, int c, int x, int y,
                      double ao) {
  const hbil_ao_bounces kind = frame->config->model.ao_bounces;
  const double r = exact_albedo(frame, c, x, y);
  if (kind == HBIL_AO_BOUNCES_PAPER)
    return 1.0 + pow(fmax(0.0, 1.0 - ao), 0.75) / 2.0;
  if (kind == HBIL_AO_BOUNCES_ALBEDO)
    return fmax(1.0, (2.0404 * r - 0.3324) * ao * ao +
                         (-4.7951 * r + 0.6417) * ao + 2.7552 * r + 0.6903);
  return 1.0;
}

static vec3 bent_normal(const exact_planes *resolved, int x, int y) {
  return vec(*exact_at(resolved, HBIL_LIGHT_BENT, x, y),
             *exact_at(resolved, HBIL_LIGHT_BENT + 1, x, y),
             *exact_at(resolved, HBIL_LIGHT_BENT + 2, x, y));
}

static void store_bent_normal(const exact_frame *frame, vec3 bent, int x, int y,
                              exact_planes *out) {
  if (frame->config->outputs.bent_normal_space == HBIL_SPACE_WORLD)
    bent = exact_to_world(&frame->camera, bent);
  *exact_at(out, EXACT_BENT_NORMAL, x, y) = bent.x;
  *exact_at(out, EXACT_BENT_NORMAL + 1, x, y) = bent.y;
  *exact_at(out, EXACT_BENT_NORMAL + 2, x, y) = bent.z;
}

/* AO and the bent cone: ao, its error, bent_normal and cone_cosine. */
static void store_cone(const exact_frame *frame, const exact_planes *resolved,
                       int x, int y, exact_planes *out) {
  const double ao = *exact_at(resolved, HBIL_LIGHT_AO, x, y);
  *exact_at(out, EXACT_AO, x, y) = ao;
  if (exact_has_bent_normal(frame->config))
    *exact_at(out, EXACT_CONE_COSINE, x, y) = sqrt(fmax(0.0, 1.0 - ao));
  if (resolved->count >= EXACT_RESOLVED_PLANES)
    *exact_at(out, EXACT_ERROR_ESTIMATE, x, y) =
        *exact_at(resolved, EXACT_RESOLVED_ERRORS, x, y);
  store_bent_normal(frame, bent_normal(resolved, x, y), x, y, out);
}

static double unknown_share(const exact_frame *frame,
                            const exact_planes *resolved, int x, int y,
                            double ao, const exact_probe_light *cached) {
  const double behind =
      resolved->count > HBIL_LIGHT_UNKNOWN && exact_fills_unknown(frame->config)
          ? *exact_at(resolved, HBIL_LIGHT_UNKNOWN, x, y)
          : 0.0;
  return fmin(1.0, exact_estimated_share(frame, x, y, ao, cached) + behind);
}

static void composite_pixel(const exact_frame *frame,
                            const exact_planes *resolved, int x, int y,
                            exact_planes *out, exact_planes *history) {
  const double ao = *exact_at(resolved, HBIL_LIGHT_AO, x, y);
  const vec3 bent = bent_normal(resolved, x, y);
  const exact_probe_light cached = exact_light_of_probes(frame, x, y, ao, bent);
  store_cone(frame, resolved, x, y, out);
  *exact_at(out, EXACT_UNKNOWN, x, y) =
      unknown_share(frame, resolved, x, y, ao, &cached);
  if (resolved->count >= EXACT_RESOLVED_PLANES)
    *exact_at(out, EXACT_ERROR_ESTIMATE + 1, x, y) =
        *exact_at(resolved, EXACT_RESOLVED_ERRORS + 1, x, y);
  for (int c = 0; c < 3; ++c) {
    const double near_irradiance =
        *exact_at(resolved, HBIL_LIGHT_RED + c, x, y);
    const double far_irradiance =
        bounces(frame, c, x, y, ao) *
        exact_far_irradiance(frame, c, x, y, ao, bent, near_irradiance,
                             &cached);
    composite_channel(frame, c, x, y, near_irradiance, far_irradiance, out,
                      history);
  }
  *exact_at(history, HBIL_HISTORY_W, x, y) =
      (float)(1.0 / exact_planar_depth(frame, x, y));
}

void exact_composite(const exact_frame *frame, const exact_planes *resolved,
                     exact_planes *out, exact_planes *history) {
  for (int y = 0; y < out->height; ++y)
    for (int x = 0; x < out->width; ++x) {
      exact_planes_clear(history, x, y);
      if (exact_is_sky(frame, x, y))
        composite_sky(frame, x, y, out);
      else
        composite_pixel(frame, resolved, x, y, out, history);
    }
}

void exact_composite_ao(const exact_frame *frame, const exact_planes *resolved,
                        exact_planes *out) {
  for (int y = 0; y < out->height; ++y)
    for (int x = 0; x < out->width; ++x)
      if (!exact_is_sky(frame, x, y))
        store_cone(frame, resolved, x, y, out);
}
