/* How much of a job's light is a guess. */
#include "tool/unknown.h"

#include "dump/surface_points.h"

#include <stdio.h>

/* Above this share there is a warning: more of the light is then guessed than
 * known, so the picture follows the guess more than the frame. */
#define MOST_UNKNOWN 0.5

void unknown_measure(const job *j, const gbuffer *g, const float *share,
                     timing_row *row) {
  const surface_points points = surface_points_of(g, &g->map.camera);
  const float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  const size_t left = (size_t)(j->shown.x - j->window.x);
  const size_t top = (size_t)(j->shown.y - j->window.y);
  double sum = 0.0;
  size_t surfaces = 0;
  for (size_t y = 0; share && y < j->shown.height; y++)
    for (size_t x = 0; x < j->shown.width; x++) {
      const size_t i = (top + y) * j->width + left + x;
      if (!surface_is_shown(&points, depth[i]))
        continue;
      sum += (double)share[i];
      surfaces++;
    }
  row->surfaces = surfaces;
  row->unknown = surfaces ? sum / (double)surfaces : 0.0;
}

double unknown_mean(const timing_row *rows, size_t count, size_t *surfaces) {
  double sum = 0.0;
  *surfaces = 0;
  for (size_t i = 0; i < count; i++) {
    sum += rows[i].unknown * (double)rows[i].surfaces;
    *surfaces += rows[i].surfaces;
  }
  return *surfaces ? sum / (double)*surfaces : 0.0;
}

/* Whether frames could learn from later ones of their place. */
static int could_learn(const job *whole) {
  const process_settings *s = whole->settings;
  return whole->count > whole->place_count && !s->learn && !s->cache_fixed &&
         !s->decide_by;
}

void unknown_report(const job *whole, int has_cache, const timing_row *rows,
                    size_t count) {
  size_t surfaces;
  const double mean = unknown_mean(rows, count, &surfaces);
  if (!surfaces)
    return;
  fprintf(stderr,
          "hbil: unknown: the light of %.1f %% of what surfaces see is "
          "a guess\n",
          100.0 * mean);
  if (mean > MOST_UNKNOWN)
    fprintf(stderr,
            "hbil: warning: most of the indirect light is a guess, because the "
            "frame doesn't show what surrounds it; what helps: --view with "
            "other pictures of the place, %sor --environment with the light "
            "that is there\n",
            has_cache && could_learn(whole)
                ? "--learn if later frames show more of it, "
                : "");
}
