/* The settings that the bench measures: one table, and the presets. */
#include "bench/settings.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define DEFAULT BENCH_MODEL_DEFAULT
#define PAPER BENCH_MODEL_PAPER
#define THIN BENCH_MODEL_THIN
#define THICK BENCH_MODEL_THICK
#define ENDLESS BENCH_MODEL_ENDLESS
#define GTAO BENCH_MODEL_GTAO
#define HBAO BENCH_MODEL_HBAO
#define LAYER BENCH_SAME_LAYER
#define RAW BENCH_UNFILTERED
#define PLAIN BENCH_NOT_EXTRAPOLATED
#define FP32 BENCH_FLOAT32
#define QUICK BENCH_QUICK
#define HALF BENCH_HALF_RESOLUTION

/* The same setting with several numbers of steps, up to the first 0. */
typedef struct sweep {
  bench_model model;
  cl_uint slices;
  float growth;
  unsigned flags;
  cl_uint steps[6];
} sweep;

static const sweep sweeps[] = {
    /* the paper's own setting, which comes first */
    {PAPER, 2, 0, LAYER | QUICK, {8}},
    {PAPER, 2, 3, 0, {8, 32}},
    /* its model at half resolution */
    {PAPER, 1, 3, HALF, {20}},
    {PAPER, 2, 3, HALF, {48}},
    {PAPER, 3, 3, HALF, {56}},
    {PAPER, 4, 3, HALF, {96}},
    /* steps, with one to four slices */
    {DEFAULT, 1, 3, QUICK, {8, 32}},
    {DEFAULT, 1, 3, 0, {4, 16, 64}},
    {DEFAULT, 2, 3, QUICK, {8, 32}},
    {DEFAULT, 2, 3, 0, {16, 48, 96}},
    {DEFAULT, 3, 3, 0, {48}},
    {DEFAULT, 4, 3, 0, {32}},
    /* half resolution */
    {DEFAULT, 1, 3, HALF, {8, 16, 20, 32, 64}},
    {DEFAULT, 2, 3, HALF, {16, 24, 48, 64, 96}},
    {DEFAULT, 3, 3, HALF, {32, 56, 96}},
    {DEFAULT, 4, 3, HALF, {32, 64, 96, 128}},
    /* samples in the pixel's own layer; how the steps grow */
    {DEFAULT, 2, 3, LAYER, {32}},
    {DEFAULT, 2, 0, 0, {32}},
    {DEFAULT, 2, 2, 0, {32}},
    {DEFAULT, 2, 5, 0, {32}},
    {DEFAULT, 3, 2, HALF, {56}},
    {DEFAULT, 3, 4, HALF, {56}},
    /* without the filter, without extrapolation, with fp32 layers */
    {DEFAULT, 2, 3, RAW, {8}},
    {DEFAULT, 2, 3, PLAIN, {8, 32}},
    {DEFAULT, 2, 3, FP32 | QUICK, {8}},
    {DEFAULT, 2, 3, FP32, {48}},
    /* thickness, and AO alone */
    {THIN, 2, 3, 0, {8, 32}},
    {THICK, 2, 3, 0, {8, 32}},
    {ENDLESS, 2, 3, QUICK, {8}},
    {ENDLESS, 2, 3, 0, {32}},
    {ENDLESS, 2, 3, HALF, {48}},
    {ENDLESS, 3, 3, HALF, {64}},
    {ENDLESS, 4, 3, HALF, {96}},
    {GTAO, 2, 3, QUICK, {8}},
    {HBAO, 2, 3, QUICK, {8}},
};

enum {
  SWEEPS = sizeof sweeps / sizeof *sweeps,
  STEPS = sizeof sweeps->steps / sizeof *sweeps->steps
};

static bench_setting setting_at(const sweep *s, size_t step) {
  return (bench_setting){.model = s->model,
                         .slices = s->slices,
                         .steps = s->steps[step],
                         .growth = s->growth,
                         .flags = s->flags};
}

static cl_uint frames_of(const bench_setting *s) {
  return s->slice_frames ? s->slice_frames : 1;
}

int bench_setting_same(const bench_setting *a, const bench_setting *b) {
  const unsigned known = ~(unsigned)QUICK;
  return a->model == b->model && a->slices == b->slices &&
         a->steps == b->steps && frames_of(a) == frames_of(b) &&
         !(a->growth < b->growth) && !(a->growth > b->growth) &&
         (a->flags & known) == (b->flags & known);
}

/* The sampling of a configuration whose width and height are set, in the
 * default model. */
static bench_setting setting_of(const hbil_config *config) {
  return (bench_setting){
      .model = DEFAULT,
      .slices = config->sampling.slices,
      .slice_frames = hbil_config_slice_frames(config),
      .steps = config->sampling.steps_per_side,
      .growth = config->sampling.step_growth,
      .flags =
          (config->sampling.sample_grid == HBIL_GRID_SAME_LAYER ? LAYER : 0u) |
          (config->sampling.unfiltered ? RAW : 0u) |
          (hbil_config_resolution(config) == HBIL_RESOLUTION_HALF ? HALF : 0u) |
          (config->model.extrapolate ? 0u : PLAIN) |
          (config->sampling.storage == HBIL_STORAGE_FLOAT32 ? (unsigned)FP32
                                                            : 0u)};
}

bench_setting bench_setting_paper(void) {
  return setting_at(&sweeps[0], 0);
}

/* The defaults, with the content's size. */
static hbil_config default_config(const bench_content *content) {
  hbil_config config;
  hbil_config_init(&config);
  config.width = content->width;
  config.height = content->height;
  return config;
}

bench_setting bench_setting_default(const bench_content *content) {
  const hbil_config config = default_config(content);
  return setting_of(&config);
}

bench_setting bench_setting_preset(const bench_content *content,
                                   hbil_quality quality) {
  hbil_config config = default_config(content);
  hbil_sampling_set(&config.sampling, quality);
  bench_setting s = setting_of(&config);
  s.preset = hbil_quality_name(quality);
  return s;
}

/* Takes the place of a setting that is the same, or becomes a new one. */
static size_t add(bench_setting *list, size_t count, const bench_setting *s) {
  size_t at = 0;
  while (at < count && !bench_setting_same(&list[at], s))
    at++;
  if (at < BENCH_MAX_SETTINGS)
    list[at] = *s;
  return at < count || count == BENCH_MAX_SETTINGS ? count : count + 1;
}

size_t bench_settings(int quick, const bench_content *content,
                      bench_setting out[BENCH_MAX_SETTINGS]) {
  bench_setting s;
  size_t count = 0, chosen = 0;
  for (size_t i = 0; i < SWEEPS; i++)
    for (size_t k = 0; k < STEPS && sweeps[i].steps[k]; k++) {
      s = setting_at(&sweeps[i], k);
      count = add(out, count, &s);
    }
  s = bench_setting_default(content);
  s.flags |= QUICK;
  count = add(out, count, &s);
  for (int q = 0; q < HBIL_QUALITY_REFERENCE; q++) {
    s = bench_setting_preset(content, (hbil_quality)q);
    s.flags |= QUICK;
    count = add(out, count, &s);
  }
  for (size_t i = 0; i < count; i++)
    if (!quick || out[i].flags & QUICK)
      out[chosen++] = out[i];
  return chosen;
}

/* --- names --- */

const char *bench_model_name(bench_model model) {
  static const char *const names[BENCH_MODELS] = {
      [DEFAULT] = "default", [PAPER] = "paper",     [THIN] = "thin",
      [THICK] = "thick",     [ENDLESS] = "endless", [GTAO] = "gtao",
      [HBAO] = "hbao"};
  return names[model];
}

int bench_model_is_ao(bench_model model) {
  return model == GTAO || model == HBAO;
}

void bench_setting_label(const bench_setting *s, char text[BENCH_LABEL]) {
  char frames[16] = "";
  if (s->slice_frames > 1)
    snprintf(frames, sizeof frames, "/%u", (unsigned)s->slice_frames);
  snprintf(text, BENCH_LABEL, "%s%s%s%s%ux%u%s g%g%s%s%s%s%s",
           s->model == DEFAULT ? "" : bench_model_name(s->model),
           s->model == DEFAULT ? "" : " ", s->preset ? s->preset : "",
           s->preset ? " " : "", (unsigned)s->slices, (unsigned)s->steps,
           frames, (double)s->growth, s->flags & LAYER ? " same-layer" : "",
           s->flags & HALF ? " half" : "", s->flags & RAW ? " unfiltered" : "",
           s->flags & PLAIN ? " not extrapolated" : "",
           s->flags & FP32 ? " fp32" : "");
}

/* --- configurations --- */

static void set_model(bench_model name, const bench_content *content,
                      hbil_model *model) {
  hbil_model_set(model, name == PAPER ? HBIL_MODEL_PAPER : HBIL_MODEL_DEFAULT);
  model->mode = HBIL_MODE_HBIL;
  model->radius = name == HBAO ? content->radius : INFINITY;
  if (name != DEFAULT)
    model->relative_thickness = name == THIN    ? 0.02f
                                : name == THICK ? 0.3f
                                                : INFINITY;
  if (name == PAPER)
    model->far_field = HBIL_FAR_NONE;
  if (bench_model_is_ao(name)) {
    model->mode = name == GTAO ? HBIL_MODE_GTAO : HBIL_MODE_HBAO;
    model->back_facing_fallback = HBIL_FALLBACK_BLACK;
    model->far_field = HBIL_FAR_NONE;
  }
}

void bench_setting_apply(const bench_setting *s, const bench_content *content,
                         hbil_config *config) {
  *config = content->config;
  set_model(s->model, content, &config->model);
  config->sampling.slices = s->slices;
  config->sampling.slice_frames = frames_of(s);
  config->sampling.steps_per_side = s->steps;
  config->sampling.step_growth = s->growth;
  config->sampling.sample_grid =
      s->flags & LAYER ? HBIL_GRID_SAME_LAYER : HBIL_GRID_FULL_RESOLUTION;
  config->sampling.resolution =
      s->flags & HALF ? HBIL_RESOLUTION_HALF : HBIL_RESOLUTION_FULL;
  config->sampling.unfiltered = s->flags & RAW ? CL_TRUE : CL_FALSE;
  config->model.extrapolate = s->flags & PLAIN ? CL_FALSE : CL_TRUE;
  config->sampling.storage =
      s->flags & FP32 ? HBIL_STORAGE_FLOAT32 : HBIL_STORAGE_PACKED;
}
