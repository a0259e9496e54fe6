/* Reads command lines by tables of options, and checks them. */
#include "tool/options.h"

#include "hbil/hbil.h"
#include "image/error.h"

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* getopt's value of the first option. */
enum { FIRST_OPTION = 256 };

/* The options that a command has, with the offsets of their structs. */
typedef struct option_list {
  const option_row *rows[OPTIONS_MOST];
  size_t bases[OPTIONS_MOST], count;
} option_list;

static option_list list_options(const option_command *c) {
  option_list l = {.count = 0};
  for (size_t g = 0; g < c->group_count; g++)
    for (size_t i = 0; i < c->groups[g].count; i++) {
      const option_row *row = &c->groups[g].rows[i];
      if (row->kind == OPTION_MORE || (c->accepts & row->of) != row->of ||
          l.count == OPTIONS_MOST)
        continue;
      l.rows[l.count] = row;
      l.bases[l.count++] = c->groups[g].base;
    }
  return l;
}

/* ------------------------------------------------------------------------ */
/* Values                                                                    */

int option_floats(const char *option, const char *text, float *out,
                  size_t count, image_error *error) {
  const char *next = text;
  for (size_t i = 0; i < count; i++) {
    char *end;
    errno = 0;
    out[i] = strtof(next, &end);
    const int overflow = errno == ERANGE && isinf(out[i]);
    if (end == next || isnan(out[i]) || overflow ||
        *end != (i + 1 < count ? ',' : '\0'))
      return count == 1
                 ? image_fail(error, "%s %s: a number is needed", option, text)
                 : image_fail(error,
                              "%s %s: %zu numbers with commas between them are "
                              "needed",
                              option, text, count);
    next = end + 1;
  }
  return 0;
}

static int read_above(const char *option, const char *text, double bound,
                      float *out, size_t count, image_error *error) {
  if (option_floats(option, text, out, count, error) != 0)
    return -1;
  for (size_t i = 0; i < count; i++)
    if (!((double)out[i] > bound) || isinf(out[i]))
      return image_fail(error, "%s %s: finite numbers above %g are needed",
                        option, text, bound);
  return 0;
}

static int read_number(const char *option, const char *text, unsigned low,
                       unsigned high, unsigned *out, image_error *error) {
  char *end;
  const long long value = strtoll(text, &end, 10);
  if (end == text || *end || value < (long long)low || value > (long long)high)
    return image_fail(error, "%s %s: a whole number from %u to %u is needed",
                      option, text, low, high);
  *out = (unsigned)value;
  return 0;
}

static int read_size(const char *option, const char *text, unsigned out[2],
                     image_error *error) {
  char end;
  if (sscanf(text, "%5ux%5u%c", &out[0], &out[1], &end) != 2 || out[0] < 1 ||
      out[0] > HBIL_MAX_SIZE || out[1] < 1 || out[1] > HBIL_MAX_SIZE)
    return image_fail(error,
                      "%s %s: WIDTHxHEIGHT is needed, each from 1 to %d, such "
                      "as 1280x720",
                      option, text, HBIL_MAX_SIZE);
  return 0;
}

int option_choice(const char *option, const char *text,
                  const char *const *words, int *out, image_error *error) {
  char list[256] = "";
  for (int i = 0; words[i]; i++) {
    if (strcmp(text, words[i]) == 0) {
      *out = i;
      return 0;
    }
    const size_t used = strlen(list);
    snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", words[i]);
  }
  return image_fail(error, "%s %s: one of %s is needed", option, text, list);
}

static int read_choice(const char *option, const char *text,
                       const option_row *row, int *out, image_error *error) {
  int index = 0;
  if (option_choice(option, text, row->words, &index, error) != 0)
    return -1;
  *out = (int)row->low + index;
  return 0;
}

/* arguments: the struct that has the row's member. */
static int read_value(const option_row *row, const char *text, void *arguments,
                      image_error *error) {
  void *member = (char *)arguments + row->member;
  char option[64];
  int failed = 0;
  snprintf(option, sizeof option, "--%s", row->name);
  switch (row->kind) {
  case OPTION_TEXT:
    *(const char **)member = text;
    break;
  case OPTION_FLAG:
  case OPTION_CLEAR:
    *(int *)member = row->kind == OPTION_FLAG;
    break;
  case OPTION_NUMBER:
    failed = read_number(option, text, row->low, row->high, member, error);
    break;
  case OPTION_FLOATS:
    failed = option_floats(option, text, member, row->high, error);
    break;
  case OPTION_ABOVE:
    failed = read_above(option, text, row->low, member, row->high, error);
    break;
  case OPTION_SIZE:
    failed = read_size(option, text, member, error);
    break;
  case OPTION_CHOICE:
    failed = read_choice(option, text, row, member, error);
    break;
  default:
    break;
  }
  return failed || !row->set ? failed : row->set(text, arguments, error);
}

/* ------------------------------------------------------------------------ */
/* Options that fit together                                                 */

int options_have(const options_given *given, size_t member) {
  for (size_t i = 0; i < given->count; i++)
    if (given->members[i] == member)
      return 1;
  return 0;
}

/* Whether an option was given and asks for something: 0 and some choices
 * don't.  choice: OPTION_ANY, or the choice that it must be. */
static int is_asked(const option_row *row, size_t base, const void *arguments,
                    const options_given *given, int choice) {
  const size_t member = base + row->member;
  if (!options_have(given, member))
    return 0;
  if (row->kind != OPTION_NUMBER && row->kind != OPTION_CHOICE)
    return 1;
  int value;
  memcpy(&value, (const char *)arguments + member, sizeof value);
  if (choice != OPTION_ANY)
    return value == choice;
  return row->kind == OPTION_NUMBER ? value != 0
                                    : !row->high || value < (int)row->high;
}

static int report(const option_row *row, const option_row *other,
                  const option_relation *r, image_error *error) {
  const int chosen = r->choice != OPTION_ANY;
  const char *word = chosen ? other->words[r->choice - (int)other->low] : "";
  return r->needed
             ? image_fail(error, "--%s: --%s%s%s%s is needed with it",
                          row->name, other->name, chosen ? " " : "", word,
                          r->why)
             : image_fail(error,
                          "--%s: not with --%s%s%s, %s; one or the other is "
                          "needed",
                          row->name, other->name, chosen ? " " : "", word,
                          r->why);
}

static int check_relation(const option_list *l, size_t i,
                          const option_relation *r, const void *arguments,
                          const options_given *given, image_error *error) {
  const size_t other = l->bases[i] + r->other;
  size_t k = 0;
  while (k < l->count && l->bases[k] + l->rows[k]->member != other)
    k++;
  if (k == l->count || is_asked(l->rows[k], l->bases[k], arguments, given,
                                r->choice) == r->needed)
    return 0;
  return report(l->rows[i], l->rows[k], r, error);
}

static int check(const option_list *l, const void *arguments,
                 const options_given *given, image_error *error) {
  for (size_t i = 0; i < l->count; i++) {
    const option_relation *r = l->rows[i]->relations;
    if (!is_asked(l->rows[i], l->bases[i], arguments, given, OPTION_ANY))
      continue;
    for (; r < l->rows[i]->relations + OPTION_RELATIONS && r->why; r++)
      if (check_relation(l, i, r, arguments, given, error) != 0)
        return -1;
  }
  return 0;
}

/* ------------------------------------------------------------------------ */
/* The command line                                                          */

/* The options as getopt_long() takes them: a table, and the letters. */
static void make_getopt_table(const option_list *l, struct option *out,
                              char *letters) {
  *letters++ = ':'; /* a missing value is told by ':' */
  *letters++ = 'h';
  for (size_t i = 0; i < l->count; i++) {
    const option_row *row = l->rows[i];
    const int bare = row->kind == OPTION_FLAG || row->kind == OPTION_CLEAR;
    out[i] = (struct option){row->name, bare ? no_argument : required_argument,
                             NULL, FIRST_OPTION + (int)i};
    if (row->letter)
      *letters++ = row->letter;
    if (row->letter && !bare)
      *letters++ = ':';
  }
  *letters = '\0';
  out[l->count] = (struct option){"help", no_argument, NULL, 'h'};
  out[l->count + 1] = (struct option){NULL, 0, NULL, 0};
}

/* Takes an option that getopt_long() has found. */
static int take(const option_list *l, int found, void *arguments,
                options_given *given, image_error *error) {
  size_t i = found >= FIRST_OPTION ? (size_t)(found - FIRST_OPTION) : 0;
  while (found < FIRST_OPTION && l->rows[i]->letter != found)
    i++;
  const size_t member = l->bases[i] + l->rows[i]->member;
  if (!options_have(given, member))
    given->members[given->count++] = member;
  return read_value(l->rows[i], optarg, (char *)arguments + l->bases[i], error);
}

int options_read(const option_command *c, int argc, char **argv,
                 void *arguments, options_given *given, image_error *error) {
  const option_list l = list_options(c);
  struct option table[OPTIONS_MOST + 2];
  char letters[2 * OPTIONS_MOST + 3];
  int found, last = optind;
  given->count = 0;
  opterr = 0;
  make_getopt_table(&l, table, letters);
  while ((found = getopt_long(argc, argv, letters, table, NULL)) != -1) {
    if (found == 'h')
      return 1;
    if (found == ':')
      return image_fail(error, "%s: %s needs a value; --help lists the options",
                        argv[0], argv[optind - 1]);
    if (found == '?')
      return image_fail(error,
                        "%s: %s is not an option; --help lists the options",
                        argv[0], argv[optind > last ? optind - 1 : last]);
    if (take(&l, found, arguments, given, error) != 0)
      return -1;
    last = optind;
  }
  return check(&l, arguments, given, error);
}
