/* The settings of a job: what `hbil process` is asked to do. */
#ifndef HBIL_TOOL_SETTINGS_H
#define HBIL_TOOL_SETTINGS_H

#include "dump/source.h"
#include "hbil/hbil.h"

/* ------------------------------------------------------------------------ */
/* Models: named sets of what is computed                                    */

/* The words of --model, in the order of the enum; ends with NULL. */
extern const char *const model_words[];

/* hbil_model_set(), and the sampling that goes with the model: slices, steps
 * and resolution.
 * The far field is not part of it: the paper has none, the default chooses one
 * by the first frame. */
void model_set(hbil_config *config, hbil_model_name model);

/* How often a first frame is run once more before its result is taken. */
unsigned model_warm_up(hbil_model_name model);

/* ------------------------------------------------------------------------ */
/* Settings                                                                  */

/* `--far environment` and `--far none`: frames have no radiance cache.  With
 * the second, process_settings.environment is "none". */
typedef enum far_without_cache {
  FAR_IS_ENVIRONMENT = HBIL_CACHE_METHOD_RSM + 1,
  FAR_IS_NONE
} far_without_cache;

/* How layers are stored; in the order of the option's words. */
typedef enum layer_precision {
  PRECISION_OF_FRAME = 0, /* halves if the colours of the first frame are */
  PRECISION_HALF,
  PRECISION_FLOAT
} layer_precision;

/* What the layer beauty is; in the order of the option's words. */
typedef enum beauty_kind {
  BEAUTY_OF_FRAME = 0, /* BEAUTY_REPLACE where the frames can */
  BEAUTY_REPLACE,      /* the frame's picture with other indirect light */
  BEAUTY_DIFFUSE       /* diffuse light and emission */
} beauty_kind;

typedef struct process_settings {
  source_options source;   /* how frames are read */
  const char *output;      /* folder of the results; must be given */
  const char *camera;      /* camera of all frames; NULL: each has its own */
  const char *environment; /* "R,G,B", "none", "frame", an image file, or NULL:
                              chosen by the first frame */
  const char *device;      /* see device_open() */
  float crop[4];           /* x, y, width and height of what is written, in
                              pixels of the picture; width 0: all of it */
  const char *cuts;        /* frames that begin another place, "none", or
                              NULL: found */
  const char *contact_sheet; /* a PNG of frames and layers, or NULL */
  unsigned layers;           /* a set (layers.h); 0: all that the mode has */
  int paper;                 /* 1: the model is that of the paper */
  /* the radiance cache */
  char *const *views; /* files that it sees first */
  unsigned view_count;
  char *const *light_views; /* files of reflective shadow maps */
  unsigned light_view_count;
  hbil_view_light view_light; /* what the views hold */
  int far;                /* hbil_cache_method, or a far_without_cache; 0: not
                             given */
  int learn;              /* 1: it sees all frames first */
  unsigned cache_voxels;  /* across a level; 0: the library's default */
  const char *cache_load; /* the file that it begins with, or NULL */
  int cache_fixed;        /* 1: frames don't change the loaded cache */
  const char *cache_save; /* the file that it is written to, or NULL */
  int radius_given, thickness_given; /* 1: so are model.radius and
                                        model.relative_thickness */
  int emission_given;    /* 1: config.gather_emission is the user's choice */
  int is_part;           /* 1: --frames picks the frames from a sequence */
  unsigned pre_roll;     /* frames at the beginning that are lit, not written */
  const char *decide_by; /* the frame that decides what is left open; NULL: the
                            first one */
  unsigned repeat;       /* runs of every frame, at least 1 */
  unsigned warm_up;      /* additional runs of the first frame */
  int preview, timings, json, quiet; /* flags */
  int resume;    /* 1: results of the same settings and frames stay */
  int overwrite; /* 1: existing results are replaced; 0: they are an error */
  int copy_channels;         /* 1: results also get the frames' own channels */
  layer_precision precision; /* of the layers in the results */
  beauty_kind beauty;
  int compression;    /* of the results, an index of exr_compressions */
  int dry_run;        /* 1: only print what would be done */
  int exact;          /* 1: the exact integral instead of the library */
  hbil_config config; /* formats and size are filled in later */
} process_settings;

/* Whether --far leaves the radiance cache out. */
static inline int settings_without_cache(const process_settings *s) {
  return s->far >= FAR_IS_ENVIRONMENT;
}

/* The defaults: all layers, the library's settings, the default model's
 * warm-up. */
void process_settings_init(process_settings *settings);

/* The words of --mode, --falloff and --ao-bounces, in the enums' order; they
 * end with NULL. */
extern const char *const mode_words[];
extern const char *const falloff_words[];
extern const char *const ao_bounces_words[];

#endif
