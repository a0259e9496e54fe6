/* Lists of frame numbers. */
#include "tool/frame_numbers.h"

#include "image/error.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* How many ranges of numbers a message names. */
enum { MOST_NAMED = 8 };

int frame_numbers_add(frame_numbers *n, unsigned value) {
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

static int ascending(const void *a, const void *b) {
  const unsigned x = *(const unsigned *)a, y = *(const unsigned *)b;
  return (x > y) - (x < y);
}

void frame_numbers_sort(frame_numbers *n) {
  if (n->count > 0)
    qsort(n->values, n->count, sizeof *n->values, ascending);
}

void frame_numbers_free(frame_numbers *n) {
  free(n->values);
  memset(n, 0, sizeof *n);
}

int frame_number_read(const char **next, unsigned *out) {
  size_t digits = 0;
  for (*out = 0; isdigit((unsigned char)**next); ++*next, digits++)
    if (digits < FRAME_DIGITS)
      *out = 10 * *out + (unsigned)(**next - '0');
  return digits > 0 && digits <= FRAME_DIGITS ? 0 : -1;
}

/* FIRST, FIRST-LAST or FIRST-LASTxSTEP.  reversed: receives both numbers if the
 * first one is larger.  (OpenImageIO's enumerate_sequence() also takes "3-1",
 * "1-2x0" and "-1", and turns 99999999999999 into 2^31-1, without an error.) */
static int read_range(const char **next, frame_numbers *out,
                      unsigned reversed[2]) {
  unsigned first, last, step = 1;
  if (frame_number_read(next, &first) != 0)
    return -1;
  last = first;
  if (**next == '-') {
    ++*next;
    if (frame_number_read(next, &last) != 0)
      return -1;
    if (**next == 'x') {
      ++*next;
      if (frame_number_read(next, &step) != 0)
        return -1;
    }
  }
  if (last < first) {
    reversed[0] = first;
    reversed[1] = last;
  }
  if (last < first || step == 0)
    return -1;
  for (unsigned i = first; i <= last; i += step)
    if (out->count >= FRAMES_MOST || frame_numbers_add(out, i) != 0)
      return -1;
  return 0;
}

int frame_numbers_read(const char *text, frame_numbers *out,
                       image_error *error) {
  const char *next = text;
  unsigned reversed[2] = {0, 0};
  int failed = read_range(&next, out, reversed);
  while (!failed && *next == ',') {
    next++;
    failed = read_range(&next, out, reversed);
  }
  if (!failed && !*next)
    return 0;
  if (reversed[0])
    return image_fail(error,
                      "--frames %s: %u is after %u; FIRST-LAST with the "
                      "smaller number first is needed",
                      text, reversed[0], reversed[1]);
  return image_fail(error,
                    "--frames %s: FIRST-LAST, FIRST-LASTxSTEP or several of "
                    "them with commas are needed, such as 1-240x2, of at most "
                    "%d frames",
                    text, FRAMES_MOST);
}

void frame_numbers_name(const frame_numbers *n, char *text, size_t size) {
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
