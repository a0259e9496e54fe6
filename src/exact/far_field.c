/*
 * The far field: light from directions that nothing on the screen blocks.
 *
 * The open part of a hemisphere is taken for a cone about the bent normal.  AO
 * is weighed by the cosine, so a cone of half-angle alpha has AO = sin^2 alpha,
 * and t = cos alpha = sqrt(1 - AO).  Band l of a cosine that is clamped to the
 * cone: c_l = 2 pi sqrt((2l + 1) / (4 pi)) integral_t^1 P_l(x) x dx, with the
 * integrals (1 - t^2) / 2, (1 - t^3) / 3 and (3 (1 - t^4) - 2 (1 - t^2)) / 8.
 * At t = 0 these are Ramamoorthi and Hanrahan's constants.  Irradiance about
 * the direction b is then sum over l, m of sqrt(4 pi / (2l + 1)) c_l L_lm
 * Y_lm(b). A constant environment gives pi AO L.
 */
#include "exact/far_field.h"

#include "exact/camera.h"
#include "exact/estimate.h"
#include "exact/input.h"
#include "exact/passes.h"
#include "exact/sky_light.h"

void exact_sh_basis(const double direction[3], double basis[9]) {
  const double x = direction[0], y = direction[1], z = direction[2];
  basis[0] = sqrt(1.0 / (4.0 * PI));
  basis[1] = sqrt(3.0 / (4.0 * PI)) * y;
  basis[2] = sqrt(3.0 / (4.0 * PI)) * z;
  basis[3] = sqrt(3.0 / (4.0 * PI)) * x;
  basis[4] = sqrt(15.0 / (4.0 * PI)) * x * y;
  basis[5] = sqrt(15.0 / (4.0 * PI)) * y * z;
  basis[6] = sqrt(5.0 / (16.0 * PI)) * (3.0 * z * z - 1.0);
  basis[7] = sqrt(15.0 / (4.0 * PI)) * x * z;
  basis[8] = sqrt(15.0 / (16.0 * PI)) * (x * x - y * y);
}

/* c_l of a cone of cosine t. */
static double cone_band(int l, double t) {
  const double t2 = t * t;
  double integral = (1.0 - t2) / 2.0;
  if (l == 1)
    integral = (1.0 - t2 * t) / 3.0;
  if (l == 2)
    integral = (3.0 * (1.0 - t2 * t2) - 2.0 * (1.0 - t2)) / 8.0;
  return sqrt((2 * l + 1) * PI) * integral;
}

static int band_of(int index) {
  return index == 0 ? 0 : index < 4 ? 1 : 2;
}

double exact_estimated_share(const exact_frame *frame, int x, int y, double ao,
                             const exact_probe_light *cached) {
  return fmin((1.0 - cached->share) * ao, exact_unlit_share(frame, x, y, ao));
}

/* Irradiance of an environment. */
static double environment_light(const exact_frame *frame, int channel,
                                double ao, vec3 bent) {
  const vec3 world = exact_to_world(&frame->camera, bent);
  const double d[3] = {world.x, world.y, world.z};
  double basis[9], sum = 0.0;
  if (frame->config->model.far_field == HBIL_FAR_CONSTANT)
    return PI * ao * (double)frame->environment[0][channel];
  exact_sh_basis(d, basis);
  for (int i = 0; i < 9; ++i) {
    const int l = band_of(i);
    sum += sqrt(4.0 * PI / (2 * l + 1)) *
           cone_band(l, sqrt(fmax(0.0, 1.0 - ao))) * basis[i] *
           (double)frame->environment[i][channel];
  }
  return fmax(0.0, sum);
}

double exact_far_irradiance(const exact_frame *frame, int channel, int x, int y,
                            double ao, vec3 bent, double near_irradiance,
                            const exact_probe_light *cached) {
  const hbil_far_field far_field = frame->config->model.far_field;
  double light = 0.0;
  if (far_field == HBIL_FAR_FRAME)
    light = PI * exact_estimated_share(frame, x, y, ao, cached) *
            (cached->guess[channel] +
             (1.0 - cached->guess_share) *
                 exact_unseen_radiance(
                     frame, channel, bent, near_irradiance / PI, 1.0 - ao,
                     cached->light[channel], ao * cached->share));
  else if (far_field != HBIL_FAR_NONE)
    light = (1.0 - cached->share) * environment_light(frame, channel, ao, bent);
  return light + PI * cached->light[channel];
}

double exact_sky_radiance(const exact_frame *frame, int channel, int x, int y) {
  const hbil_far_field far_field = frame->config->model.far_field;
  const vec3 world =
      exact_to_world(&frame->camera, vec_normalize(exact_ray(frame, x, y)));
  const double d[3] = {world.x, world.y, world.z};
  double basis[9], sum = 0.0;
  if (frame->input[EXACT_EMISSION])
    return exact_light(frame, EXACT_EMISSION + channel, x, y);
  if (far_field == HBIL_FAR_NONE || far_field == HBIL_FAR_FRAME)
    return 0.0;
  if (far_field == HBIL_FAR_CONSTANT)
    return (double)frame->environment[0][channel];
  exact_sh_basis(d, basis);
  for (int i = 0; i < 9; ++i)
    sum += basis[i] * (double)frame->environment[i][channel];
  return fmax(0.0, sum);
}
