/* Names of files. */
#define _POSIX_C_SOURCE 200809L
#include "tool/paths.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

char *path_join(const char *a, const char *between, const char *b) {
  const size_t size = strlen(a) + strlen(between) + strlen(b) + 1;
  char *text = malloc(size);
  if (text)
    snprintf(text, size, "%s%s%s", a, between, b);
  return text;
}

char *path_stem_in(const char *folder, const char *frame) {
  const char *slash = strrchr(frame, '/');
  char *stem = path_join(folder, "/", slash ? slash + 1 : frame);
  if (stem) {
    char *dot = strrchr(stem, '.');
    if (dot && dot > strrchr(stem, '/') + 1)
      *dot = '\0';
  }
  return stem;
}

char *path_parent(const char *path) {
  size_t length = strlen(path);
  while (length > 1 && path[length - 1] == '/')
    length--;
  while (length > 0 && path[length - 1] != '/')
    length--;
  while (length > 1 && path[length - 1] == '/')
    length--;
  return length ? strndup(path, length) : strdup(".");
}

/* A folder that another process makes meanwhile is as good. */
static int make_one(const char *folder, unsigned *made) {
  struct stat status;
  if (mkdir(folder, 0777) == 0) {
    ++*made;
    return 0;
  }
  if (errno != EEXIST)
    return -1;
  if (stat(folder, &status) == 0 && S_ISDIR(status.st_mode))
    return 0;
  errno = ENOTDIR;
  return -1;
}

int path_make_folders(const char *folder, unsigned *made) {
  char *parent = NULL;
  int failed = make_one(folder, made);
  if (failed && errno == ENOENT && *folder &&
      (parent = path_parent(folder)) != NULL && strcmp(parent, folder) != 0)
    failed = path_make_folders(parent, made) != 0 || make_one(folder, made);
  const int why = errno;
  free(parent);
  errno = why;
  return failed ? -1 : 0;
}

void path_remove_folders(const char *folder, unsigned made) {
  char *there = made ? strdup(folder) : NULL;
  while (there && made) {
    const int removed = rmdir(there) == 0;
    if (!removed && errno != ENOENT)
      break;
    made -= (unsigned)removed;
    char *parent = path_parent(there);
    if (parent && strcmp(parent, there) == 0)
      made = 0;
    free(there);
    there = parent;
  }
  free(there);
}

char *path_existing(const char *folder) {
  struct stat status;
  char *there = strdup(folder);
  while (there && stat(there, &status) != 0 &&
         (errno == ENOENT || errno == ENOTDIR)) {
    char *parent = path_parent(there);
    const int same = parent && strcmp(parent, there) == 0;
    free(there);
    there = parent;
    if (same)
      break;
  }
  return there;
}

int path_is_writable(const char *folder) {
  struct stat status;
  char *there = path_existing(folder);
  int usable = there && stat(there, &status) == 0;
  if (usable && !S_ISDIR(status.st_mode)) {
    usable = 0;
    errno = ENOTDIR;
  }
  usable = usable && access(there, W_OK | X_OK) == 0;
  const int why = errno;
  free(there);
  errno = why;
  return usable;
}
