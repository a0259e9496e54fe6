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
#include <unistd.h>

/* The file begins with this; the history follows. */
typedef struct preface {
  char magic[8];
  uint64_t key, size;
  double exposure;
} preface;

static const char file_magic[8] = {'h', 'b', 'i', 'l', 'l', 'i', 'g', '1'};

static int write_file(const temporary *t, const char *path,
                      const saved_history *h, image_error *error) {
  preface head = {.key = h->key, .size = h->size, .exposure = h->exposure};
  memcpy(head.magic, file_magic, sizeof head.magic);
  FILE *file = temporary_stream(t);
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
  temporary t;
  if (temporary_open(path, &t, error) != 0)
    return -1;
  if (write_file(&t, path, h, error) == 0)
    return temporary_commit(&t, path, EXISTING_REPLACED, error);
  temporary_discard(&t);
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

void saved_history_remove(const char *path) {
  unlink(path);
}
