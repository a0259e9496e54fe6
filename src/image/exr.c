/*
 * OpenEXR files read through OpenEXRCore.
 *
 * Files are opened here and handed to the library as streams, so that errno is
 * known when a file cannot be opened and every message ends up in image_error.
 */
#define _POSIX_C_SOURCE 200809L
#include "image/exr_dwa.h"
#include "image/image.h"

#include <openexr.h>

#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A header may claim any size; beyond these it is damaged, not an image. */
#define MAX_PIXELS ((uint64_t)1 << 28)
#define MAX_SIDE (1 << 24)
#define MAX_TILE (1 << 16)
#define MAX_CHANNELS 4096

#define DAMAGED_PIXELS "truncated or damaged pixel data"

typedef struct stream {
  const char *path;
  int fd;
  char message[512]; /* the library's first complaint: others follow from it */
} stream;

static void keep_message(exr_const_context_t context, exr_result_t code,
                         const char *message) {
  void *user = NULL;
  (void)code;
  if (context && exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user) {
    stream *s = user;
    if (!s->message[0])
      snprintf(s->message, sizeof s->message, "%s", message);
  }
}

static int64_t stream_size(exr_const_context_t context, void *user) {
  struct stat status;
  (void)context;
  return fstat(((stream *)user)->fd, &status) == 0 ? (int64_t)status.st_size
                                                   : -1;
}

/* Bytes up to the end of the file; fewer than asked for is the caller's to
 * judge. */
static int64_t stream_read(exr_const_context_t context, void *user, void *data,
                           uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t report) {
  uint64_t done = 0;
  while (done < size) {
    ssize_t n = pread(((stream *)user)->fd, (char *)data + done,
                      (size_t)(size - done), (off_t)(offset + done));
    if (n < 0 && errno == EINTR)
      continue;
    if (n < 0) {
      report(context, EXR_ERR_READ_IO, "%s", strerror(errno));
      return -1;
    }
    if (n == 0)
      break;
    done += (uint64_t)n;
  }
  return (int64_t)done;
}

/*
 * What the library holds for one file.  Damaged headers ask for absurd chunks;
 * those are refused, not tried.
 */
typedef struct budget {
  size_t held, limit; /* bytes */
  int exceeded;
} budget;

/* The library's allocators are told nothing but a size, so the file that a
 * thread is at work on is noted here.  NULL: no limit. */
static _Thread_local budget *current;

/* In front of each allocation. */
typedef union block {
  size_t size;
  max_align_t align;
} block;

static void *budget_take(size_t size) {
  budget *b = current;
  if (b && size > b->limit - b->held) {
    b->exceeded = 1;
    return NULL;
  }
  block *taken =
      size <= SIZE_MAX - sizeof *taken ? malloc(sizeof *taken + size) : NULL;
  if (!taken)
    return NULL;
  taken->size = size;
  if (b)
    b->held += size;
  return taken + 1;
}

static void budget_give(void *memory) {
  block *taken = memory;
  if (!taken)
    return;
  if (current)
    current->held -= taken[-1].size;
  free(taken - 1);
}

static exr_context_initializer_t initializer(stream *s) {
  exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
  init.error_handler_fn = keep_message;
  init.alloc_fn = budget_take;
  init.free_fn = budget_give;
  init.user_data = s;
  init.read_fn = stream_read;
  init.size_fn = stream_size;
  init.max_image_width = init.max_image_height = MAX_SIDE;
  init.max_tile_width = init.max_tile_height = MAX_TILE;
  init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
  return init;
}

static const char *complaint(const stream *s, exr_result_t result) {
  return s->message[0] ? s->message : exr_get_default_error_message(result);
}

/* ------------------------------------------------------------------------ */
/* Reading                                                                   */

typedef struct reader {
  stream stream;
  exr_context_t context;
  budget memory;
  int parts;
  exr_attr_box2i_t window; /* of the first flat part */
  size_t channels;         /* of all parts with that window */
  image_error *error;
} reader;

static void reader_close(reader *r) {
  if (r->context)
    exr_finish(&r->context);
  current = NULL;
  if (r->stream.fd >= 0)
    close(r->stream.fd);
}

/* Why the library gave up. */
static int library_failed(const reader *r, const char *what,
                          exr_result_t result) {
  if (r->memory.exceeded)
    return image_fail(r->error,
                      "%s: %s, or one that needs more memory than 4 times its "
                      "image and %d MiB; a complete file is needed",
                      r->stream.path, what, EXR_SPARE_MEMORY >> 20);
  return image_fail(r->error, "%s: %s (%s); a complete file is needed",
                    r->stream.path, what, complaint(&r->stream, result));
}

static int check_kind(reader *r) {
  static const unsigned char magic[4] = {0x76, 0x2f, 0x31, 0x01};
  unsigned char start[4];
  struct stat status;
  if (fstat(r->stream.fd, &status) != 0 || !S_ISREG(status.st_mode))
    return image_fail(r->error,
                      "%s: not a regular file; an OpenEXR file is "
                      "needed",
                      r->stream.path);
  if (pread(r->stream.fd, start, sizeof start, 0) != (ssize_t)sizeof start ||
      memcmp(start, magic, sizeof magic) != 0)
    return image_fail(r->error,
                      "%s: not an OpenEXR file; an .exr is needed, or a "
                      "PNG, TIFF or HDR file where it serves",
                      r->stream.path);
  return 0;
}

static int is_flat(reader *r, int part) {
  exr_storage_t storage;
  return exr_get_storage(r->context, part, &storage) == EXR_ERR_SUCCESS &&
         (storage == EXR_STORAGE_SCANLINE || storage == EXR_STORAGE_TILED);
}

static int64_t extent(int32_t low, int32_t high) {
  return (int64_t)high - low + 1;
}

/* Takes the size from the first flat part. */
static int find_window(reader *r) {
  int part = 0;
  while (part < r->parts && !is_flat(r, part))
    part++;
  if (part == r->parts)
    return image_fail(r->error,
                      "%s: holds deep data only; flat pixels are "
                      "needed",
                      r->stream.path);
  if (exr_get_data_window(r->context, part, &r->window) != EXR_ERR_SUCCESS)
    return image_fail(r->error, "%s: has no data window; the file is damaged",
                      r->stream.path);
  const int64_t width = extent(r->window.min.x, r->window.max.x);
  const int64_t height = extent(r->window.min.y, r->window.max.y);
  if (width < 1 || height < 1 ||
      (uint64_t)width > MAX_PIXELS / (uint64_t)height)
    return image_fail(r->error,
                      "%s: claims %lld x %lld pixels; at most %llu pixels are "
                      "read",
                      r->stream.path, (long long)width, (long long)height,
                      (unsigned long long)MAX_PIXELS);
  return 0;
}

/* The channels of a part that can be read together with the first, or NULL. */
static const exr_attr_chlist_t *part_channels(reader *r, int part) {
  const exr_attr_chlist_t *channels = NULL;
  exr_attr_box2i_t window;
  if (!is_flat(r, part) ||
      exr_get_data_window(r->context, part, &window) != EXR_ERR_SUCCESS ||
      memcmp(&window, &r->window, sizeof window) != 0 ||
      exr_get_channels(r->context, part, &channels) != EXR_ERR_SUCCESS)
    return NULL;
  return channels;
}

static size_t pixels(const reader *r) {
  return (size_t)extent(r->window.min.x, r->window.max.x) *
         (size_t)extent(r->window.min.y, r->window.max.y);
}

/* Now that the image is known, so is what may be held for it: our planes are
 * one of its four times. */
static int count_channels(reader *r) {
  for (int part = 0; part < r->parts; part++) {
    const exr_attr_chlist_t *channels = part_channels(r, part);
    r->channels += channels ? (size_t)channels->num_channels : 0;
  }
  if (r->channels > MAX_CHANNELS)
    return image_fail(r->error, "%s: claims %zu channels; at most %d are read",
                      r->stream.path, r->channels, MAX_CHANNELS);
  r->memory.limit += 3 * sizeof(float) * r->channels * pixels(r);
  return 0;
}

static int reader_parse(reader *r) {
  const exr_context_initializer_t init = initializer(&r->stream);
  r->memory.limit = EXR_SPARE_MEMORY;
  current = &r->memory;
  exr_result_t result = exr_start_read(&r->context, r->stream.path, &init);
  if (result == EXR_ERR_SUCCESS)
    result = exr_get_count(r->context, &r->parts);
  /* The library goes on behind what it can't parse, with an image of 64 x 64
   * pixels in place of what it didn't find. */
  if (result != EXR_ERR_SUCCESS || r->stream.message[0])
    return library_failed(r, "damaged OpenEXR header", result);
  return find_window(r) != 0 || count_channels(r) != 0 ? -1 : 0;
}

static int reader_open(reader *r, const char *path, image_error *error) {
  memset(r, 0, sizeof *r);
  r->error = error;
  r->stream.path = path;
  r->stream.fd = open(path, O_RDONLY);
  if (r->stream.fd < 0)
    return image_fail(error,
                      "%s: cannot be read: %s; an OpenEXR file is "
                      "needed",
                      path, strerror(errno));
  if (check_kind(r) != 0 || reader_parse(r) != 0) {
    reader_close(r);
    return -1;
  }
  return 0;
}

/* PART.CHANNEL, the name of a channel whose own name is taken. */
static void qualified_name(reader *r, int part, const char *channel, char *name,
                           size_t size) {
  const char *part_name = NULL;
  if (exr_get_name(r->context, part, &part_name) != EXR_ERR_SUCCESS ||
      !part_name)
    part_name = "";
  snprintf(name, size, "%s.%s", part_name, channel);
}

static void read_key(reader *r, image *out) {
  const char *key = NULL;
  int32_t length = 0;
  if (exr_attr_get_string(r->context, 0, EXR_KEY, &length, &key) ==
          EXR_ERR_SUCCESS &&
      key && length >= 0)
    snprintf(out->key, sizeof out->key, "%.*s", (int)length, key);
}

static void set_size(const reader *r, image *out) {
  memset(out, 0, sizeof *out);
  out->x = r->window.min.x;
  out->y = r->window.min.y;
  out->width = (uint32_t)extent(r->window.min.x, r->window.max.x);
  out->height = (uint32_t)extent(r->window.min.y, r->window.max.y);
}

/* One that claims more than can be read is none. */
static void read_display(reader *r, image *out) {
  exr_attr_box2i_t box;
  if (exr_get_display_window(r->context, 0, &box) != EXR_ERR_SUCCESS)
    return;
  const int64_t width = extent(box.min.x, box.max.x);
  const int64_t height = extent(box.min.y, box.max.y);
  if (width >= 1 && height >= 1 && width <= MAX_SIDE && height <= MAX_SIDE)
    out->display =
        (image_window){box.min.x, box.min.y, (uint32_t)width, (uint32_t)height};
}

static int read_matrix(const reader *r, const char *name, double out[16]) {
  exr_attr_m44f_t m;
  if (exr_attr_get_m44f(r->context, 0, name, &m) != EXR_ERR_SUCCESS)
    return 0;
  for (int i = 0; i < 16; i++)
    out[i] = (double)m.m[i];
  return 1;
}

/* Appends a word to what is known of the program. */
static void add_origin(image *out, const char *word, size_t length) {
  const size_t used = strlen(out->origin);
  snprintf(out->origin + used, sizeof out->origin - used, "%s%.*s",
           used ? " " : "", (int)length, word);
}

/* Programs sign with a text, or put their name in front of a slash. */
static void read_origin(const reader *r, image *out) {
  static const char *const signs[] = {"Software", "software", "generatedBy",
                                      "BlenderMultiChannel"};
  int32_t count = 0;
  for (size_t i = 0; i < sizeof signs / sizeof *signs; i++) {
    const char *text = NULL;
    int32_t length = 0;
    if (exr_attr_get_string(r->context, 0, signs[i], &length, &text) ==
            EXR_ERR_SUCCESS &&
        text && length >= 0)
      add_origin(out, text, (size_t)length);
  }
  exr_get_attribute_count(r->context, 0, &count);
  for (int32_t i = 0; i < count; i++) {
    const exr_attribute_t *attribute = NULL;
    if (exr_get_attribute_by_index(r->context, 0, EXR_ATTR_LIST_FILE_ORDER, i,
                                   &attribute) != EXR_ERR_SUCCESS)
      return;
    const char *slash = strchr(attribute->name, '/');
    if (slash) {
      add_origin(out, attribute->name, (size_t)(slash - attribute->name));
      return;
    }
  }
}

static void read_attributes(reader *r, image *out) {
  image_matrices *m = &out->matrices;
  read_key(r, out);
  read_display(r, out);
  m->has_camera = read_matrix(r, "worldToCamera", m->world_to_camera);
  m->has_ndc = read_matrix(r, "worldToNDC", m->world_to_ndc);
  read_origin(r, out);
  /* asking for what isn't there is no complaint about the file */
  r->stream.message[0] = '\0';
}

static int list_part(reader *r, int part, image *out) {
  const exr_attr_chlist_t *channels = part_channels(r, part);
  for (int i = 0; channels && i < channels->num_channels; i++) {
    char name[sizeof out->planes->name];
    const char *plain = channels->entries[i].name.str;
    snprintf(name, sizeof name, "%s", plain);
    if (image_find(out, name) || (part > 0 && !strchr(plain, '.')))
      qualified_name(r, part, plain, name, sizeof name);
    if (!image_find(out, name) && !image_declare(out, name))
      return image_no_memory(r->error, r->stream.path);
  }
  return 0;
}

int exr_read_header(const char *path, image *out, image_error *error) {
  reader r;
  int failed = 0;
  memset(out, 0, sizeof *out);
  if (reader_open(&r, path, error) != 0)
    return -1;
  set_size(&r, out);
  read_attributes(&r, out);
  for (int part = 0; part < r.parts && !failed; part++)
    failed = list_part(&r, part, out);
  reader_close(&r);
  if (failed)
    image_free(out);
  return failed;
}

/* Where a wanted plane is found. */
typedef struct source {
  int part;
  int channel; /* of the part's list, which the decoder follows */
  image_type type;
} source;

static image_type type_of(const exr_attr_chlist_entry_t *entry) {
  return entry->pixel_type == EXR_PIXEL_UINT   ? IMAGE_UINT
         : entry->pixel_type == EXR_PIXEL_HALF ? IMAGE_HALF
                                               : IMAGE_FLOAT;
}

static int find_source(reader *r, const char *wanted, source *out) {
  for (int pass = 0; pass < 2; pass++) /* plain names go first */
    for (int part = 0; part < r->parts; part++) {
      const exr_attr_chlist_t *channels = part_channels(r, part);
      for (int i = 0; channels && i < channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &channels->entries[i];
        char name[sizeof((image_plane *)0)->name];
        snprintf(name, sizeof name, "%s", entry->name.str);
        if (pass)
          qualified_name(r, part, entry->name.str, name, sizeof name);
        if (strcmp(name, wanted) != 0)
          continue;
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
          return image_fail(r->error,
                            "%s: channel %s is subsampled; a value "
                            "for every pixel is needed",
                            r->stream.path, wanted);
        *out = (source){part, i, type_of(entry)};
        return 0;
      }
    }
  return image_fail(r->error, "%s: has no channel %s (see hbil info)",
                    r->stream.path, wanted);
}

/* A decoder of one part, used for chunk after chunk. */
typedef struct decoder {
  reader *reader;
  int part;
  const image *img;
  const source *sources; /* one for each plane of img */
  exr_decode_pipeline_t pipeline;
  int started;
} decoder;

/* Points the wanted channels at the pixel (x,y) of their planes; returns how
 * many they are. */
static int aim(decoder *d, size_t x, size_t y) {
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
 * Of a part with three or four channels OpenEXRCore's quick routines write all,
 * as halves, even if only some of them are wanted, to where the others don't
 * point.  A stride that these routines don't know keeps them away; aim() puts
 * it right again.
 */
static exr_result_t choose_routines(decoder *d, int wanted) {
  for (int i = 0; i < d->pipeline.channel_count; i++)
    if (wanted < d->pipeline.channel_count)
      d->pipeline.channels[i].user_pixel_stride = 2 * sizeof(float);
  return exr_decoding_choose_default_routines(d->reader->context, d->part,
                                              &d->pipeline);
}

static exr_result_t decode_chunk(decoder *d, const exr_chunk_info_t *chunk,
                                 size_t x, size_t y) {
  exr_context_t context = d->reader->context;
  exr_result_t result =
      d->started
          ? exr_decoding_update(context, d->part, chunk, &d->pipeline)
          : exr_decoding_initialize(context, d->part, chunk, &d->pipeline);
  if (result != EXR_ERR_SUCCESS)
    return result;
  const int wanted = aim(d, x, y);
  if (!d->started) {
    d->started = 1;
    result = choose_routines(d, wanted);
    aim(d, x, y);
  }
  return result == EXR_ERR_SUCCESS
             ? exr_decoding_run(context, d->part, &d->pipeline)
             : result;
}

static exr_result_t decode_scanlines(decoder *d) {
  const reader *r = d->reader;
  int32_t lines = 0;
  exr_result_t result =
      exr_get_scanlines_per_chunk(r->context, d->part, &lines);
  if (result == EXR_ERR_SUCCESS && lines < 1)
    result = EXR_ERR_INVALID_ATTR;
  for (int64_t y = r->window.min.y;
       result == EXR_ERR_SUCCESS && y <= r->window.max.y; y += lines) {
    exr_chunk_info_t chunk;
    result = exr_read_scanline_chunk_info(r->context, d->part, (int)y, &chunk);
    if (result == EXR_ERR_SUCCESS)
      result = decode_chunk(d, &chunk, 0, (size_t)(y - r->window.min.y));
  }
  return result;
}

static exr_result_t decode_tiles(decoder *d) {
  const reader *r = d->reader;
  int32_t width = 0, height = 0;
  exr_result_t result =
      exr_get_tile_sizes(r->context, d->part, 0, 0, &width, &height);
  if (result == EXR_ERR_SUCCESS && (width < 1 || height < 1))
    result = EXR_ERR_INVALID_ATTR;
  for (uint32_t y = 0; result == EXR_ERR_SUCCESS && y < d->img->height;
       y += (uint32_t)height)
    for (uint32_t x = 0; result == EXR_ERR_SUCCESS && x < d->img->width;
         x += (uint32_t)width) {
      exr_chunk_info_t chunk;
      result = exr_read_tile_chunk_info(
          r->context, d->part, (int)(x / (uint32_t)width),
          (int)(y / (uint32_t)height), 0, 0, &chunk);
      if (result == EXR_ERR_SUCCESS)
        result = decode_chunk(d, &chunk, x, y);
    }
  return result;
}

static exr_result_t decode_core(reader *r, int part, const image *img,
                                const source *sources) {
  decoder d = {.reader = r, .part = part, .img = img, .sources = sources};
  exr_storage_t storage = EXR_STORAGE_SCANLINE;
  exr_get_storage(r->context, part, &storage);
  const exr_result_t result =
      storage == EXR_STORAGE_TILED ? decode_tiles(&d) : decode_scanlines(&d);
  if (d.started)
    exr_decoding_destroy(r->context, &d.pipeline);
  return result;
}

/* Bytes of a chunk of a part, which may be larger than its image. */
static uint64_t chunk_bytes(reader *r, int part) {
  const exr_attr_chlist_t *channels = part_channels(r, part);
  const uint32_t across = (uint32_t)extent(r->window.min.x, r->window.max.x);
  exr_tile_level_mode_t levels;
  exr_tile_round_mode_t rounding;
  uint32_t width = 0, height = 0;
  int32_t lines = 0;
  uint64_t pixel = 0;
  if (exr_get_tile_descriptor(r->context, part, &width, &height, &levels,
                              &rounding) != EXR_ERR_SUCCESS &&
      exr_get_scanlines_per_chunk(r->context, part, &lines) == EXR_ERR_SUCCESS)
    height = (uint32_t)lines;
  for (int i = 0; i < channels->num_channels; i++)
    pixel += channels->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
  return pixel * height * (width > across ? width : across);
}

/* Bytes of all parts' tables of chunks, which that library reads unasked. */
static uint64_t table_bytes(const reader *r) {
  uint64_t chunks = 0;
  for (int part = 0; part < r->parts; part++) {
    int32_t count = 0;
    exr_get_chunk_count(r->context, part, &count);
    chunks += count > 0 ? (uint64_t)count : 0;
  }
  return 8 * chunks;
}

/* That library has no allocator of ours.  It holds one chunk, packed and
 * unpacked, and what is between: 2.7 to 3.1 chunks are measured. */
static int check_dwa(reader *r, int part) {
  const uint64_t needed = 4 * chunk_bytes(r, part) + table_bytes(r);
  if (needed <= r->memory.limit - r->memory.held)
    return 0;
  r->memory.exceeded = 1;
  return library_failed(r, DAMAGED_PIXELS, EXR_ERR_OUT_OF_MEMORY);
}

static int decode_dwa(reader *r, int part, const image *img,
                      const source *sources) {
  const exr_attr_chlist_t *channels = part_channels(r, part);
  exr_target *targets = calloc(img->count, sizeof *targets);
  size_t count = 0;
  if (!targets)
    return image_no_memory(r->error, r->stream.path);
  for (size_t i = 0; i < img->count; i++)
    if (sources[i].part == part)
      targets[count++] = (exr_target){
          channels->entries[sources[i].channel].name.str, img->planes[i].pixels,
          img->planes[i].type == IMAGE_UINT};
  const int failed = exr_dwa_read(r->stream.path, part, img->width, img->height,
                                  targets, count, r->error);
  free(targets);
  return failed;
}

static int decode_part(reader *r, int part, const image *img,
                       const source *sources) {
  exr_compression_t compression = EXR_COMPRESSION_NONE;
  exr_get_compression(r->context, part, &compression);
  if (compression == EXR_COMPRESSION_DWAA ||
      compression == EXR_COMPRESSION_DWAB)
    return check_dwa(r, part) != 0 ? -1 : decode_dwa(r, part, img, sources);
  const exr_result_t result = decode_core(r, part, img, sources);
  return result == EXR_ERR_SUCCESS ? 0
                                   : library_failed(r, DAMAGED_PIXELS, result);
}

static int is_wanted(const image *img, const source *sources, int part) {
  for (size_t i = 0; i < img->count; i++)
    if (sources[i].part == part)
      return 1;
  return 0;
}

static int read_planes(reader *r, const char *const *names, size_t count,
                       int as_is, image *out, source *sources) {
  for (size_t i = 0; i < count; i++) {
    if (image_find(out, names[i]))
      continue;
    if (find_source(r, names[i], &sources[out->count]) != 0)
      return -1;
    image_plane *plane = image_add(out, names[i]);
    if (!plane)
      return image_no_memory(r->error, r->stream.path);
    plane->type = as_is ? sources[out->count - 1].type : IMAGE_FLOAT;
  }
  for (int part = 0; part < r->parts; part++)
    if (is_wanted(out, sources, part) &&
        decode_part(r, part, out, sources) != 0)
      return -1;
  return 0;
}

static int read_file(const char *path, const char *const *names, size_t count,
                     int as_is, image *out, image_error *error) {
  reader r;
  memset(out, 0, sizeof *out);
  if (reader_open(&r, path, error) != 0)
    return -1;
  set_size(&r, out);
  read_display(&r, out);
  source *sources = calloc(count ? count : 1, sizeof *sources);
  int failed = sources ? read_planes(&r, names, count, as_is, out, sources)
                       : image_no_memory(error, path);
  free(sources);
  reader_close(&r);
  if (failed)
    image_free(out);
  return failed;
}

int exr_read(const char *path, const char *const *names, size_t count,
             image *out, image_error *error) {
  return read_file(path, names, count, 0, out, error);
}

int exr_read_as_is(const char *path, const char *const *names, size_t count,
                   image *out, image_error *error) {
  return read_file(path, names, count, 1, out, error);
}
