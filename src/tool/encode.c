/* Writes what a job makes of a frame. */
#include "tool/encode.h"

#include "image/error.h"
#include "image/exr_read.h"
#include "image/exr_style.h"
#include "image/exr_write.h"
#include "image/image.h"
#include "image/picture.h"
#include "image/png_write.h"
#include "image/window.h"
#include "tool/contact_sheet.h"
#include "tool/heatmap.h"
#include "tool/job_key.h"
#include "tool/preview.h"
#include "tool/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* Pictures                                                                  */

static int write_preview(const encoder *e, const job_frame *f,
                         const image *result, layer l, image_error *error) {
  char *path = job_preview_path(f, l);
  const int failed = path ? preview_write(path, result, l, e->resume->exposure,
                                          job_existing(e->job), error)
                          : image_no_memory(error, f->path);
  free(path);
  return failed;
}

static int write_previews(const encoder *e, const job_frame *f,
                          const image *result, image_error *error) {
  for (int l = 0; l < LAYER_COUNT; l++)
    if (e->job->layers >> l & 1 &&
        write_preview(e, f, result, (layer)l, error) != 0)
      return -1;
  return 0;
}

/* Reads the layers of a result that exists. */
static int read_result(const job *j, const char *path, image *out,
                       image_error *error) {
  const char *names[LAYER_COUNT * 3];
  image layers;
  if (layers_image(j->layers, 0, 0, 0, &layers) != 0)
    return image_no_memory(error, path);
  for (size_t i = 0; i < layers.count; i++)
    names[i] = layers.planes[i].name;
  const int failed = exr_read(path, names, layers.count, out, error);
  image_free(&layers);
  return failed;
}

/* The sheet always shows the first frame, which sets the exposure. */
static int add_row(encoder *e, const job_frame *f, const image *result,
                   image_error *error) {
  const char *slash = strrchr(f->stem, '/');
  if (!(e->resume->exposure > 0.0f))
    e->resume->exposure = preview_exposure(result);
  return contact_sheet_add(&e->sheet, slash + 1, result, e->resume->exposure) ==
                 0
             ? 0
             : image_no_memory(error, e->job->settings->contact_sheet);
}

static int show_frame(encoder *e, size_t item, const char *path,
                      const image *result, image_error *error) {
  const job_frame *f = &e->job->frames[item];
  image existing = {0};
  if (!contact_sheet_shows(&e->sheet,
                           (size_t)e->job->before + item - e->whole->pre_roll))
    return 0;
  if (resume_is_needed(e->resume, item))
    return add_row(e, f, result, error);
  const int failed = read_result(e->job, path, &existing, error) != 0 ||
                     add_row(e, f, &existing, error) != 0;
  image_free(&existing);
  return failed ? -1 : 0;
}

/* ------------------------------------------------------------------------ */
/* The result                                                                */

/* Prints "[3/8] DIR/frame.exr", or shows a bar on a terminal. */
static void print_line(encoder *e, size_t item, const char *path) {
  const int pre_roll = (int)e->whole->pre_roll;
  const int number = e->job->before + (int)item + 1;
  if (e->job->settings->quiet)
    return;
  if (e->progress.terminal && !e->lines) {
    progress_frames(&e->progress, e->done, e->needed);
    return;
  }
  progress_line_begin();
  if (number <= pre_roll) {
    fprintf(stderr, "[pre-roll %d/%d] ", number, pre_roll);
    report_text(e->job->frames[item].path, stderr);
    fputc('\n', stderr);
  } else {
    fprintf(stderr, "[%d/%d] ", number - pre_roll, e->whole->count - pre_roll);
    report_text(path, stderr);
    fputs(e->resume->finished[item] ? " is there already\n" : "\n", stderr);
  }
  progress_line_end();
}

/* Adds the copied channels behind the layers. */
static int add_copied(image *result, const image *copied) {
  result->view_count = copied->view_count;
  memcpy(result->views, copied->views, sizeof result->views);
  for (size_t i = 0; i < copied->count; i++) {
    image_plane *plane = image_add(result, copied->planes[i].name);
    if (!plane)
      return -1;
    plane->type = copied->planes[i].type;
    image_place(copied->planes[i].pixels, image_data_window(copied),
                plane->pixels, image_data_window(result));
  }
  return 0;
}

static void remove_copied(image *result, size_t layers) {
  while (result->count > layers)
    free(result->planes[--result->count].pixels);
}

static const float largest_half = 65504.0f;

/* Whether a value is larger than half floats can be.  The device clips what it
 * makes halves of, so the largest half stands for such values. */
static unsigned is_clipped(const image_plane *plane, size_t i) {
  return plane->halves ? (plane->halves[i] & 0x7fff) == 0x7bff
                       : fabsf(plane->pixels[i]) > largest_half;
}

/* The pixels of a layer that are clipped in some channel. */
static size_t clipped_pixels(const image_plane *planes, size_t channels,
                             size_t pixels) {
  unsigned some = 0;
  size_t count = 0;
  for (size_t c = 0; c < channels; c++)
    for (size_t i = 0; i < pixels; i++)
      some |= is_clipped(&planes[c], i);
  for (size_t i = 0; some && i < pixels; i++) {
    unsigned clipped = 0;
    for (size_t c = 0; c < channels; c++)
      clipped |= is_clipped(&planes[c], i);
    count += clipped;
  }
  return count;
}

static void count_clipped(encoder *e, const image *result) {
  const size_t pixels = (size_t)result->width * result->height;
  const image_plane *planes = result->planes;
  for (int l = 0; l < LAYER_COUNT; l++)
    if (e->job->layers >> l & 1) {
      const size_t channels = strlen(layer_table[l].components);
      e->clipped[l] += clipped_pixels(planes, channels, pixels);
      planes += channels;
    }
}

/* "hbil: warning: half floats end at 65504, at which 3 pixels of beauty are
 * clipped; --precision float holds them" */
static void tell_clipped(const encoder *e) {
  const char *before = "hbil: warning: half floats end at 65504, at which ";
  int some = 0;
  for (int l = 0; l < LAYER_COUNT; l++)
    if (e->clipped[l]) {
      fprintf(stderr, "%s%zu pixel%s of %s", some ? ", " : before,
              e->clipped[l], e->clipped[l] > 1 ? "s" : "", layer_table[l].name);
      some = 1;
    }
  if (some)
    fputs(" are clipped; --precision float holds them\n", stderr);
}

static int write_planes(encoder *e, size_t item, const char *path,
                        image *result, image *copied, image_error *error) {
  const job_frame *f = &e->job->frames[item];
  const exr_style style = {e->job->settings->compression, f->path,
                           job_existing(e->job)};
  const size_t layers = result->count;
  const hbil_model *model = &e->job->config.model;
  job_key_sign(result, e->resume->keys[item]);
  result->near_radius = model->radius;
  result->ao_radius =
      model->mode == HBIL_MODE_HBAO ? model->radius : model->ao_radius;
  for (size_t i = 0; i < layers; i++)
    result->planes[i].type = e->job->half ? IMAGE_HALF : IMAGE_FLOAT;
  if (e->job->half && !e->job->settings->quiet)
    count_clipped(e, result);
  const int failed = add_copied(result, copied) != 0
                         ? image_no_memory(error, f->path)
                         : exr_write_as(path, result, NULL, &style, error);
  remove_copied(result, layers);
  image_free(copied);
  return failed;
}

static int write_result(encoder *e, size_t item, image *result, image *copied,
                        image_error *error) {
  const job_frame *f = &e->job->frames[item];
  char *path = job_result_path(f);
  if (!path)
    return image_no_memory(error, f->path);
  int failed = e->resume->finished[item]
                   ? 0
                   : write_planes(e, item, path, result, copied, error);
  /* of two jobs, the one whose result it is writes the previews, too */
  if (!failed && e->job->settings->preview && !e->resume->finished[item])
    failed = write_previews(e, f, result, error);
  if (!failed)
    failed = show_frame(e, item, path, result, error);
  if (!failed)
    print_line(e, item, path);
  free(path);
  return failed;
}

int encode_frame(encoder *e, size_t item, image *result, image *copied,
                 image_error *error) {
  const int preview = e->job->settings->preview;
  if (job_is_pre_roll(e->job, (int)item)) {
    e->done += resume_is_needed(e->resume, item) ? 1u : 0u;
    print_line(e, item, NULL);
    return 0;
  }
  if (resume_is_needed(e->resume, item)) {
    e->done++;
    if (item == e->job->pre_roll && preview)
      e->resume->exposure = preview_exposure(result);
  }
  return write_result(e, item, result, copied, error);
}

/* ------------------------------------------------------------------------ */
/* All frames                                                                */

int encoder_begin(encoder *e, const job *j, resume *r, image_error *error) {
  const char *sheet = j->settings->contact_sheet;
  const int is_first = !e->job;
  e->job = j;
  e->resume = r;
  for (int i = 0; i < j->count; i++)
    e->needed += resume_is_needed(r, (size_t)i) ? 1u : 0u;
  if (!is_first)
    return 0;
  progress_start(&e->progress, "frames", 0.0, j->settings->quiet);
  return !sheet || contact_sheet_open(&e->sheet, j->layers, j->has_cache,
                                      (size_t)e->whole->count -
                                          e->whole->pre_roll,
                                      j->shown.width, j->shown.height) == 0
             ? 0
             : image_no_memory(error, sheet);
}

int encoder_shows_cache(const encoder *e) {
  return e->sheet.picture.rgb && e->sheet.cache;
}

int encoder_show_cache(encoder *e, const void *bytes, size_t size,
                       image_error *error) {
  const job *j = e->job;
  contact_sheet *sheet = &e->sheet;
  exact_saved_cache cache;
  int failed = exact_saved_open(bytes, size, &cache) != EXACT_SUCCESS;
  for (size_t row = 0; row < contact_sheet_rows(sheet) && !failed; row++) {
    const long at = (long)contact_sheet_frame(sheet, row) +
                    (long)e->whole->pre_roll - j->before;
    const job_frame *f = &j->frames[at];
    picture tile = {0};
    if (at < 0 || at >= j->count) /* of another place */
      continue;
    failed =
        cache_picture(&cache, f, &j->shown, sheet->tile_width,
                      sheet->tile_height, e->resume->exposure, &tile) != 0 ||
        contact_sheet_add_cache(sheet, row, &tile) != 0;
    picture_free(&tile);
  }
  return failed ? image_no_memory(error, j->settings->contact_sheet) : 0;
}

int encoder_finish(encoder *e, image_error *error) {
  const picture *sheet = &e->sheet.picture;
  tell_clipped(e);
  if (!sheet->rgb)
    return 0;
  if (e->sheet.unlabelled)
    heatmap_warn_without_font();
  return png_write(e->whole->settings->contact_sheet, sheet->rgb, sheet->width,
                   sheet->height, job_existing(e->whole), error);
}

void encoder_close(encoder *e) {
  contact_sheet_close(&e->sheet);
}
