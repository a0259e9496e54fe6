/* hbil info: what is understood of a file, and whether it fits together. */
#include "tool/tool.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct option options[] = {
    {"camera", required_argument, NULL, 'c'},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static void usage(void) {
  puts("usage: hbil info [options] FRAME.exr...\n"
       "\n"
       "Tells which channels were understood as what, and their ranges; then\n"
       "checks that depth, camera, positions and normals fit together.\n"
       "\n"
       "  --camera FILE  JSON camera (FRAME.json beside FRAME.exr)\n"
       "\n"
       "Exit status: 0 if hbil process can use the files, else 2.");
}

typedef struct range {
  float low, high;
  size_t odd; /* infinite or NaN */
} range;

static range find_range(const float *values, size_t count) {
  range r = {INFINITY, -INFINITY, 0};
  for (size_t i = 0; i < count; i++) {
    if (!isfinite(values[i])) {
      r.odd++;
      continue;
    }
    r.low = fminf(r.low, values[i]);
    r.high = fmaxf(r.high, values[i]);
  }
  return r;
}

static void print_role(const gbuffer *g, role r) {
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  if (!g->map.count[r])
    printf("  %-10s not in the file\n", role_name(r));
  for (size_t c = 0; c < g->map.count[r]; c++) {
    const range found = find_range(gbuffer_plane(g, r, c), pixels);
    printf("  %-10s ", c ? "" : role_name(r));
    for (int at = tool_show(g->map.names[r][c], stdout); at < 28; at++)
      putchar(' ');
    if (found.low <= found.high)
      printf(" %g .. %g", (double)found.low, (double)found.high);
    if (found.odd)
      printf(" (%zu not finite)", found.odd);
    putchar('\n');
  }
}

static void print_depth(const gbuffer *g, float background) {
  const float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  float low = INFINITY, high = 0.0f;
  size_t surface = 0;
  for (size_t i = 0; i < pixels; i++)
    if (gbuffer_is_surface(depth[i], background)) {
      low = fminf(low, depth[i]);
      high = fmaxf(high, depth[i]);
      surface++;
    }
  printf("  surfaces   %.1f %% of the pixels",
         100.0 * (double)surface / (double)pixels);
  if (surface)
    printf(", depth %g .. %g", (double)low, (double)high);
  putchar('\n');
}

/* ------------------------------------------------------------------------ */
/* Does it fit together?                                                     */

typedef struct check {
  const gbuffer *g;
  hbil_camera camera;
  float background;
} check;

static void pixel_ray(const check *k, size_t i, double ray[3]) {
  const size_t width = k->g->planes.width;
  ray[0] = ((double)(i % width) + 0.5 - k->camera.cx) / k->camera.fx;
  ray[1] = ((double)(i / width) + 0.5 - k->camera.cy) / k->camera.fy;
  ray[2] = 1.0;
}

/* Rotates a view-space vector into the world. */
static void to_world(const check *k, const double v[3], double out[3]) {
  const double *m = k->camera.world_from_view;
  for (int i = 0; i < 3; i++)
    out[i] = m[4 * i] * v[0] + m[4 * i + 1] * v[1] + m[4 * i + 2] * v[2];
}

/* How far the rebuilt position is from the file's, as a share of the distance
 * from the eye.  ray_depth: take depth as that distance, not planar. */
static double position_error(const check *k, size_t i, int ray_depth) {
  const double depth = gbuffer_plane(k->g, ROLE_DEPTH, 0)[i];
  double ray[3], out[3], off = 0.0, far = 0.0;
  pixel_ray(k, i, ray);
  const double length = sqrt(ray[0] * ray[0] + ray[1] * ray[1] + 1.0);
  const double scale = ray_depth ? depth / length : depth;
  to_world(k, ray, out);
  for (int c = 0; c < 3; c++) {
    const double eye = k->camera.world_from_view[4 * c + 3];
    const double p = gbuffer_plane(k->g, ROLE_POSITION, (size_t)c)[i];
    const double d = out[c] * scale + eye - p;
    off += d * d;
    far += (p - eye) * (p - eye);
  }
  return far > 0.0 ? sqrt(off / far) : 0.0;
}

static double largest_error(const check *k, int ray_depth) {
  const float *depth = gbuffer_plane(k->g, ROLE_DEPTH, 0);
  const size_t pixels = (size_t)k->g->planes.width * k->g->planes.height;
  double worst = 0.0;
  for (size_t i = 0; i < pixels; i++)
    if (gbuffer_is_surface(depth[i], k->background)) {
      const double e = position_error(k, i, ray_depth);
      worst = e > worst || isnan(e) ? e : worst;
    }
  return worst;
}

static void check_position(const check *k) {
  const double planar = largest_error(k, 0), ray = largest_error(k, 1);
  printf("  position   rebuilt from depth and camera: largest relative error "
         "%.2g%s\n",
         planar, planar < 1e-3 ? ", they agree" : "");
  if (!(planar < 1e-3) && ray < 1e-3)
    puts("             the depth is the distance from the eye, not planar");
  else if (!(planar < 1e-3))
    puts("             the camera is not that of this frame, or the depth is "
         "in other units");
}

/* Normals must be turned towards the eye. */
static void check_normals(const check *k) {
  const float *depth = gbuffer_plane(k->g, ROLE_DEPTH, 0);
  const size_t pixels = (size_t)k->g->planes.width * k->g->planes.height;
  size_t surface = 0, facing = 0;
  for (size_t i = 0; i < pixels; i++) {
    double ray[3], world[3], cosine = 0.0;
    if (!gbuffer_is_surface(depth[i], k->background))
      continue;
    pixel_ray(k, i, ray);
    to_world(k, ray, world);
    for (int c = 0; c < 3; c++)
      cosine -= world[c] * gbuffer_plane(k->g, ROLE_NORMAL, (size_t)c)[i];
    surface++;
    facing += cosine >= -1e-3;
  }
  const double share = surface ? (double)facing / (double)surface : 1.0;
  printf("  normals    %.1f %% face the eye%s\n", 100.0 * share,
         share < 0.98 ? "; they may not be in world space" : "");
}

static void self_check(const gbuffer *g, const camera_file *camera,
                       float background) {
  check k = {.g = g, .background = background};
  gbuffer_hbil_camera(camera, &k.camera);
  printf("  camera     focal lengths %g, %g pixels, centre %g, %g, at %g %g "
         "%g\n",
         k.camera.fx, k.camera.fy, k.camera.cx, k.camera.cy,
         k.camera.world_from_view[3], k.camera.world_from_view[7],
         k.camera.world_from_view[11]);
  if (g->map.count[ROLE_POSITION])
    check_position(&k);
  check_normals(&k);
}

static int is_used(const channel_map *map, const char *name) {
  for (int r = 0; r < ROLE_COUNT; r++)
    for (size_t c = 0; c < map->count[r]; c++)
      if (strcmp(map->names[r][c], name) == 0)
        return 1;
  return 0;
}

/* The layers none of whose channels mean anything here, each named once. */
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
    tool_show(group, stdout);
    putchar('\n');
    last = name;
    last_length = length;
  }
}

static int print_planes(const char *path, const gbuffer *g,
                        const char *camera_path, image_error *error) {
  hbil_config config;
  camera_file camera;
  hbil_config_init(&config);
  channels_conventions(&g->map, &config);
  tool_show(path, stdout);
  printf(": %u x %u pixels, read as %s\n", g->planes.width, g->planes.height,
         dump_kind_name(g->map.kind));
  for (int r = 0; r < ROLE_COUNT; r++)
    print_role(g, (role)r);
  if (g->map.count[ROLE_DEPTH])
    print_depth(g, config.background);
  if (channels_check(&g->map, path, error) != 0 ||
      gbuffer_camera(path, camera_path, &camera, error) != 0 ||
      gbuffer_check_camera(path, &g->planes, &camera, error) != 0)
    return -1;
  self_check(g, &camera, config.background);
  return 0;
}

static int print_file(const char *path, const char *camera,
                      image_error *error) {
  image header;
  channel_map map;
  gbuffer g;
  if (exr_read_header(path, &header, error) != 0)
    return -1;
  channels_map(&header, &map);
  int failed = gbuffer_read(path, &map, ~0u, &g, error);
  if (!failed) {
    failed = print_planes(path, &g, camera, error);
    print_ignored(&header, &map);
    gbuffer_free(&g);
  }
  image_free(&header);
  return failed;
}

int cmd_info(int argc, char **argv) {
  image_error error;
  const char *camera = NULL;
  int option, status = TOOL_OK;
  while ((option = option_next(argc, argv, ":h", options, &error)) != -1) {
    if (option == '?')
      return tool_report(&error);
    if (option == 'h') {
      usage();
      return TOOL_OK;
    }
    camera = optarg;
  }
  if (optind == argc) {
    image_fail(&error, "no file; one FRAME.exr or more is needed");
    return tool_report(&error);
  }
  for (int i = optind; i < argc; i++)
    if (print_file(argv[i], camera, &error) != 0) {
      fflush(stdout);
      status = tool_report(&error);
    }
  return status;
}
