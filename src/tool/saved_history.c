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
#include <unistd.h>

#define FILE_NAME ".hbil-light"

/* The file begins with this; the history follows. */
typedef struct preface {
  char magic[8];
  uint64_t key, size;
  double exposure;
} preface;

static const char file_magic[8] = {'h', 'b', 'i', 'l', 'l', 'i', 'g', '1'};

static char *history_path(const char *folder) {
  char *path = malloc(strlen(folder) + sizeof "/" FILE_NAME);
  if (path)
    strcat(strcpy(path, folder), "/" FILE_NAME);
  return path;
}

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

int saved_history_write(const char *folder, const saved_history *h,
                        image_error *error) {
  char *path = history_path(folder);
  char *name = path ? temporary_name(path, error) : NULL;
  int failed = -1;
  if (!path)
    image_no_memory(error, folder);
  else if (name && write_file(name, path, h, error) == 0)
    failed = temporary_commit(name, path, error);
  else
    temporary_discard(name);
  free(path);
  return failed;
}

int saved_history_read(const char *folder, saved_history *h) {
  preface head;
  char *path = history_path(folder);
  FILE *file = path ? fopen(path, "rb") : NULL;
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
  free(path);
  return found;
}

/* Whether it is called NAME.tmpPID, NAME is a file that this program writes,
 * and the process is gone. */
static int is_leftover(const char *name) {
  const char *mark = NULL;
  for (const char *at = name; (at = strstr(at, ".tmp")); at++)
    mark = at;
  if (!mark || !isdigit((unsigned char)mark[4]) || mark - name < 4)
    return 0;
  char *end;
  const long id = strtol(mark + 4, &end, 10);
  return !*end && id > 0 &&
         (!strncmp(mark - 4, ".exr", 4) || !strncmp(mark - 4, ".png", 4) ||
          !strncmp(name, FILE_NAME, sizeof FILE_NAME - 1)) &&
         kill((pid_t)id, 0) != 0 && errno == ESRCH;
}

void saved_history_sweep(const char *folder) {
  DIR *entries = opendir(folder);
  for (struct dirent *e; entries && (e = readdir(entries));)
    if (is_leftover(e->d_name))
      unlinkat(dirfd(entries), e->d_name, 0);
  if (entries)
    closedir(entries);
}

void saved_history_remove(const char *folder) {
  char *path = history_path(folder);
  if (path)
    unlink(path);
  free(path);
}
