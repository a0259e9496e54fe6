/* What the first frame's pixels decide about its light. */
#include "tool/light_choice.h"

#include "dump/read_gbuffer.h"
#include "dump/surface_points.h"
#include "tool/refusal.h"

#include <stdlib.h>
#include <string.h>

static const char *const far_texts[] = {
    [HBIL_SOURCE_NOT_SEEN] =
        "the mean radiance of the frame's surfaces: no bright sky is visible",
    [HBIL_SOURCE_IN_DIRECT] =
        ("the mean radiance of the frame's surfaces, where direct light is "
         "weaker than that of the visible sky"),
    [HBIL_SOURCE_NOT_IN_DIRECT] =
        "the radiance of the visible sky, which direct light does not contain",
};
static const char *const emission_texts[] = {
    [HBIL_SOURCE_NOT_SEEN] = NULL,
    [HBIL_SOURCE_IN_DIRECT] = "not gathered: direct light contains it",
    [HBIL_SOURCE_NOT_IN_DIRECT] = "gathered: direct light does not contain it",
};

const char *light_choice_far_text(const hbil_sources *found) {
  return far_texts[found->sky];
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

int light_choice_by(const char *path, const gbuffer *g, hbil_config *config,
                    hbil_frame *frame, hbil_sources *found,
                    image_error *error) {
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
