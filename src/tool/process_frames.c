/* The frames of a job: while one is lit, the next is read and the last one
 * written. */
#include "tool/process.h"

#include "tool/contact_sheet.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A frame on its way. */
typedef struct slot {
  gbuffer g;
  uint64_t hash; /* of what the library is given */
  image kept;    /* its own channels that go on into the result */
  image result;
  resume_light light; /* what it hands on */
} slot;

typedef struct lighting {
  process *process;
  slot slots[PIPELINE_SLOTS];
  contact_sheet sheet;
  progress progress;
  size_t needed, done; /* frames that are lit */
} lighting;

static slot *slot_of(lighting *l, size_t item) {
  return &l->slots[item % PIPELINE_SLOTS];
}

/* ------------------------------------------------------------------------ */
/* Decode                                                                    */

static unsigned used_roles(const process *p) {
  enum {
    ALWAYS = 1 << ROLE_DEPTH | 1 << ROLE_NORMAL | 1 << ROLE_ALBEDO |
             1 << ROLE_DIRECT | 1 << ROLE_EMISSION | 1 << ROLE_BACKGROUND
  };
  const int moved = p->config.reprojection == HBIL_REPROJECTION_MOTION;
  return ALWAYS | (moved ? 1u << ROLE_MOTION : 0u);
}

/* All channels but those that a layer of ours replaces. */
static int read_kept(const process *p, const job *j, image *out,
                     image_error *error) {
  image header, layers = {0};
  if (exr_read_header(j->path, &header, error) != 0)
    return -1;
  const char **names = calloc(header.count + 1, sizeof *names);
  size_t count = 0;
  int failed = !names || layers_image(p->layers, 0, 0, &layers) != 0
                   ? image_no_memory(error, j->path)
                   : 0;
  for (size_t i = 0; !failed && i < header.count; i++)
    if (!image_find(&layers, header.planes[i].name))
      names[count++] = header.planes[i].name;
  if (!failed)
    failed = exr_read_as_is(j->path, names, count, out, error);
  free(names);
  image_free(&layers);
  image_free(&header);
  return failed;
}

static int decode(void *user, size_t item, image_error *error) {
  lighting *l = user;
  const process *p = l->process;
  job *j = &p->jobs[item];
  slot *s = slot_of(l, item);
  if (process_find_key(p, j, error) != 0)
    return -1;
  if (!process_is_needed(p, j))
    return 0;
  if (gbuffer_read(j->path, &j->map, used_roles(p), &s->g, error) != 0)
    return -1;
  if (p->options->keep && !j->finished && read_kept(p, j, &s->kept, error) != 0)
    return -1;
  s->hash = p->exact ? 0 : sequence_hash(p->sequence, &s->g);
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Light                                                                     */

/* Through the library or without it. */
static int light_planes(const process *p, size_t item, slot *s,
                        image_error *error) {
  const job *j = &p->jobs[item];
  float environment[9][3];
  const unsigned runs = p->options->repeat + (item ? 0 : p->options->warm_up);
  memcpy(environment, p->environment, sizeof environment);
  if (!p->exact)
    return sequence_run(p->sequence, &s->g, s->hash, &j->camera, environment,
                        runs, &s->result, &p->rows[item], error);
  exact_run(p->exact, &s->g, &j->camera, environment, runs, &s->result);
  return 0;
}

static int hands_on(const process *p, size_t item) {
  return p->light.size && (int)item + 1 < p->end;
}

/* For the frames that are left, should this process not live to do them. */
static int take_light(const process *p, size_t item, slot *s,
                      image_error *error) {
  if (!hands_on(p, item))
    return 0;
  if (!s->light.bytes && !(s->light.bytes = malloc(p->light.size)))
    return image_no_memory(error, p->jobs[item].path);
  s->light.size = p->light.size;
  s->light.key = p->jobs[item].key;
  if (!p->exact)
    return sequence_take_light(p->sequence, s->light.bytes, error);
  exact_take_light(p->exact, s->light.bytes);
  return 0;
}

static int light(void *user, size_t item, image_error *error) {
  lighting *l = user;
  const process *p = l->process;
  const job *j = &p->jobs[item];
  slot *s = slot_of(l, item);
  p->rows[item].frame = j->path;
  if (!process_is_needed(p, j))
    return 0;
  if (!s->result.count &&
      layers_image(p->layers, p->width, p->height, &s->result) != 0)
    return image_no_memory(error, j->path);
  s->result.x = s->g.planes.x;
  s->result.y = s->g.planes.y;
  const int failed = light_planes(p, item, s, error) != 0 ||
                     take_light(p, item, s, error) != 0;
  gbuffer_free(&s->g);
  return failed ? -1 : 0;
}

/* ------------------------------------------------------------------------ */
/* Encode                                                                    */

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

/* Copies what of a plane is in another window; the rest stays black. */
static void place(const image *from, const float *pixels, image *to,
                  float *out) {
  const int64_t left = (int64_t)to->x - from->x, top = (int64_t)to->y - from->y;
  for (uint32_t y = 0; y < to->height; y++)
    for (uint32_t x = 0; x < to->width; x++)
      if (top + y >= 0 && top + y < from->height && left + x >= 0 &&
          left + x < from->width)
        out[(size_t)y * to->width + x] =
            pixels[(size_t)(top + y) * from->width + (size_t)(left + x)];
}

/* The kept channels behind the layers. */
static int add_kept(image *result, const image *kept) {
  for (size_t i = 0; i < kept->count; i++) {
    image_plane *plane = image_add(result, kept->planes[i].name);
    if (!plane)
      return -1;
    plane->type = kept->planes[i].type;
    place(kept, kept->planes[i].pixels, result, plane->pixels);
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
  if (!hands_on(p, item))
    return 0;
  s->light.exposure = p->exposure;
  return resume_save(p->options->output, &s->light, error);
}

static int encode(void *user, size_t item, image_error *error) {
  lighting *l = user;
  process *p = l->process;
  const job *j = &p->jobs[item];
  slot *s = slot_of(l, item);
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
/* All of them                                                               */

static int open_sheet(lighting *l) {
  process *p = l->process;
  if (!p->options->contact_sheet)
    return 0;
  return contact_sheet_open(&l->sheet, p->layers, (size_t)p->count, p->width,
                            p->height) == 0
             ? 0
             : image_no_memory(&p->error, p->options->contact_sheet);
}

static int write_sheet(lighting *l) {
  const picture *sheet = &l->sheet.picture;
  process *p = l->process;
  if (!sheet->rgb)
    return 0;
  if (l->sheet.unlabelled)
    preview_no_font();
  return png_write(p->options->contact_sheet, sheet->rgb, sheet->width,
                   sheet->height, &p->error);
}

static void release(lighting *l) {
  contact_sheet_close(&l->sheet);
  for (int i = 0; i < PIPELINE_SLOTS; i++) {
    gbuffer_free(&l->slots[i].g);
    image_free(&l->slots[i].kept);
    image_free(&l->slots[i].result);
    free(l->slots[i].light.bytes);
  }
}

int process_frames(process *p) {
  lighting l = {.process = p};
  const pipeline stages = {.stages = {decode, light, encode},
                           .user = &l,
                           .items = (size_t)p->count,
                           .seconds = p->seconds};
  for (int i = 0; i < p->count; i++)
    l.needed += process_is_needed(p, &p->jobs[i]) ? 1u : 0u;
  progress_start(&l.progress, "frames", 0.0, p->options->quiet);
  const double start = progress_clock();
  int failed = open_sheet(&l) != 0 || pipeline_run(&stages, &p->error) != 0;
  p->wall = progress_clock() - start;
  p->lit = l.needed;
  progress_clear();
  if (!failed)
    failed = write_sheet(&l);
  release(&l);
  if (!failed && p->light.size)
    resume_done(p->options->output);
  return failed;
}
