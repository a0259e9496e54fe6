/* Which file a path leads to. */
#define _POSIX_C_SOURCE 200809L
#include "tool/file_place.h"

#include "tool/paths.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A chain of more links is a loop. */
enum { MOST_LINKS = 40, LONGEST_LINK = 4096 };

static int find(const char *path, int links, file_place *out);

/* The part of a path behind its folder, without slashes at its end. */
static char *last_part(const char *path) {
  size_t end = strlen(path);
  while (end > 1 && path[end - 1] == '/')
    end--;
  size_t begin = end;
  while (begin > 0 && path[begin - 1] != '/')
    begin--;
  return strndup(path + begin, end - begin);
}

/* Appends a part of a path to the way from a folder. */
static int go_on(file_place *place, const char *part) {
  if (!*part || strcmp(part, ".") == 0)
    return 0;
  char *slash = strrchr(place->rest, '/');
  if (strcmp(part, "..") == 0 && slash) {
    *slash = '\0';
    return 0;
  }
  char *rest = path_join(place->rest, "/", part);
  free(place->rest);
  place->rest = rest;
  return rest ? 0 : -1;
}

/* The place of a file that doesn't exist: its folder's, and its name. */
static int find_by_folder(const char *path, int links, file_place *out) {
  char *folder = path_parent(path), *name = last_part(path);
  int failed = !folder || !name;
  if (!failed && strcmp(folder, path) == 0)
    failed = (out->rest = strdup(path)) == NULL;
  else if (!failed)
    failed = find(folder, links, out) != 0 || go_on(out, name) != 0;
  free(folder);
  free(name);
  return failed ? -1 : 0;
}

/* The place that a link names which leads nowhere. */
static int find_by_link(const char *path, const char *target, int links,
                        file_place *out) {
  char *folder = *target == '/' ? NULL : path_parent(path);
  char *whole = *target == '/' ? strdup(target)
                : folder       ? path_join(folder, "/", target)
                               : NULL;
  const int failed = whole ? find(whole, links + 1, out) : -1;
  free(folder);
  free(whole);
  return failed;
}

/* What a link names, malloc'd; NULL if `path` is no link.  Not on the stack:
 * find() calls itself for every folder that is missing. */
static char *read_link(const char *path) {
  char *target = malloc(LONGEST_LINK);
  const ssize_t length = target ? readlink(path, target, LONGEST_LINK - 1) : -1;
  if (length > 0) {
    target[length] = '\0';
    return target;
  }
  free(target);
  return NULL;
}

static int find(const char *path, int links, file_place *out) {
  struct stat info;
  if (stat(path, &info) == 0) {
    out->disk = info.st_dev;
    out->inode = info.st_ino;
    out->rest = strdup("");
    return out->rest ? 0 : -1;
  }
  char *target = links < MOST_LINKS ? read_link(path) : NULL;
  const int failed = target ? find_by_link(path, target, links, out)
                            : find_by_folder(path, links, out);
  free(target);
  return failed;
}

int file_place_find(const char *path, file_place *out) {
  memset(out, 0, sizeof *out);
  return find(path, 0, out);
}

void file_place_free(file_place *place) {
  free(place->rest);
  place->rest = NULL;
}

int file_place_compare(const file_place *a, const file_place *b) {
  if (a->disk != b->disk)
    return a->disk < b->disk ? -1 : 1;
  if (a->inode != b->inode)
    return a->inode < b->inode ? -1 : 1;
  return strcmp(a->rest, b->rest);
}
