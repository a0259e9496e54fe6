/* Finds the sequence that a folder holds. */
#define _POSIX_C_SOURCE 200809L
#include "tool/frame_folder.h"

#include "tool/paths.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* The files that were seen so far. */
typedef struct sequence_names {
  size_t count;
  char *first;   /* the name of one of them */
  char *pattern; /* theirs, with a # for each digit of the shortest number */
  char *padded;  /* the same for the longest number that begins with 0 */
} sequence_names;

int frame_folder_exists(const char *path) {
  struct stat status;
  return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

static int is_frame(const char *name) {
  const char *dot = strrchr(name, '.');
  return name[0] != '.' && dot && strcasecmp(dot, ".exr") == 0;
}

/* The name with a # for each digit of its last number; malloc'd. */
static char *pattern_of(const char *name) {
  char *out = strdup(name);
  size_t end = out ? strlen(out) : 0;
  while (end > 0 && !isdigit((unsigned char)out[end - 1]))
    end--;
  for (; end > 0 && isdigit((unsigned char)out[end - 1]); end--)
    out[end - 1] = '#';
  return out;
}

/* Whether two patterns differ at most in the number of their last #. */
static int is_same(const char *a, const char *b) {
  const char *end_a = strrchr(a, '#'), *end_b = strrchr(b, '#');
  if (!end_a || !end_b)
    return strcmp(a, b) == 0;
  size_t front_a = (size_t)(end_a - a) + 1, front_b = (size_t)(end_b - b) + 1;
  while (front_a > 0 && a[front_a - 1] == '#')
    front_a--;
  while (front_b > 0 && b[front_b - 1] == '#')
    front_b--;
  return strcmp(end_a, end_b) == 0 && front_a == front_b &&
         memcmp(a, b, front_a) == 0;
}

/* Whether the last number of a name begins with 0. */
static int is_padded(const char *name, const char *pattern) {
  const char *last = strrchr(pattern, '#');
  size_t first = last ? (size_t)(last - pattern) : 0;
  while (last && first > 0 && pattern[first - 1] == '#')
    first--;
  return last && name[first] == '0';
}

static int report_two(const char *folder, const char *a, const char *b,
                      image_error *error) {
  return image_fail(
      error, "%s: holds %s and %s; the pattern of one sequence is needed",
      folder, a, b);
}

static int add(sequence_names *s, const char *folder, const char *name,
               image_error *error) {
  char *pattern = pattern_of(name);
  if (!s->first)
    s->first = strdup(name);
  if (!pattern || !s->first) {
    free(pattern);
    return image_no_memory(error, folder);
  }
  if (is_padded(name, pattern) &&
      (!s->padded || strlen(s->padded) < strlen(pattern))) {
    free(s->padded);
    s->padded = strdup(pattern);
    if (!s->padded) {
      free(pattern);
      return image_no_memory(error, folder);
    }
  }
  const int same = !s->pattern || is_same(s->pattern, pattern);
  if (!same)
    report_two(folder, s->pattern, pattern, error);
  if (same && (!s->pattern || strlen(pattern) < strlen(s->pattern))) {
    char *longer = s->pattern;
    s->pattern = pattern;
    pattern = longer;
  }
  free(pattern);
  s->count++;
  return same ? 0 : -1;
}

static int look(const char *folder, sequence_names *s, image_error *error) {
  DIR *entries = opendir(folder);
  int failed = 0;
  if (!entries)
    return image_fail(error, "%s: cannot be read: %s", folder, strerror(errno));
  for (struct dirent *e; !failed && (e = readdir(entries));)
    if (is_frame(e->d_name))
      failed = add(s, folder, e->d_name, error);
  closedir(entries);
  if (!failed && !s->count)
    failed = image_fail(
        error, "%s: holds no EXR file; a folder with frames is needed", folder);
  /* with fewer digits the pattern stands for numbers without zeros in front */
  if (!failed && s->padded && strlen(s->padded) > strlen(s->pattern))
    failed = report_two(folder, s->pattern, s->padded, error);
  return failed;
}

char *frame_folder_pattern(const char *folder, image_error *error) {
  sequence_names s = {0, NULL, NULL, NULL};
  char *out = NULL;
  if (look(folder, &s, error) == 0) {
    out = path_join(folder, folder[strlen(folder) - 1] == '/' ? "" : "/",
                    s.count == 1 ? s.first : s.pattern);
    if (!out)
      image_no_memory(error, folder);
  }
  free(s.first);
  free(s.pattern);
  free(s.padded);
  return out;
}
