/* Passes that are multiplied with a pixel's coverage. */
#include "dump/coverage.h"

void coverage_divide(gbuffer *g) {
  static const role multiplied[] = {ROLE_DEPTH, ROLE_NORMAL, ROLE_POSITION,
                                    ROLE_ALBEDO};
  const float *coverage = gbuffer_plane(g, ROLE_COVERAGE, 0);
  if (!coverage || !g->map.how.premultiplied)
    return;
  for (size_t k = 0; k < sizeof multiplied / sizeof *multiplied; k++)
    for (size_t c = 0; c < g->map.count[multiplied[k]]; c++) {
      float *v = gbuffer_plane(g, multiplied[k], c);
      for (size_t i = 0; v && i < gbuffer_pixels(g); i++)
        if (coverage[i] > 0.0f && coverage[i] < 1.0f)
          v[i] /= coverage[i];
    }
}
