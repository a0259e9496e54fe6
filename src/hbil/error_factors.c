/* From the spread of the gathered light to the error of its mean. */
#include "error_factors.h"

#include <math.h>

/*
 * The standard deviation of the light that recompose averages, times this
 * factor, is an error that 95 % of the pixels don't exceed.  These are the
 * factors for two slices; error_factors() scales them for more.  Each is the
 * largest that any of twelve scenes needed with two to four slices, rounded up
 * (doc/method.md, section 19).  single: for E_near with one slice; it differs
 * only at half resolution, where one slice may miss small bright things
 * altogether.
 */
typedef struct factors {
  float ao, near_irradiance, single;
} factors;

static const int step_counts[] = {8, 16, 32, 64, 96, 128};
enum { STEP_COUNTS = sizeof step_counts / sizeof *step_counts };

static const factors endless_full[STEP_COUNTS] = {
    {2.30f, 4.45f, 4.45f}, {1.60f, 2.55f, 2.55f}, {1.05f, 1.70f, 1.70f},
    {0.75f, 1.20f, 1.20f}, {0.65f, 0.85f, 0.85f}, {0.65f, 0.75f, 0.75f}};
static const factors endless_half[STEP_COUNTS] = {
    {3.15f, 6.55f, 38.5f}, {2.25f, 3.00f, 6.95f}, {1.65f, 2.00f, 3.95f},
    {1.40f, 2.00f, 3.75f}, {1.35f, 1.80f, 3.70f}, {1.35f, 1.70f, 3.70f}};
static const factors finite_full[STEP_COUNTS] = {
    {2.60f, 3.00f, 3.00f}, {1.50f, 1.75f, 1.75f}, {1.40f, 1.15f, 1.15f},
    {0.90f, 0.90f, 0.90f}, {0.70f, 0.80f, 0.80f}, {0.65f, 0.70f, 0.70f}};
static const factors finite_half[STEP_COUNTS] = {
    {3.50f, 4.10f, 17.0f}, {1.80f, 2.55f, 3.60f}, {1.65f, 1.80f, 2.15f},
    {1.35f, 1.60f, 1.85f}, {1.25f, 1.60f, 1.75f}, {1.25f, 1.60f, 1.75f}};

/* The logarithm is interpolated linearly between the measured numbers of steps.
 * It is extrapolated down to half of the first one; beyond that, and above the
 * last one, it is constant. */
static float between(float a, float b, float t) {
  return a * powf(b / a, fmaxf(fminf(t, 1.0f), -1.0f));
}

hbil_error_args error_factors(int slices, int steps, bool finite_thickness,
                              bool half_resolution) {
  const factors *f = finite_thickness
                         ? (half_resolution ? finite_half : finite_full)
                         : (half_resolution ? endless_half : endless_full);
  int i = 0;
  while (i + 2 < STEP_COUNTS && step_counts[i + 1] < steps)
    ++i;
  const float from = (float)step_counts[i], to = (float)step_counts[i + 1];
  const float t = logf((float)steps / from) / logf(to / from);
  /* The spread falls with the root of the number of slices, but the error that
   * they all share doesn't. */
  const float more = sqrtf(fmaxf(0.5f * (float)slices, 1.0f));
  const float near_irradiance =
      slices == 1 ? between(f[i].single, f[i + 1].single, t)
                  : between(f[i].near_irradiance, f[i + 1].near_irradiance, t);
  return (hbil_error_args){more * between(f[i].ao, f[i + 1].ao, t),
                           more * near_irradiance};
}
