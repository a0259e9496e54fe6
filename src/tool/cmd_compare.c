/* hbil compare: how much two images differ. */
#include "image/error.h"
#include "image/formats.h"
#include "image/image.h"
#include "image/image_read.h"
#include "image/temporary_sweep.h"
#include "tool/commands.h"
#include "tool/compare_measure.h"
#include "tool/file_uses.h"
#include "tool/heatmap.h"
#include "tool/options.h"
#include "tool/paths.h"
#include "tool/report.h"

#include <getopt.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct compare_options {
  const char *heatmap, *mask, *mask_depth;
  float max_rmse;
  unsigned blocks;
  int json;
} compare_options;

#define AT(field) offsetof(compare_options, field)

static const option_row rows[] = {
    {ROW_TEXT("heatmap", AT(heatmap), "PNG"),
     .help = "picture of the error: black is none, white the limit that is "
             "printed; replaces only pictures that hbil wrote"},
    {ROW_FLOATS("max-rmse", AT(max_rmse), 1, "X"),
     .help = "exit status 1 if the RMSE is above X or a value is not finite"},
    {ROW_TEXT("mask", AT(mask), "FRAME.exr"),
     .help = "compare only where the G-buffer FRAME has a surface and, channel "
             "by channel, an albedo above 0.02"},
    {ROW_TEXT("mask-depth", AT(mask_depth), "FRAME.exr"),
     .help = "compare only where FRAME has a surface"},
    {ROW_NUMBER("blocks", AT(blocks), 1, 256, "N"),
     .help = "compare means over blocks of N x N pixels, 1..256: what is left "
             "of the error is not noise ({})"},
    {ROW_FLAG("json", AT(json)), .help = "print the numbers as JSON"}};
static const option_group group = {.rows = rows,
                                   .count = sizeof rows / sizeof *rows};
static const option_command command = {
    .usage =
        "usage: hbil compare [options] A[:LAYER] B[:LAYER]\n\nMeasures how far "
        "A is from B, files of EXR, TIFF, HDR or PNG; sRGB is made linear.  "
        "LAYER is the part of the channels' names in front of the last dot, "
        "such as indirect or ViewLayer.DiffInd, or as much of it as fits no "
        "other layer, such as DiffInd; or one channel, such as ao.V.  A colon "
        "with nothing behind it stands for the channels without a layer.  "
        "Without LAYER all channels are compared, by name.  If one file alone "
        "has a LAYER, it is meant for both; the other one's channels without a "
        "layer are taken if it has no such layer.  Channels are paired by "
        "their last letter.  Of EXR files with different parts of a picture, "
        "the pixels are compared that both have.",
    .groups = &group,
    .group_count = 1,
    .notes = "relative MSE: mean of (a-b)^2 / (b^2 + 0.01).  PSNR: against the "
             "largest value of B.  95 % within: of the pixels, by the channel "
             "that differs most.  Values that are not finite are counted and "
             "otherwise ignored."};

static void print_text(const compare_result *r) {
  printf("RMSE           %.6g\n"
         "relative MSE   %.6g\n"
         "PSNR           %.2f dB (peak %g)\n"
         "largest error  %.6g\n"
         "95 %% within    %.6g (mean of B %.6g)\n"
         "not finite     %zu\n"
         "values         %zu\n",
         r->rmse, r->relative, r->psnr, r->peak, r->largest, r->within, r->mean,
         r->not_finite, r->values);
}

/* JSON has no infinity, so the PSNR of equal images is null. */
static int print_json(const compare_result *r, image_error *error) {
  json_t *psnr = isfinite(r->psnr) ? json_real(r->psnr) : json_null();
  json_t *root = json_pack(
      "{s:f, s:f, s:o, s:f, s:f, s:f, s:f, s:I, s:I}", "rmse", r->rmse,
      "relative_mse", r->relative, "psnr", psnr, "peak", r->peak,
      "largest_error", r->largest, "within_95", r->within, "mean", r->mean,
      "not_finite", (json_int_t)r->not_finite, "values", (json_int_t)r->values);
  const int failed = !root || json_dumpf(root, stdout, JSON_INDENT(2)) != 0;
  json_decref(root);
  if (failed)
    return image_fail(error, "compare: cannot be written as JSON");
  puts("");
  return 0;
}

static int write_heatmap(const compare_options *o, const float *heat,
                         const image *like, image_error *error) {
  const size_t pixels = (size_t)like->width * like->height;
  float limit = 0.0f;
  char *folder = path_parent(o->heatmap);
  if (folder)
    temporary_sweep(folder);
  free(folder);
  if (compare_heat_limit(heat, pixels, &limit) != 0)
    return image_no_memory(error, o->heatmap);
  if (heatmap_write(o->heatmap, heat, like->width, like->height, limit,
                    error) != 0)
    return -1;
  if (!o->json) {
    fputs("heat map       ", stdout);
    report_text(o->heatmap, stdout);
    printf(", white: %g\n", (double)limit);
  }
  return 0;
}

static int measure(const compare_options *o, const compare_side *a,
                   const compare_side *b, const compare_mask *m,
                   compare_result *out, image_error *error) {
  const size_t pixels = (size_t)a->planes.width * a->planes.height;
  float *heat = o->heatmap ? malloc(pixels * sizeof *heat) : NULL;
  if (o->heatmap && !heat)
    return image_no_memory(error, o->heatmap);
  int failed = compare_measure(a, b, m, heat, out, error);
  if (!failed && heat)
    failed = write_heatmap(o, heat, &a->planes, error);
  free(heat);
  return failed;
}

/* Whether the heat map replaces nothing but a picture of hbil that is not
 * compared. */
static int check_heatmap(const compare_options *o, const char *mask,
                         const compare_side *a, const compare_side *b,
                         image_error *error) {
  file_uses uses = {0};
  const int failed =
      file_uses_read(&uses, a->path, "the image", error) != 0 ||
      file_uses_read(&uses, b->path, "the image", error) != 0 ||
      (mask && file_uses_read(&uses, mask, "the mask", error) != 0) ||
      file_uses_write(&uses, o->heatmap, "--heatmap", "another name is",
                      FILE_PICTURE, error) != 0 ||
      file_uses_check(&uses, error) != 0 ||
      file_use_may_replace(&uses.list[uses.count - 1], file_kind_of(o->heatmap),
                           error) != 0;
  file_uses_free(&uses);
  return failed ? -1 : 0;
}

static int compare(const compare_options *o, char **arguments, compare_side *a,
                   compare_side *b, compare_result *out, image_error *error) {
  const char *mask = o->mask ? o->mask : o->mask_depth;
  compare_mask m;
  if (compare_sides_name(arguments[0], arguments[1], a, b, error) != 0 ||
      (o->heatmap && (formats_check(error) != 0 ||
                      check_heatmap(o, mask, a, b, error) != 0)) ||
      compare_sides_read(a, b, error) != 0)
    return -1;
  int failed = compare_mask_read(mask, o->mask != NULL, &a->planes, &m, error);
  if (!failed && o->blocks > 1)
    compare_take_means(a, b, &m, o->blocks);
  if (!failed)
    failed = measure(o, a, b, &m, out, error);
  compare_mask_free(&m);
  if (!failed && out->values + out->not_finite == 0)
    failed = image_fail(error, "%s: the mask leaves no pixel to compare", mask);
  return failed ? -1 : 0;
}

/* Layers of hbil whose surfaces are within other radii show other things. */
static void print_radii(const image *a, const image *b) {
  const struct {
    const char *what;
    float a, b;
  } list[] = {{"near field    ", a->near_radius, b->near_radius},
              {"radius of ao  ", a->ao_radius, b->ao_radius}};
  for (size_t i = 0; i < sizeof list / sizeof *list; i++)
    if (list[i].a > 0.0f && list[i].b > 0.0f && list[i].a != list[i].b)
      printf("%s %g in A, %g in B\n", list[i].what, (double)list[i].a,
             (double)list[i].b);
}

static void tell_radii(const char *a, const char *b) {
  image headers[2] = {{0}, {0}};
  image_error error;
  if (image_read_header(a, headers, &error) == 0 &&
      image_read_header(b, headers + 1, &error) == 0)
    print_radii(headers, headers + 1);
  image_free(headers);
  image_free(headers + 1);
}

static int run(const compare_options *o, char **arguments) {
  compare_side a, b;
  image_error error;
  compare_result r = {0};
  int failed = compare(o, arguments, &a, &b, &r, &error) != 0;
  if (!failed && !o->json)
    tell_radii(a.path, b.path);
  compare_side_free(&a);
  compare_side_free(&b);
  if (!failed && o->json)
    failed = print_json(&r, &error) != 0;
  if (failed)
    return report_error(&error);
  if (!o->json)
    print_text(&r);
  const int over =
      r.rmse > (double)o->max_rmse || (r.not_finite > 0 && !isinf(o->max_rmse));
  return over ? STATUS_DIFFERS : STATUS_OK;
}

int cmd_compare(int argc, char **argv) {
  compare_options o = {.max_rmse = INFINITY, .blocks = 1};
  options_given given;
  image_error error;
  const int read = options_read(&command, argc, argv, &o, &given, &error);
  if (read > 0) {
    options_help(&command, &o);
    return STATUS_OK;
  }
  if (read == 0 && argc - optind == 2)
    return run(&o, argv + optind);
  if (read == 0)
    image_fail(&error, "compare: %d files; two are needed", argc - optind);
  return report_error(&error);
}
