/* Adaptive sampling: the numbers of samples to choose from, and what a probe's
 * spread says of the error with each. */
#include "internal.h"

#include <float.h>
#include <math.h>

/*
 * With so many samples a side and two slices, 95 % of the pixels are off by at
 * most so many times the spread that the probe finds in their tile: of AO, and
 * of E_near relative to its mean.  Measured against the exact integral on the
 * procedural room and four public dumps, the worst of which these hold for
 * (HACKING.md, "Adaptive sampling").
 */
static const struct {
  int samples;
  float ao, near_light;
} measured[] = {{8, 0.73f, 1.37f},  {12, 0.47f, 1.09f}, {16, 0.32f, 0.82f},
                {24, 0.20f, 0.62f}, {32, 0.14f, 0.50f}, {48, 0.10f, 0.37f},
                {64, 0.09f, 0.29f}, {96, 0.08f, 0.25f}, {128, 0.07f, 0.22f},
                {192, 0.07f, 0.21f}};
enum { MEASURED = sizeof measured / sizeof *measured };
_Static_assert(MEASURED + 1 == HBIL_MOST_RUNGS, "a rung each, and the most");

/*
 * The same for how much the pixels differ that the filter brings together
 * (hbil_config.error), of the worst scene each.  More slices differ less, by
 * their root, from what they are all off by.
 */
static const float error_ao[] = {1.40f, 1.05f, 0.85f, 0.62f, 0.60f,
                                 0.60f, 0.60f, 0.60f, 0.60f, 0.60f};
static const float error_near[] = {3.20f, 2.20f, 1.90f, 1.50f, 1.45f,
                                   1.25f, 1.20f, 1.05f, 1.00f, 0.90f};
_Static_assert(sizeof error_ao == MEASURED * sizeof *error_ao &&
                   sizeof error_near == sizeof error_ao,
               "one for each number of samples");

bool ladder_on(const hbil_config *config) {
  return !isinf(config->max_error[0]) || !isinf(config->max_error[1]);
}

static void add_rung(ladder *l, int at, int slices, int samples, int levels) {
  l->rung[at].steps = (cl_uint)l->steps;
  l->rung[at].slices = slices;
  l->rung[at].samples = samples;
  l->steps +=
      (size_t)levels * HBIL_LAYERS * 2 * (size_t)slices * (size_t)(samples + 1);
}

ladder ladder_of(const hbil_config *config, int levels) {
  ladder l = {.count = 0};
  const int slices = (int)config->slices, most = (int)config->samples;
  if (ladder_on(config)) {
    for (int i = 0; i < MEASURED && measured[i].samples < most; ++i)
      add_rung(&l, l.count++, slices, measured[i].samples, levels);
    add_rung(&l, HBIL_MOST_RUNGS, HBIL_PROBE_SLICES, HBIL_PROBE_SAMPLES,
             levels);
    add_rung(&l, l.count++, slices, most, levels);
  } else {
    add_rung(&l, 0, slices, most, levels);
  }
  return l;
}

void ladder_limits(const hbil_config *config, ladder *l) {
  for (int i = 0; i < l->count; ++i) {
    /* more than the last can't be had; finite, since kernels are built so */
    const bool last = i + 1 == l->count;
    l->rung[i].ao =
        last ? FLT_MAX : fminf(config->max_error[0] / measured[i].ao, FLT_MAX);
    l->rung[i].near_light =
        last ? FLT_MAX
             : fminf(config->max_error[1] / measured[i].near_light, 1e18f);
  }
}

/* Between the measured numbers of samples the logarithm is a line. */
static float at_samples(const float *factor, int samples) {
  int i = 0;
  while (i + 2 < MEASURED && measured[i + 1].samples < samples)
    ++i;
  const float from = (float)measured[i].samples;
  const float to = (float)measured[i + 1].samples;
  const float t =
      fminf(fmaxf(logf((float)samples / from) / logf(to / from), 0.0f), 1.0f);
  return factor[i] * powf(factor[i + 1] / factor[i], t);
}

hbil_error_args error_factors(const ladder *l) {
  hbil_error_args f = {{0.0f}, {0.0f}};
  const int count = l->count ? l->count : 1;
  for (int i = 0; i < count; ++i) {
    const hbil_rung *r = &l->rung[i];
    const float more = sqrtf(fmaxf(0.5f * (float)r->slices, 1.0f));
    f.ao[i] = more * at_samples(error_ao, r->samples);
    f.near_light[i] = more * at_samples(error_near, r->samples);
  }
  return f;
}
