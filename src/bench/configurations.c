/* What is measured: one table. */
#include "bench/bench.h"

#include <string.h>

#define FULL HBIL_LATTICE_FULL
#define LAYER HBIL_LATTICE_LAYER

/* slices, samples a side, growth of the steps, lattice, raw, quick */
static const bench_configuration table[] = {
    /* the paper's setting, and what each departure from it does */
    {2, 8, 0.0f, LAYER, 0, 1},
    {2, 8, 2.0f, LAYER, 0, 0},
    {2, 8, 0.0f, FULL, 0, 1},
    {2, 8, 1.0f, FULL, 0, 0},
    {2, 8, 2.0f, FULL, 0, 1},
    {2, 8, 4.0f, FULL, 0, 0},
    {2, 8, 2.0f, FULL, 1, 1},
    /* samples */
    {2, 4, 2.0f, FULL, 0, 1},
    {2, 16, 2.0f, FULL, 0, 0},
    {2, 32, 2.0f, FULL, 0, 1},
    {2, 64, 2.0f, FULL, 0, 0},
    {2, 16, 2.0f, LAYER, 0, 0},
    {2, 32, 2.0f, LAYER, 0, 0},
    {2, 64, 2.0f, LAYER, 0, 0},
    /* steps, where there are many */
    {2, 32, 0.0f, FULL, 0, 0},
    {2, 32, 1.0f, FULL, 0, 0},
    {2, 32, 4.0f, FULL, 0, 0},
    /* slices */
    {1, 4, 2.0f, FULL, 0, 0},
    {1, 8, 2.0f, FULL, 0, 1},
    {1, 16, 2.0f, FULL, 0, 0},
    {1, 32, 2.0f, FULL, 0, 0},
    {1, 64, 2.0f, FULL, 0, 0},
    {4, 8, 2.0f, FULL, 0, 1},
    {4, 16, 2.0f, FULL, 0, 0},
    {4, 32, 2.0f, FULL, 0, 0},
    {8, 8, 2.0f, FULL, 0, 0},
    {8, 64, 2.0f, FULL, 0, 0},
};

enum { ALL = sizeof table / sizeof *table };

size_t bench_configurations(int quick, const bench_configuration **out) {
  static bench_configuration chosen[ALL];
  size_t count = 0;
  for (size_t i = 0; i < ALL; i++)
    if (!quick || table[i].quick)
      chosen[count++] = table[i];
  *out = chosen;
  return count;
}

bench_configuration bench_reference(void) {
  return (bench_configuration){32, 256, 0.0f, FULL, 0, 0};
}

static int same(const bench_configuration *a, const bench_configuration *b) {
  return a->slices == b->slices && a->samples == b->samples &&
         !(a->growth < b->growth) && !(a->growth > b->growth) &&
         a->lattice == b->lattice && a->raw == b->raw;
}

int bench_is_start(const bench_configuration *c) {
  return same(c, &table[0]);
}

int bench_is_default(const bench_configuration *c) {
  hbil_config config;
  hbil_config_init(&config);
  const bench_configuration standard = {config.slices,
                                        config.samples,
                                        config.step_growth,
                                        config.lattice,
                                        config.raw_interleave != 0,
                                        0};
  return same(c, &standard);
}

void bench_configure(const bench_configuration *c, hbil_config *config) {
  config->slices = c->slices;
  config->samples = c->samples;
  config->step_growth = c->growth;
  config->lattice = c->lattice;
  config->raw_interleave = c->raw ? CL_TRUE : CL_FALSE;
}

void bench_label(const bench_configuration *c, char *text, size_t size) {
  snprintf(text, size, "%ux%u %s g%g%s", (unsigned)c->slices,
           (unsigned)c->samples, c->lattice == FULL ? "full" : "layer",
           (double)c->growth, c->raw ? " raw" : "");
}
