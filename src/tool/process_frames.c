/* The frames of a job: while one is lit, the next is read and the last one
 * written. */
#include "tool/process_frames.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

slot *process_slot(lighting *l, size_t item) {
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

/* Told for the first frame that has any; the others are alike.  Frames are read
 * one after the other. */
static void look_for_mistakes(process *p, const job *j, const gbuffer *g) {
  selfcheck found;
  if (p->options->quiet || p->warned)
    return;
  selfcheck_frame(g, &p->config, &j->map.camera, &found);
  for (int i = 0; i < found.count; i++)
    process_warn(j->path, found.text[i]);
  p->warned = found.count > 0;
}

static int decode(void *user, size_t item, image_error *error) {
  lighting *l = user;
  process *p = l->process;
  job *j = &p->jobs[item];
  slot *s = process_slot(l, item);
  if (process_find_key(p, j, error) != 0)
    return -1;
  if (!process_is_needed(p, j))
    return 0;
  if (gbuffer_read(j->path, &j->map, used_roles(p), &s->g, error) != 0)
    return -1;
  look_for_mistakes(p, j, &s->g);
  if (p->options->keep && !j->finished && read_kept(p, j, &s->kept, error) != 0)
    return -1;
  s->hash = p->exact ? 0 : sequence_hash(p->sequence, &s->g);
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Light                                                                     */

/* Through the library or without it. */
static int light_planes(const process *p, size_t item, slot *s, image *result,
                        image_error *error) {
  const job *j = &p->jobs[item];
  float environment[9][3];
  const unsigned runs = p->options->repeat + (item ? 0 : p->options->warm_up);
  memcpy(environment, p->environment, sizeof environment);
  if (!p->exact)
    return sequence_run(p->sequence, &s->g, s->hash, &j->camera, environment,
                        runs, result, &p->rows[item], error);
  return exact_sequence_run(p->exact, &s->g, &j->camera, environment, runs,
                            result, error);
}

/* Bent normals go back into the world that the dump's header has. */
static void mirror_bent(image *result) {
  float *z = layers_plane(result, LAYER_BENT, 2);
  for (size_t i = 0; z && i < (size_t)result->width * result->height; i++)
    z[i] = -z[i];
}

/* Planes, once. */
static int make_layers(const process *p, uint32_t width, uint32_t height,
                       image *out) {
  return out->count ? 0 : layers_image(p->layers, width, height, out);
}

/* Lights a frame, and leaves of it what is to be written. */
static int light_window(lighting *l, size_t item, slot *s, image_error *error) {
  const process *p = l->process;
  const job *j = &p->jobs[item];
  const image_window *shown = &p->shown;
  const int all = shown->width == p->width && shown->height == p->height;
  image *lit = all ? &s->result : &l->whole;
  if (make_layers(p, p->width, p->height, lit) != 0 ||
      make_layers(p, shown->width, shown->height, &s->result) != 0)
    return image_no_memory(error, j->path);
  if (light_planes(p, item, s, lit, error) != 0)
    return -1;
  if (j->view.mirrored)
    mirror_bent(lit);
  for (size_t i = 0; !all && i < lit->count; i++)
    image_place(lit->planes[i].pixels, p->window, s->result.planes[i].pixels,
                *shown);
  s->result.x = shown->x;
  s->result.y = shown->y;
  s->result.display = p->jobs[0].map.display;
  return 0;
}

int process_hands_on(const process *p, size_t item) {
  return p->light.size && (int)item + 1 < p->end;
}

/* For the frames that are left, should this process not live to do them. */
static int take_light(const process *p, size_t item, slot *s,
                      image_error *error) {
  if (!process_hands_on(p, item))
    return 0;
  if (!s->light.bytes && !(s->light.bytes = malloc(p->light.size)))
    return image_no_memory(error, p->jobs[item].path);
  s->light.size = p->light.size;
  s->light.key = p->jobs[item].key;
  if (!p->exact)
    return sequence_take_light(p->sequence, s->light.bytes, error);
  exact_sequence_take_light(p->exact, s->light.bytes);
  return 0;
}

static int light(void *user, size_t item, image_error *error) {
  lighting *l = user;
  const process *p = l->process;
  const job *j = &p->jobs[item];
  slot *s = process_slot(l, item);
  p->rows[item].frame = j->path;
  if (!process_is_needed(p, j))
    return 0;
  const int failed = light_window(l, item, s, error) != 0 ||
                     take_light(p, item, s, error) != 0;
  gbuffer_free(&s->g);
  return failed ? -1 : 0;
}

/* ------------------------------------------------------------------------ */
/* All of them                                                               */

static void release(lighting *l) {
  contact_sheet_close(&l->sheet);
  image_free(&l->whole);
  for (int i = 0; i < PIPELINE_SLOTS; i++) {
    gbuffer_free(&l->slots[i].g);
    image_free(&l->slots[i].kept);
    image_free(&l->slots[i].result);
    free(l->slots[i].light.bytes);
  }
}

int process_frames(process *p) {
  lighting l = {.process = p};
  const pipeline stages = {.stages = {decode, light, process_encode},
                           .user = &l,
                           .items = (size_t)p->count,
                           .seconds = p->seconds};
  for (int i = 0; i < p->count; i++)
    l.needed += process_is_needed(p, &p->jobs[i]) ? 1u : 0u;
  progress_start(&l.progress, "frames", 0.0, p->options->quiet);
  const double start = progress_clock();
  int failed =
      process_open_sheet(&l) != 0 || pipeline_run(&stages, &p->error) != 0;
  p->wall = progress_clock() - start;
  p->lit = l.needed;
  progress_clear();
  if (!failed)
    failed = process_write_sheet(&l);
  release(&l);
  if (!failed && p->light.size)
    resume_done(p->options->output);
  return failed;
}
