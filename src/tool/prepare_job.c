/* Makes a job from settings and files. */
#include "tool/prepare_job.h"

#include "image/error.h"
#include "tool/job_files.h"
#include "tool/job_frames.h"
#include "tool/job_light.h"
#include "tool/job_output.h"
#include "tool/views.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int choose_layers(job *j, image_error *error) {
  const process_settings *s = j->settings;
  const hbil_mode mode = j->config.model.mode;
  const unsigned possible = layers_possible(mode, s->exact);
  /* whether the mode could, and only the exact integral cannot */
  const int exact =
      s->exact && (layers_possible(mode, 0) & s->layers) == s->layers;
  char cannot[160], can[160];
  j->layers = s->layers ? s->layers : layers_of_mode(mode);
  if ((j->layers & ~possible) == 0)
    return 0;
  layers_names(j->layers & ~possible, cannot, sizeof cannot);
  layers_names(possible, can, sizeof can);
  return image_fail(error, "--layers %s: not with %s%s; some of %s are needed",
                    cannot, exact ? "--quality reference" : "--mode ",
                    exact ? "" : mode_words[mode], can);
}

/* Whether the user asks for a radiance cache. */
static int asks_for_cache(const process_settings *s) {
  return s->view_count || s->light_view_count || s->far || s->learn ||
         s->cache_load || s->cache_save;
}

/* Whether frames have a radiance cache.  Unasked, they have one if it can know
 * more than a frame itself, because the camera moves.  Only one mode has light,
 * and the paper has no cache. */
static int wants_cache(const job *j) {
  const process_settings *s = j->settings;
  int moves = 0;
  for (int i = 1; i < j->count && !moves; i++)
    moves = memcmp(&j->frames[i].map.camera, &j->frames[0].map.camera,
                   sizeof j->frames[0].map.camera) != 0;
  if (settings_without_cache(s) || s->exact ||
      j->config.model.mode != HBIL_MODE_HBIL)
    return 0;
  return asks_for_cache(s) ||
         (moves && !s->paper && !j->frames[0].map.how.from_depth);
}

static void configure(job *j) {
  channel_map_configure(&j->frames[0].map, &j->config);
  if (j->settings->exact) { /* see frame_source_read() */
    j->config.inputs.depth_kind = HBIL_DEPTH_PLANAR;
    j->config.inputs.depth_scale = 1.0f;
    j->config.inputs.sky_depth = INFINITY;
  }
  j->config.width = j->width;
  j->config.height = j->height;
  j->config.outputs.bent_normal_space = HBIL_SPACE_WORLD;
  j->config.execution.profiling = j->settings->timings ? CL_TRUE : CL_FALSE;
}

/* Decides whether there is a radiance cache, and the settings beside it. */
static int prepare_world(job *j, image_error *error) {
  const process_settings *s = j->settings;
  hbil_model world = j->config.model;
  j->world = wants_cache(j);
  if (!j->world)
    return 0;
  if (j->frames[0].map.how.from_depth)
    return image_fail(error,
                      "--normals from-depth: not with --view, --learn, "
                      "--cache-load or --cache-save, whose radiance cache "
                      "needs normals");
  hbil_model_set(&world, HBIL_MODEL_WORLD);
  j->config.model.provider =
      s->far ? (hbil_provider)s->far : HBIL_PROVIDER_RAYS;
  if (!s->thickness_given && !s->paper)
    j->config.model.relative_thickness = world.relative_thickness;
  return views_check(j, error) != 0 ||
                 (s->cache_load &&
                  cache_file_read(s->cache_load, &j->loaded, error) != 0)
             ? -1
             : 0;
}

int job_prepare(job *j, const process_settings *settings, char *const *files,
                int count, image_error *error) {
  memset(j, 0, sizeof *j);
  j->settings = settings;
  j->config = settings->config;
  if (!settings->output)
    return image_fail(error, "no output folder; -o DIR is needed");
  if (count < 1)
    return image_fail(error, "no frame; one FRAME.exr or more is needed");
  j->frames = calloc((size_t)count, sizeof *j->frames);
  if (!j->frames)
    return image_no_memory(error, files[0]);
  j->count = count;
  if (choose_layers(j, error) != 0 || job_frames_check(j, files, error) != 0 ||
      job_environment_read(j, error) != 0)
    return -1;
  if (settings->exact && j->frames[0].map.how.from_depth)
    return image_fail(error,
                      "--normals from-depth: not with --quality reference, "
                      "whose exact integral needs normals");
  configure(j);
  /* after the output folder is made: in a/../b, a may be missing until then */
  return prepare_world(j, error) != 0 || job_output_prepare(j, error) != 0 ||
                 job_files_check(j, error) != 0
             ? -1
             : 0;
}
