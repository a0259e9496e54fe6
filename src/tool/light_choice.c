/* What the first frame's pixels decide about its light. */
#include "tool/light_choice.h"

#include "dump/read_gbuffer.h"
#include "dump/surface_points.h"

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

/* At edges, surfaces have a share of the background, which is no lamp. */
static void remove_sky(const gbuffer *g) {
  const surface_points s = surface_points_of(g, &g->map.camera);
  const float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  for (size_t c = 0; c < g->map.count[ROLE_EMISSION]; c++) {
    float *emission = gbuffer_plane(g, ROLE_EMISSION, c);
    const float *sky = g->map.emission_is_sky
                           ? emission
                           : gbuffer_plane(g, ROLE_BACKGROUND, c);
    for (size_t i = 0; sky && i < gbuffer_pixels(g); i++)
      if (surface_is_shown(&s, depth[i]))
        emission[i] -= sky[i];
  }
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
  hbil_frame_init(frame);
  frame->camera = map->camera;
  channel_map_hardware_depth(map, frame->hardware_depth);
  channel_map_configure(map, config);
  config->width = g.planes.width;
  config->height = g.planes.height;
  remove_sky(&g);
  const hbil_host_planes planes = gbuffer_host_planes(&g);
  const hbil_status status = hbil_config_suggest(&planes, config, frame, found);
  gbuffer_free(&g);
  return status == HBIL_SUCCESS
             ? 0
             : image_fail(error, "%s: the first look at it: %s", path,
                          hbil_status_string(status));
}
