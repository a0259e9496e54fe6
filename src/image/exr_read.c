#include "image/exr_read.h"
#include "image/exr_attributes.h"
#include "image/exr_channels.h"
#include "image/exr_decode.h"
#include "image/exr_dwa.h"
#include "image/exr_file.h"

#include <stdlib.h>
#include <string.h>

int exr_read_header(const char *path, image *out, image_error *error) {
  exr_file f;
  memset(out, 0, sizeof *out);
  if (exr_file_open(&f, path, error) != 0)
    return -1;
  exr_attributes_windows(&f, out);
  exr_attributes_describe(&f, out);
  const int failed = exr_channels_list(&f, out);
  exr_file_close(&f);
  if (failed)
    image_free(out);
  return failed;
}

static int is_wanted(const image *img, const exr_source *sources, int part) {
  for (size_t i = 0; i < img->count; i++)
    if (sources[i].part == part)
      return 1;
  return 0;
}

static int read_part(exr_file *f, int part, const image *img,
                     const exr_source *sources) {
  return exr_dwa_compressed(f, part) ? exr_dwa_decode(f, part, img, sources)
                                     : exr_decode(f, part, img, sources);
}

/* Adds the named planes to `out` and fills them.  Afterwards sources[i] says
 * where plane i came from. */
static int read_planes(exr_file *f, const char *const *names, size_t count,
                       int as_is, image *out, exr_source *sources) {
  for (size_t i = 0; i < count; i++) {
    if (image_find(out, names[i]))
      continue;
    if (exr_channels_find(f, names[i], &sources[out->count]) != 0)
      return -1;
    image_plane *plane = image_add_unset(out, names[i]);
    if (!plane)
      return image_no_memory(f->error, f->stream.path);
    plane->type = as_is ? sources[out->count - 1].type : IMAGE_FLOAT;
  }
  for (int part = 0; part < f->parts; part++)
    if (is_wanted(out, sources, part) && read_part(f, part, out, sources) != 0)
      return -1;
  return 0;
}

static int read_file(const char *path, const char *const *names, size_t count,
                     int as_is, image *out, image_error *error) {
  exr_file f;
  memset(out, 0, sizeof *out);
  if (exr_file_open(&f, path, error) != 0)
    return -1;
  exr_attributes_windows(&f, out);
  exr_source *sources = calloc(count ? count : 1, sizeof *sources);
  const int failed = sources
                         ? read_planes(&f, names, count, as_is, out, sources)
                         : image_no_memory(error, path);
  free(sources);
  exr_file_close(&f);
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
