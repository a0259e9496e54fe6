#define _POSIX_C_SOURCE 200809L
#include "image/exr_decode.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <unistd.h>

#include "image/exr_inflate.h"

/* Decodes chunks of a part, in any order. */
typedef struct decoder {
  const exr_file *file;
  int part;
  const image *img;
  const exr_source *sources; /* one for each plane of img */
  exr_decode_pipeline_t pipeline;
  exr_inflate inflate;
  int started;
} decoder;

/* Makes the pipeline write the wanted channels into their planes, beginning at
 * pixel (x,y).  Returns the number of wanted channels. */
static int set_destinations(decoder *d, size_t x, size_t y) {
  const size_t first = y * d->img->width + x;
  int wanted = 0;
  for (size_t i = 0; i < d->img->count; i++) {
    if (d->sources[i].part != d->part)
      continue;
    exr_coding_channel_info_t *channel =
        &d->pipeline.channels[d->sources[i].channel];
    channel->decode_to_ptr = (uint8_t *)(d->img->planes[i].pixels + first);
    channel->user_data_type =
        d->img->planes[i].type == IMAGE_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
    channel->user_bytes_per_element = sizeof(float);
    channel->user_pixel_stride = sizeof(float);
    channel->user_line_stride = (int32_t)(d->img->width * sizeof(float));
    wanted++;
  }
  return wanted;
}

/*
 * OpenEXRCore 3.1 has fast unpacking routines for parts with three or four
 * channels.  They ignore which channels are wanted: they also write halves to
 * the unset destinations of the others.  The library does not choose these
 * routines if the pixel stride is one that they can't handle, so such a stride
 * is set here while it chooses.
 */
static exr_result_t choose_routines(decoder *d, int wanted) {
  for (int i = 0; i < d->pipeline.channel_count; i++)
    if (wanted < d->pipeline.channel_count)
      d->pipeline.channels[i].user_pixel_stride = 2 * sizeof(float);
  const exr_result_t result = exr_decoding_choose_default_routines(
      d->file->context, d->part, &d->pipeline);
  return result == EXR_ERR_SUCCESS
             ? exr_inflate_start(&d->inflate, &d->pipeline)
             : result;
}

/* Decodes a chunk whose top left pixel is (x,y) in the image. */
static exr_result_t decode_chunk(decoder *d, const exr_chunk_info_t *chunk,
                                 size_t x, size_t y) {
  exr_context_t context = d->file->context;
  exr_result_t result =
      d->started
          ? exr_decoding_update(context, d->part, chunk, &d->pipeline)
          : exr_decoding_initialize(context, d->part, chunk, &d->pipeline);
  if (result != EXR_ERR_SUCCESS)
    return result;
  const int wanted = set_destinations(d, x, y);
  if (!d->started) {
    d->started = 1;
    result = choose_routines(d, wanted);
    set_destinations(d, x, y); /* restores the true stride */
  }
  return result == EXR_ERR_SUCCESS
             ? exr_decoding_run(context, d->part, &d->pipeline)
             : result;
}

/* Decodes the chunk that begins with this line. */
static exr_result_t decode_lines(decoder *d, int64_t y) {
  const exr_file *f = d->file;
  exr_chunk_info_t chunk;
  const exr_result_t result =
      exr_read_scanline_chunk_info(f->context, d->part, (int)y, &chunk);
  return result == EXR_ERR_SUCCESS
             ? decode_chunk(d, &chunk, 0, (size_t)(y - f->window.min.y))
             : result;
}

static exr_result_t decode_scanlines(decoder *d) {
  const exr_file *f = d->file;
  int32_t lines = 0;
  exr_result_t result =
      exr_get_scanlines_per_chunk(f->context, d->part, &lines);
  if (result == EXR_ERR_SUCCESS && lines < 1)
    result = EXR_ERR_INVALID_ATTR;
  for (int64_t y = f->window.min.y;
       result == EXR_ERR_SUCCESS && y <= f->window.max.y; y += lines)
    result = decode_lines(d, y);
  return result;
}

static exr_result_t decode_tiles(decoder *d) {
  const exr_file *f = d->file;
  int32_t width = 0, height = 0;
  exr_result_t result =
      exr_get_tile_sizes(f->context, d->part, 0, 0, &width, &height);
  if (result == EXR_ERR_SUCCESS && (width < 1 || height < 1))
    result = EXR_ERR_INVALID_ATTR;
  for (uint32_t y = 0; result == EXR_ERR_SUCCESS && y < d->img->height;
       y += (uint32_t)height)
    for (uint32_t x = 0; result == EXR_ERR_SUCCESS && x < d->img->width;
         x += (uint32_t)width) {
      exr_chunk_info_t chunk;
      result = exr_read_tile_chunk_info(
          f->context, d->part, (int)(x / (uint32_t)width),
          (int)(y / (uint32_t)height), 0, 0, &chunk);
      if (result == EXR_ERR_SUCCESS)
        result = decode_chunk(d, &chunk, x, y);
    }
  return result;
}

static void decoder_close(decoder *d) {
  if (d->started)
    exr_decoding_destroy(d->file->context, &d->pipeline);
  exr_inflate_end(&d->inflate);
}

static exr_result_t decode_part(decoder *d, exr_storage_t storage) {
  const exr_result_t result =
      storage == EXR_STORAGE_TILED ? decode_tiles(d) : decode_scanlines(d);
  decoder_close(d);
  return result;
}

/* ------------------------------------------------------------------------ */
/* Threads                                                                   */

/* Threads at most; bytes of an image below which one is enough. */
enum { MOST_THREADS = 16, FEW_BYTES = 1 << 20 };

/* What all threads share. */
typedef struct team {
  int32_t lines;      /* of a chunk */
  atomic_llong chunk; /* the next one to be decoded */
  atomic_int has_failed;
} team;

typedef struct member {
  team *team;
  decoder decoder;
  exr_budget budget; /* its share of the file's */
  pthread_t thread;
} member;

static void *decode_some(void *user) {
  member *m = user;
  const exr_file *f = m->decoder.file;
  budget_select(&m->budget);
  for (;;) {
    const int64_t y =
        f->window.min.y + atomic_fetch_add(&m->team->chunk, 1) * m->team->lines;
    if (y > f->window.max.y || atomic_load(&m->team->has_failed))
      break;
    if (decode_lines(&m->decoder, y) != EXR_ERR_SUCCESS)
      atomic_store(&m->team->has_failed, 1);
  }
  decoder_close(&m->decoder);
  budget_select(NULL);
  return NULL;
}

/* How many threads are worth it. */
static int threads_for(const exr_file *f, const image *img) {
  const long cpus = sysconf(_SC_NPROCESSORS_ONLN);
  if (sizeof(float) * img->count * f->width * f->height < FEW_BYTES)
    return 1;
  return cpus < 1 ? 1 : cpus < MOST_THREADS ? (int)cpus : MOST_THREADS;
}

/* Decodes on several threads.  Returns 0 if they could not decode everything,
 * which says nothing of why: that depends on which of them was faster. */
static int decode_together(exr_file *f, const decoder *d, int count) {
  team t = {.lines = 0};
  member members[MOST_THREADS];
  exr_chunk_info_t first;
  int started = 1;
  /* makes the library read the table of chunks, which belongs to the file */
  if (exr_get_scanlines_per_chunk(f->context, d->part, &t.lines) !=
          EXR_ERR_SUCCESS ||
      t.lines < 1 ||
      exr_read_scanline_chunk_info(f->context, d->part, f->window.min.y,
                                   &first) != EXR_ERR_SUCCESS)
    return 0;
  const size_t share = (f->budget.limit - f->budget.held) / (size_t)count;
  for (int i = 0; i < count; i++)
    members[i] =
        (member){.team = &t, .decoder = *d, .budget = {.limit = share}};
  while (started < count && pthread_create(&members[started].thread, NULL,
                                           decode_some, &members[started]) == 0)
    started++;
  decode_some(&members[0]);
  for (int i = 1; i < started; i++)
    pthread_join(members[i].thread, NULL);
  budget_select(&f->budget);
  return !atomic_load(&t.has_failed);
}

int exr_decode(exr_file *f, int part, const image *img,
               const exr_source *sources) {
  decoder d = {.file = f, .part = part, .img = img, .sources = sources};
  exr_storage_t storage = EXR_STORAGE_SCANLINE;
  exr_get_storage(f->context, part, &storage);
  const int threads = storage == EXR_STORAGE_SCANLINE ? threads_for(f, img) : 1;
  if (threads > 1) {
    f->stream.is_mute = 1;
    const int done = decode_together(f, &d, threads);
    f->stream.is_mute = 0;
    if (done)
      return 0;
  }
  /* one thread finds the same error in every run */
  const exr_result_t result = decode_part(&d, storage);
  return result == EXR_ERR_SUCCESS
             ? 0
             : exr_file_fail(f, EXR_DAMAGED_PIXELS, result);
}
