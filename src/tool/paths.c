/* Names of files. */
#define _POSIX_C_SOURCE 200809L
#include "tool/paths.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
