/*
 * What to take for light that the screen doesn't show, when nobody says: a look
 * at the first frame.
 *
 * A renderer's direct diffuse light holds the sky's.  Where a lit sky is seen,
 * unblocked directions therefore add nothing; where none is, they end on
 * surfaces outside the picture, and what the frame's own surfaces send is the
 * better guess than black.  (Measured on four public scenes, see HACKING.md.)
 */
#include "tool/tool.h"

#include <math.h>
#include <stdio.h>

/* Share of background pixels above which a sky counts as seen. */
#define SKY_SEEN 1e-3

static int is_background(float depth, float background) {
  return !(depth > 0.0f && depth < background && isfinite(depth));
}

/* Light of background pixel i; 0 where the file does not say. */
static double sky_light(const gbuffer *g, size_t i) {
  double sum = 0.0;
  for (size_t c = 0; c < g->map.count[ROLE_EMISSION]; c++)
    sum += gbuffer_plane(g, ROLE_EMISSION, c)[i];
  return isfinite(sum) && sum > 0.0 ? sum : 0.0;
}

void policy_far_field(const gbuffer *first, hbil_config *config,
                      const char **reason) {
  const float *depth = gbuffer_plane(first, ROLE_DEPTH, 0);
  const size_t pixels = (size_t)first->planes.width * first->planes.height;
  size_t lit = 0;
  for (size_t i = 0; i < pixels; i++)
    if (is_background(depth[i], config->background) && sky_light(first, i) > 0)
      lit++;
  if ((double)lit > SKY_SEEN * (double)pixels) {
    config->far_field = HBIL_FAR_NONE;
    *reason = "none: a lit sky is seen, and direct light holds what it sends";
  } else {
    config->far_field = HBIL_FAR_FRAME;
    *reason = "what the frame's surfaces send: no lit sky is seen";
  }
}
