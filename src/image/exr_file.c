#include "image/exr_file.h"

#include <string.h>

/* A header that claims more than this is damaged. */
#define MAX_PIXELS ((uint64_t)1 << 28)
#define MAX_TILE (1 << 16)
#define MAX_CHANNELS 4096

int64_t exr_extent(int32_t first, int32_t last) {
  return (int64_t)last - first + 1;
}

int exr_file_fail(const exr_file *f, const char *what, exr_result_t result) {
  if (f->budget.exceeded)
    return image_fail(f->error,
                      "%s: %s, or one that needs more memory than 4 times its "
                      "image and %d MiB; a complete file is needed",
                      f->stream.path, what, EXR_SPARE_MEMORY >> 20);
  return image_fail(
      f->error, "%s: %s (%s); a complete file is needed", f->stream.path, what,
      f->stream.message[0] ? f->stream.message
                           : exr_get_default_error_message(result));
}

static int is_flat(const exr_file *f, int part) {
  exr_storage_t storage;
  return exr_get_storage(f->context, part, &storage) == EXR_ERR_SUCCESS &&
         (storage == EXR_STORAGE_SCANLINE || storage == EXR_STORAGE_TILED);
}

static int find_window(exr_file *f) {
  int part = 0;
  while (part < f->parts && !is_flat(f, part))
    part++;
  if (part == f->parts)
    return image_fail(f->error,
                      "%s: holds deep data only; flat pixels are needed",
                      f->stream.path);
  if (exr_get_data_window(f->context, part, &f->window) != EXR_ERR_SUCCESS)
    return image_fail(f->error, "%s: has no data window; the file is damaged",
                      f->stream.path);
  const int64_t width = exr_extent(f->window.min.x, f->window.max.x);
  const int64_t height = exr_extent(f->window.min.y, f->window.max.y);
  if (width < 1 || height < 1 ||
      (uint64_t)width > MAX_PIXELS / (uint64_t)height)
    return image_fail(f->error,
                      "%s: claims %lld x %lld pixels; at most %llu pixels are "
                      "read",
                      f->stream.path, (long long)width, (long long)height,
                      (unsigned long long)MAX_PIXELS);
  f->width = (uint32_t)width;
  f->height = (uint32_t)height;
  return 0;
}

const exr_attr_chlist_t *exr_file_channels(const exr_file *f, int part) {
  const exr_attr_chlist_t *channels = NULL;
  exr_attr_box2i_t window;
  if (!is_flat(f, part) ||
      exr_get_data_window(f->context, part, &window) != EXR_ERR_SUCCESS ||
      memcmp(&window, &f->window, sizeof window) != 0 ||
      exr_get_channels(f->context, part, &channels) != EXR_ERR_SUCCESS)
    return NULL;
  return channels;
}

/* Raises the limit of memory now that the size of the image is known.  The
 * caller's planes are one of the 4 times that the limit is documented as. */
static int extend_budget(exr_file *f) {
  size_t channels = 0;
  for (int part = 0; part < f->parts; part++) {
    const exr_attr_chlist_t *list = exr_file_channels(f, part);
    channels += list ? (size_t)list->num_channels : 0;
  }
  if (channels > MAX_CHANNELS)
    return image_fail(f->error, "%s: claims %zu channels; at most %d are read",
                      f->stream.path, channels, MAX_CHANNELS);
  f->budget.limit += 3 * sizeof(float) * channels * f->width * f->height;
  return 0;
}

static exr_context_initializer_t initializer(exr_stream *stream) {
  exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
  exr_stream_attach(stream, &init);
  init.alloc_fn = budget_take;
  init.free_fn = budget_give;
  init.max_image_width = init.max_image_height = EXR_MAX_SIDE;
  init.max_tile_width = init.max_tile_height = MAX_TILE;
  init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
  return init;
}

static int parse_header(exr_file *f) {
  const exr_context_initializer_t init = initializer(&f->stream);
  f->budget.limit = EXR_SPARE_MEMORY;
  budget_select(&f->budget);
  exr_result_t result = exr_start_read(&f->context, f->stream.path, &init);
  if (result == EXR_ERR_SUCCESS)
    result = exr_get_count(f->context, &f->parts);
  /* The library reports success even if it could not parse an attribute, and
   * invents an image of 64 x 64 pixels if no window was found.  Its message is
   * then the only sign of damage. */
  if (result != EXR_ERR_SUCCESS || f->stream.message[0])
    return exr_file_fail(f, "damaged OpenEXR header", result);
  return find_window(f) != 0 || extend_budget(f) != 0 ? -1 : 0;
}

int exr_file_open(exr_file *f, const char *path, image_error *error) {
  memset(f, 0, sizeof *f);
  f->error = error;
  if (exr_stream_open(&f->stream, path, error) == 0 && parse_header(f) == 0)
    return 0;
  exr_file_close(f);
  return -1;
}

void exr_file_close(exr_file *f) {
  if (f->context)
    exr_finish(&f->context);
  budget_select(NULL);
  exr_stream_close(&f->stream);
}
