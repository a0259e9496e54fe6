/* Takes the frames of a job through reading, computing and writing. */
#include "tool/run_frames.h"

#include "image/clock.h"
#include "image/error.h"
#include "image/image.h"
#include "image/window.h"
#include "tool/encode.h"
#include "tool/frame_source.h"
#include "tool/report.h"
#include "tool/unknown.h"

#include <stdlib.h>
#include <string.h>

/* What belongs to a frame while it is in the pipeline. */
typedef struct slot {
  gbuffer g;
  uint64_t hash; /* of what the library is given */
  image copied;  /* channels of its own that go into the result */
  image result;
  saved_history history; /* that it hands on */
} slot;

typedef struct run {
  const job *job;
  lighting *lighting;
  resume *resume;
  frame_source source;
  encoder encoder;
  timing_row *rows;
  slot slots[PIPELINE_SLOTS];
  image whole;  /* computed pixels, if not all of them are written */
  image hidden; /* layers that are not written */
} run;

static slot *slot_of(run *r, size_t item) {
  return &r->slots[item % PIPELINE_SLOTS];
}

/* ------------------------------------------------------------------------ */
/* Decode                                                                    */

static int decode(void *user, size_t item, image_error *error) {
  run *r = user;
  slot *s = slot_of(r, item);
  if (resume_find_key(r->resume, item, error) != 0)
    return -1;
  const int needed = resume_is_needed(r->resume, item);
  if (!needed && !resume_is_seen(r->resume, item))
    return 0;
  if (frame_source_read(&r->source, item, &s->g, error) != 0)
    return -1;
  if (!needed)
    return 0;
  if (r->job->settings->copy_channels && !r->resume->finished[item] &&
      frame_source_read_copied(&r->source, item, &s->copied, error) != 0)
    return -1;
  s->hash = lighting_hash(r->lighting, &s->g);
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Compute                                                                   */

/* Brings bent normals back into the left-handed world of the dump. */
static void mirror_bent_normals(image *result) {
  float *z = layers_plane(result, LAYER_BENT_NORMAL, 2);
  for (size_t i = 0; z && i < (size_t)result->width * result->height; i++)
    z[i] = -z[i];
}

/* Allocates the planes the first time. */
static int make_layers(unsigned layers, uint32_t width, uint32_t height,
                       image *out) {
  return out->count ? 0 : layers_image(layers, width, height, out);
}

/* Computes a frame; s->result gets the pixels that are written. */
static int compute_frame(run *r, size_t item, slot *s, image_error *error) {
  const job *j = r->job;
  const image_window *shown = &j->shown;
  const int all = shown->width == j->width && shown->height == j->height;
  image *computed = all ? &s->result : &r->whole;
  if (make_layers(j->layers, j->width, j->height, computed) != 0 ||
      make_layers(j->layers, shown->width, shown->height, &s->result) != 0 ||
      make_layers(j->hidden, j->width, j->height, &r->hidden) != 0)
    return image_no_memory(error, j->frames[item].path);
  if (lighting_run(r->lighting, j, item, &s->g, s->hash, computed, &r->hidden,
                   &r->rows[item], error) != 0)
    return -1;
  unknown_measure(j, &s->g,
                  layers_plane_of(computed, &r->hidden, LAYER_UNKNOWN, 0),
                  &r->rows[item]);
  if (j->frames[item].seen.mirrored)
    mirror_bent_normals(computed);
  for (size_t i = 0; !all && i < computed->count; i++)
    image_place(computed->planes[i].pixels, j->window,
                s->result.planes[i].pixels, *shown);
  s->result.x = shown->x;
  s->result.y = shown->y;
  s->result.display = j->frames[0].map.display;
  return 0;
}

/* Takes the history that the frame hands on, should this process not live to
 * use it. */
static int take_history(run *r, size_t item, slot *s, image_error *error) {
  saved_history *h = &s->history;
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
  slot *s = slot_of(r, item);
  r->rows[item].frame = r->job->frames[item].path;
  int failed = 0;
  if (resume_is_needed(r->resume, item))
    failed = compute_frame(r, item, s, error) != 0 ||
             take_history(r, item, s, error) != 0;
  else if (resume_is_seen(r->resume, item))
    failed = lighting_see(r->lighting, r->job->frames[item].path, &s->g, error);
  gbuffer_free(&s->g);
  return failed ? -1 : 0;
}

/* ------------------------------------------------------------------------ */
/* Encode                                                                    */

static int encode(void *user, size_t item, image_error *error) {
  run *r = user;
  slot *s = slot_of(r, item);
  if (encode_frame(&r->encoder, item, &s->result, &s->copied, error) != 0)
    return -1;
  if (!resume_is_needed(r->resume, item) || !resume_hands_on(r->resume, item))
    return 0;
  s->history.exposure = r->resume->exposure;
  return saved_history_write(r->resume->history_path, &s->history, error);
}

/* ------------------------------------------------------------------------ */
/* All frames                                                                */

static void release(run *r) {
  encoder_close(&r->encoder);
  image_free(&r->whole);
  image_free(&r->hidden);
  for (int i = 0; i < PIPELINE_SLOTS; i++) {
    gbuffer_free(&r->slots[i].g);
    image_free(&r->slots[i].copied);
    image_free(&r->slots[i].result);
    free(r->slots[i].history.bytes);
  }
}

/* Shows what the radiance cache knows in the end. */
static int show_cache(run *r, image_error *error) {
  void *bytes;
  size_t size;
  if (!encoder_shows_cache(&r->encoder))
    return 0;
  if (lighting_cache_bytes(r->lighting, &bytes, &size, error) != 0)
    return -1;
  const int failed = encoder_show_cache(&r->encoder, bytes, size, error);
  free(bytes);
  return failed;
}

static int run_all(run *r, frame_times *times, image_error *error) {
  const pipeline stages = {.stages = {decode, compute, encode},
                           .user = r,
                           .items = (size_t)r->job->count,
                           .seconds = times->stages};
  if (encoder_open(&r->encoder, error) != 0)
    return -1;
  const double start = seconds_now();
  const int failed = pipeline_run(&stages, error);
  times->wall = seconds_now() - start;
  times->computed = r->encoder.needed;
  progress_clear();
  return failed != 0                 ? failed
         : show_cache(r, error) != 0 ? -1
                                     : encoder_finish(&r->encoder, error);
}

/* With all frames done, nothing is to be continued: neither this job nor one
 * that was killed and began with another of these frames. */
static void remove_histories(const job *j) {
  for (int i = (int)j->settings->pre_roll; i < j->count; i++) {
    char *path = job_history_path(j, i);
    if (path)
      saved_history_remove(path);
    free(path);
  }
}

int run_frames(const job *j, first_frame *first, lighting *l, resume *r,
               frame_times *times, image_error *error) {
  memset(times, 0, sizeof *times);
  times->rows = calloc((size_t)j->count, sizeof *times->rows);
  times->stages = calloc((size_t)j->count, sizeof *times->stages);
  if (!times->rows || !times->stages)
    return image_no_memory(error, j->frames[0].path);
  run all = {.job = j,
             .lighting = l,
             .resume = r,
             .source = {.job = j, .first = first},
             .encoder = {.job = j, .resume = r, .lines = j->settings->exact},
             .rows = times->rows};
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
