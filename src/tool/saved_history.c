/* The history that the last frame hands on, in a file beside the results. */
#define _POSIX_C_SOURCE 200809L
#include "tool/saved_history.h"

#include "image/error.h"
#include "image/temporary.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <signal.h>
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

static int write_file(const char *name, const char *path,
                      const saved_history *h, image_error *error) {
  preface head = {.key = h->key, .size = h->size, .exposure = h->exposure};
  memcpy(head.magic, file_magic, sizeof head.magic);
  head.hash = hash_of(head, h->bytes);
  FILE *file = fopen(name, "wb");
  int failed = !file || fwrite(&head, sizeof head, 1, file) != 1 ||
               fwrite(h->bytes, h->size, 1, file) != 1;
  if (file && fclose(file) != 0)
    failed = 1;
  return failed ? image_fail(error, "%s: cannot be written: %s", path,
                             strerror(errno))
                : 0;
}

int saved_history_write(const char *path, const saved_history *h,
                        image_error *error) {
  char *name = temporary_name(path, error);
  if (!name)
    return -1;
  if (write_file(name, path, h, error) == 0)
    return temporary_commit(name, path, error);
  temporary_discard(name);
  return -1;
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
  FILE *file = fopen(path, "rb");
  if (!file)
    return SAVED_NOTHING;
  const saved_state state = read_file(file, h);
  fclose(file);
  return state;
}

/* Where .tmpPID begins in a name that ends so, if that process is gone; else
 * NULL. */
static const char *end_of_leftover(const char *name) {
  const char *mark = NULL;
  for (const char *at = name; (at = strstr(at, ".tmp")); at++)
    mark = at;
  if (!mark || !isdigit((unsigned char)mark[4]))
    return NULL;
  char *end;
  const long id = strtol(mark + 4, &end, 10);
  return !*end && id > 0 && kill((pid_t)id, 0) != 0 && errno == ESRCH ? mark
                                                                      : NULL;
}

/* Whether a file that this program writes for a frame is called so: FRAME.exr,
 * FRAME.LAYER.png, or the history. */
static int is_own(const job *j, const char *name, size_t length) {
  static const char history[] = ".hbil-light.";
  const size_t head = sizeof history - 1;
  const int is_history = length > head && !strncmp(name, history, head);
  if (!is_history && (length < 4 || (strncmp(name + length - 4, ".exr", 4) &&
                                     strncmp(name + length - 4, ".png", 4))))
    return 0;
  for (int i = (int)j->settings->pre_roll; i < j->count; i++) {
    const char *stem = strrchr(j->frames[i].stem, '/') + 1;
    const size_t own = strlen(stem);
    if (is_history
            ? length == head + own && !memcmp(name + head, stem, own)
            : length > own && !memcmp(name, stem, own) && name[own] == '.')
      return 1;
  }
  return 0;
}

void saved_history_sweep(const job *j) {
  DIR *entries = opendir(j->settings->output);
  for (struct dirent *e; entries && (e = readdir(entries));) {
    const char *end = end_of_leftover(e->d_name);
    if (end && is_own(j, e->d_name, (size_t)(end - e->d_name)))
      unlinkat(dirfd(entries), e->d_name, 0);
  }
  if (entries)
    closedir(entries);
}

void saved_history_remove(const char *path) {
  unlink(path);
}
