/* The history that the last frame hands on, in a file beside the results. */
#define _POSIX_C_SOURCE 200809L
#include "tool/saved_history.h"

#include "image/error.h"
#include "image/regular_file.h"
#include "image/temporary.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The file begins with this; the history follows. */
typedef struct preface {
  char magic[8];
  uint64_t key, size;
  double exposure;
} preface;

static const char file_magic[8] = {'h', 'b', 'i', 'l', 'l', 'i', 'g', '1'};

static int write_file(const char *name, const char *path,
                      const saved_history *h, image_error *error) {
  preface head = {.key = h->key, .size = h->size, .exposure = h->exposure};
  memcpy(head.magic, file_magic, sizeof head.magic);
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

int saved_history_read(const char *path, saved_history *h) {
  preface head;
  const char *why;
  FILE *file = regular_file_stream(path, &why);
  const int found = file && fread(&head, sizeof head, 1, file) == 1 &&
                    !memcmp(head.magic, file_magic, sizeof head.magic) &&
                    head.size == h->size &&
                    fread(h->bytes, h->size, 1, file) == 1 &&
                    fgetc(file) == EOF;
  if (found) {
    h->key = head.key;
    h->exposure = (float)head.exposure;
  }
  if (file)
    fclose(file);
  return found;
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
