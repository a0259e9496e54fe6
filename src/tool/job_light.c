/* The far field of a job, and whether emission is gathered. */
#include "tool/job_light.h"

#include "dump/light_sources.h"
#include "dump/read_gbuffer.h"
#include "image/error.h"
#include "image/formats_rgb.h"
#include "tool/options.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int check_finite(const job *j, image_error *error) {
  const float *values = &j->environment[0][0];
  for (size_t i = 0; i < sizeof j->environment / sizeof *values; i++)
    if (!isfinite(values[i]))
      return image_fail(error,
                        "--environment %s: not finite; finite radiance is "
                        "needed",
                        j->settings->environment);
  return 0;
}

/* A latitude-longitude map becomes spherical harmonics. */
static int load_map(job *j, image_error *error) {
  const char *path = j->settings->environment;
  float *rgb = NULL;
  uint32_t width, height;
  if (formats_read_rgb(path, &rgb, &width, &height, error) != 0)
    return -1;
  const hbil_status status = hbil_environment_from_latlong(
      rgb, width, height, 0, NULL, j->environment);
  free(rgb);
  if (status != HBIL_SUCCESS)
    return image_fail(error, "%s: %s", path, hbil_status_string(status));
  j->config.model.far_field = HBIL_FAR_SH;
  return 0;
}

static int read_environment(job *j, image_error *error) {
  const char *text = j->settings->environment;
  float constant[3];
  if (text && !strcmp(text, "frame")) {
    j->config.model.far_field = HBIL_FAR_FRAME;
    return 0;
  }
  if (!text || !strcmp(text, "none"))
    return 0;
  if (option_floats("", text, constant, 3, NULL) == 0) {
    memcpy(j->environment[0], constant, sizeof constant);
    j->config.model.far_field = HBIL_FAR_CONSTANT;
  } else if (load_map(j, error) != 0)
    return -1;
  return check_finite(j, error);
}

/* Whether the mode can use such a far field. */
static int check_mode(const job *j, image_error *error) {
  const hbil_mode mode = j->config.model.mode;
  const hbil_far_field far = j->config.model.far_field;
  if (mode != HBIL_MODE_HBIL && far == HBIL_FAR_FRAME)
    return image_fail(error,
                      "--environment frame: not with --mode %s, which looks at "
                      "no light; none or R,G,B is needed",
                      mode_words[mode]);
  if (mode == HBIL_MODE_HBAO && far == HBIL_FAR_SH)
    return image_fail(error,
                      "--environment %s: a map is not possible with --mode "
                      "hbao, which has no bent cone; none or R,G,B is needed",
                      j->settings->environment);
  return 0;
}

int job_environment_read(job *j, image_error *error) {
  return read_environment(j, error) != 0 || check_mode(j, error) != 0 ? -1 : 0;
}

static int look_at_first(job *j, const char **far, const char **emission,
                         image_error *error) {
  const job_frame *first = j->frames;
  const unsigned roles = 1u << ROLE_DEPTH | 1u << ROLE_NORMAL |
                         1u << ROLE_DIRECT | 1u << ROLE_EMISSION |
                         1u << ROLE_BACKGROUND;
  gbuffer g;
  hbil_camera camera;
  if (gbuffer_read(first->path, &first->map, roles, &g, error) != 0)
    return -1;
  camera_file_to_hbil(&first->camera, &camera);
  if (!j->settings->environment)
    far_field_choose(&g, &j->config, j->environment, far);
  if (!j->settings->emission_given)
    emission_choose(&g, &camera, &j->config, emission);
  gbuffer_free(&g);
  return 0;
}

int job_light_decide(job *j, image_error *error) {
  const process_settings *s = j->settings;
  const char *far = "none: this --mode looks at no light", *emission = NULL;
  if (j->config.model.mode == HBIL_MODE_HBIL &&
      !(s->environment && s->emission_given) &&
      look_at_first(j, &far, &emission, error) != 0)
    return -1;
  if (!s->quiet && !s->environment)
    fprintf(stderr, "hbil: light of unblocked directions: %s\n", far);
  if (!s->quiet && emission)
    fprintf(stderr, "hbil: emission: %s\n", emission);
  return 0;
}
