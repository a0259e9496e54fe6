/* Makes a job from settings and files. */
#include "tool/prepare_job.h"

#include "image/error.h"
#include "tool/job_frames.h"
#include "tool/job_light.h"
#include "tool/job_output.h"

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
      job_environment_read(j, error) != 0 || job_output_prepare(j, error) != 0)
    return -1;
  if (settings->exact && j->frames[0].map.how.from_depth)
    return image_fail(error,
                      "--normals from-depth: not with --quality reference, "
                      "whose exact integral needs normals");
  configure(j);
  return 0;
}
