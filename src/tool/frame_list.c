/* Which files a sequence has. */
#define _POSIX_C_SOURCE 200809L
#include "tool/frame_list.h"

#include "image/error.h"
#include "tool/frame_folder.h"
#include "tool/frame_numbers.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <glob.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* How many missing files a message names. */
enum { MOST_NAMED = 8 };

/* ------------------------------------------------------------------------ */
/* Patterns                                                                  */

/* A file name with a place for a number.  (OpenImageIO's parse_pattern() makes
 * 16 digits of ####, and replaces a # in the folder's name instead.  Its
 * scan_for_matching_filenames() finds nothing for %d, nor in names with +, $ or
 * %.) */
typedef struct pattern {
  const char *text;
  size_t before;  /* characters in front of the number's place */
  size_t behind;  /* where the name goes on */
  unsigned width; /* digits at least */
} pattern;

/* The length of %d or %0Nd at p, or 0. */
static size_t percent_length(const char *p, unsigned *width) {
  const char *next = p + 1;
  *width = 1;
  if (*next == '0') {
    next++;
    if (frame_number_read(&next, width) != 0 || *width < 1 ||
        *width > FRAME_DIGITS)
      return 0;
  }
  return *next == 'd' ? (size_t)(next - p) + 1 : 0;
}

static int find_pattern(const char *text, pattern *out) {
  const char *slash = strrchr(text, '/');
  const char *name = slash ? slash + 1 : text;
  out->text = text;
  for (const char *p = strchr(name, '%'); p; p = strchr(p + 1, '%')) {
    const size_t length = percent_length(p, &out->width);
    out->before = (size_t)(p - text);
    out->behind = out->before + length;
    if (length > 0)
      return 1;
  }
  const char *last = strrchr(name, '#');
  if (!last)
    return 0;
  const char *first = last;
  while (first > name && first[-1] == '#')
    first--;
  out->before = (size_t)(first - text);
  out->behind = (size_t)(last - text) + 1;
  out->width = (unsigned)(out->behind - out->before);
  return out->width <= FRAME_DIGITS;
}

static char *pattern_file(const pattern *p, unsigned number) {
  const size_t size = strlen(p->text) + FRAME_DIGITS + 2;
  char *file = malloc(size);
  if (file)
    snprintf(file, size, "%.*s%0*u%s", (int)p->before, p->text, (int)p->width,
             number, p->text + p->behind);
  return file;
}

/* Whether the pattern could have made this name; fills in its number. */
static int match(const pattern *p, const char *prefix, const char *name,
                 unsigned *number) {
  const size_t front = strlen(prefix);
  if (strncmp(name, prefix, front) != 0)
    return 0;
  const char *next = name + front;
  const char *digits = next;
  if (frame_number_read(&next, number) != 0 ||
      strcmp(next, p->text + p->behind) != 0)
    return 0;
  const size_t count = (size_t)(next - digits);
  return count == p->width || (count > p->width && *digits != '0');
}

/* The numbers of the files that exist, in order. */
static int find_numbers(const pattern *p, frame_numbers *out,
                        image_error *error) {
  const char *slash = strrchr(p->text, '/');
  const size_t name = slash ? (size_t)(slash - p->text) + 1 : 0;
  char *folder = name ? strndup(p->text, name) : strdup(".");
  char *prefix = strndup(p->text + name, p->before - name);
  DIR *entries = folder && prefix ? opendir(folder) : NULL;
  int failed = 0;
  unsigned number;
  for (struct dirent *e; !failed && entries && (e = readdir(entries));)
    if (match(p, prefix, e->d_name, &number))
      failed = frame_numbers_add(out, number);
  if (entries)
    closedir(entries);
  if (!folder || !prefix || failed)
    failed = image_no_memory(error, p->text);
  free(folder);
  free(prefix);
  if (!failed)
    frame_numbers_sort(out);
  return failed;
}

/* ------------------------------------------------------------------------ */
/* What is missing                                                           */

static int exists(const char *file) {
  struct stat status;
  return stat(file, &status) == 0 || (errno != ENOENT && errno != ENOTDIR);
}

static int report_none(const pattern *p, image_error *error) {
  return image_fail(error,
                    "%s: there is no such frame; a pattern of files that exist "
                    "is needed",
                    p->text);
}

static int report_missing(const pattern *p, const frame_numbers *missing,
                          size_t all, image_error *error) {
  frame_numbers there = {NULL, 0, 0};
  char text[256], rest[256];
  int failed = find_numbers(p, &there, error);
  frame_numbers_name(missing, text, sizeof text);
  frame_numbers_name(&there, rest, sizeof rest);
  if (!failed && there.count == 0)
    failed = report_none(p, error);
  else if (!failed)
    failed =
        image_fail(error,
                   "%s: %zu of %zu frames %s missing: %s; --frames with those "
                   "that are there (%s) is needed",
                   p->text, missing->count, all,
                   missing->count == 1 ? "is" : "are", text, rest);
  frame_numbers_free(&there);
  return failed;
}

/* Without --frames, a gap between equally spaced numbers is an accident. */
static int check_holes(const pattern *p, const frame_numbers *there,
                       image_error *error) {
  frame_numbers missing = {NULL, 0, 0};
  unsigned step = FRAME_LAST;
  int failed = 0;
  size_t all = there->count;
  for (size_t i = 1; i < there->count; i++)
    if (there->values[i] - there->values[i - 1] < step)
      step = there->values[i] - there->values[i - 1];
  for (size_t i = 1; i < there->count && !failed; i++)
    for (unsigned n = there->values[i - 1] + step;
         n < there->values[i] && !failed; n += step)
      failed = frame_numbers_add(&missing, n);
  if (failed)
    failed = image_no_memory(error, p->text);
  else if (missing.count)
    failed = report_missing(p, &missing, all + missing.count, error);
  frame_numbers_free(&missing);
  return failed;
}

/* Names the missing files that no pattern made, in one line. */
static int report_missing_files(char *const *files, size_t count,
                                size_t missing, image_error *error) {
  char names[IMAGE_ERROR_SIZE - 128] = "";
  size_t named = 0, used = 0;
  for (size_t i = 0; i < count && named < MOST_NAMED; i++) {
    const size_t needed = strlen(files[i]) + 3;
    if (exists(files[i]) || used + needed > sizeof names)
      continue;
    used += (size_t)snprintf(names + used, sizeof names - used, "%s%s",
                             used ? ", " : "", files[i]);
    named++;
  }
  char more[32] = "";
  if (named < missing)
    snprintf(more, sizeof more, " and %zu more", missing - named);
  return image_fail(error, "%zu of %zu frames are missing: %s%s", missing,
                    count, names, more);
}

/* A single missing file is reported by its reader. */
static int check_files(const frame_list *list, image_error *error) {
  size_t missing = 0;
  for (size_t i = 0; i < list->count; i++)
    missing += !exists(list->files[i]);
  return missing < 2
             ? 0
             : report_missing_files(list->files, list->count, missing, error);
}

/* ------------------------------------------------------------------------ */
/* The list                                                                  */

/* Takes over the malloc'd name; NULL means that memory ran out. */
static int add_file(frame_list *list, char *file, image_error *error) {
  char **files =
      file ? realloc(list->files, (list->count + 1) * sizeof *files) : NULL;
  if (!files) {
    free(file);
    return image_no_memory(error, "the list of frames");
  }
  list->files = files;
  list->files[list->count++] = file;
  return 0;
}

static int add_numbered(const pattern *p, const frame_numbers *n,
                        frame_list *list, image_error *error) {
  frame_numbers missing = {NULL, 0, 0};
  int failed = 0;
  for (size_t i = 0; i < n->count && !failed; i++) {
    failed = add_file(list, pattern_file(p, n->values[i]), error);
    if (!failed && !exists(list->files[list->count - 1]) &&
        frame_numbers_add(&missing, n->values[i]) != 0)
      failed = image_no_memory(error, p->text);
  }
  if (!failed && missing.count)
    failed = report_missing(p, &missing, n->count, error);
  frame_numbers_free(&missing);
  return failed;
}

/* The files of a pattern that exist.  holes: whether numbers may be missing. */
static int add_existing(const pattern *p, int holes, frame_list *list,
                        image_error *error) {
  frame_numbers there = {NULL, 0, 0};
  int failed = find_numbers(p, &there, error);
  if (!failed && there.count == 0)
    failed = report_none(p, error);
  if (!failed)
    failed = (!holes && check_holes(p, &there, error) != 0) ||
             add_numbered(p, &there, list, error) != 0;
  frame_numbers_free(&there);
  return failed ? -1 : 0;
}

/* Adds the existing frames before the first one that is asked for, which lie as
 * far apart as those do, `most` at most. */
static int add_pre_roll(const pattern *p, const frame_numbers *asked,
                        unsigned most, frame_list *list, image_error *error) {
  frame_numbers there = {NULL, 0, 0};
  const unsigned first = asked->values[0];
  const unsigned next = asked->count > 1 ? asked->values[1] : first + 1;
  const unsigned step = next > first ? next - first : 1;
  int failed = find_numbers(p, &there, error);
  size_t from = 0, end = 0;
  for (size_t i = 0; i < there.count; i++)
    if (there.values[i] < first && (first - there.values[i]) % step == 0)
      there.values[end++] = there.values[i];
  if (end > most)
    from = end - most;
  for (size_t i = from; i < end && !failed; i++)
    failed = add_file(list, pattern_file(p, there.values[i]), error);
  list->pre_roll = (unsigned)list->count;
  frame_numbers_free(&there);
  return failed;
}

/* What arguments stand for. */
typedef struct request {
  const frame_numbers *asked; /* NULL: all frames that exist */
  unsigned pre_roll;
} request;

static int add_asked(const pattern *p, const request *r, frame_list *list,
                     image_error *error) {
  if (list->count == 0 && r->pre_roll &&
      add_pre_roll(p, r->asked, r->pre_roll, list, error) != 0)
    return -1;
  return add_numbered(p, r->asked, list, error);
}

static int add_argument(const char *argument, const request *r,
                        frame_list *list, image_error *error) {
  pattern p;
  /* an existing file is taken as it is, even if its name is like a pattern */
  if ((r->asked || !exists(argument)) && find_pattern(argument, &p))
    return r->asked ? add_asked(&p, r, list, error)
                    : add_existing(&p, 0, list, error);
  if (r->asked)
    return image_fail(error,
                      "--frames: %s has no place for a number; a pattern such "
                      "as frame.%%04d.exr or frame.####.exr is needed",
                      argument);
  return add_file(list, strdup(argument), error);
}

/* A folder stands for the pattern of what it holds. */
static int add_folder(const char *folder, const request *r, frame_list *list,
                      image_error *error) {
  char *held = frame_folder_pattern(folder, error);
  const int failed = held ? add_argument(held, r, list, error) : -1;
  free(held);
  return failed;
}

int frame_list_make(char *const *arguments, int count, const char *ranges,
                    unsigned pre_roll, frame_list *out, image_error *error) {
  frame_numbers asked = {NULL, 0, 0};
  const request r = {ranges ? &asked : NULL, pre_roll};
  memset(out, 0, sizeof *out);
  int failed = ranges ? frame_numbers_read(ranges, &asked, error) : 0;
  for (int i = 0; i < count && !failed; i++)
    failed = (frame_folder_exists(arguments[i]) ? add_folder : add_argument)(
        arguments[i], &r, out, error);
  frame_numbers_free(&asked);
  if (!failed)
    failed = check_files(out, error);
  if (failed)
    frame_list_free(out);
  return failed ? -1 : 0;
}

/* Files by a shell's wildcards, which a quoted argument still has. */
static int add_matching(const char *wildcards, frame_list *list,
                        image_error *error) {
  glob_t found;
  int failed = 0;
  if (glob(wildcards, 0, NULL, &found) != 0)
    return image_fail(error, "%s: no such files", wildcards);
  for (size_t i = 0; i < found.gl_pathc && !failed; i++)
    failed = add_file(list, strdup(found.gl_pathv[i]), error);
  globfree(&found);
  return failed;
}

int frame_list_add(const char *argument, frame_list *list, image_error *error) {
  pattern p;
  if (exists(argument))
    return add_file(list, strdup(argument), error);
  if (find_pattern(argument, &p))
    return add_existing(&p, 1, list, error);
  return strpbrk(argument, "*?[") ? add_matching(argument, list, error)
                                  : add_file(list, strdup(argument), error);
}

void frame_list_free(frame_list *list) {
  for (size_t i = 0; i < list->count; i++)
    free(list->files[i]);
  free(list->files);
  memset(list, 0, sizeof *list);
}
