/* The history that the last frame hands on, in a file beside the results. */
#define _POSIX_C_SOURCE 200809L
#include "tool/saved_history.h"

#include "image/error.h"
#include "image/regular_file.h"
#include "image/temporary.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

/* The file begins with this; the history follows. */
typedef struct preface {
  char magic[8];
  uint64_t key, size;
  double exposure;
  uint64_t hash; /* of everything in the file */
} preface;
_Static_assert(sizeof(preface) == 40, "no padding");

static const char file_magic[8] = {'h', 'b', 'i', 'l', 'l', 'i', 'g', '2'};

/* The hash of a file; that in its preface counts as 0. */
static uint64_t hash_of(preface head, const void *bytes) {
  head.hash = 0;
  return XXH3_64bits_withSeed(bytes, head.size,
                              XXH3_64bits(&head, sizeof head));
}

static void write_history(const void *history, FILE *out) {
  const saved_history *h = history;
  preface head = {.key = h->key, .size = h->size, .exposure = h->exposure};
  memcpy(head.magic, file_magic, sizeof head.magic);
  head.hash = hash_of(head, h->bytes);
  fwrite(&head, sizeof head, 1, out);
  fwrite(h->bytes, h->size, 1, out);
}

int saved_history_write(const char *path, const saved_history *h,
                        image_error *error) {
  return temporary_write(path, EXISTING_REPLACED, write_history, h, error);
}

static saved_state read_file(FILE *file, saved_history *h) {
  preface head;
  struct stat info;
  if (fread(&head, sizeof head, 1, file) != 1 ||
      memcmp(head.magic, file_magic, sizeof head.magic) != 0 ||
      fstat(fileno(file), &info) != 0 ||
      (uint64_t)info.st_size - sizeof head != head.size)
    return SAVED_DAMAGED;
  if (head.size != h->size)
    return SAVED_NOTHING;
  if (fread(h->bytes, h->size, 1, file) != 1 ||
      head.hash != hash_of(head, h->bytes))
    return SAVED_DAMAGED;
  h->key = head.key;
  h->exposure = (float)head.exposure;
  return SAVED_WHOLE;
}

saved_state saved_history_read(const char *path, saved_history *h) {
  const char *why;
  FILE *file = regular_file_stream(path, &why);
  if (!file)
    return SAVED_NOTHING;
  const saved_state state = read_file(file, h);
  fclose(file);
  return state;
}

void saved_history_remove(const char *path) {
  unlink(path);
}
