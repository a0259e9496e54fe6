/* Adaptive sampling: the numbers of samples to choose from, and what a probe's
 * spread says of the error with each. */
#include "internal.h"

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

/* Between the measured numbers of samples the logarithm is a line. */
static float at_samples(const float *factor, int samples) {
  int i = 0;
  while (i + 2 < MEASURED && measured[i + 1].samples < samples)
    ++i;
  const float from = (float)measured[i].samples;
  const float to = (float)measured[i + 1].samples;
  const float t = logf((float)samples / from) / logf(to / from);
  return factor[i] *
         powf(factor[i + 1] / factor[i], fminf(fmaxf(t, 0.0f), 1.0f));
}

static void add_rung(ladder *l, int at, int slices, int samples, int levels) {
  hbil_rung *r = &l->rung[at];
  const float more = sqrtf(fmaxf(0.5f * (float)slices, 1.0f));
  r->steps = (cl_uint)l->steps;
  r->slices = slices;
  r->samples = samples;
  r->error_ao = more * at_samples(error_ao, samples);
  r->error_near = more * at_samples(error_near, samples);
  l->steps +=
      (size_t)levels * HBIL_LAYERS * 2 * (size_t)slices * (size_t)(samples + 1);
}

/* A million of spreads is as good as any number, and finite, as kernels are
 * built to expect. */
static void limit(hbil_rung *r, const float most[2], int measurement) {
  r->ao = fminf(most[0] / measured[measurement].ao, 1e6f);
  r->near_light = fminf(most[1] / measured[measurement].near_light, 1e6f);
}

ladder ladder_of(const hbil_config *config, int levels) {
  ladder l = {.count = 0};
  const int slices = (int)config->slices, most = (int)config->samples;
  if (!ladder_on(config)) {
    add_rung(&l, 0, slices, most, levels);
    return l;
  }
  for (int i = 0; i < MEASURED && measured[i].samples < most; ++i) {
    add_rung(&l, l.count, slices, measured[i].samples, levels);
    limit(&l.rung[l.count++], config->max_error, i);
  }
  add_rung(&l, l.count++, slices, most, levels);
  add_rung(&l, HBIL_MOST_RUNGS, HBIL_PROBE_SLICES, HBIL_PROBE_SAMPLES, levels);
  return l;
}
