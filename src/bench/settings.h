/* The settings that the bench measures: a model, and how well it is sampled. */
#ifndef HBIL_BENCH_SETTINGS_H
#define HBIL_BENCH_SETTINGS_H

#include "bench/content.h"
#include "hbil/hbil.h"

/* What a result should be; each model has an exact integral of its own. */
typedef enum bench_model {
  BENCH_MODEL_DEFAULT = 0, /* that of hbil process */
  BENCH_MODEL_PAPER,
  BENCH_MODEL_THIN,  /* the default, with occluders 2 % of their depth thick */
  BENCH_MODEL_THICK, /* the same with 30 % */
  BENCH_MODEL_ENDLESS, /* the same with occluders that never end */
  BENCH_MODEL_GTAO,    /* AO alone */
  BENCH_MODEL_HBAO,    /* AO alone, within a radius */
  BENCH_MODELS
} bench_model;

/* A sum of these is what a setting departs in. */
enum {
  BENCH_SAME_LAYER = 1, /* samples lie in the pixel's own layer */
  BENCH_UNFILTERED = 2,
  BENCH_NOT_EXTRAPOLATED = 4,
  BENCH_FLOAT32 = 8, /* storage of the layers; packed else */
  BENCH_QUICK = 16,  /* also part of the short list */
  BENCH_HALF_RESOLUTION = 32
};

typedef struct bench_setting {
  bench_model model;
  cl_uint slices, steps; /* steps: per side of a slice */
  float growth;          /* hbil_config.step_growth */
  unsigned flags;
  const char *preset;   /* its name, or NULL */
  cl_uint slice_frames; /* hbil_config.sampling's; 0: 1 */
} bench_setting;

enum { BENCH_MAX_SETTINGS = 80, BENCH_LABEL = 80 };

/* All settings, or those of the short list, for pictures as large as the
 * content; returns how many. */
size_t bench_settings(int quick, const bench_content *content,
                      bench_setting out[BENCH_MAX_SETTINGS]);
/* The paper's setting, which times are told as multiples of. */
bench_setting bench_setting_paper(void);
/* The default model with the sampling that is the default for pictures of the
 * content's size. */
bench_setting bench_setting_default(const bench_content *content);
/* The default model with the sampling of a preset. */
bench_setting bench_setting_preset(const bench_content *content,
                                   hbil_quality quality);
int bench_setting_same(const bench_setting *a, const bench_setting *b);

/* "default", "paper", "thin", ... */
const char *bench_model_name(bench_model model);
/* Whether the model computes AO and no light. */
int bench_model_is_ao(bench_model model);
/* "fast 1x16 g3 same-layer": model (unless default), preset, slices x steps,
 * growth and flags; "3x56/3": slices that three frames share. */
void bench_setting_label(const bench_setting *s, char text[BENCH_LABEL]);
/* The content's configuration with a setting. */
void bench_setting_apply(const bench_setting *s, const bench_content *content,
                         hbil_config *config);

#endif
