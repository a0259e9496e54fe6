/* Captured frames as content.  This is the one file of the bench that knows
 * dumps. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/content.h"
#include "dump/frame_camera.h"
#include "dump/read_channel_map.h"
#include "dump/read_gbuffer.h"
#include "dump/surface_points.h"
#include "image/image.h"
#include "image/image_read.h"

static const role roles[BENCH_INPUTS] = {ROLE_DEPTH,    ROLE_NORMAL,
                                         ROLE_ALBEDO,   ROLE_DIRECT,
                                         ROLE_EMISSION, ROLE_MOTION};

/* --- one frame --- */

/* map: to be freed by the caller, also after a failure. */
static int read_map(const char *path, const char *camera, channel_map *map,
                    camera_file *out, image_error *error) {
  image header;
  frame_camera seen;
  source_options guess;
  source_options_init(&guess);
  channel_map_init(map, DUMP_PLAIN);
  if (image_read_header(path, &header, error) != 0)
    return -1;
  const int failed = channel_map_read(path, &header, &guess, map, error) != 0 ||
                     channel_map_check(map, path, error) != 0 ||
                     frame_camera_read(path, &header, map, camera, &guess,
                                       &seen, NULL, error) != 0 ||
                     frame_camera_aim(path, &seen, map, out, error) != 0;
  image_free(&header);
  return failed ? -1 : 0;
}

/* Without any light there would be nothing to gather: every surface gets the
 * irradiance of a white sky. */
static int add_light(bench_content *content, bench_frame *frame,
                     image_error *error) {
  const size_t values = 3 * bench_pixels(content);
  if (frame->plane[BENCH_DIRECT])
    return 0;
  float *light = malloc(values * sizeof *light);
  if (!light)
    return image_no_memory(error, content->name);
  for (size_t i = 0; i < values; i++)
    light[i] = 3.14159265f / content->config.inputs.direct_scale;
  frame->plane[BENCH_DIRECT] = light;
  snprintf(content->note, sizeof content->note,
           "The file has no direct light; an irradiance of pi stands in for "
           "it.");
  return 0;
}

static int copy_planes(const gbuffer *g, bench_content *out, bench_frame *frame,
                       image_error *error) {
  for (int i = 0; i < BENCH_INPUTS; i++) {
    const float *channels[3] = {NULL, NULL, NULL};
    const size_t count = bench_input_channels((bench_input)i);
    for (size_t c = 0; c < count; c++)
      channels[c] = gbuffer_plane(g, roles[i], c);
    if (channels[count - 1] &&
        bench_content_copy(out, frame, (bench_input)i, channels, error) != 0)
      return -1;
  }
  return add_light(out, frame, error);
}

static int choose_far_field(const gbuffer *g, bench_content *out,
                            image_error *error) {
  const hbil_host_planes planes = gbuffer_host_planes(g);
  hbil_config config = out->config;
  hbil_frame frame;
  hbil_frame_init(&frame);
  frame.camera = out->frame[0].camera;
  config.width = out->width;
  config.height = out->height;
  const hbil_status status =
      hbil_config_suggest(&planes, &config, &frame, NULL);
  if (status != HBIL_SUCCESS)
    return image_fail(error, "%s: the first look at it: %s", out->name,
                      hbil_status_string(status));
  out->config.model.far_field = config.model.far_field;
  memcpy(out->environment, frame.environment, sizeof out->environment);
  out->sky_share = frame.sky_share;
  return 0;
}

/* What the first frame decides for all: size, conventions, and the far field,
 * which is chosen as hbil process does. */
static int adopt(const gbuffer *g, unsigned index, bench_content *out,
                 image_error *error) {
  hbil_config config = out->config;
  channel_map_configure(&g->map, &config);
  if (index == 0) {
    out->width = g->planes.width;
    out->height = g->planes.height;
    out->config = config;
    return choose_far_field(g, out, error);
  }
  if (g->planes.width != out->width || g->planes.height != out->height)
    return image_fail(error,
                      "%s: %u x %u pixels, but the first frame has %u x %u; "
                      "frames of one size are needed",
                      out->name, g->planes.width, g->planes.height, out->width,
                      out->height);
  if (config.inputs.projection != out->config.inputs.projection)
    return image_fail(error,
                      "%s: its camera's projection is another than the first "
                      "frame's",
                      out->name);
  return 0;
}

static int load_frame(const bench_options *options, unsigned index,
                      bench_content *out, image_error *error) {
  const char *path = options->frames[index];
  channel_map map;
  camera_file camera;
  gbuffer g;
  unsigned wanted = 1u << ROLE_BACKGROUND;
  for (int i = 0; i < BENCH_INPUTS; i++)
    wanted |= 1u << roles[i];
  snprintf(out->name, sizeof out->name, "%s", path);
  int failed = read_map(path, options->camera, &map, &camera, error) != 0 ||
               gbuffer_read(path, &map, wanted, &g, error) != 0;
  if (!failed) {
    camera_file_to_hbil(&camera, &out->frame[index].camera);
    surface_depths_make_planar(&g); /* for sums over depths */
    failed = adopt(&g, index, out, error) != 0 ||
             copy_planes(&g, out, &out->frame[index], error) != 0;
    gbuffer_free(&g);
  }
  channel_map_free(&map);
  return failed ? -1 : 0;
}

/* --- all frames --- */

/* A quarter of the surfaces' mean depth, because a dump's unit of length may be
 * anything; orthographic: a quarter of the picture's width. */
static float fitting_radius(const bench_content *content) {
  const bench_frame *frame = &content->frame[0];
  double sum = 0.0, count = 0.0;
  if (content->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC)
    return (float)(0.25 * content->width / frame->camera.fx);
  for (size_t i = 0; i < bench_pixels(content); i++)
    if (bench_is_surface(content, i)) {
      sum += (double)frame->plane[BENCH_DEPTH][i];
      count += 1.0;
    }
  return count > 0.0 ? (float)(0.25 * sum / count) : 1.0f;
}

int bench_content_load_dumps(const bench_options *options, bench_content *out,
                             image_error *error) {
  out->frame = calloc(options->frame_count, sizeof *out->frame);
  if (!out->frame)
    return image_no_memory(error, options->frames[0]);
  out->frames = options->frame_count;
  for (unsigned i = 0; i < options->frame_count; i++)
    if (load_frame(options, i, out, error) != 0)
      return -1;
  out->radius = fitting_radius(out);
  return 0;
}
