/*
 * Gather with the kernels' samples: for each pixel the settings' number of
 * slices, in directions that differ between the 16 pixels of a 4x4 block, and
 * steps_per_side samples on each half-slice.
 */
#include "exact/hemisphere.h"
#include "exact/passes.h"
#include "exact/planes.h"
#include "exact/samples.h"
#include "exact/settings.h"
#include "exact/threads.h"

typedef struct gather {
  const exact_frame *frame;
  const exact_planes *split;
  exact_planes *gathered;
} gather;

static march march_along(const receiver *r, const sampling *how, double ux,
                         double uy) {
  march m = exact_march_begin(r, ux, uy);
  exact_visit_samples(r, how, &m);
  exact_march_end(&m);
  return m;
}

static void gather_pixel(const gather *g, int x, int y) {
  const hbil_config *config = g->frame->config;
  const coverage_kind kind = exact_coverage_kind(config, COVERAGE_SECTORS);
  hemisphere sum = {0};
  if (!exact_is_gathered(config, x, y)) {
    exact_planes_clear(g->gathered, x, y);
    return;
  }
  const receiver r = exact_receiver(g->frame, g->split, x, y, kind, NULL);
  if (!r.s.is) {
    exact_store_sky(&r, g->gathered);
    return;
  }
  const sampling how = exact_sampling(&r);
  for (int slice = 0; slice < how.pattern.slices; ++slice) {
    double ux, uy;
    exact_slice_direction(&how, slice, &ux, &uy);
    const march ahead = march_along(&r, &how, ux, uy);
    const march behind = march_along(&r, &how, -ux, -uy);
    exact_add_slice(&sum, config, &ahead, &behind);
  }
  exact_store_gathered(&r, &sum, how.pattern.slices, g->gathered);
}

static void gather_row(void *user, int y, void *scratch) {
  const gather *g = user;
  (void)scratch;
  for (int x = 0; x < g->split->width; ++x)
    gather_pixel(g, x, y);
}

exact_status exact_gather(const exact_frame *frame, const exact_planes *split,
                          exact_planes *gathered) {
  const hbil_config *config = frame->config;
  gather g = {frame, split, gathered};
  const exact_rows rows = {
      .run = gather_row, .user = &g, .height = split->height};
  if (!exact_planes_fit(split, config->width, config->height,
                        HBIL_SPLIT_PLANES) ||
      !exact_planes_fit(gathered, config->width, config->height,
                        HBIL_LIGHT_PLANES))
    return EXACT_BAD_ARGUMENT;
  return exact_run_rows(&rows);
}
