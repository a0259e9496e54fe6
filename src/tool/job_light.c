/* The light that a frame's planes don't contain. */
#include "tool/job_light.h"

#include "dump/read_gbuffer.h"
#include "dump/surface_points.h"
#include "image/formats_rgb.h"
#include "tool/options.h"
#include "tool/refusal.h"
#include "tool/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ------------------------------------------------------------------------ */
/* What the pixels of frames and views decide                                */

/* Pictures that decide, besides the first frame, of each kind: a place shows
 * itself in fewer, and reading a film a third time would take long. */
enum { MOST_PICTURES = 64 };

static const char *const far_texts[] = {
    [HBIL_SOURCE_NOT_SEEN] = "the mean radiance of the frame's surfaces",
    [HBIL_SOURCE_IN_DIRECT] =
        ("the mean radiance of the frame's surfaces, where direct light is "
         "weaker than that of the visible sky"),
    [HBIL_SOURCE_NOT_IN_DIRECT] =
        "the radiance of the visible sky, which direct light does not contain",
};
static const char *const place_texts[] = {
    [HBIL_PLACE_SKY_SEEN] = "",
    [HBIL_PLACE_EMPTY] = "what lies behind the surfaces is black",
    [HBIL_PLACE_OPEN] =
        "lit ground, with no ceiling and no walls around, is in the open",
    [HBIL_PLACE_DARK] = "no sky is visible, and none lights the shadows",
    [HBIL_PLACE_ENCLOSED] =
        "no sky is visible, but a ceiling, or walls that face each other",
    [HBIL_PLACE_NO_GROUND] = "no sky is visible, and too little ground",
};
static const char *const emission_texts[] = {
    [HBIL_SOURCE_NOT_SEEN] = NULL,
    [HBIL_SOURCE_IN_DIRECT] = "not gathered: direct light contains it",
    [HBIL_SOURCE_NOT_IN_DIRECT] = "gathered: direct light does not contain it",
};

void light_choice_far_text(const hbil_sources *found, float sky_share,
                           char out[LIGHT_TEXT_SIZE]) {
  const char *why = place_texts[found->place];
  int end = snprintf(out, LIGHT_TEXT_SIZE, "%s", far_texts[found->sky]);
  if (sky_share > 0.0f)
    end += snprintf(out + end, LIGHT_TEXT_SIZE - (size_t)end,
                    ", but nothing in %.0f %% of them", 100.0 * sky_share);
  snprintf(out + end, LIGHT_TEXT_SIZE - (size_t)end, "%s%s", *why ? ": " : "",
           why);
}

const char *light_choice_emission_text(const hbil_sources *found) {
  return emission_texts[found->lamps];
}

/* Emission without the sky, the planes that differ from the G-buffer's. */
typedef struct lamp_planes {
  float *channel[ROLE_CHANNELS]; /* NULL: the G-buffer's own */
} lamp_planes;

static void lamp_planes_free(lamp_planes *l) {
  for (size_t c = 0; c < ROLE_CHANNELS; c++)
    free(l->channel[c]);
}

/* At edges, surfaces have a share of the background, which is no lamp. */
static int remove_sky(const gbuffer *g, lamp_planes *out) {
  const surface_points s = surface_points_of(g, &g->map.camera);
  const float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  const size_t pixels = gbuffer_pixels(g);
  memset(out, 0, sizeof *out);
  for (size_t c = 0; c < g->map.count[ROLE_EMISSION]; c++) {
    const float *emission = gbuffer_plane(g, ROLE_EMISSION, c);
    const float *sky = g->map.emission_is_sky
                           ? emission
                           : gbuffer_plane(g, ROLE_BACKGROUND, c);
    if (!sky)
      continue;
    float *lamps = out->channel[c] = malloc(pixels * sizeof *lamps);
    if (!lamps)
      return -1;
    for (size_t i = 0; i < pixels; i++)
      lamps[i] =
          surface_is_shown(&s, depth[i]) ? emission[i] - sky[i] : emission[i];
  }
  return 0;
}

static hbil_status suggest(const gbuffer *g, const lamp_planes *lamps,
                           hbil_config *config, hbil_frame *frame,
                           hbil_sources *found) {
  hbil_host_planes planes = gbuffer_host_planes(g);
  for (size_t c = 0; c < ROLE_CHANNELS; c++)
    if (lamps->channel[c])
      planes.emission.channel[c] = lamps->channel[c];
  hbil_frame_init(frame);
  frame->camera = g->map.camera;
  channel_map_hardware_depth(&g->map, frame->hardware_depth);
  channel_map_configure(&g->map, config);
  config->width = g->planes.width;
  config->height = g->planes.height;
  return hbil_config_suggest(&planes, config, frame, found);
}

/* Lets the library decide by a frame (hbil_suggest.h), of which depth, normals,
 * direct light, emission and background count.  Of config, model.mode counts;
 * config and frame receive the decision.  Returns 0, or -1 with `error` filled.
 */
static int light_choice_by(const char *path, const gbuffer *g,
                           hbil_config *config, hbil_frame *frame,
                           hbil_sources *found, image_error *error) {
  lamp_planes lamps;
  const int no_memory = remove_sky(g, &lamps);
  const hbil_status status = no_memory
                                 ? HBIL_OUT_OF_HOST_MEMORY
                                 : suggest(g, &lamps, config, frame, found);
  lamp_planes_free(&lamps);
  if (no_memory)
    return image_no_memory(error, path);
  return status == HBIL_SUCCESS ? 0 : refusal(NULL, path, status, NULL, error);
}

int light_choice_make(const char *path, const channel_map *map,
                      hbil_config *config, hbil_frame *frame,
                      hbil_sources *found, image_error *error) {
  const unsigned roles = 1u << ROLE_DEPTH | 1u << ROLE_NORMAL |
                         1u << ROLE_DIRECT | 1u << ROLE_EMISSION |
                         1u << ROLE_BACKGROUND;
  gbuffer g;
  if (gbuffer_read(path, map, roles, &g, error) != 0)
    return -1;
  const int failed = light_choice_by(path, &g, config, frame, found, error);
  gbuffer_free(&g);
  return failed;
}

/* ------------------------------------------------------------------------ */
/* The light of a job                                                        */

static int check_finite(const job *j, image_error *error) {
  const float *values = &j->far.environment[0][0];
  for (size_t i = 0; i < sizeof j->far.environment / sizeof *values; i++)
    if (!isfinite(values[i]))
      return image_fail(error,
                        "--environment %s: not finite; finite radiance is "
                        "needed",
                        j->settings->environment);
  return 0;
}

/* What was understood of a map.  The first function of the harmonics is the
 * constant 1 / sqrt(4 pi). */
static void tell_map(const job *j, const float *rgb, uint32_t width,
                     uint32_t height) {
  const float *sum = j->far.environment[0];
  const double mean = 0.28209479177387814;
  char text[384];
  int is_bright = 0;
  for (size_t i = 0; i < 3 * (size_t)width * height && !is_bright; i++)
    is_bright = rgb[i] > 1.0f;
  snprintf(text, sizeof text,
           "a latitude-longitude map of %u x %u pixels, mean radiance %.3g "
           "%.3g %.3g; its top row is +z, its middle column +x and what is "
           "left of that +y, as in Blender%s%s",
           width, height, mean * (double)sum[0], mean * (double)sum[1],
           mean * (double)sum[2],
           width == 2 * height ? "" : "; twice as wide as high is usual",
           is_bright ? ""
                     : "; no value is above 1: colours for a display (PNG, "
                       "JPEG) must be made linear light first");
  report_note(j->settings->environment, "", text);
}

/* A latitude-longitude map becomes spherical harmonics. */
static int load_map(job *j, image_error *error) {
  const char *path = j->settings->environment;
  float *rgb = NULL;
  uint32_t width, height;
  if (formats_read_rgb(path, &rgb, &width, &height, error) != 0)
    return -1;
  const hbil_status status = hbil_environment_from_latlong(
      rgb, width, height, 0, NULL, j->far.environment);
  if (status == HBIL_SUCCESS && !j->settings->quiet)
    tell_map(j, rgb, width, height);
  free(rgb);
  if (status != HBIL_SUCCESS)
    return refusal(NULL, path, status, NULL, error);
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
  if (text && !strcmp(text, "none"))
    j->config.model.far_field = HBIL_FAR_NONE;
  if (!text || !strcmp(text, "none"))
    return 0;
  if (option_floats("", text, constant, 3, NULL) == 0) {
    memcpy(j->far.environment[0], constant, sizeof constant);
    j->config.model.far_field = HBIL_FAR_CONSTANT;
  } else if (access(text, F_OK) != 0) {
    return image_fail(error,
                      "--environment %s: cannot be read: neither three numbers "
                      "nor a file that exists; R,G,B, a map, frame or none is "
                      "needed",
                      text);
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

/* Lets the frame decide that decides for the job. */
static int choose(job *j, first_frame *first, hbil_config *config,
                  hbil_frame *frame, hbil_sources *found, image_error *error) {
  const job_frame *f = job_first(j);
  if (f != j->frames)
    return light_choice_make(f->path, &f->map, config, frame, found, error);
  return first_frame_read(first, j, error) != 0
             ? -1
             : light_choice_by(f->path, &first->g, config, frame, found, error);
}

/* Lets some of these pictures, evenly spread, decide with those before. */
static int look_at(const job *j, const job_frame *pictures, int count,
                   hbil_config *config, hbil_frame *frame, hbil_sources *found,
                   image_error *error) {
  const int looks = count < MOST_PICTURES ? count : MOST_PICTURES;
  for (int i = 0; i < looks; i++) {
    const job_frame *f = pictures + (long)i * count / looks;
    if (f != job_first(j) &&
        light_choice_make(f->path, &f->map, config, frame, found, error) != 0)
      return -1;
  }
  return 0;
}

/* Takes what the user left open from all that is known of the place before the
 * first frame is lit: a frame, views, and frames that are learnt from.  Chunks
 * that one frame decides for learn from different ones, and must decide alike.
 */
static int look_around(job *j, first_frame *first, hbil_sources *found,
                       image_error *error) {
  const int learnt = j->settings->learn && !j->decider ? j->count : 0;
  hbil_config config = j->config;
  hbil_frame frame;
  if (choose(j, first, &config, &frame, found, error) != 0 ||
      look_at(j, j->views, j->view_count, &config, &frame, found, error) != 0 ||
      look_at(j, j->frames, learnt, &config, &frame, found, error) != 0)
    return -1;
  if (!j->settings->environment) {
    j->config.model.far_field = config.model.far_field;
    memcpy(j->far.environment, frame.environment, sizeof j->far.environment);
    j->far.sky_share = frame.sky_share;
  }
  if (!j->settings->emission_given)
    j->config.model.gather_emission = config.model.gather_emission;
  return 0;
}

/* Beauty that replaces light needs it, and
 * the share that is a guess is told, even if its layer isn't written.  A job
 * for `beauty` alone that may leave out light which doesn't show
 * (HBIL_SKIP_UNUSED) still may: asking for the share, too, would forbid it. */
static unsigned hidden_layers(const job *j) {
  const unsigned unknown = 1u << LAYER_UNKNOWN;
  const unsigned light = j->replaces ? 1u << LAYER_INDIRECT : 0u;
  const int may_skip =
      j->layers == 1u << LAYER_BEAUTY && !j->replaces &&
      (j->config.history.reprojection == HBIL_REPROJECTION_NONE ||
       j->config.model.feedback == HBIL_FEEDBACK_RADIANCE);
  return (light |
          (!may_skip && layers_show_guesses(j->layers, &j->config) ? unknown
                                                                   : 0u)) &
         ~j->layers;
}

int job_light_decide(job *j, first_frame *first, image_error *error) {
  const process_settings *s = j->settings;
  const int looks = j->config.model.mode == HBIL_MODE_HBIL;
  hbil_sources found = {.sky = HBIL_SOURCE_NOT_SEEN};
  char text[LIGHT_TEXT_SIZE] = "none: this --mode looks at no light";
  if (looks && !(s->environment && s->emission_given) &&
      look_around(j, first, &found, error) != 0)
    return -1;
  if (looks)
    light_choice_far_text(&found, j->far.sky_share, text);
  if (!s->quiet && !s->environment)
    fprintf(stderr, "hbil: light of unblocked directions: %s\n", text);
  const char *emission = light_choice_emission_text(&found);
  if (!s->quiet && !s->emission_given && emission)
    fprintf(stderr, "hbil: emission: %s\n", emission);
  j->hidden = hidden_layers(j);
  return 0;
}
