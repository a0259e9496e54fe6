/* How much of the open directions the sky lights, told by direct light. */
#include "exact/sky_light.h"

#include "exact/input.h"
#include "exact/passes.h"
#include "exact/vector.h"

double exact_sky_share(const exact_frame *frame) {
  return frame->config->model.far_field == HBIL_FAR_FRAME
             ? (double)frame->sky_share
             : 0.0;
}

double exact_sky_light(const exact_frame *frame, int x, int y) {
  double light = 0.0;
  if (frame->config->model.far_field != HBIL_FAR_FRAME)
    return 0.0;
  for (int c = 0; c < 3; ++c) {
    const double sky = (double)frame->environment[0][c];
    if (sky > 0.0)
      light = fmax(light, exact_direct(frame, c, x, y) / PI / sky);
  }
  return light;
}

double exact_unlit_part(double sky_light, double ao, double *lit) {
  const double excess = sky_light / fmax(ao, 1e-6) - 1.0;
  *lit = clamp((double)HBIL_LIT_SLOPE * excess, 0.0, 1.0);
  return fmax(0.0, -excess);
}

/* exact_sky_light(), as the mean over the pixel and its neighbours above, below
 * and to the right, as far as they are at its depth.  Above and below the
 * picture, the pixel stands for its neighbour. */
static double mean_sky_light(const exact_frame *frame, int x, int y) {
  const int width = (int)frame->config->width;
  const int height = (int)frame->config->height;
  const double z = exact_planar_depth(frame, x, y);
  double sum = exact_sky_light(frame, x, y), count = 1.0;
  for (int i = 0; i < 3; ++i) {
    const int nx = x + (i == 2);
    const int below = y + (i == 0) - (i == 1);
    const int ny = below < 0 ? 0 : below < height ? below : height - 1;
    if (nx >= width || exact_is_sky(frame, nx, ny))
      continue;
    const double off = (exact_planar_depth(frame, nx, ny) / z - 1.0) /
                       (double)HBIL_PLANE_TOLERANCE;
    const double share = fmax(0.0, 1.0 - off * off);
    sum += share * exact_sky_light(frame, nx, ny);
    count += share;
  }
  return sum / count;
}

/*
 * HBIL_FAR_FRAME: the part of the open share `ao` that ends on a surface after
 * all.  Direct light that contains the sky's shows that no more than
 * E_direct / pi / L_sky of the hemisphere sees the sky.  So the part
 * u = 1 - E_direct / pi / L_sky / ao of the open directions is without sky.
 * Without a sun, u may be an error of L_sky, so an open direction is taken for
 * blocked with the probability u, and the part is u^2.  Where the sun shines,
 * E_direct tells nothing, and u is that of the other pixels.
 */
double exact_unlit_share(const exact_frame *frame, int x, int y, double ao) {
  double lit;
  if (frame->config->model.far_field != HBIL_FAR_FRAME)
    return 0.0;
  double unlit = exact_unlit_part(mean_sky_light(frame, x, y), ao, &lit);
  unlit += lit * frame->estimate.unlit;
  return (1.0 - exact_sky_share(frame)) * ao * unlit *
         (unlit + frame->estimate.sun * (1.0 - unlit));
}
