/*
 * Which files a sequence has: plain names, and patterns such as
 * shot/frame.%04d.exr or frame.####.exr with the numbers of --frames, or with
 * those that are there.
 */
#define _POSIX_C_SOURCE 200809L
#include "tool/tool.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Numbers have at most seven digits. */
enum { MOST_DIGITS = 7, MOST_FRAME = 9999999, MOST_FRAMES = 1000000 };

/* How many of what is missing a message names. */
enum { MOST_NAMED = 8 };

/* A list of numbers of frames. */
typedef struct numbers {
  unsigned *values;
  size_t count, room;
} numbers;

static int add_number(numbers *n, unsigned value) {
  if (n->count == n->room) {
    const size_t room = n->room ? 2 * n->room : 64;
    unsigned *values = realloc(n->values, room * sizeof *values);
    if (!values)
      return -1;
    n->values = values;
    n->room = room;
  }
  n->values[n->count++] = value;
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Ranges                                                                    */

/* Digits at *at, which moves behind them. */
static int read_number(const char **at, unsigned *out) {
  size_t digits = 0;
  for (*out = 0; isdigit((unsigned char)**at); ++*at, digits++)
    if (digits < MOST_DIGITS)
      *out = 10 * *out + (unsigned)(**at - '0');
  return digits > 0 && digits <= MOST_DIGITS ? 0 : -1;
}

/* FIRST, FIRST-LAST or FIRST-LASTxSTEP */
static int read_range(const char **at, numbers *out) {
  unsigned first, last, step = 1;
  if (read_number(at, &first) != 0)
    return -1;
  last = first;
  if (**at == '-') {
    ++*at;
    if (read_number(at, &last) != 0)
      return -1;
    if (**at == 'x') {
      ++*at;
      if (read_number(at, &step) != 0)
        return -1;
    }
  }
  if (last < first || step == 0)
    return -1;
  for (unsigned i = first; i <= last; i += step)
    if (out->count >= MOST_FRAMES || add_number(out, i) != 0)
      return -1;
  return 0;
}

static int read_ranges(const char *text, numbers *out, image_error *error) {
  const char *at = text;
  int failed = read_range(&at, out);
  while (!failed && *at == ',') {
    at++;
    failed = read_range(&at, out);
  }
  if (!failed && !*at)
    return 0;
  return image_fail(error,
                    "--frames %s: FIRST-LAST, FIRST-LASTxSTEP or several of "
                    "them with commas are needed, such as 1-240x2, of at most "
                    "%d frames",
                    text, MOST_FRAMES);
}

/* ------------------------------------------------------------------------ */
/* Patterns                                                                  */

/* A name with a number in it. */
typedef struct pattern {
  const char *text;
  size_t before; /* characters in front of the number's place */
  size_t behind; /* where the name goes on */
  unsigned width;
} pattern;

/* %d or %0Nd at p; its length, or 0. */
static size_t percent_length(const char *p, unsigned *width) {
  const char *at = p + 1;
  *width = 1;
  if (*at == '0') {
    at++;
    if (read_number(&at, width) != 0 || *width < 1 || *width > MOST_DIGITS)
      return 0;
  }
  return *at == 'd' ? (size_t)(at - p) + 1 : 0;
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
  return out->width <= MOST_DIGITS;
}

static char *pattern_file(const pattern *p, unsigned number) {
  const size_t size = strlen(p->text) + MOST_DIGITS + 2;
  char *file = malloc(size);
  if (file)
    snprintf(file, size, "%.*s%0*u%s", (int)p->before, p->text, (int)p->width,
             number, p->text + p->behind);
  return file;
}

/* The number in the name of a file that the pattern could have made. */
static int match(const pattern *p, const char *prefix, const char *name,
                 unsigned *number) {
  const size_t front = strlen(prefix);
  if (strncmp(name, prefix, front) != 0)
    return 0;
  const char *at = name + front;
  const char *digits = at;
  if (read_number(&at, number) != 0 || strcmp(at, p->text + p->behind) != 0)
    return 0;
  const size_t count = (size_t)(at - digits);
  return count == p->width || (count > p->width && *digits != '0');
}

static int ascending(const void *a, const void *b) {
  const unsigned x = *(const unsigned *)a, y = *(const unsigned *)b;
  return (x > y) - (x < y);
}

/* The numbers of the files that are there, in order. */
static int find_numbers(const pattern *p, numbers *out, image_error *error) {
  const char *slash = strrchr(p->text, '/');
  const size_t name = slash ? (size_t)(slash - p->text) + 1 : 0;
  char *folder = name ? strndup(p->text, name) : strdup(".");
  char *prefix = strndup(p->text + name, p->before - name);
  DIR *entries = folder && prefix ? opendir(folder) : NULL;
  int failed = 0;
  unsigned number;
  for (struct dirent *e; !failed && entries && (e = readdir(entries));)
    if (match(p, prefix, e->d_name, &number))
      failed = add_number(out, number);
  if (entries)
    closedir(entries);
  if (!folder || !prefix || failed)
    failed = image_no_memory(error, p->text);
  free(folder);
  free(prefix);
  if (!failed && out->count > 0)
    qsort(out->values, out->count, sizeof *out->values, ascending);
  return failed;
}

/* ------------------------------------------------------------------------ */
/* What is missing                                                           */

static int is_there(const char *file) {
  struct stat status;
  return stat(file, &status) == 0 || (errno != ENOENT && errno != ENOTDIR);
}

/* "5, 17-19 and 12 more" */
static void name_numbers(const numbers *n, char *text, size_t size) {
  size_t used = 0, i = 0;
  text[0] = '\0';
  for (int named = 0; i < n->count && named < MOST_NAMED; named++) {
    size_t last = i;
    while (last + 1 < n->count && n->values[last + 1] == n->values[last] + 1)
      last++;
    used += (size_t)snprintf(text + used, size - used, "%s%u", used ? ", " : "",
                             n->values[i]);
    if (last > i)
      used +=
          (size_t)snprintf(text + used, size - used, "-%u", n->values[last]);
    i = last + 1;
  }
  if (i < n->count)
    snprintf(text + used, size - used, " and %zu more", n->count - i);
}

static int refuse_missing(const pattern *p, const numbers *missing, size_t of,
                          image_error *error) {
  char text[256];
  name_numbers(missing, text, sizeof text);
  return image_fail(error,
                    "%s: %zu of %zu frames %s missing: %s; --frames with those "
                    "that are there is needed",
                    p->text, missing->count, of,
                    missing->count == 1 ? "is" : "are", text);
}

/* Without --frames the numbers must be equally spaced: a hole would be an
 * accident. */
static int check_holes(const pattern *p, const numbers *there,
                       image_error *error) {
  numbers missing = {NULL, 0, 0};
  unsigned step = MOST_FRAME;
  int failed = 0;
  size_t of = there->count;
  for (size_t i = 1; i < there->count; i++)
    if (there->values[i] - there->values[i - 1] < step)
      step = there->values[i] - there->values[i - 1];
  for (size_t i = 1; i < there->count && !failed; i++)
    for (unsigned n = there->values[i - 1] + step;
         n < there->values[i] && !failed; n += step)
      failed = add_number(&missing, n);
  if (failed)
    failed = image_no_memory(error, p->text);
  else if (missing.count)
    failed = refuse_missing(p, &missing, of + missing.count, error);
  free(missing.values);
  return failed;
}

/* Names in one line, of files that aren't patterns'. */
static int refuse_files(char *const *files, size_t count, size_t missing,
                        image_error *error) {
  char names[IMAGE_ERROR_SIZE - 128] = "";
  size_t named = 0, used = 0;
  for (size_t i = 0; i < count && named < MOST_NAMED; i++) {
    const size_t needed = strlen(files[i]) + 3;
    if (is_there(files[i]) || used + needed > sizeof names)
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

/* One that is missing is told by its reader. */
static int check_files(const frame_list *list, image_error *error) {
  size_t missing = 0;
  for (size_t i = 0; i < list->count; i++)
    missing += !is_there(list->files[i]);
  return missing < 2 ? 0
                     : refuse_files(list->files, list->count, missing, error);
}

/* ------------------------------------------------------------------------ */
/* The list                                                                  */

/* Takes the malloc'd name, NULL where memory has run out. */
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

static int add_numbered(const pattern *p, const numbers *n, frame_list *list,
                        image_error *error) {
  numbers missing = {NULL, 0, 0};
  int failed = 0;
  for (size_t i = 0; i < n->count && !failed; i++) {
    failed = add_file(list, pattern_file(p, n->values[i]), error);
    if (!failed && !is_there(list->files[list->count - 1]) &&
        add_number(&missing, n->values[i]) != 0)
      failed = image_no_memory(error, p->text);
  }
  if (!failed && missing.count)
    failed = refuse_missing(p, &missing, n->count, error);
  free(missing.values);
  return failed;
}

static int add_pattern(const pattern *p, const numbers *asked, frame_list *list,
                       image_error *error) {
  numbers there = {NULL, 0, 0};
  if (asked)
    return add_numbered(p, asked, list, error);
  int failed = find_numbers(p, &there, error);
  if (!failed && there.count == 0)
    failed = image_fail(error,
                        "%s: there is no such frame; a pattern of files that "
                        "are there is needed",
                        p->text);
  if (!failed)
    failed = check_holes(p, &there, error) != 0 ||
             add_numbered(p, &there, list, error) != 0;
  free(there.values);
  return failed ? -1 : 0;
}

static int add_argument(const char *argument, const numbers *asked,
                        frame_list *list, image_error *error) {
  pattern p;
  /* a file whose own name looks like a pattern goes first */
  if ((asked || !is_there(argument)) && find_pattern(argument, &p))
    return add_pattern(&p, asked, list, error);
  if (asked)
    return image_fail(error,
                      "--frames: %s has no place for a number; a pattern such "
                      "as frame.%%04d.exr or frame.####.exr is needed",
                      argument);
  return add_file(list, strdup(argument), error);
}

int frames_list(char *const *arguments, int count, const char *ranges,
                frame_list *out, image_error *error) {
  numbers asked = {NULL, 0, 0};
  memset(out, 0, sizeof *out);
  int failed = ranges ? read_ranges(ranges, &asked, error) : 0;
  for (int i = 0; i < count && !failed; i++)
    failed = add_argument(arguments[i], ranges ? &asked : NULL, out, error);
  free(asked.values);
  if (!failed)
    failed = check_files(out, error);
  if (failed)
    frames_free(out);
  return failed ? -1 : 0;
}

void frames_free(frame_list *list) {
  for (size_t i = 0; i < list->count; i++)
    free(list->files[i]);
  free(list->files);
  memset(list, 0, sizeof *list);
}
