/* glossy: light that a rough mirror reflects, beyond what the gather has found
 * of it. */
#include "glossy.h"

#include <math.h>

#include "passes.h"

float glossy_lobe(const hbil_config *config) {
  const double roughness = (double)config->model.roughness;
  const double alpha2 = pow(roughness, 4);
  return (float)((1 - alpha2) / (2 * alpha2));
}

/* Means of x = 1 - cosine and of x^2 under 1 / (1 + k x)^2, x in 0..2, in
 * closed form.  The orders are P1 = 1 - x and P2 = 1 - 3 x + 3/2 x^2. */
void glossy_bands(float lobe, float bands[2]) {
  /* below it digits cancel, and what is left grows as k does, to 1e-6 */
  const double k = fmax((double)lobe, 1e-3), part = (double)lobe / k;
  const double width = 1 + 2 * k, log_width = log(width);
  const double x = (log_width - 2 * k / width) * width / (2 * k * k);
  const double x2 =
      (2 * k - 2 * log_width + 2 * k / width) * width / (2 * k * k * k);
  bands[0] = (float)(part * (1 - x));
  bands[1] = (float)(part * (1 - 3 * x + 1.5 * x2));
}

hbil_status enqueue_glossy(hbil_plan *plan, commands *chain,
                           const hbil_frame *frame) {
  const hbil_config *c = &plan->config;
  cl_mem plane[PLANE_COUNT];
  if (!plan->layout.glossy)
    return HBIL_SUCCESS;
  const hbil_composite_args args = composite_args(plan, frame, plane);
  hbil_glossy_args own = {.split = plan->layout.split, .lobe = glossy_lobe(c)};
  const cl_mem glossy = bind_plane(plan, frame, PLANE_GLOSSY, &own.glossy);
  glossy_bands(own.lobe, own.bands);
  const argument list[] = {ARG(args),
                           ARG(own),
                           BUFFER_ARG(plan, BUFFER_SPLIT),
                           BUFFER_ARG(plan, BUFFER_RESOLVED),
                           BUFFER_ARG(plan, BUFFER_ESTIMATE),
                           ARG(plane[PLANE_DEPTH]),
                           ARG(plane[PLANE_ALBEDO]),
                           ARG(plane[PLANE_DIRECT]),
                           BUFFER_ARG(plan, BUFFER_GLOSSY_PROBES),
                           ARG(glossy)};
  return LAUNCH(chain, KERNEL_GLOSSY, list, (vectors_across(plan) + 3) / 4,
                c->height, 1);
}
