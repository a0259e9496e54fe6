/* hbil info: what is understood of a file, and whether it fits together. */
#include "dump/frame_camera.h"
#include "dump/frame_check.h"
#include "dump/read_channel_map.h"
#include "dump/read_gbuffer.h"
#include "dump/settle.h"
#include "image/camera_json.h"
#include "image/error.h"
#include "image/image.h"
#include "image/image_read.h"
#include "image/window.h"
#include "tool/commands.h"
#include "tool/frame_list.h"
#include "tool/info_sequence.h"
#include "tool/job_light.h"
#include "tool/options.h"
#include "tool/report.h"
#include "tool/source_arguments.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct info_options {
  source_options source;
  const char *camera, *frames;
} info_options;

static const option_row frame_rows[] = {
    {ROW_TEXT("frames", offsetof(info_options, frames), "RANGES"),
     .help = "numbers for the patterns, such as 1-240x2,300 (all that exist)"},
    {ROW_TEXT("camera", offsetof(info_options, camera), "FILE"),
     .help = "JSON camera (FRAME.json beside FRAME.exr, or else the header's, "
             "or else one that fits the positions, as `positions` in place of "
             "FILE)"}};
static const option_group groups[] = {{.rows = frame_rows, .count = 2},
                                      SOURCE_GROUP};
static const option_command command = {
    .usage =
        "usage: hbil info [options] FRAME.exr...\n\nTells which channels were "
        "understood as what, and their ranges; what is missing; then checks "
        "that depth, camera, positions and normals fit together, names the "
        "option that helps where they don't, and tells depths that aren't "
        "those "
        "of surfaces: means over edges, motion blur, depth of field.  At the "
        "end, the size of the "
        "radiance cache that hbil process would have for all these frames.",
    .groups = groups,
    .group_count = 2,
    .notes = "FRAME.exr may be a pattern or a folder, as for hbil process; "
             "then the first frame is told in full, and one line says whether "
             "the others go with it.  "
             "Exit status: 0 if hbil process can use the files as the frames "
             "of one job, else 2."};

/* ------------------------------------------------------------------------ */
/* What the file has                                                         */

typedef struct range {
  float low, high;
  size_t not_finite;
} range;

static range find_range(const float *values, size_t count) {
  range r = {INFINITY, -INFINITY, 0};
  for (size_t i = 0; i < count; i++) {
    if (!isfinite(values[i])) {
      r.not_finite++;
      continue;
    }
    r.low = fminf(r.low, values[i]);
    r.high = fmaxf(r.high, values[i]);
  }
  return r;
}

/* What is lost if a role is missing. */
static const char *cost(role r) {
  static const char *const costs[ROLE_COUNT] = {
      [ROLE_DEPTH] = "it is needed",
      [ROLE_NORMAL] = "they are needed, or --normals from-depth",
      [ROLE_ALBEDO] = "every surface is taken as white and passes on too much "
                      "light",
      [ROLE_DIRECT] = "only emission, which is then gathered, sends light; "
                      "occlusion needs none",
      [ROLE_EMISSION] = "lamps and sky are black in beauty",
      [ROLE_BACKGROUND] = "nothing is lost if emission contains the sky",
      [ROLE_MOTION] = "--reprojection camera is possible, motion is not",
      [ROLE_POSITION] = "only the normals check depth and camera",
      [ROLE_INDIRECT] = "only --view-light radiance and --beauty replace need "
                        "it",
      [ROLE_COVERAGE] = "edges may be a mixture",
      [ROLE_PICTURE] = "beauty is diffuse light and emission alone",
      [ROLE_ALPHA] = "beauty has no alpha"};
  return costs[r];
}

static void print_range(const gbuffer *g, role r, size_t c) {
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  const range found = find_range(gbuffer_plane(g, r, c), pixels);
  if (found.low <= found.high)
    printf(" %g .. %g", (double)found.low, (double)found.high);
  if (found.not_finite)
    printf(" (%zu not finite)", found.not_finite);
}

/* g: the planes as they are stored. */
static void print_role(const channel_map *map, const gbuffer *g, role r) {
  if (*map->lacks[r]) {
    printf("  %-10s left out, since there is no ", role_name(r));
    report_text(map->lacks[r], stdout);
    printf(": %s\n", cost(r));
  } else if (!map->count[r] && !(r == ROLE_NORMAL && map->how.from_depth) &&
             (r != ROLE_COVERAGE || map->how.premultiplied))
    printf("  %-10s not in the file: %s\n", role_name(r), cost(r));
  for (size_t c = 0; c < map->count[r]; c++) {
    printf("  %-10s ", c ? "" : role_name(r));
    for (int column = report_text(map->names[r][c], stdout); column < 28;
         column++)
      putchar(' ');
    if (g->map.count[r])
      print_range(g, r, c);
    if (map->files[r] && c == 0) {
      fputs(" in ", stdout);
      report_text(map->files[r], stdout);
    }
    puts(map->gamma[r] && role_is_colour(r) ? ", sRGB, made linear" : "");
  }
}

static void print_window(const channel_map *map) {
  const image_window *d = &map->data, *s = &map->display;
  const image_window both = image_window_common(*d, *s);
  if (memcmp(d, s, sizeof *d) == 0)
    return;
  printf("  window     pixels at %d, %d of a picture of %u x %u at %d, %d%s\n",
         d->x, d->y, s->width, s->height, s->x, s->y,
         both.width == d->width && both.height == d->height
             ? ""
             : "; those outside are used and not written");
}

static void print_conventions(const channel_map *map) {
  static const char *const depths[] = {
      "along the camera's axis", "from the eye", "taken from positions",
      "0..1 between the clipping planes", "1..0 between the clipping planes"};
  static const char *const lights[] = {"E", "E/pi", "E albedo/pi"};
  const conventions *how = &map->how;
  printf("  depth is   %s%s (--depth)", depths[how->depth],
         how->backwards ? ", backwards" : "");
  if (how->from_near && how->depth == DEPTH_RAY)
    printf(", from the near plane at %g (--clip)", how->near);
  if (isfinite(how->sky_depth))
    printf("; sky from %g on (--sky-depth)", (double)how->sky_depth);
  if (how->from_depth)
    printf("\n  normals    rebuilt from depth (--normals)");
  else
    printf("\n  normals    in %s space%s (--normals)",
           how->normals == SPACE_WORLD ? "world" : "camera",
           how->encoded ? ", encoded" : "");
  if (how->flips)
    printf(", flipped %s%s%s (--flip)", how->flips & 1 ? "x" : "",
           how->flips & 2 ? "y" : "", how->flips & 4 ? "z" : "");
  putchar('\n');
  if (map->count[ROLE_DIRECT])
    printf("  direct is  %s (--direct)\n", lights[how->direct]);
  if (how->unit != 1.0)
    printf("  units      depth and positions times %g (--unit-scale)\n",
           how->unit);
}

/* ------------------------------------------------------------------------ */
/* Whether it fits together                                                  */

static void print_camera(const frame_camera *seen, const channel_map *map) {
  const hbil_camera *camera = &map->camera;
  printf("  camera     %s: ", seen->from);
  if (map->projection == HBIL_PROJECTION_ORTHOGRAPHIC)
    printf("orthographic, %g, %g pixels a unit, the picture %g x %g units",
           camera->fx, camera->fy, map->display.width / camera->fx,
           map->display.height / camera->fy);
  else
    printf("focal lengths %g, %g pixels", camera->fx, camera->fy);
  printf(", centre %g, %g, at %g %g %g%s\n", camera->cx, camera->cy,
         camera->world_from_view[3], camera->world_from_view[7],
         camera->world_from_view[11],
         seen->mirrored ? ", its world mirrored" : "");
  if (*seen->lens)
    printf("  lens       %s\n", seen->lens);
  if (map->exposure > 0.0)
    printf("  exposure   %g; results have it, too (--exposure)\n",
           map->exposure);
}

/* Whether positions fit, and what helps if no warning says it.  Samples may lie
 * anywhere in their pixels. */
static const char *verdict(const frame_check *k, double pixels) {
  return k->positions < 1e-3 ? "they agree"
         : pixels < 1.0      ? "they agree within a pixel, which is enough"
         : k->found.count    ? "they differ, as told below"
                          : "they differ: store both as 32-bit floats, of one "
                            "sample at each pixel's middle, or leave one out "
                            "(--map position=, --depth position)";
}

static void print_positions(const gbuffer *g, const frame_check *k) {
  const int parallel = g->map.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const double pixels =
      k->positions * (parallel ? g->planes.width : g->map.camera.fx);
  printf("  position   rebuilt from depth and camera: 90 %% within %.2g of the "
         "%s",
         k->positions, parallel ? "picture's width" : "distance");
  if (k->positions >= 1e-3)
    printf(" (%.2g pixels)", pixels);
  printf(", %s\n", verdict(k, pixels));
}

static void print_check(const gbuffer *g, const frame_check *k) {
  printf("  surfaces   %.1f %% of the pixels", 100.0 * k->surface);
  if (k->surface > 0.0)
    printf(", depth %g .. %g", k->low, k->high);
  putchar('\n');
  if (!isnan(k->positions))
    print_positions(g, k);
  if (g->map.count[ROLE_NORMAL]) {
    printf("  normals    %.1f %% face the eye", 100.0 * k->facing);
    if (!isnan(k->agreement))
      printf(", %.1f degrees off the depth's own on average",
             acos(fmin(1.0, k->agreement)) * 57.29577951308232);
    putchar('\n');
  }
  for (int i = 0; i < k->found.count; i++)
    printf("  warning    %s\n", k->found.text[i]);
}

static int is_used(const channel_map *map, const char *name) {
  for (int r = 0; r < ROLE_COUNT; r++)
    for (size_t c = 0; c < map->count[r]; c++)
      if (strcmp(map->names[r][c], name) == 0)
        return 1;
  return 0;
}

/* Prints each layer of which no channel is used, once. */
static void print_ignored(const image *header, const channel_map *map) {
  const char *last = "";
  size_t last_length = 0;
  for (size_t i = 0; i < header->count; i++) {
    const char *name = header->planes[i].name;
    const char *dot = strrchr(name, '.');
    const size_t length = dot ? (size_t)(dot - name) : strlen(name);
    if (is_used(map, name) ||
        (length == last_length && strncmp(name, last, length) == 0))
      continue;
    char group[sizeof header->planes->name];
    snprintf(group, sizeof group, "%.*s", (int)length, name);
    printf("  %-10s ", last_length ? "" : "not used");
    report_text(group, stdout);
    putchar('\n');
    last = name;
    last_length = length;
  }
}

/* Prints the ranges of the planes as they are stored. */
static int print_roles(const char *path, const channel_map *map,
                       image_error *error) {
  channel_map whole = *map;
  gbuffer g;
  whole.window = map->data;
  if (gbuffer_read_as_stored(path, &whole, ~(1u << ROLE_BACKGROUND), &g,
                             error) != 0)
    return -1;
  for (int r = 0; r < ROLE_COUNT; r++)
    print_role(map, &g, (role)r);
  gbuffer_free(&g);
  return 0;
}

/* What hbil process would decide if the file were its first frame. */
static int print_light(const char *path, const channel_map *map,
                       image_error *error) {
  hbil_config config;
  hbil_frame frame;
  hbil_sources found = {.sky = HBIL_SOURCE_NOT_SEEN};
  char text[LIGHT_TEXT_SIZE];
  hbil_config_init(&config);
  if (light_choice_make(path, map, &config, &frame, &found, error) != 0)
    return -1;
  const char *emission = light_choice_emission_text(&found);
  light_choice_far_text(&found, frame.sky_share, text);
  printf("  far light  %s (--environment)\n", text);
  if (emission)
    printf("  emission   %s (--gather-emission)\n", emission);
  return 0;
}

static int check_frame(const char *path, const channel_map *map,
                       const frame_camera *seen, image_error *error) {
  hbil_config config;
  frame_check found;
  gbuffer g;
  hbil_config_init(&config);
  channel_map_configure(map, &config);
  if (gbuffer_read(path, map, ~0u, &g, error) != 0)
    return -1;
  print_camera(seen, map);
  frame_check_whole(&g, &config, &map->camera, &found);
  print_check(&g, &found);
  gbuffer_free(&g);
  return print_light(path, map, error);
}

/* Those that a renderer has written of its own accord; see --exposure. */
static void print_numbers(const image *header) {
  for (size_t i = 0; i < header->number_count; i++) {
    fputs(i ? ", " : "  numbers    ", stdout);
    report_text(header->numbers[i].name, stdout);
    printf(" %g", header->numbers[i].value);
  }
  if (header->number_count)
    puts(" in the header");
}

/* Whether the file has what is needed, and its camera. */
static int check_header(const char *path, const image *header,
                        const info_options *o, channel_map *map,
                        frame_camera *seen, image_error *error) {
  camera_file camera;
  return channel_map_check(map, path, error) != 0 ||
                 frame_camera_read(path, header, map, o->camera, &o->source,
                                   seen, NULL, error) != 0 ||
                 frame_camera_aim(path, seen, map, &camera, error) != 0
             ? -1
             : 0;
}

static int print_understood(const char *path, const image *header,
                            const info_options *o, channel_map *map,
                            image_error *error) {
  frame_camera seen;
  findings guessed;
  print_window(map);
  print_numbers(header);
  if (print_roles(path, map, error) != 0 ||
      check_header(path, header, o, map, &seen, error) != 0 ||
      conventions_settle(path, map, &guessed, error) != 0)
    return -1;
  for (int i = 0; i < guessed.count; i++)
    printf("  guessed    %s\n", guessed.text[i]);
  print_conventions(map);
  return check_frame(path, map, &seen, error);
}

static int print_whole(const char *path, const image *header,
                       const info_options *o, channel_map *map,
                       image_error *error) {
  report_text(path, stdout);
  printf(": %u x %u pixels, read as %s (--source %s)\n", header->width,
         header->height, source_table[map->kind].about,
         source_table[map->kind].word);
  const int failed = print_understood(path, header, o, map, error);
  print_ignored(header, map);
  return failed;
}

/* A later frame of a sequence, which is read as the first one is. */
static int check_later(const char *path, const image *header,
                       const info_options *o, const channel_map *first,
                       channel_map *map, image_error *error) {
  frame_camera seen;
  if (check_header(path, header, o, map, &seen, error) != 0)
    return -1;
  channel_map_read_alike(map, first);
  return 0;
}

/* Adds the file to `all` if it can be used.  later: it isn't the first one of a
 * sequence, and is checked without words. */
static int print_file(const char *path, const info_options *o, int later,
                      usable *all, image_error *error) {
  image header;
  channel_map *map = &all->maps[all->count];
  if (image_read_header(path, &header, error) != 0)
    return -1;
  int failed = channel_map_read(path, &header, &o->source, map, error);
  if (!failed) {
    failed = later ? check_later(path, &header, o, all->maps, map, error)
                   : print_whole(path, &header, o, map, error);
    if (failed)
      channel_map_free(map);
    else
      all->pictures[all->count++] = (extent_picture){path, map};
  }
  image_free(&header);
  return failed;
}

/* sequence: the files are those of patterns or folders.  The first one stands
 * for all, and the first that can't be used is told. */
static int print_files(char *const *files, size_t count, int sequence,
                       const info_options *o, image_error *error) {
  usable all = {.pictures = calloc(count, sizeof *all.pictures),
                .maps = calloc(count, sizeof *all.maps)};
  int status = STATUS_OK;
  if (!all.pictures || !all.maps) {
    image_no_memory(error, files[0]);
    status = report_error(error);
  }
  for (size_t i = 0; all.pictures && all.maps && i < count &&
                     (!sequence || status == STATUS_OK);
       i++)
    if (print_file(files[i], o, sequence && i > 0, &all, error) != 0) {
      fflush(stdout);
      status = report_error(error);
    }
  if (status == STATUS_OK && info_sequence_print(&all, sequence, error) != 0) {
    fflush(stdout);
    status = report_error(error);
  }
  for (size_t i = 0; i < all.count; i++)
    channel_map_free(&all.maps[i]);
  free(all.pictures);
  free(all.maps);
  return status;
}

int cmd_info(int argc, char **argv) {
  image_error error;
  info_options o = {.camera = NULL};
  options_given given;
  frame_list list = {NULL, 0, 0};
  source_options_init(&o.source);
  const int read = options_read(&command, argc, argv, &o, &given, &error);
  if (read > 0)
    options_help(&command, &o);
  if (read == 0 && optind == argc)
    image_fail(&error, "no file; one FRAME.exr or more is needed");
  if (read > 0)
    return STATUS_OK;
  if (read < 0 || optind == argc ||
      frame_list_make(argv + optind, argc - optind, o.frames, 0, &list,
                      &error) != 0)
    return report_error(&error);
  const int sequence = list.count != (size_t)(argc - optind);
  const int status = print_files(list.files, list.count, sequence, &o, &error);
  frame_list_free(&list);
  return status;
}
