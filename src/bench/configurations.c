/* What is measured: one table, the presets, and the models. */
#include "bench/bench.h"

#include <math.h>
#include <string.h>

#define FULL HBIL_GRID_FULL_RESOLUTION
#define LAYER HBIL_GRID_SAME_LAYER
#define PACKED HBIL_STORAGE_PACKED
#define FLOAT32 HBIL_STORAGE_FLOAT32
#define HALF HBIL_STORAGE_HALF
#define FLOAT11 HBIL_STORAGE_FLOAT11

/* slices, samples a side, growth of the steps, lattice, raw, quick, model,
 * preset, storage, plain, not adaptive */
static const bench_configuration table[] = {
    /* the paper's setting, and what each departure from it does */
    {2, 8, 0.0f, LAYER, 0, 1, BENCH_PAPER, NULL, PACKED, 1, 0, 0},
    {2, 8, 0.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 8, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 8, 0.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 8, 1.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 8, 2.0f, FULL, 0, 1, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 8, 4.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 8, 2.0f, FULL, 1, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    /* nothing extrapolated */
    {2, 8, 2.0f, FULL, 0, 1, BENCH_PAPER, NULL, PACKED, 1, 0, 0},
    {2, 24, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 1, 0, 0},
    {2, 32, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 1, 0, 0},
    {2, 48, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 1, 0, 0},
    {2, 64, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 1, 0, 0},
    {2, 24, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 40, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 48, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    /* storage: few samples, and the tool's */
    {2, 8, 2.0f, FULL, 0, 1, BENCH_PAPER, NULL, FLOAT32, 0, 0, 0},
    {2, 8, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, HALF, 0, 0, 0},
    {2, 8, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, FLOAT11, 0, 0, 0},
    {2, 48, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, FLOAT32, 0, 0, 0},
    {2, 48, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, HALF, 0, 0, 0},
    {2, 48, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, FLOAT11, 0, 0, 0},
    /* samples */
    {2, 4, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 16, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 32, 2.0f, FULL, 0, 1, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 48, 1.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 64, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 96, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 16, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 24, 1.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 48, 1.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {3, 32, 1.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 32, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 64, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 128, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    /* steps, where there are many */
    {2, 32, 0.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 32, 1.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 32, 4.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 32, 0.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 32, 1.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {2, 32, 4.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    /* slices */
    {1, 4, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 8, 2.0f, FULL, 0, 1, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 16, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 32, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 36, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 64, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 8, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 13, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 14, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 16, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 24, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 32, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 64, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {4, 8, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {4, 16, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {4, 32, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {4, 32, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {4, 64, 2.0f, LAYER, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    /* what else adaptive sampling chooses from */
    {1, 6, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 12, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 24, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    {1, 48, 2.0f, FULL, 0, 0, BENCH_PAPER, NULL, PACKED, 0, 0, 0},
    /* occluders that end */
    {2, 8, 2.0f, FULL, 0, 0, BENCH_THICK_02, NULL, PACKED, 0, 0, 0},
    {2, 32, 2.0f, FULL, 0, 0, BENCH_THICK_02, NULL, PACKED, 0, 0, 0},
    {2, 8, 2.0f, FULL, 0, 1, BENCH_THICK_08, NULL, PACKED, 0, 0, 0},
    {2, 32, 2.0f, FULL, 0, 0, BENCH_THICK_08, NULL, PACKED, 0, 0, 0},
    {2, 8, 2.0f, FULL, 0, 0, BENCH_THICK_30, NULL, PACKED, 0, 0, 0},
    {2, 32, 2.0f, FULL, 0, 0, BENCH_THICK_30, NULL, PACKED, 0, 0, 0},
    /* the tool's model; the last one is its default */
    {2, 8, 2.0f, FULL, 0, 0, BENCH_TOOL, NULL, PACKED, 0, 0, 0},
    {2, 32, 2.0f, FULL, 0, 0, BENCH_TOOL, NULL, PACKED, 0, 0, 0},
    {2, 48, 2.0f, LAYER, 0, 0, BENCH_TOOL, NULL, PACKED, 0, 0, 0},
    {2, 48, 2.0f, FULL, 0, 1, BENCH_TOOL, NULL, PACKED, 0, 0, 0},
    /* AO alone */
    {2, 8, 2.0f, FULL, 0, 1, BENCH_GTAO, NULL, PACKED, 0, 0, 0},
    {2, 8, 2.0f, FULL, 0, 1, BENCH_HBAO, NULL, PACKED, 0, 0, 0},
};

enum { TABLE = sizeof table / sizeof *table };

/* Adaptive sampling, of 2x96 full g2 at most: what 95 % of the pixels may be
 * off by, of AO or of E_near. */
static const struct {
  float ao, light;
  int quick;
} promises[] = {{0.15f, 0, 0}, {0.12f, 0, 0}, {0.1f, 0, 0},  {0.085f, 0, 0},
                {0.07f, 0, 0}, {0.06f, 0, 0}, {0.05f, 0, 1}, {0, 2.0f, 0},
                {0, 1.5f, 0},  {0, 1.0f, 0},  {0, 0.7f, 0},  {0, 0.5f, 1}};

enum { PROMISES = sizeof promises / sizeof *promises };

/* --- the list --- */

static int same_sampling(const bench_configuration *a,
                         const bench_configuration *b) {
  return a->slices == b->slices && a->samples == b->samples &&
         !(a->growth < b->growth) && !(a->growth > b->growth) &&
         a->lattice == b->lattice && a->raw == b->raw &&
         a->storage == b->storage && a->plain == b->plain &&
         !(a->most_ao < b->most_ao) && !(a->most_ao > b->most_ao) &&
         !(a->most_light < b->most_light) && !(a->most_light > b->most_light);
}

static int same(const bench_configuration *a, const bench_configuration *b) {
  return a->model == b->model && same_sampling(a, b);
}

int bench_is_adaptive(const bench_configuration *c) {
  return c->most_ao > 0.0f || c->most_light > 0.0f;
}

int bench_is_uniform_of(const bench_configuration *uniform,
                        const bench_configuration *adaptive) {
  bench_configuration c = *adaptive;
  c.slices = uniform->slices;
  c.samples = uniform->samples;
  c.most_ao = c.most_light = 0.0f;
  return same(&c, uniform);
}

static bench_configuration sampling_of(const hbil_config *config) {
  return (bench_configuration){.slices = config->slices,
                               .samples = config->steps_per_side,
                               .growth = config->step_growth,
                               .lattice = config->sample_grid,
                               .raw = config->unfiltered != 0,
                               .model = BENCH_PAPER,
                               .storage = config->storage,
                               .plain = !config->extrapolate};
}

/* Names the row that is there already, or adds one. */
static size_t add_preset(bench_configuration *list, size_t count,
                         hbil_quality quality, bench_model model) {
  hbil_config config;
  hbil_config_init(&config);
  hbil_config_set_quality(&config, quality);
  bench_configuration c = sampling_of(&config);
  c.preset = hbil_quality_name(quality);
  c.model = model;
  c.quick = model == BENCH_PAPER;
  size_t at = 0;
  while (at < count && !same(&list[at], &c))
    at++;
  list[at] = c;
  return at < count ? count : count + 1;
}

_Static_assert(TABLE + PROMISES + 2 * HBIL_QUALITY_REFERENCE <=
                   BENCH_MAX_CONFIGURATIONS,
               "room for the table and the presets");

static bench_configuration promised(size_t i) {
  return (bench_configuration){.slices = 2,
                               .samples = 96,
                               .growth = 2.0f,
                               .lattice = FULL,
                               .quick = promises[i].quick,
                               .model = BENCH_PAPER,
                               .storage = PACKED,
                               .most_ao = promises[i].ao,
                               .most_light = promises[i].light};
}

size_t bench_configurations(int quick,
                            bench_configuration out[BENCH_MAX_CONFIGURATIONS]) {
  size_t count = TABLE, chosen = 0;
  memcpy(out, table, sizeof table);
  for (int q = 0; q < HBIL_QUALITY_REFERENCE; q++) {
    count = add_preset(out, count, (hbil_quality)q, BENCH_PAPER);
    count = add_preset(out, count, (hbil_quality)q, BENCH_TOOL);
  }
  for (size_t i = 0; i < PROMISES; i++)
    out[count++] = promised(i);
  for (size_t i = 0; i < count; i++)
    if (!quick || out[i].quick)
      out[chosen++] = out[i];
  return chosen;
}

const char *bench_storage_name(const bench_configuration *c) {
  static const char *const names[] = {[PACKED] = "packed",
                                      [FLOAT32] = "fp32",
                                      [HALF] = "half",
                                      [FLOAT11] = "float11"};
  return names[c->storage];
}

int bench_is_of_storage(const bench_configuration *c) {
  bench_configuration plain = *c;
  plain.storage = FLOAT32;
  for (size_t i = 0; i < TABLE; i++)
    if (same(&plain, &table[i]))
      return 1;
  return 0;
}

bench_configuration bench_first(void) {
  return table[0];
}

bench_configuration bench_default(void) {
  hbil_config config;
  hbil_config_init(&config);
  return sampling_of(&config);
}

int bench_is_default(const bench_configuration *c) {
  const bench_configuration standard = bench_default();
  return same(c, &standard);
}

int bench_is_tools_default(const bench_configuration *c) {
  process_options options;
  process_options_init(&options);
  bench_configuration standard = sampling_of(&options.config);
  standard.model = BENCH_TOOL;
  return same(c, &standard);
}

void bench_label(const bench_configuration *c, char *text, size_t size) {
  const char *model = bench_model_name(c->model);
  char most[32] = "";
  if (c->most_ao > 0.0f)
    snprintf(most, sizeof most, " AO<%g", (double)c->most_ao);
  else if (c->most_light > 0.0f)
    snprintf(most, sizeof most, " E<%g", (double)c->most_light);
  snprintf(text, size, "%s%s%s%s%ux%u %s g%g%s%s%s%s%s", model,
           *model ? " " : "", c->preset ? c->preset : "", c->preset ? " " : "",
           (unsigned)c->slices, (unsigned)c->samples,
           c->lattice == FULL ? "full" : "layer", (double)c->growth,
           c->raw ? " raw" : "", c->storage == PACKED ? "" : " ",
           c->storage == PACKED ? "" : bench_storage_name(c),
           c->plain ? " plain" : "", most);
}

/* --- models --- */

const char *bench_model_name(bench_model model) {
  static const char *const names[BENCH_MODELS] = {
      [BENCH_PAPER] = "",
      [BENCH_THICK_02] = "thick .02",
      [BENCH_THICK_08] = "thick .08",
      [BENCH_THICK_30] = "thick .3",
      [BENCH_TOOL] = "tool",
      [BENCH_GTAO] = "gtao",
      [BENCH_HBAO] = "hbao"};
  return names[model];
}

int bench_is_ao_alone(bench_model model) {
  return model == BENCH_GTAO || model == BENCH_HBAO;
}

int bench_is_thick(bench_model model) {
  return model == BENCH_THICK_02 || model == BENCH_THICK_08 ||
         model == BENCH_THICK_30;
}

static void set_model(const bench_content *content, bench_model model,
                      hbil_config *config) {
  if (model == BENCH_THICK_02)
    config->relative_thickness = 0.02f;
  else if (model == BENCH_THICK_08)
    config->relative_thickness = 0.08f;
  else if (model == BENCH_THICK_30)
    config->relative_thickness = 0.3f;
  else if (model == BENCH_GTAO)
    config->mode = HBIL_MODE_GTAO;
  else if (model == BENCH_HBAO) {
    config->mode = HBIL_MODE_HBAO;
    config->radius = content->radius;
  } else if (model == BENCH_TOOL) {
    process_set_model(config);
    config->far_field = content->far;
  }
}

const void *bench_environment(const bench_content *content,
                              hbil_far_field far) {
  return far == content->far ? content->sky : content->environment;
}

void bench_configure(const bench_content *content, const bench_configuration *c,
                     hbil_config *config) {
  *config = content->config;
  set_model(content, c->model, config);
  config->slices = c->slices;
  config->steps_per_side = c->samples;
  config->step_growth = c->growth;
  config->sample_grid = c->lattice;
  config->unfiltered = c->raw ? CL_TRUE : CL_FALSE;
  config->storage = c->storage;
  config->extrapolate = c->plain ? CL_FALSE : CL_TRUE;
  config->max_error[0] = c->most_ao > 0.0f ? c->most_ao : INFINITY;
  config->max_error[1] = c->most_light > 0.0f ? c->most_light : INFINITY;
}
