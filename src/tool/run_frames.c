/* Takes the frames of a job through reading, computing and writing. */
#include "tool/run_frames.h"

#include "image/clock.h"
#include "image/error.h"
#include "image/image.h"
#include "image/window.h"
#include "tool/beauty.h"
#include "tool/frame_source.h"
#include "tool/report.h"
#include "tool/unknown.h"

#include <stdlib.h>
#include <string.h>

typedef struct layer_planes {
  image planes;
  image_memory memory; /* that they lie in */
} layer_planes;

/* What is read of a frame, until it is computed. */
typedef struct frame_read {
  image_memory memory; /* of the G-buffer's planes */
  gbuffer g;
} frame_read;

/* What is computed of a frame, until it is written. */
typedef struct frame_lit {
  layer_planes layers;
  saved_history history; /* that it hands on */
} frame_lit;

/* What belongs to a frame from the first stage to the last. */
typedef struct frame_own {
  uint64_t hash; /* of what the library is given */
  image copied;  /* channels of its own that go into the result */
} frame_own;

typedef struct run {
  const job *job;
  lighting *lighting;
  resume *resume;
  frame_source source;
  encoder *encoder;
  timing_row *rows;
  size_t depth; /* of the pipeline */
  frame_read read[PIPELINE_DEPTH];
  frame_lit lit[PIPELINE_DEPTH];
  frame_own own[PIPELINE_SLOTS];
  layer_planes whole;  /* computed pixels, if not all of them are written */
  layer_planes hidden; /* layers that are not written */
} run;

static frame_read *read_of(run *r, size_t item) {
  return &r->read[item % r->depth];
}

static frame_lit *lit_of(run *r, size_t item) {
  return &r->lit[item % r->depth];
}

static frame_own *own_of(run *r, size_t item) {
  return &r->own[item % PIPELINE_SLOTS];
}

/* ------------------------------------------------------------------------ */
/* Decode                                                                    */

static int decode(void *user, size_t item, image_error *error) {
  run *r = user;
  frame_read *f = read_of(r, item);
  frame_own *own = own_of(r, item);
  if (resume_find_key(r->resume, item, error) != 0)
    return -1;
  const int needed = resume_is_needed(r->resume, item);
  if (!needed && !resume_is_seen(r->resume, item))
    return 0;
  if (frame_source_read(&r->source, item, &f->memory, &f->g, error) != 0)
    return -1;
  if (!needed)
    return 0;
  if (r->job->settings->copy_channels && !r->resume->finished[item] &&
      frame_source_read_copied(&r->source, item, &own->copied, error) != 0)
    return -1;
  own->hash = lighting_hash(r->lighting, &f->g);
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Compute                                                                   */

/* Brings bent normals back into the left-handed world of the dump. */
static void mirror_bent_normals(image *result) {
  const size_t pixels = (size_t)result->width * result->height;
  float *z = layers_plane(result, LAYER_BENT_NORMAL, 2);
  uint16_t *halves = layers_halves(result, LAYER_BENT_NORMAL, 2);
  for (size_t i = 0; z && i < pixels; i++)
    z[i] = -z[i];
  for (size_t i = 0; halves && i < pixels; i++)
    halves[i] ^= 0x8000; /* the sign */
}

/* Light gets the frame's exposure again. */
static void expose(double exposure, image *result) {
  const size_t pixels = (size_t)result->width * result->height;
  for (int l = 0; l < LAYER_COUNT && exposure > 0.0; l++)
    for (size_t c = 0; c < strlen(layer_table[l].components); c++) {
      float *plane = layers_is_light((layer)l, c)
                         ? layers_plane(result, (layer)l, c)
                         : NULL;
      for (size_t i = 0; plane && i < pixels; i++)
        plane[i] *= (float)exposure;
    }
}

/* Allocates the planes the first time. */
static int make_layers(unsigned layers, unsigned halves, uint32_t width,
                       uint32_t height, layer_planes *out) {
  if (out->planes.count)
    return 0;
  image_memory_empty(&out->memory, layers_bytes(layers, halves, width, height));
  image_memory_select(&out->memory);
  const int failed = layers_image(layers, halves, width, height, &out->planes);
  image_memory_select(NULL);
  return failed;
}

static void free_layers(layer_planes *p) {
  image_free(&p->planes);
  image_memory_free(&p->memory);
}

/* Computes a frame; result gets the pixels that are written. */
static int compute_frame(run *r, size_t item, layer_planes *result,
                         image_error *error) {
  const job *j = r->job;
  const gbuffer *g = &read_of(r, item)->g;
  const image_window *shown = &j->shown;
  const unsigned halves = job_halves(j);
  const int all = shown->width == j->width && shown->height == j->height;
  layer_planes *to = all ? result : &r->whole;
  image *computed = &to->planes, *hidden = &r->hidden.planes;
  if (make_layers(j->layers, halves, j->width, j->height, to) != 0 ||
      make_layers(j->layers, halves, shown->width, shown->height, result) !=
          0 ||
      make_layers(j->hidden, 0, j->width, j->height, &r->hidden) != 0)
    return image_no_memory(error, j->frames[item].path);
  if (lighting_run(r->lighting, j, item, g, own_of(r, item)->hash, computed,
                   hidden, &r->rows[item], error) != 0)
    return -1;
  unknown_measure(j, g, layers_plane_of(computed, hidden, LAYER_UNKNOWN, 0),
                  &r->rows[item]);
  if (j->frames[item].seen.mirrored)
    mirror_bent_normals(computed);
  if (j->replaces)
    beauty_replace(g, hidden, computed);
  expose(j->frames[item].map.exposure, computed);
  for (size_t i = 0; !all && i < computed->count; i++)
    image_place(computed->planes[i].pixels, j->window,
                result->planes.planes[i].pixels, *shown);
  result->planes.x = shown->x;
  result->planes.y = shown->y;
  result->planes.display = j->display;
  return 0;
}

/* Takes the history that the frame hands on, should this process not live to
 * use it. */
static int take_history(run *r, size_t item, saved_history *h,
                        image_error *error) {
  if (!resume_hands_on(r->resume, item))
    return 0;
  h->size = r->resume->history_size;
  if (!h->bytes && !(h->bytes = malloc(h->size)))
    return image_no_memory(error, r->job->frames[item].path);
  h->key = r->resume->keys[item];
  return lighting_history_save(r->lighting, h->bytes, error);
}

static int compute(void *user, size_t item, image_error *error) {
  run *r = user;
  gbuffer *g = &read_of(r, item)->g;
  frame_lit *f = lit_of(r, item);
  r->rows[item].frame = r->job->frames[item].path;
  int failed = 0;
  if (resume_is_needed(r->resume, item))
    failed = compute_frame(r, item, &f->layers, error) != 0 ||
             take_history(r, item, &f->history, error) != 0;
  else if (resume_is_seen(r->resume, item))
    failed = lighting_see(r->lighting, r->job->frames[item].path, g, error);
  gbuffer_free(g);
  return failed ? -1 : 0;
}

/* ------------------------------------------------------------------------ */
/* Encode                                                                    */

static int encode(void *user, size_t item, image_error *error) {
  run *r = user;
  frame_lit *f = lit_of(r, item);
  if (encode_frame(r->encoder, item, &f->layers.planes,
                   &own_of(r, item)->copied, error) != 0)
    return -1;
  if (!resume_is_needed(r->resume, item) || !resume_hands_on(r->resume, item))
    return 0;
  f->history.exposure = r->resume->exposure;
  return saved_history_write(r->resume->history_path, &f->history, error);
}

/* ------------------------------------------------------------------------ */
/* All frames                                                                */

static void release(run *r) {
  free_layers(&r->whole);
  free_layers(&r->hidden);
  for (int i = 0; i < PIPELINE_DEPTH; i++) {
    gbuffer_free(&r->read[i].g);
    image_memory_free(&r->read[i].memory);
    free_layers(&r->lit[i].layers);
    free(r->lit[i].history.bytes);
  }
  for (int i = 0; i < PIPELINE_SLOTS; i++)
    image_free(&r->own[i].copied);
}

/* Frames of so many bytes, planes that are read and layers, are in memory one
 * at a time in each stage, with others twice as many.  1 GiB in all serves
 * pictures of 2560 x 1440 pixels; larger ones take so long in each stage that
 * all processors are busy there. */
static size_t depth_of(const job *j) {
  const size_t most = (size_t)1 << 30;
  const size_t frame =
      frame_source_bytes(j, 0) +
      layers_bytes(j->layers, job_halves(j), j->shown.width, j->shown.height);
  return frame > most / PIPELINE_DEPTH ? 1 : PIPELINE_DEPTH;
}

/* Shows what the radiance cache knows in the end. */
static int show_cache(run *r, image_error *error) {
  void *bytes;
  size_t size;
  if (!encoder_shows_cache(r->encoder))
    return 0;
  if (lighting_cache_bytes(r->lighting, &bytes, &size, error) != 0)
    return -1;
  const int failed = encoder_show_cache(r->encoder, bytes, size, error);
  free(bytes);
  return failed;
}

static int run_all(run *r, frame_times *times, image_error *error) {
  const pipeline stages = {.stages = {decode, compute, encode},
                           .user = r,
                           .items = (size_t)r->job->count,
                           .depth = r->depth,
                           .seconds = times->stages + r->job->before};
  if (encoder_begin(r->encoder, r->job, r->resume, error) != 0)
    return -1;
  const double start = seconds_now();
  const int failed = pipeline_run(&stages, error);
  times->wall += seconds_now() - start;
  times->computed = r->encoder->needed;
  progress_clear();
  return failed != 0 ? failed : show_cache(r, error);
}

/* With all frames done, nothing is to be continued: neither this job nor one
 * that was killed and began with another of these frames. */
static void remove_histories(const job *j) {
  for (int i = (int)j->pre_roll; i < j->count; i++) {
    char *path = job_history_path(j, i);
    if (path)
      saved_history_remove(path);
    free(path);
  }
}

int frame_times_make(frame_times *times, const job *whole, image_error *error) {
  memset(times, 0, sizeof *times);
  times->rows = calloc((size_t)whole->count, sizeof *times->rows);
  times->stages = calloc((size_t)whole->count, sizeof *times->stages);
  return times->rows && times->stages
             ? 0
             : image_no_memory(error, whole->frames[0].path);
}

int run_frames(const job *j, first_frame *first, lighting *l, resume *r,
               encoder *e, frame_times *times, image_error *error) {
  run all = {.job = j,
             .lighting = l,
             .resume = r,
             .source = {.job = j, .first = first},
             .encoder = e,
             .rows = times->rows + j->before,
             .depth = depth_of(j)};
  const int failed = run_all(&all, times, error);
  release(&all);
  if (failed == 0)
    remove_histories(j);
  return failed;
}

void frame_times_free(frame_times *times) {
  free(times->rows);
  free(times->stages);
  memset(times, 0, sizeof *times);
}
