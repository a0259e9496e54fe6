/* From the spread of the gathered light to the error of its mean. */
#include "error_factors.h"

#include <math.h>

/*
 * The standard deviation of the light that recompose averages, times this
 * factor, is an error that 95 % of the pixels don't exceed.  The factors were
 * measured with two slices; for each number of steps, the worst of five scenes
 * was taken (doc/method.md, section 19).
 */
static const struct {
  int steps;
  float ao, near_irradiance;
} measured[] = {{8, 1.40f, 3.20f},  {12, 1.05f, 2.20f}, {16, 0.85f, 1.90f},
                {24, 0.62f, 1.50f}, {32, 0.60f, 1.45f}, {48, 0.60f, 1.25f},
                {64, 0.60f, 1.20f}, {96, 0.60f, 1.05f}, {128, 0.60f, 1.00f},
                {192, 0.60f, 0.90f}};
enum { MEASURED = sizeof measured / sizeof *measured };

/* The logarithm is interpolated linearly between the measured numbers of steps,
 * and extrapolated below the first one; above the last one it is constant. */
static float between(float a, float b, float t) {
  return a * powf(b / a, fminf(t, 1.0f));
}

hbil_error_args error_factors(int slices, int steps) {
  int i = 0;
  while (i + 2 < MEASURED && measured[i + 1].steps < steps)
    ++i;
  const float from = (float)measured[i].steps;
  const float to = (float)measured[i + 1].steps;
  const float t = logf((float)steps / from) / logf(to / from);
  /* The spread falls with the root of the number of slices, but the error that
   * they all share doesn't. */
  const float more = sqrtf(fmaxf(0.5f * (float)slices, 1.0f));
  const hbil_error_args factors = {
      more * between(measured[i].ao, measured[i + 1].ao, t),
      more * between(measured[i].near_irradiance,
                     measured[i + 1].near_irradiance, t)};
  return factors;
}
