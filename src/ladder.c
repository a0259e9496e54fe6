/* Adaptive sampling: the numbers of samples to choose from, and what they are
 * held against. */
#include "internal.h"

#include <math.h>

/*
 * From the fewest to the most, in the order of the time they take: one slice as
 * long as more samples help more than another one would (HACKING.md, "Adaptive
 * sampling").
 */
static const struct {
  int slices, samples;
} choices[] = {{1, 4},  {1, 6},  {1, 8},  {1, 12}, {1, 16}, {1, 24},  {1, 32},
               {1, 48}, {2, 32}, {2, 48}, {2, 64}, {2, 96}, {2, 128}, {2, 192}};
enum { CHOICES = sizeof choices / sizeof *choices };
_Static_assert(CHOICES + 1 <= HBIL_MOST_RUNGS, "a rung each, and the most");

/* The ruler.  For such limits fewer samples will do where occluders don't end
 * and no light is refused for black, which leaves E_near darker and its errors
 * a larger share (HACKING.md, "Adaptive sampling", has what fewer leave). */
enum { RULER_SLICES = 2, RULER_SAMPLES = 96 };
static const struct {
  float ao, near_irradiance;
  int samples;
} lax[] = {{0.12f, INFINITY, 24}, {0.1f, INFINITY, 32}, {0.06f, 1.5f, 64}};

/*
 * What a pixel is off by, of what the filtered pixels that are judged are off
 * from the ruler: that times a factor.  Rungs of more than one slice look along
 * the ruler's own directions and share its error: that comes on top.  Measured:
 * the least with which all of five scenes keep all limits (HACKING.md,
 * "Adaptive sampling").
 */
static const struct {
  float ao, near_irradiance;
} factor[] = {{1.15f, 1.2f}, {1.1f, 1.35f}}; /* occluders without end, with */
static const float shared_ao = 0.04f, shared_near = 0.12f; /* over the mean */

/*
 * How much the pixels differ that the filter brings together, times this, is an
 * error that 95 % of the pixels don't exceed (hbil_config.error): with so many
 * samples, of the worst scene each.  More slices differ less, by their root,
 * from what they are all off by.
 */
static const struct {
  int samples;
  float ao, near_irradiance;
} measured[] = {{8, 1.40f, 3.20f},  {12, 1.05f, 2.20f}, {16, 0.85f, 1.90f},
                {24, 0.62f, 1.50f}, {32, 0.60f, 1.45f}, {48, 0.60f, 1.25f},
                {64, 0.60f, 1.20f}, {96, 0.60f, 1.05f}, {128, 0.60f, 1.00f},
                {192, 0.60f, 0.90f}};
enum { MEASURED = sizeof measured / sizeof *measured };

bool ladder_on(const hbil_config *config) {
  return !isinf(config->max_error[0]) || !isinf(config->max_error[1]);
}

/* Between the measured numbers of samples, and before the first, the logarithm
 * is a line. */
static float between(float a, float b, float t) {
  return a * powf(b / a, fminf(t, 1.0f));
}

static void add_rung(ladder *l, int at, int slices, int samples, int levels) {
  hbil_rung *r = &l->rung[at];
  int i = 0;
  while (i + 2 < MEASURED && measured[i + 1].samples < samples)
    ++i;
  const float from = (float)measured[i].samples;
  const float to = (float)measured[i + 1].samples;
  const float t = logf((float)samples / from) / logf(to / from);
  const float more = sqrtf(fmaxf(0.5f * (float)slices, 1.0f));
  r->steps = (cl_uint)l->steps;
  r->slices = slices;
  r->samples = samples;
  r->error_ao = more * between(measured[i].ao, measured[i + 1].ao, t);
  r->error_near = more * between(measured[i].near_irradiance,
                                 measured[i + 1].near_irradiance, t);
  l->steps +=
      (size_t)levels * HBIL_LAYERS * 2 * (size_t)slices * (size_t)(samples + 1);
}

/* A million is as good as any number, and finite, as kernels are built to
 * expect. */
static hbil_limit_args limit(const hbil_config *config, int slices) {
  const float *const most = config->max_error;
  const float ao = slices > 1 ? shared_ao : 0.0f;
  const float light = slices > 1 ? shared_near : 0.0f;
  const bool end = config_ends(config);
  const hbil_limit_args l = {
      fminf(sqrtf(fmaxf(most[0] * most[0] - ao * ao, 0.0f)) / factor[end].ao,
            1e6f),
      fminf(fmaxf(most[1] - light, 0.0f) / factor[end].near_irradiance, 1e6f)};
  return l;
}

static bool may_be_lax(const hbil_config *config) {
  const bool limits_light = !isinf(config->max_error[1]);
  return !config_ends(config) &&
         !(limits_light && config_refuses(config) &&
           config->back_facing_fallback == HBIL_FALLBACK_BLACK);
}

static int ruler_samples(const hbil_config *config) {
  if (may_be_lax(config))
    for (size_t i = 0; i < sizeof lax / sizeof *lax; ++i)
      if (config->max_error[0] >= lax[i].ao &&
          config->max_error[1] >= lax[i].near_irradiance)
        return lax[i].samples;
  return (int)config->steps_per_side > RULER_SAMPLES
             ? (int)config->steps_per_side
             : RULER_SAMPLES;
}

ladder ladder_of(const hbil_config *config, int levels) {
  ladder l = {.count = 0};
  const int slices = (int)config->slices, most = (int)config->steps_per_side;
  if (!ladder_on(config)) {
    add_rung(&l, 0, slices, most, levels);
    return l;
  }
  int before = 0;
  for (int i = 0; i < CHOICES; ++i) {
    const int own = choices[i].slices < slices ? choices[i].slices : slices;
    const int all = own * choices[i].samples;
    if (choices[i].samples > most || all <= before || all >= slices * most)
      continue;
    add_rung(&l, l.count++, own, choices[i].samples, levels);
    before = all;
  }
  add_rung(&l, l.count++, slices, most, levels);
  for (int i = 0; i < l.count; ++i)
    l.limit[i] = limit(config, l.rung[i].slices);
  add_rung(&l, LADDER_RULER, slices > RULER_SLICES ? slices : RULER_SLICES,
           ruler_samples(config), levels);
  return l;
}
