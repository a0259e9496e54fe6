/* A radiance cache in a file. */
#define _POSIX_C_SOURCE 200809L
#include "tool/cache_file.h"

#include "image/regular_file.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <xxhash.h>

/* The file begins with this; what hbil_cache_save() gives follows.  There is
 * no padding. */
typedef struct head {
  char magic[8];
  char version[24]; /* of the library */
  cache_file file;
} head;
_Static_assert(sizeof(head) == 88, "no padding");

/* The last character counts up when the format changes. */
static const char file_magic[8] = {'h', 'b', 'i', 'l', 'c', 'a', 'c', '1'};

/* The hash of a file; that in its head counts as 0. */
static uint64_t hash_of(head h, const void *bytes) {
  h.file.hash = 0;
  return XXH3_64bits_withSeed(bytes, h.file.size, XXH3_64bits(&h, sizeof h));
}

static int cannot_read(const char *path, const char *why, image_error *error) {
  return image_fail(error, "%s: cannot be read: %s", path, why);
}

static int reject(const char *path, const char *what, image_error *error) {
  return image_fail(error, "%s: %s; a file that --cache-save wrote is needed",
                    path, what);
}

/* The limits are those of hbil_cache_config. */
static int is_possible(const cache_file *f) {
  int possible = f->voxels >= 16 && f->voxels <= 256 &&
                 (f->voxels & (f->voxels - 1)) == 0 && f->levels >= 1 &&
                 f->levels <= 4 && f->voxel_size >= 1e-6 &&
                 f->voxel_size <= 1e6;
  for (int c = 0; c < 3; c++)
    possible = possible && isfinite(f->centre[c]);
  return possible;
}

static int read_head(const char *path, FILE *file, head *out,
                     image_error *error) {
  struct stat info;
  errno = 0;
  const int complete = fread(out, sizeof *out, 1, file) == 1;
  if (ferror(file) || fstat(fileno(file), &info) != 0)
    return cannot_read(path, strerror(errno), error);
  if (!complete || memcmp(out->magic, file_magic, sizeof file_magic) != 0)
    return reject(path, "is no radiance cache", error);
  out->version[sizeof out->version - 1] = '\0';
  if (strcmp(out->version, hbil_version()) != 0)
    return image_fail(error,
                      "%s: a radiance cache of another version; one that hbil "
                      "%s wrote is needed",
                      path, hbil_version());
  if (!is_possible(&out->file))
    return reject(path, "is damaged", error);
  if ((uint64_t)info.st_size != sizeof *out + out->file.size)
    return reject(path, "is truncated or damaged", error);
  return 0;
}

int cache_file_recognise(const char *path) {
  char start[sizeof file_magic];
  FILE *file = fopen(path, "rb");
  const int is_one = file && fread(start, sizeof start, 1, file) == 1 &&
                     memcmp(start, file_magic, sizeof start - 1) == 0;
  if (file)
    fclose(file);
  return is_one;
}

int cache_file_read(const char *path, cache_file *out, image_error *error) {
  head h;
  const char *why;
  FILE *file = regular_file_stream(path, &why);
  if (!file)
    return cannot_read(path, why, error);
  const int failed = read_head(path, file, &h, error);
  fclose(file);
  if (!failed)
    *out = h.file;
  return failed;
}

int cache_file_read_bytes(const char *path, const cache_file *expected,
                          void *bytes, image_error *error) {
  head h;
  const char *why;
  FILE *file = regular_file_stream(path, &why);
  if (!file)
    return cannot_read(path, why, error);
  int failed = read_head(path, file, &h, error);
  if (!failed &&
      (h.file.hash != expected->hash || h.file.size != expected->size))
    failed = image_fail(error, "%s: has changed meanwhile", path);
  if (!failed && fread(bytes, h.file.size, 1, file) != 1)
    failed = cannot_read(path, strerror(errno), error);
  fclose(file);
  return !failed && h.file.hash != hash_of(h, bytes)
             ? reject(path, "is damaged", error)
             : failed;
}

typedef struct content {
  head head;
  const void *bytes;
} content;

static void write_content(const void *content_, FILE *out) {
  const content *c = content_;
  fwrite(&c->head, sizeof c->head, 1, out);
  fwrite(c->bytes, c->head.file.size, 1, out);
}

int cache_file_write(const char *path, cache_file *file, const void *bytes,
                     existing_file existing, image_error *error) {
  content c;
  memset(&c, 0, sizeof c);
  memcpy(c.head.magic, file_magic, sizeof c.head.magic);
  snprintf(c.head.version, sizeof c.head.version, "%s", hbil_version());
  c.head.file = *file;
  c.head.file.hash = file->hash = hash_of(c.head, bytes);
  c.bytes = bytes;
  return temporary_write(path, existing, write_content, &c, error);
}
