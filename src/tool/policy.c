/*
 * What to take for light that the screen doesn't show, when nobody says: a look
 * at the first frame.
 *
 * Unblocked directions end on surfaces outside the picture, and what the
 * frame's own surfaces send is a better guess than black; or they end in the
 * sky, whose light a renderer's direct diffuse light holds already.  Where a
 * lit sky is seen, its radiance tells the two apart: direct light below the
 * sky's shows what is hidden from it.  (Measured on public scenes, see
 * HACKING.md.)
 */
#include "tool/tool.h"

#include <math.h>
#include <stdio.h>

/* Share of background pixels above which a sky counts as seen. */
#define SKY_SEEN 1e-3

static int is_background(float depth, float background) {
  return !(depth > 0.0f && depth < background && isfinite(depth));
}

/*
 * Radiance of the sky that is seen, the mean of square roots, squared: the
 * sun's disc is no measure of the sky.  0 where too little lit sky is seen.
 */
static void sky_radiance(const gbuffer *g, float background, float out[3]) {
  const float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  const size_t channels = g->map.count[ROLE_EMISSION];
  double sum[3] = {0};
  size_t sky = 0;
  for (size_t i = 0; i < pixels; i++) {
    double lit = 0;
    for (size_t c = 0; c < channels && c < 3; c++) {
      const double v = gbuffer_plane(g, ROLE_EMISSION, c)[i];
      if (is_background(depth[i], background) && isfinite(v) && v > 0) {
        sum[c] += sqrt(v);
        lit += v;
      }
    }
    sky += lit > 0;
  }
  for (size_t c = 0; c < 3; c++) {
    const double root = sky ? sum[c < channels ? c : 0] / (double)sky : 0;
    out[c] = (double)sky > SKY_SEEN * (double)pixels ? (float)(root * root) : 0;
  }
}

void policy_far_field(const gbuffer *first, hbil_config *config,
                      float environment[9][3], const char **reason) {
  sky_radiance(first, config->background, environment[0]);
  config->far_field = HBIL_FAR_FRAME;
  if (environment[0][0] + environment[0][1] + environment[0][2] > 0)
    *reason = "what the frame's surfaces send, as far as direct light is less "
              "than the sky's that is seen";
  else
    *reason = "what the frame's surfaces send: no lit sky is seen";
}
