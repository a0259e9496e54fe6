/*
 * Push/pull (Kraus 2009): fills the holes of CARRIED with a smooth continuation
 * of the light around them.
 *
 * Push: a texel of the next coarser level is the weighted mean of its four
 * children, and its weight is a quarter of the sum of theirs:
 *   L = sum w_i L_i / sum w_i,   w = sum w_i / 4.
 * Pull: on the way back, a texel of weight 0 takes the value of the coarser
 * level, interpolated bilinearly.  A child lies a quarter of a coarse texel off
 * its parent's centre, so along each axis the parent counts 3/4 and the nearest
 * neighbour on the child's side 1/4.  Texels that have a weight never change.
 * Sky has the weight -1: it gives no light and takes none.
 */
#include <math.h>

#include "exact/passes.h"
#include "exact/planes.h"

static void push_texel(const exact_planes *fine, exact_planes *coarse, int x,
                       int y) {
  double sum[4] = {0.0, 0.0, 0.0, 0.0};
  for (int child = 0; child < 4; ++child) {
    const int cx = 2 * x + (child & 1), cy = 2 * y + (child >> 1);
    if (cx >= fine->width || cy >= fine->height)
      continue;
    const double w = fmax(*exact_at(fine, HBIL_CARRIED_WEIGHT, cx, cy), 0.0);
    for (int c = 0; c < 3; ++c)
      sum[c] += w * *exact_at(fine, c, cx, cy);
    sum[3] += w;
  }
  for (int c = 0; c < 3; ++c)
    *exact_at(coarse, c, x, y) = sum[3] > 0.0 ? sum[c] / sum[3] : 0.0;
  *exact_at(coarse, HBIL_CARRIED_WEIGHT, x, y) = sum[3] / 4.0;
}

static exact_status push(const exact_planes *fine, exact_planes *coarse) {
  const exact_status status =
      exact_planes_create(coarse, (fine->width + 1) / 2, (fine->height + 1) / 2,
                          HBIL_CARRIED_PLANES);
  for (int y = 0; y < coarse->height; ++y)
    for (int x = 0; x < coarse->width; ++x)
      push_texel(fine, coarse, x, y);
  return status;
}

/* Along one axis, the parent's index or (neighbour) that of the texel beside
 * it, no farther than the border. */
static int coarse_index(int fine, bool neighbour, int size) {
  const int index = fine / 2 + (neighbour ? (fine & 1 ? 1 : -1) : 0);
  return index < 0 ? 0 : index >= size ? size - 1 : index;
}

static double interpolate(const exact_planes *coarse, int plane, int x, int y) {
  double sum = 0.0;
  for (int tap = 0; tap < 4; ++tap) {
    const int cx = coarse_index(x, tap & 1, coarse->width);
    const int cy = coarse_index(y, tap >> 1, coarse->height);
    const double share = (tap & 1 ? 0.25 : 0.75) * (tap >> 1 ? 0.25 : 0.75);
    sum += share * *exact_at(coarse, plane, cx, cy);
  }
  return sum;
}

static void pull(const exact_planes *coarse, exact_planes *fine) {
  for (int y = 0; y < fine->height; ++y)
    for (int x = 0; x < fine->width; ++x)
      if (*exact_at(fine, HBIL_CARRIED_WEIGHT, x, y) == 0.0)
        for (int p = 0; p < HBIL_CARRIED_PLANES; ++p)
          *exact_at(fine, p, x, y) = interpolate(coarse, p, x, y);
}

exact_status exact_push_pull(exact_planes *carried) {
  exact_planes coarse;
  if (!carried->values || carried->count < HBIL_CARRIED_PLANES)
    return EXACT_BAD_ARGUMENT;
  if (carried->width == 1 && carried->height == 1)
    return EXACT_SUCCESS;
  exact_status status = push(carried, &coarse);
  if (status == EXACT_SUCCESS)
    status = exact_push_pull(&coarse);
  if (status == EXACT_SUCCESS)
    pull(&coarse, carried);
  exact_planes_free(&coarse);
  return status;
}
