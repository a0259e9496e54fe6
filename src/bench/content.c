/* What is measured on: the procedural room, or a captured frame. */
#include "bench/bench.h"
#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
  ROOM_WIDTH = 1280,
  ROOM_HEIGHT = 720,
  QUICK_WIDTH = 320,
  QUICK_HEIGHT = 180,
  /* pixels that errors are measured at: the exact integral of one takes a core
   * some ten milliseconds, and 8000 tell an error to a few per cent */
  COMPARED = 8000,
  QUICK_COMPARED = 1000
};

static const float pi = 3.14159265f;

size_t bench_input_channels(bench_input input) {
  return input == BENCH_DEPTH ? 1 : 3;
}

size_t bench_pixels(const bench_content *content) {
  return (size_t)content->width * content->height;
}

int bench_is_surface(const bench_content *content, size_t pixel) {
  return gbuffer_is_surface(content->frame[0].plane[BENCH_DEPTH][pixel],
                            content->config.sky_depth);
}

/* An input of a frame, to be filled; NULL when out of memory. */
static float *add_input(bench_content *content, bench_frame *frame,
                        bench_input input) {
  frame->plane[input] = malloc(bench_pixels(content) *
                               bench_input_channels(input) * sizeof(float));
  return frame->plane[input];
}

static int copy_input(bench_content *content, bench_frame *frame,
                      bench_input input, const float *const *channels) {
  const size_t pixels = bench_pixels(content);
  float *plane = add_input(content, frame, input);
  if (!plane)
    return -1;
  for (size_t c = 0; c < bench_input_channels(input); c++)
    memcpy(plane + c * pixels, channels[c], pixels * sizeof *plane);
  return 0;
}

static int copy_motion(bench_content *content, bench_frame *frame,
                       const float *const channels[2]) {
  const size_t pixels = bench_pixels(content);
  frame->motion = malloc(2 * pixels * sizeof *frame->motion);
  if (!frame->motion)
    return -1;
  for (size_t c = 0; c < 2; c++)
    memcpy(frame->motion + c * pixels, channels[c],
           pixels * sizeof *frame->motion);
  return 0;
}

/* --- the room --- */

static int copy_scene(bench_content *content, const scene_frame *scene,
                      bench_frame *out) {
  const float *const depth[] = {scene->depth};
  float *const *const vectors[] = {scene->normal, scene->albedo, scene->direct,
                                   scene->emission};
  const float *const motion[] = {scene->motion[0], scene->motion[1]};
  out->camera = scene->camera;
  if (copy_input(content, out, BENCH_DEPTH, depth) != 0 ||
      copy_motion(content, out, motion) != 0)
    return -1;
  for (int i = 0; i < 4; i++) {
    const float *const channels[] = {vectors[i][0], vectors[i][1],
                                     vectors[i][2]};
    if (copy_input(content, out, (bench_input)(BENCH_NORMAL + i), channels) !=
        0)
      return -1;
  }
  return 0;
}

/* As hbil demo lights it. */
static void configure_room(bench_content *content) {
  const float around[3] = {0.12f, 0.11f, 0.1f};
  channel_map plain;
  channels_init(&plain, DUMP_PLAIN);
  channels_conventions(&plain, &content->config);
  content->far = HBIL_FAR_FRAME;
  content->radius = 1.0f;
  content->config.far_field = HBIL_FAR_CONSTANT;
  memcpy(content->environment[0], around, sizeof around);
}

static int load_room(const bench_options *options, bench_content *out,
                     image_error *error) {
  const uint32_t width = options->quick ? QUICK_WIDTH : ROOM_WIDTH;
  const uint32_t height = options->quick ? QUICK_HEIGHT : ROOM_HEIGHT;
  snprintf(out->name, sizeof out->name, "procedural room");
  out->width = options->width ? options->width : width;
  out->height = options->height ? options->height : height;
  out->frames = BENCH_FRAMES;
  configure_room(out);
  for (unsigned i = 0; i < out->frames; i++) {
    scene_frame scene;
    if (scene_render(SCENE_ROOM, out->width, out->height, 0.0, i, &scene) != 0)
      return image_no_memory(error, "the room");
    const int failed = copy_scene(out, &scene, &out->frame[i]);
    scene_free(&scene);
    if (failed)
      return image_no_memory(error, "the room");
  }
  return 0;
}

/* --- a captured frame --- */

static const role roles[BENCH_INPUTS] = {ROLE_DEPTH, ROLE_NORMAL, ROLE_ALBEDO,
                                         ROLE_DIRECT, ROLE_EMISSION};

/* A G-buffer without light would leave nothing to gather: every surface then
 * receives as much as under a sky of unit radiance. */
static int add_light(bench_content *content, image_error *error) {
  const size_t values = 3 * bench_pixels(content);
  bench_frame *frame = &content->frame[0];
  if (frame->plane[BENCH_DIRECT])
    return 0;
  float *light = add_input(content, frame, BENCH_DIRECT);
  if (!light)
    return image_no_memory(error, content->name);
  for (size_t i = 0; i < values; i++)
    light[i] = pi / content->config.direct_scale;
  snprintf(content->note, sizeof content->note,
           "The file has no direct light; irradiance pi stands in for it.");
  return 0;
}

static int copy_dump(const gbuffer *g, bench_content *out, image_error *error) {
  for (int i = 0; i < BENCH_INPUTS; i++) {
    const float *channels[3] = {NULL};
    for (size_t c = 0; c < bench_input_channels((bench_input)i); c++)
      channels[c] = gbuffer_plane(g, roles[i], c);
    if (channels[0] &&
        copy_input(out, &out->frame[0], (bench_input)i, channels) != 0)
      return image_no_memory(error, out->name);
  }
  const float *const motion[] = {gbuffer_plane(g, ROLE_MOTION, 0),
                                 gbuffer_plane(g, ROLE_MOTION, 1)};
  if (motion[0] && motion[1] && copy_motion(out, &out->frame[0], motion) != 0)
    return image_no_memory(error, out->name);
  return add_light(out, error);
}

/* A quarter of the surfaces' mean depth, or of the picture's width where depth
 * has no scale: a dump's unit may be anything. */
static float fitting_radius(const bench_content *content) {
  if (content->config.projection == HBIL_PROJECTION_ORTHOGRAPHIC)
    return (float)(0.25 * content->width / content->frame[0].camera.fx);
  const float *depth = content->frame[0].plane[BENCH_DEPTH];
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < bench_pixels(content); i++)
    if (bench_is_surface(content, i)) {
      sum += (double)depth[i];
      count += 1.0;
    }
  return count > 0.0 ? (float)(0.25 * sum / count) : 1.0f;
}

/* As hbil process decides. */
static void fit_far_field(const gbuffer *g, bench_content *content) {
  hbil_config config = content->config;
  const char *reason;
  policy_far_field(g, &config, content->sky, &reason);
  content->far = config.far_field;
}

int bench_read_map(const char *path, const char *camera, channel_map *map,
                   camera_file *out, image_error *error) {
  image header;
  view seen;
  source_options guess;
  source_options_init(&guess);
  channels_init(map, DUMP_PLAIN); /* nothing to be freed, whatever fails */
  if (image_read_header(path, &header, error) != 0)
    return -1;
  const int failed =
      channels_map(path, &header, &guess, map, error) != 0 ||
      channels_check(map, path, error) != 0 ||
      view_read(path, &header, camera, &guess, &seen, error) != 0 ||
      view_aim(path, &seen, map, out, error) != 0;
  image_free(&header);
  return failed ? -1 : 0;
}

static int load_dump(const bench_options *options, bench_content *out,
                     image_error *error) {
  channel_map map;
  gbuffer g;
  unsigned wanted = 1u << ROLE_BACKGROUND | 1u << ROLE_MOTION;
  snprintf(out->name, sizeof out->name, "%s", options->dump);
  out->frames = 1;
  for (int i = 0; i < BENCH_INPUTS; i++)
    wanted |= 1u << roles[i];
  camera_file camera;
  if (bench_read_map(options->dump, options->camera, &map, &camera, error) != 0)
    return -1;
  gbuffer_hbil_camera(&camera, &out->frame[0].camera);
  out->width = map.window.width;
  out->height = map.window.height;
  channels_conventions(&map, &out->config);
  if (gbuffer_read(options->dump, &map, wanted, &g, error) != 0)
    return -1;
  const int failed = copy_dump(&g, out, error);
  fit_far_field(&g, out);
  out->radius = failed ? 1.0f : fitting_radius(out);
  gbuffer_free(&g);
  return failed;
}

/* --- the truth --- */

/* Blender's name of the pass, behind any view layer. */
static int is_indirect(const char *channel, char component) {
  static const char *const passes[] = {"DiffInd", "Diffuse Indirect"};
  for (int i = 0; i < 2; i++) {
    char tail[32];
    const int length =
        snprintf(tail, sizeof tail, "%s.%c", passes[i], component);
    const size_t whole = strlen(channel), part = (size_t)length;
    if (whole >= part && strcmp(channel + whole - part, tail) == 0 &&
        (whole == part || channel[whole - part - 1] == '.'))
      return 1;
  }
  return 0;
}

static int find_truth(const char *path, const image *header,
                      const bench_content *content, const char *names[3],
                      image_error *error) {
  for (int c = 0; c < 3; c++) {
    names[c] = NULL;
    for (size_t i = 0; i < header->count && !names[c]; i++)
      if (is_indirect(header->planes[i].name, "RGB"[c]))
        names[c] = header->planes[i].name;
    if (!names[c])
      return image_fail(error,
                        "%s: no indirect light; DiffInd.{R,G,B} (Blender's "
                        "diffuse indirect pass) are needed",
                        path);
  }
  if (header->width == content->width && header->height == content->height)
    return 0;
  return image_fail(error,
                    "%s: %u x %u pixels, but the dump has %u x %u; the truth "
                    "of this frame is needed",
                    path, header->width, header->height, content->width,
                    content->height);
}

static int copy_truth(const image *from, const char *const names[3],
                      bench_content *out) {
  const size_t pixels = bench_pixels(out);
  out->truth = malloc(3 * pixels * sizeof *out->truth);
  for (int c = 0; c < 3 && out->truth; c++)
    memcpy(out->truth + (size_t)c * pixels, image_find(from, names[c])->pixels,
           pixels * sizeof *out->truth);
  return out->truth ? 0 : -1;
}

static int load_truth(const char *path, bench_content *out,
                      image_error *error) {
  image header, planes = {0};
  const char *names[3];
  if (exr_read_header(path, &header, error) != 0)
    return -1;
  int failed = find_truth(path, &header, out, names, error) != 0 ||
               exr_read(path, names, 3, &planes, error) != 0;
  if (!failed && copy_truth(&planes, names, out) != 0)
    failed = image_no_memory(error, path) != 0;
  image_free(&planes);
  image_free(&header);
  return failed ? -1 : 0;
}

/* --- both --- */

/* The library's defaults; but the direct light of hbil process holds what
 * lamps send. */
static void default_model(bench_content *out) {
  hbil_config_init(&out->config);
  out->config.gather_emission = CL_FALSE;
}

/* Of every so many blocks of 4x4 pixels in both directions one, so that no more
 * pixels than wanted are left. */
static uint32_t block_step(const bench_content *content, size_t most) {
  uint32_t step = 1;
  while (bench_pixels(content) / 16 / step / step > most)
    step++;
  return step;
}

/* One pixel of a block; its place goes through all sixteen along every row and
 * every column of blocks. */
static int choose_compared(const bench_options *options, bench_content *out,
                           image_error *error) {
  const size_t standard = options->quick ? QUICK_COMPARED : COMPARED;
  const uint32_t step =
      block_step(out, options->pixels ? options->pixels : standard);
  out->compared = calloc(bench_pixels(out), 1);
  if (!out->compared)
    return image_no_memory(error, out->name);
  for (uint32_t by = 0; 4 * step * by < out->height; by++)
    for (uint32_t bx = 0; 4 * step * bx < out->width; bx++) {
      const uint32_t place = (5 * bx + 7 * by) % 16;
      const uint32_t x = 4 * step * bx + place % 4;
      const uint32_t y = 4 * step * by + place / 4;
      if (x >= out->width || y >= out->height)
        continue;
      out->compared[(size_t)y * out->width + x] = 1;
      out->compared_count++;
    }
  return 0;
}

int bench_content_load(const bench_options *options, bench_content *out,
                       image_error *error) {
  memset(out, 0, sizeof *out);
  default_model(out);
  int failed = options->dump ? load_dump(options, out, error) != 0 ||
                                   (options->truth &&
                                    load_truth(options->truth, out, error) != 0)
                             : load_room(options, out, error) != 0;
  if (!failed && options->dump && options->scale > 1)
    failed = bench_content_enlarge(out, options->scale, error);
  out->config.width = out->width;
  out->config.height = out->height;
  out->config.profiling = CL_TRUE;
  if (!failed)
    failed = choose_compared(options, out, error);
  if (failed)
    bench_content_free(out);
  return failed ? -1 : 0;
}

void bench_content_drop_planes(bench_content *content) {
  for (int f = 0; f < BENCH_FRAMES; f++) {
    for (int i = 0; i < BENCH_INPUTS; i++) {
      free(content->frame[f].plane[i]);
      content->frame[f].plane[i] = NULL;
    }
    free(content->frame[f].motion);
    content->frame[f].motion = NULL;
  }
}

void bench_content_free(bench_content *content) {
  bench_content_drop_planes(content);
  free(content->truth);
  free(content->compared);
  memset(content, 0, sizeof *content);
}
