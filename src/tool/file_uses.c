/* The files that a command reads and those that it writes. */
#define _POSIX_C_SOURCE 200809L
#include "tool/file_uses.h"

#include "tool/paths.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

/* ------------------------------------------------------------------------ */
/* Which file a path leads to                                                */

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

/* Follows links, also one to a file that doesn't exist.  Two paths have the
 * same place if a file written to one of them is found at the other.  0, or -1
 * if memory runs out; file_place_free() frees the place in both cases. */
static int file_place_find(const char *path, file_place *out) {
  memset(out, 0, sizeof *out);
  return find(path, 0, out);
}

static void file_place_free(file_place *place) {
  free(place->rest);
  place->rest = NULL;
}

/* An order of places: negative, 0 for the same place, or positive. */
static int file_place_compare(const file_place *a, const file_place *b) {
  if (a->disk != b->disk)
    return a->disk < b->disk ? -1 : 1;
  if (a->inode != b->inode)
    return a->inode < b->inode ? -1 : 1;
  return strcmp(a->rest, b->rest);
}

int file_place_is_made_with(const char *folder, const char *other) {
  file_place a, b;
  const int found = file_place_find(folder, &a) == 0;
  const size_t length = found ? strlen(a.rest) : 0;
  const int made = file_place_find(other, &b) == 0 && length > 0 &&
                   a.disk == b.disk && a.inode == b.inode &&
                   strncmp(a.rest, b.rest, length) == 0 &&
                   (b.rest[length] == '\0' || b.rest[length] == '/');
  file_place_free(&a);
  file_place_free(&b);
  return made;
}

/* ------------------------------------------------------------------------ */
/* Files that are read and written                                           */

static int make_room(file_uses *uses) {
  if (uses->count < uses->room)
    return 0;
  const size_t room = 2 * uses->room + 16;
  file_use *list = realloc(uses->list, room * sizeof *list);
  if (!list)
    return -1;
  uses->list = list;
  uses->room = room;
  return 0;
}

int file_uses_add(file_uses *uses, file_use use, image_error *error) {
  use.place = (file_place){0};
  if (!use.path || make_room(uses) != 0 ||
      file_place_find(use.path, &use.place) != 0) {
    file_place_free(&use.place);
    free(use.path);
    return image_no_memory(error, use.what);
  }
  use.index = uses->count;
  uses->list[uses->count++] = use;
  return 0;
}

int file_uses_read(file_uses *uses, const char *path, const char *what,
                   image_error *error) {
  return file_uses_add(uses, (file_use){.path = strdup(path), .what = what},
                       error);
}

int file_uses_write(file_uses *uses, const char *path, const char *option,
                    const char *need, file_kind kind, image_error *error) {
  return file_uses_add(
      uses,
      (file_use){
          .path = strdup(path), .what = option, .need = need, .kind = kind},
      error);
}

/* Pictures are PNG, whatever their names say. */
static int check_ending(const file_use *use, image_error *error) {
  const char *slash = strrchr(use->path, '/');
  const char *ending = strrchr(slash ? slash : use->path, '.');
  return use->kind != FILE_PICTURE || !ending || !strcasecmp(ending, ".png")
             ? 0
             : image_fail(error,
                          "%s: %s writes PNG alone; a name that ends in .png "
                          "is needed",
                          use->path, use->what);
}

int file_use_may_replace(const file_use *use, file_kind there,
                         image_error *error) {
  if (there == FILE_ABSENT || there == FILE_BLANK || there == use->kind)
    return check_ending(use, error);
  if (there == FILE_IRREGULAR)
    return image_fail(error,
                      "%s: cannot be written: not a regular file; another name "
                      "is needed",
                      use->path);
  return image_fail(error,
                    "%s: is not %s, and %s replaces nothing else; %s needed",
                    use->path, file_kind_name(use->kind), use->what, use->need);
}

void file_uses_free(file_uses *uses) {
  for (size_t i = 0; i < uses->count; i++) {
    file_place_free(&uses->list[i].place);
    free(uses->list[i].path);
  }
  free(uses->list);
  memset(uses, 0, sizeof *uses);
}

static int compare_indices(const void *a, const void *b) {
  const file_use *x = a, *y = b;
  return x->index < y->index ? -1 : x->index > y->index;
}

/* By places; those of one place as they were added. */
static int compare_places(const void *a, const void *b) {
  const file_use *x = a, *y = b;
  const int order = file_place_compare(&x->place, &y->place);
  return order ? order : compare_indices(a, b);
}

/* "b.exr: the result of b.exr would overwrite the view b.exr; another output
 * folder is needed" */
static int report(const file_use *written, const file_use *other,
                  image_error *error) {
  const int two_frames = written->frame && other->frame;
  if (two_frames && strcmp(written->frame, other->frame) == 0)
    return image_fail(error, "%s: is given twice; each frame once is needed",
                      written->frame);
  const char *name = other->frame  ? other->frame
                     : other->need ? ""
                                   : other->path;
  return image_fail(error, "%s: %s%s%s would overwrite %s%s%s; %s needed",
                    written->path, written->what, written->frame ? " of " : "",
                    written->frame ? written->frame : "", other->what,
                    other->frame  ? " of "
                    : other->need ? ""
                                  : " ",
                    name,
                    two_frames ? "different file names are" : written->need);
}

/* The first written file, in the order in which they were added, that has the
 * place of an earlier one, *other; NULL: there is none.  The list is sorted by
 * places. */
static const file_use *find_clash(const file_uses *uses,
                                  const file_use **other) {
  const file_use *written = NULL;
  for (size_t i = 1, first = 0; i < uses->count; i++) {
    const file_use *use = &uses->list[i];
    if (file_place_compare(&use->place, &uses->list[first].place) != 0)
      first = i;
    else if (use->need && (!written || use->index < written->index)) {
      written = use;
      *other = &uses->list[first];
    }
  }
  return written;
}

int file_uses_check(file_uses *uses, image_error *error) {
  const file_use *other = NULL;
  if (!uses->count)
    return 0;
  qsort(uses->list, uses->count, sizeof *uses->list, compare_places);
  const file_use *written = find_clash(uses, &other);
  const int failed = written ? report(written, other, error) : 0;
  qsort(uses->list, uses->count, sizeof *uses->list, compare_indices);
  return failed;
}
