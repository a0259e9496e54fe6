/* See searches.h. */
#include "searches.h"

#include <math.h>
#include <string.h>

#include "planes.h"

static bool any_of(const hbil_config *config, const int *list, size_t count) {
  for (size_t i = 0; i < count; ++i)
    if (plane_format(config, list[i])->component != HBIL_NONE)
      return true;
  return false;
}

/* Whether an output shows light that passes the near field, or comes from it.
 */
static bool shows_light(const hbil_config *config) {
  static const int list[] = {PLANE_NEAR,   PLANE_FAR,     PLANE_INDIRECT,
                             PLANE_BEAUTY, PLANE_UNKNOWN, PLANE_GLOSSY};
  return (config->model.mode == HBIL_MODE_HBIL ||
          config->model.far_field != HBIL_FAR_NONE) &&
         any_of(config, list, sizeof list / sizeof *list);
}

float near_thickness_share(const hbil_config *config) {
  return fminf(config->model.relative_thickness,
               config->model.near_relative_thickness);
}

static bool shows_occlusion(const hbil_config *config) {
  static const int list[] = {PLANE_AO, PLANE_BENT, PLANE_CONE, PLANE_ERROR};
  return any_of(config, list, sizeof list / sizeof *list);
}

void searches_settle(hbil_config *config) {
  hbil_model *model = &config->model;
  if (model->mode == HBIL_MODE_HBAO)
    model->ao_radius = model->radius;
  else if (shows_occlusion(config) && !shows_light(config))
    model->radius = model->ao_radius;
  else
    return;
  model->near_relative_thickness = INFINITY;
}

bool searches_differ(const hbil_config *config, hbil_config *ao) {
  const hbil_model *model = &config->model;
  if (!shows_occlusion(config) ||
      (model->radius == model->ao_radius &&
       near_thickness_share(config) == model->relative_thickness))
    return false;
  *ao = *config;
  memset(&ao->outputs, 0, sizeof ao->outputs);
  ao->outputs.ao = config->outputs.ao;
  ao->outputs.bent_normal = config->outputs.bent_normal;
  ao->outputs.error_estimate = config->outputs.error_estimate;
  ao->model.mode = HBIL_MODE_GTAO;
  ao->model.radius = model->ao_radius;
  ao->model.near_relative_thickness = INFINITY;
  ao->model.far_field = HBIL_FAR_NONE;
  ao->model.ao_bounces = HBIL_AO_BOUNCES_NONE;
  ao->model.cache_method = HBIL_CACHE_METHOD_NONE;
  return true;
}

/* A near field of a few voxels is short: three fifths of the steps give light
 * the same error (doc/measurements.md, "How defaults were chosen").  A search
 * that ao shares has all steps. */
cl_uint near_steps(const hbil_config *config) {
  const cl_uint steps = config->sampling.steps_per_side;
  hbil_config ao;
  return config->model.cache_method != HBIL_CACHE_METHOD_NONE &&
                 isfinite(config->model.radius) && shows_light(config) &&
                 (!shows_occlusion(config) || searches_differ(config, &ao))
             ? (3 * steps + 4) / 5
             : steps;
}
