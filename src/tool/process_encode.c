/* What is written of a frame: pictures, the result, the light it hands on. */
#include "tool/process_frames.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int write_preview(const process *p, const job *j, const image *result,
                         layer l, image_error *error) {
  char *path = process_preview_path(j, l);
  const int failed = path ? preview_write(path, result, l, p->exposure, error)
                          : image_no_memory(error, j->path);
  free(path);
  return failed;
}

static int write_previews(const process *p, const job *j, const image *result,
                          image_error *error) {
  for (int l = 0; l < LAYER_COUNT; l++)
    if (p->layers >> l & 1 && write_preview(p, j, result, (layer)l, error) != 0)
      return -1;
  return 0;
}

/* The layers of a result that is there already. */
static int read_result(const process *p, const char *path, image *out,
                       image_error *error) {
  const char *names[LAYER_COUNT * 3];
  image layers;
  if (layers_image(p->layers, 0, 0, &layers) != 0)
    return image_no_memory(error, path);
  for (size_t i = 0; i < layers.count; i++)
    names[i] = layers.planes[i].name;
  const int failed = exr_read(path, names, layers.count, out, error);
  image_free(&layers);
  return failed;
}

/* The first frame is always in it, so that the exposure is known. */
static int add_row(lighting *l, const job *j, const image *result,
                   image_error *error) {
  process *p = l->process;
  const char *slash = strrchr(j->stem, '/');
  if (!(p->exposure > 0.0f))
    p->exposure = preview_exposure(result);
  return contact_sheet_add(&l->sheet, slash + 1, result, p->exposure) == 0
             ? 0
             : image_no_memory(error, p->options->contact_sheet);
}

static int show_frame(lighting *l, size_t item, const char *path,
                      const image *result, image_error *error) {
  const process *p = l->process;
  const job *j = &p->jobs[item];
  image there = {0};
  if (!contact_sheet_shows(&l->sheet, item))
    return 0;
  if (process_is_needed(p, j))
    return add_row(l, j, result, error);
  const int failed = read_result(p, path, &there, error) != 0 ||
                     add_row(l, j, &there, error) != 0;
  image_free(&there);
  return failed ? -1 : 0;
}

/* "[3/8] DIR/frame.exr", or a bar on a terminal. */
static void tell(lighting *l, const job *j, const char *path) {
  const process *p = l->process;
  if (p->options->quiet)
    return;
  if (l->progress.terminal && !p->exact) {
    progress_frames(&l->progress, l->done, l->needed);
    return;
  }
  progress_line_begin();
  fprintf(stderr, "[%d/%d] ", (int)(j - p->jobs) + 1, p->count);
  tool_show(path, stderr);
  fputs(j->finished ? " is there already\n" : "\n", stderr);
  progress_line_end();
}

/* The kept channels behind the layers. */
static int add_kept(image *result, const image *kept) {
  for (size_t i = 0; i < kept->count; i++) {
    image_plane *plane = image_add(result, kept->planes[i].name);
    if (!plane)
      return -1;
    plane->type = kept->planes[i].type;
    image_place(kept->planes[i].pixels, image_data_window(kept), plane->pixels,
                image_data_window(result));
  }
  return 0;
}

/* Takes them away again. */
static void drop_kept(image *result, size_t layers) {
  while (result->count > layers)
    free(result->planes[--result->count].pixels);
}

static int write_planes(const process *p, const job *j, const char *path,
                        slot *s, image_error *error) {
  const exr_style style = {p->options->compression, j->path};
  const size_t layers = s->result.count;
  resume_sign(&s->result, j->key);
  for (size_t i = 0; i < layers; i++)
    s->result.planes[i].type = p->options->half ? IMAGE_HALF : IMAGE_FLOAT;
  const int failed = add_kept(&s->result, &s->kept) != 0
                         ? image_no_memory(error, j->path)
                         : exr_write_as(path, &s->result, NULL, &style, error);
  drop_kept(&s->result, layers);
  image_free(&s->kept);
  return failed;
}

/* Writes it unless it is there. */
static int write_result(lighting *l, const job *j, slot *s,
                        image_error *error) {
  char *path = process_join(j->stem, "", ".exr");
  if (!path)
    return image_no_memory(error, j->path);
  const size_t item = (size_t)(j - l->process->jobs);
  int failed = j->finished ? 0 : write_planes(l->process, j, path, s, error);
  if (!failed)
    failed = show_frame(l, item, path, &s->result, error);
  if (!failed)
    tell(l, j, path);
  free(path);
  return failed;
}

static int save_light(const process *p, size_t item, slot *s,
                      image_error *error) {
  if (!process_hands_on(p, item))
    return 0;
  s->light.exposure = p->exposure;
  return resume_save(p->options->output, &s->light, error);
}

int process_encode(void *user, size_t item, image_error *error) {
  lighting *l = user;
  process *p = l->process;
  const job *j = &p->jobs[item];
  slot *s = process_slot(l, item);
  if (!process_is_needed(p, j))
    return write_result(l, j, s, error);
  l->done++;
  if (item == 0 && p->options->preview)
    p->exposure = preview_exposure(&s->result);
  if (p->options->preview && !j->finished &&
      write_previews(p, j, &s->result, error) != 0)
    return -1;
  return write_result(l, j, s, error) != 0 ? -1 : save_light(p, item, s, error);
}

/* ------------------------------------------------------------------------ */
/* The contact sheet                                                         */

int process_open_sheet(lighting *l) {
  process *p = l->process;
  if (!p->options->contact_sheet)
    return 0;
  return contact_sheet_open(&l->sheet, p->layers, (size_t)p->count,
                            p->shown.width, p->shown.height) == 0
             ? 0
             : image_no_memory(&p->error, p->options->contact_sheet);
}

int process_write_sheet(lighting *l) {
  const picture *sheet = &l->sheet.picture;
  process *p = l->process;
  if (!sheet->rgb)
    return 0;
  if (l->sheet.unlabelled)
    preview_no_font();
  return png_write(p->options->contact_sheet, sheet->rgb, sheet->width,
                   sheet->height, &p->error);
}
