/* hbil compare: how far two images are apart. */
#define _POSIX_C_SOURCE 200809L
#include "tool/tool.h"

#include <getopt.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
  OPTION_HEATMAP = 256,
  OPTION_MAX_RMSE,
  OPTION_MASK,
  OPTION_MASK_DEPTH,
  OPTION_JSON
};

static const struct option options[] = {
    {"heatmap", required_argument, NULL, OPTION_HEATMAP},
    {"max-rmse", required_argument, NULL, OPTION_MAX_RMSE},
    {"mask", required_argument, NULL, OPTION_MASK},
    {"mask-depth", required_argument, NULL, OPTION_MASK_DEPTH},
    {"json", no_argument, NULL, OPTION_JSON},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

/* Keeps the relative error of dark pixels finite. */
static const double relative_epsilon = 0.01;
static const float least_albedo = 0.02f;

static void usage(void) {
  puts(
      "usage: hbil compare [options] A.exr[:LAYER] B.exr[:LAYER]\n"
      "\n"
      "Measures how far A is from B, the reference.  LAYER is a name in front\n"
      "of channels, such as indirect, ViewLayer.DiffInd or DiffInd, or one\n"
      "channel, such as AO.V; without it all channels are compared.  Channels\n"
      "are paired by their last letter.\n"
      "\n"
      "  --heatmap PNG      picture of the error: black none, white the limit\n"
      "                     that is printed\n"
      "  --max-rmse X       exit status 1 if the RMSE is above X or a value "
      "is\n"
      "                     not finite\n"
      "  --mask FRAME.exr   only where the G-buffer FRAME has a surface and,\n"
      "                     channel by channel, albedo above 0.02\n"
      "  --mask-depth FRAME.exr\n"
      "                     only where FRAME has a surface\n"
      "  --json             print the numbers as JSON\n"
      "\n"
      "relative MSE: mean of (a-b)^2 / (b^2 + 0.01).  PSNR: against the\n"
      "largest value of B.  95 % within: of the pixels, by their worst "
      "channel.\n"
      "Values that are not finite are counted, and left\n"
      "out of everything else.");
}

typedef struct compare_options {
  const char *heatmap, *mask, *mask_depth;
  float max_rmse;
  int json;
} compare_options;

/* ------------------------------------------------------------------------ */
/* What is compared with what                                                */

typedef struct side {
  char *path;        /* malloc'd */
  const char *layer; /* in the argument, or NULL */
  image header, planes;
} side;

/* FILE or FILE:LAYER; a file whose own name has a colon goes first. */
static int parse_side(const char *argument, side *out, image_error *error) {
  const char *colon = strrchr(argument, ':');
  out->path = strdup(argument);
  if (!out->path)
    return image_no_memory(error, argument);
  if (colon && colon > argument && access(argument, F_OK) != 0) {
    out->path[colon - argument] = '\0';
    out->layer = colon + 1;
  }
  return exr_read_header(out->path, &out->header, error);
}

static void free_side(side *s) {
  image_free(&s->header);
  image_free(&s->planes);
  free(s->path);
}

/* Whether `name` is `wanted`, or the same with a view layer in front:
 * "DiffInd" stands for "ViewLayer.DiffInd". */
static int ends_in(const char *name, size_t length, const char *wanted) {
  const size_t tail = strlen(wanted);
  return length >= tail && strncmp(name + length - tail, wanted, tail) == 0 &&
         (length == tail || name[length - tail - 1] == '.');
}

static int in_layer(const char *channel, const char *wanted) {
  const char *dot = strrchr(channel, '.');
  return !wanted || ends_in(channel, strlen(channel), wanted) ||
         (dot && ends_in(channel, (size_t)(dot - channel), wanted));
}

static const char *component(const char *channel) {
  const char *dot = strrchr(channel, '.');
  return dot ? dot + 1 : channel;
}

/* Alpha says how much a pixel covers, not how bright it is. */
static int select_channels(const side *s, const char **out) {
  int count = 0;
  for (size_t i = 0; i < s->header.count; i++)
    if (in_layer(s->header.planes[i].name, s->layer) &&
        !(s->layer && strcmp(component(s->header.planes[i].name), "A") == 0))
      out[count++] = s->header.planes[i].name;
  return count;
}

static int read_side(side *s, const char **selected, int *count,
                     image_error *error) {
  *count = select_channels(s, selected);
  if (*count == 0)
    return image_fail(error,
                      "%s: has no layer %s; a name in front of its "
                      "channels is needed",
                      s->path, s->layer ? s->layer : "at all");
  return exr_read(s->path, selected, (size_t)*count, &s->planes, error);
}

/* The plane of b that belongs to channel `name` of a. */
static const image_plane *partner(const side *a, const side *b,
                                  const char *name) {
  if (a->planes.count == 1 && b->planes.count == 1)
    return &b->planes.planes[0];
  if (!a->layer && !b->layer)
    return image_find(&b->planes, name);
  for (size_t i = 0; i < b->planes.count; i++)
    if (strcmp(component(b->planes.planes[i].name), component(name)) == 0)
      return &b->planes.planes[i];
  return NULL;
}

static int read_sides(side *a, side *b, image_error *error) {
  int count_a, count_b;
  const char **selected =
      calloc(a->header.count + b->header.count + 1, sizeof *selected);
  if (!selected)
    return image_no_memory(error, a->path);
  if (!a->layer != !b->layer) { /* one layer is meant for both */
    a->layer = a->layer ? a->layer : b->layer;
    b->layer = a->layer;
  }
  int failed = read_side(a, selected, &count_a, error) != 0 ||
               read_side(b, selected, &count_b, error) != 0;
  free(selected);
  if (failed)
    return -1;
  if (a->planes.width != b->planes.width ||
      a->planes.height != b->planes.height)
    return image_fail(error,
                      "%s: %u x %u pixels, but %s has %u x %u; images of one "
                      "size are needed",
                      a->path, a->planes.width, a->planes.height, b->path,
                      b->planes.width, b->planes.height);
  if (count_a != count_b)
    return image_fail(error,
                      "%s: %d channels, but %s has %d; layers with the same "
                      "channels are needed",
                      a->path, count_a, b->path, count_b);
  for (size_t i = 0; i < a->planes.count; i++)
    if (!partner(a, b, a->planes.planes[i].name))
      return image_fail(error,
                        "%s: channel %s has no partner in %s; layers with the "
                        "same channels are needed",
                        a->path, a->planes.planes[i].name, b->path);
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Where it is compared                                                      */

typedef struct mask {
  gbuffer g; /* without planes: everything counts */
  float background;
  int albedo;
} mask;

/* How a G-buffer is read for its depth and albedo; depths that need a camera to
 * be read need one here, too. */
static int map_mask(const char *path, channel_map *map, image_error *error) {
  image header;
  source_options guess;
  view seen;
  camera_file camera;
  source_options_init(&guess);
  if (image_read_header(path, &header, error) != 0)
    return -1;
  int failed = channels_map(path, &header, &guess, map, error);
  if (!failed)
    map->window = image_window_common(map->data, map->display);
  if (!failed && map->count[ROLE_DEPTH] && !convert_is_straight(&map->how))
    failed = view_read(path, &header, NULL, &guess, &seen, error) != 0 ||
             view_aim(path, &seen, map, &camera, error) != 0;
  image_free(&header);
  return failed;
}

static int read_mask(const compare_options *o, const image *like, mask *out,
                     image_error *error) {
  const char *path = o->mask ? o->mask : o->mask_depth;
  channel_map map;
  hbil_config config;
  memset(out, 0, sizeof *out);
  if (!path)
    return 0;
  if (map_mask(path, &map, error) != 0)
    return -1;
  hbil_config_init(&config);
  channels_conventions(&map, &config);
  out->background = config.sky_depth;
  out->albedo = o->mask != NULL;
  if (!map.count[ROLE_DEPTH] || (out->albedo && !map.count[ROLE_ALBEDO]))
    return image_fail(
        error, "%s: cannot be a mask: no %s; a G-buffer is needed", path,
        role_name(map.count[ROLE_DEPTH] ? ROLE_ALBEDO : ROLE_DEPTH));
  if (gbuffer_read(path, &map, 1u << ROLE_DEPTH | 1u << ROLE_ALBEDO, &out->g,
                   error) != 0)
    return -1;
  if (out->g.planes.width != like->width ||
      out->g.planes.height != like->height)
    return image_fail(error,
                      "%s: %u x %u pixels, but the images have %u x %u; a mask "
                      "of their size is needed",
                      path, out->g.planes.width, out->g.planes.height,
                      like->width, like->height);
  return 0;
}

/* The plane of albedo that belongs to a channel, by its letter. */
static const float *mask_albedo(const mask *m, const char *channel) {
  const char *letter = component(channel);
  const char *place = strlen(letter) == 1 ? strchr("RGB", *letter) : NULL;
  return m->albedo && place
             ? gbuffer_plane(&m->g, ROLE_ALBEDO, (size_t)(place - "RGB"))
             : NULL;
}

static int counts(const float *depth, const float *albedo, float background,
                  size_t i) {
  return (!depth || gbuffer_is_surface(depth[i], background)) &&
         (!albedo || albedo[i] > least_albedo);
}

/* ------------------------------------------------------------------------ */
/* The measure                                                               */

typedef struct sums {
  double square, relative, largest, peak, reference;
  size_t values, odd;
} sums;

/* heat (or NULL) collects squared errors, one per pixel; worst the largest of
 * the channels, and is below 0 where nothing is compared. */
static void add_channel(const image_plane *a, const image_plane *b,
                        const mask *m, size_t pixels, sums *s, float *heat,
                        float *worst) {
  const float *depth = gbuffer_plane(&m->g, ROLE_DEPTH, 0);
  const float *albedo = mask_albedo(m, a->name);
  for (size_t i = 0; i < pixels; i++) {
    if (!counts(depth, albedo, m->background, i))
      continue;
    if (!isfinite(a->pixels[i]) || !isfinite(b->pixels[i])) {
      s->odd++;
      continue;
    }
    const double reference = b->pixels[i];
    const double off = a->pixels[i] - reference;
    s->square += off * off;
    s->relative += off * off / (reference * reference + relative_epsilon);
    s->largest = fmax(s->largest, fabs(off));
    s->peak = fmax(s->peak, fabs(reference));
    s->reference += reference;
    s->values++;
    worst[i] = fmaxf(worst[i], (float)fabs(off));
    if (heat)
      heat[i] += (float)(off * off);
  }
}

typedef struct result {
  double rmse, relative, psnr, largest, peak, mean;
  double within; /* 95 % of the pixels */
  size_t values, odd;
} result;

static result finish(const sums *s) {
  const double n = s->values ? (double)s->values : 1.0;
  result r = {.rmse = sqrt(s->square / n),
              .relative = s->relative / n,
              .largest = s->largest,
              .peak = s->peak,
              .mean = s->reference / n,
              .values = s->values,
              .odd = s->odd};
  r.psnr = r.rmse > 0.0 ? 20.0 * log10(s->peak / r.rmse) : INFINITY;
  return r;
}

static void print_text(const result *r) {
  printf("RMSE           %.6g\n"
         "relative MSE   %.6g\n"
         "PSNR           %.2f dB (peak %g)\n"
         "largest error  %.6g\n"
         "95 %% within    %.6g (mean of B %.6g)\n"
         "not finite     %zu\n"
         "values         %zu\n",
         r->rmse, r->relative, r->psnr, r->peak, r->largest, r->within, r->mean,
         r->odd, r->values);
}

/* JSON has no infinity: equal images have null. */
static int print_json(const result *r, image_error *error) {
  json_t *psnr = isfinite(r->psnr) ? json_real(r->psnr) : json_null();
  json_t *root = json_pack(
      "{s:f, s:f, s:o, s:f, s:f, s:f, s:f, s:I, s:I}", "rmse", r->rmse,
      "relative_mse", r->relative, "psnr", psnr, "peak", r->peak,
      "largest_error", r->largest, "within_95", r->within, "mean", r->mean,
      "not_finite", (json_int_t)r->odd, "values", (json_int_t)r->values);
  const int failed = !root || json_dumpf(root, stdout, JSON_INDENT(2)) != 0;
  json_decref(root);
  if (failed)
    return image_fail(error, "compare: cannot be written as JSON");
  puts("");
  return 0;
}

static int ascending(const void *a, const void *b) {
  const float x = *(const float *)a, y = *(const float *)b;
  return (x > y) - (x < y);
}

/* What 95 % of the pixels that are compared don't exceed; sorts. */
static double within_95(float *worst, size_t pixels) {
  size_t left_out = 0;
  qsort(worst, pixels, sizeof *worst, ascending);
  while (left_out < pixels && worst[left_out] < 0.0f)
    left_out++;
  const size_t count = pixels - left_out;
  return count ? (double)worst[left_out + (count - 1) * 95 / 100] : 0.0;
}

/* White is the error that one pixel in a hundred exceeds: a single bright
 * pixel would hide all others. */
static int write_heatmap(const char *path, float *heat, const image *like,
                         float *limit, image_error *error) {
  const size_t pixels = (size_t)like->width * like->height;
  float *sorted = malloc(pixels * sizeof *sorted);
  if (!sorted)
    return image_no_memory(error, path);
  for (size_t i = 0; i < pixels; i++)
    sorted[i] = heat[i] = sqrtf(heat[i]);
  qsort(sorted, pixels, sizeof *sorted, ascending);
  *limit = sorted[(pixels - 1) * 99 / 100];
  if (!(*limit > 0.0f))
    *limit = sorted[pixels - 1];
  free(sorted);
  return preview_heatmap(path, heat, like->width, like->height, *limit, error);
}

static int measure(const compare_options *o, const side *a, const side *b,
                   const mask *m, result *out, image_error *error) {
  const size_t pixels = (size_t)a->planes.width * a->planes.height;
  float *heat = o->heatmap ? calloc(pixels, sizeof *heat) : NULL;
  float *worst = malloc((pixels + 1) * sizeof *worst);
  sums s = {0};
  float limit = 0.0f;
  if ((o->heatmap && !heat) || !worst) {
    free(heat);
    free(worst);
    return image_no_memory(error, a->path);
  }
  for (size_t i = 0; i < pixels; i++)
    worst[i] = -1.0f;
  for (size_t i = 0; i < a->planes.count; i++)
    add_channel(&a->planes.planes[i], partner(a, b, a->planes.planes[i].name),
                m, pixels, &s, heat, worst);
  *out = finish(&s);
  out->within = within_95(worst, pixels);
  free(worst);
  int failed = 0;
  if (heat)
    failed = write_heatmap(o->heatmap, heat, &a->planes, &limit, error);
  if (heat && !failed && !o->json) {
    fputs("heat map       ", stdout);
    tool_show(o->heatmap, stdout);
    printf(", white: %g\n", (double)limit);
  }
  free(heat);
  return failed;
}

static int compare(const compare_options *o, side *a, side *b, result *out,
                   image_error *error) {
  mask m;
  if (read_sides(a, b, error) != 0)
    return -1;
  int failed = read_mask(o, &a->planes, &m, error) != 0 ||
               measure(o, a, b, &m, out, error) != 0;
  gbuffer_free(&m.g);
  if (!failed && out->values + out->odd == 0)
    failed = image_fail(error, "%s: the mask leaves no pixel to compare",
                        o->mask ? o->mask : o->mask_depth);
  return failed ? -1 : 0;
}

static int run(const compare_options *o, char **arguments) {
  side a = {0}, b = {0};
  image_error error;
  result r = {0};
  int failed = parse_side(arguments[0], &a, &error) != 0 ||
               parse_side(arguments[1], &b, &error) != 0 ||
               compare(o, &a, &b, &r, &error) != 0;
  free_side(&a);
  free_side(&b);
  if (!failed && o->json)
    failed = print_json(&r, &error) != 0;
  if (failed)
    return tool_report(&error);
  if (!o->json)
    print_text(&r);
  const int over =
      r.rmse > (double)o->max_rmse || (r.odd > 0 && !isinf(o->max_rmse));
  return over ? TOOL_DIFFERS : TOOL_OK;
}

static int set_option(int option, compare_options *o, image_error *error) {
  switch (option) {
  case OPTION_HEATMAP:
    o->heatmap = optarg;
    return 0;
  case OPTION_MASK:
    o->mask = optarg;
    return 0;
  case OPTION_MASK_DEPTH:
    o->mask_depth = optarg;
    return 0;
  case OPTION_JSON:
    o->json = 1;
    return 0;
  default:
    return option_floats("--max-rmse", optarg, &o->max_rmse, 1, error);
  }
}

int cmd_compare(int argc, char **argv) {
  compare_options o = {.max_rmse = INFINITY};
  image_error error;
  int option;
  while ((option = option_next(argc, argv, ":h", options, &error)) != -1) {
    if (option == 'h') {
      usage();
      return TOOL_OK;
    }
    if (option == '?' || set_option(option, &o, &error) != 0)
      return tool_report(&error);
  }
  if (argc - optind != 2) {
    image_fail(&error, "compare: %d files; two are needed", argc - optind);
    return tool_report(&error);
  }
  return run(&o, argv + optind);
}
